"""Samples of an isotropic BRDF, as every reader gives them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# A direction counts as in the plane of incidence if it is no farther from it than this [rad], 0.06 degrees: more than
# what rounding leaves of an azimuth of 180 degrees, less than the finest step of a goniometer.
IN_PLANE = 1e-3
# Light angles that are no farther apart than this [rad] are one: files have few digits.
SAME_LIGHT = 1e-4

# A direction so close to the horizon [rad] that division by its cosine would only amplify noise: 0.06 degrees.
GRAZING = 1e-3


@dataclass(frozen=True)
class Measurement:
    """An isotropic BRDF, sampled.

    Attributes
    ----------
    name
        Of what was measured, "" if the file does not say.
    theta_l : shape (samples,)
        Angle of the light from the normal [rad], in [0, pi/2).
    theta_v : shape (samples,)
        Angle of the viewer from the normal [rad], in [0, pi/2].
    dphi : shape (samples,)
        Azimuth of the viewer from that of the light [rad], in [-pi, pi]; 0 is the side of the light, where a
        retroreflector shines.
    f : shape (samples, channels)
        BRDF [1/sr], without the cosine, >= 0.
    had_cosine
        Whether the file's values had a cosine, which the reader took for that of theta_l and divided out.
    """

    name: str
    theta_l: Array
    theta_v: Array
    dphi: Array
    f: Array
    had_cosine: bool = False

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.theta_l)

    def lights(self) -> Array:
        """The light angles there are [rad], ascending."""
        ordered = np.sort(self.theta_l)
        first = np.diff(ordered, prepend=-np.inf) > SAME_LIGHT
        return np.asarray(ordered[first])

    def plane_of_incidence(self, theta_l: float) -> tuple[Array, Array]:
        """Samples in the plane of incidence under one light.

        Parameters
        ----------
        theta_l
            One of `lights` [rad].

        Returns
        -------
        tuple
            View angle [rad], ascending, shape (n,), positive on the side of the light; and f [1/sr], shape
            (n, channels).
        """
        signed = self.theta_v * np.cos(self.dphi)
        across = np.abs(self.theta_v * np.sin(self.dphi))
        chosen = np.flatnonzero((np.abs(self.theta_l - theta_l) <= SAME_LIGHT) & (across <= IN_PLANE))
        ordered = chosen[np.argsort(signed[chosen], kind="stable")]
        return signed[ordered], self.f[ordered]

    def chosen(self, where: Array) -> Measurement:
        """Some of the samples, by a mask or by indices."""
        arrays = ("theta_l", "theta_v", "dphi", "f")
        return replace(self, **{name: getattr(self, name)[where] for name in arrays})


class Coefficient(NamedTuple):
    """A coefficient of retroreflection: the angles that R_A is taken at [degrees], and R_A [cd/(lx m^2)]."""

    observation_deg: float
    entrance_deg: float
    value: float


@dataclass(frozen=True)
class CoefficientSamples:
    """Coefficients of retroreflection, as a laboratory or a standard states them.

    Attributes
    ----------
    name
        Of what was measured, "" if nothing says.
    observation : shape (samples,)
        Angle between l and v [rad], >= 0.
    beta1, beta2 : shape (samples,)
        Components of the entrance angle [rad]; see `photometry.goniometer`.
    ra : shape (samples,)
        R_A [cd/(lx m^2)], > 0.
    """

    name: str
    observation: Array
    beta1: Array
    beta2: Array
    ra: Array

    def __len__(self) -> int:
        """The number of values."""
        return len(self.ra)
