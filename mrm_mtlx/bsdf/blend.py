"""Partial retroreflection: weighted mixtures of two lobes, and of two lookups of the environment."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.quadrature import ACCURACY
from mrm_mtlx.bsdf.vectors import components, mirror

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.lobe import Lobe
    from mrm_mtlx.bsdf.microfacet_lobe import Microfacet


@dataclass(frozen=True)
class Blend:
    """Two lobes, f = (1 - w) f_a + w f_b (Portsmouth et al. 2026, section 4).

    Parameters
    ----------
    a, b : Lobe
        Any lobes; `a` alone at w = 0, `b` alone at w = 1.
    w : array_like, shape (...)
        Weight of `b`, in [0, 1]; broadcasts with the samples.

    Raises
    ------
    ValueError
        By the methods: if a weight is not in [0, 1].
    """

    a: Lobe
    b: Lobe
    w: ArrayLike = 0.5

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""
        return self._mixed(self.a.eval(v, l), self.b.eval(v, l), self._weight()[..., None])

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density of `sample`: that of the lobes, mixed as they are."""
        return self._mixed(self.a.pdf(v, l), self.b.pdf(v, l), self._weight())

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions of light by the one-sample choice of a lobe, `b` with probability w (Veach 1997, section 9.2)."""
        u, w = components("u", u), self._weight()
        chosen = u[..., 2] < w
        # Inside its part of the interval, the number is uniform again.
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = np.where(chosen, u[..., 2] / w, (u[..., 2] - w) / (1.0 - w))
        u = np.stack([*np.broadcast_arrays(u[..., 0], u[..., 1], rest)], axis=-1)
        return np.where(chosen[..., None], self.b.sample(v, u), self.a.sample(v, u))

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Directional albedo, see `lobe.Lobe.albedo`: those of the lobes, mixed as they are."""
        a, b = (lobe.albedo(v, accuracy=accuracy) for lobe in (self.a, self.b))
        return self._mixed(a, b, self._weight()[..., None])

    def _weight(self) -> Array:
        w = np.asarray(self.w, dtype=float)
        if np.any(~((w >= 0.0) & (w <= 1.0))):
            msg = f"w must be in [0, 1], got {w.min():g} to {w.max():g}"
            raise ValueError(msg)
        return w

    @staticmethod
    def _mixed(a: Array, b: Array, w: Array) -> Array:
        return np.asarray((1.0 - w) * a + w * b)


def partially_retroreflective(lobe: Microfacet, mask: ArrayLike) -> Blend:
    """The lobe blended with its retroreflective version.

    `mask` is 0 where the surface is ordinary, 0.5 where both are averaged, 1 where all is retroreflective, as a texture
    says it (OpenPBR's and glTF's weight; real-time shaders have the constant 0.5).

    Examples
    --------
    >>> from mrm_mtlx.bsdf import Conductor
    >>> tape, v = Conductor(0.2, 3.4, alpha=(0.1, 0.1)), np.array([0.6, 0.0, 0.8])
    >>> averaged = partially_retroreflective(tape, 0.5)
    >>> bool(np.allclose(averaged.eval(v, v), averaged.eval(v, mirror(v))))
    True
    """
    return Blend(replace(lobe, retroreflective=False), replace(lobe, retroreflective=True), mask)


def environment_radiance(lookup: Callable[[Array], Array], v: ArrayLike, mask: ArrayLike) -> Array:
    """Radiance of the environment as a partially retroreflective surface looks it up, (..., 3).

    Ordinary reflection looks along v', the mirror direction, retroreflection along v: (1 - mask) L(v') + mask L(v).
    Real-time renderers look a filtered environment up so, once per lobe.

    Parameters
    ----------
    lookup
        From directions (..., 3) to radiance (..., 3).
    v : array_like, shape (..., 3)
        Directions to the viewer, in the local frame.
    mask : array_like, shape (...)
        As in `partially_retroreflective`.
    """
    v, mask = components("v", v), np.asarray(mask, dtype=float)[..., None]
    return np.asarray((1.0 - mask) * lookup(mirror(v)) + mask * lookup(v))
