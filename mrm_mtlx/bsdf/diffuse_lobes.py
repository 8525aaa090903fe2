"""Diffuse reflection as lobes: what a retroreflector is compared with, and lies on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.diffuse import compensated_oren_nayar, compensated_oren_nayar_albedo
from mrm_mtlx.bsdf.quadrature import ACCURACY
from mrm_mtlx.bsdf.ranges import NOT_NEGATIVE, UNIT_INTERVAL
from mrm_mtlx.bsdf.vectors import color, components, direction, dot

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


class Diffuse(ABC):
    """Reflection to the upper side, sampled with the cosine of l."""

    @abstractmethod
    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""

    @abstractmethod
    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Directional albedo, see `lobe.Lobe.albedo`; a closed form, whatever the accuracy."""

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density of `sample`, n.l / pi."""
        v, l = direction("v", v), direction("l", l)
        return np.where(_above(v, l), l[..., 2] / np.pi, 0.0)

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions of light, see `lobe.Lobe.sample`: uniform on the disc, raised to the hemisphere (Malley)."""
        v, u = direction("v", v), components("u", u)
        radius, phi = np.sqrt(u[..., 0]), 2.0 * np.pi * u[..., 1]
        z = np.sqrt(1.0 - u[..., 0])
        l = np.stack([radius * np.cos(phi), radius * np.sin(phi), z], axis=-1)
        return np.where(v[..., 2:] > 0.0, l, 0.0)


@dataclass(frozen=True)
class Lambert(Diffuse):
    """The same radiance in all directions, f = color / pi, of a colour >= 0."""

    color: ArrayLike = 1.0

    def __post_init__(self) -> None:
        """Raise `ValueError` for a colour below 0."""
        NOT_NEGATIVE.check("color", self.color)

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""
        above = _above(direction("v", v), direction("l", l))[..., None]
        return np.where(above, color("color", self.color) / np.pi, 0.0)

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:  # noqa: ARG002
        """The colour, for views from above."""
        return np.where(direction("v", v)[..., 2:] > 0.0, color("color", self.color), 0.0)


@dataclass(frozen=True)
class EON(Diffuse):
    """Energy-preserving Oren and Nayar (Portsmouth, Kutz and Hill 2025), rough diffuse reflection.

    Parameters
    ----------
    color : array_like
        Albedo of the facets, in [0, 1].
    roughness : array_like, shape (...)
        The model's own, in [0, 1].
    """

    color: ArrayLike = 1.0
    roughness: ArrayLike = 0.5

    def __post_init__(self) -> None:
        """Raise `ValueError` for what is out of its range."""
        UNIT_INTERVAL.check("color", self.color)
        UNIT_INTERVAL.check("roughness", self.roughness)

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""
        v, l = np.broadcast_arrays(direction("v", v), direction("l", l))
        above = _above(v, l)[..., None]
        cos_v, cos_l = (np.where(above, w[..., 2:], 1.0) for w in (v, l))
        f = compensated_oren_nayar(cos_v, cos_l, dot(v, l)[..., None], self._roughness(), color("color", self.color))
        return np.where(above, f, 0.0)

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:  # noqa: ARG002
        """Directional albedo, see `lobe.Lobe.albedo` (Portsmouth et al. 2025)."""
        z = direction("v", v)[..., 2:]
        found = compensated_oren_nayar_albedo(np.where(z > 0.0, z, 1.0), self._roughness(), color("color", self.color))
        return np.where(z > 0.0, found, 0.0)

    def _roughness(self) -> Array:
        return np.asarray(self.roughness, dtype=float)[..., None]


def _above(v: Array, l: Array) -> Array:
    return np.asarray((v[..., 2] > 0.0) & (l[..., 2] > 0.0))
