"""Samples to fit a material to: directions, measured values, and the residuals of a model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.fitting.residuals import LOG
from mrm_mtlx.measured.measurement import GRAZING, IN_PLANE, SAME_LIGHT, CoefficientSamples, Measurement
from mrm_mtlx.photometry import goniometer
from mrm_mtlx.photometry.color import luminance_weights

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.fitting.residuals import Residual

# Added before the logarithm is taken [1/sr]: what is darker counts for little.
FLOOR = 1e-3
# Samples that are fitted: of more, as MERL's million, these are drawn.
MAXIMUM = 20_000
# Differences of values that should be equal, as a factor, that are still no sign of an error.
_NOT_RECIPROCAL = 1.25


@dataclass(frozen=True)
class Samples:
    """Values at directions.

    Attributes
    ----------
    name
        Of what was measured.
    v, l : shape (samples, 3)
        Unit, above the surface, in the local frame.
    factor : shape (samples, 1)
        What makes the quantity of f: 1, or cos(beta) cos(nu).
    value : shape (samples, channels)
        The quantity: f [1/sr], or R_A [cd/(lx m^2)].
    weights : shape (3,) or None
        By which the model's channels make the one value, where it is photometric.
    residual
        The scale on which model and values are compared.
    floor
        Of the residual.
    """

    name: str
    v: Array
    l: Array
    factor: Array
    value: Array
    weights: Array | None = None
    residual: Residual = LOG
    floor: float = FLOOR

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.value)

    @property
    def count(self) -> int:
        """The number of residuals."""
        return int(self.value.size)

    def chosen(self, where: Array) -> Samples:
        """Some of the samples, by a mask or by indices."""
        return replace(self, v=self.v[where], l=self.l[where], factor=self.factor[where], value=self.value[where])

    def modelled(self, f: Array) -> Array:
        """The quantity of a model's BRDF, (samples, 3, ...) -> (samples, channels, ...)."""
        if self.weights is not None:
            f = np.tensordot(f, self.weights, axes=(1, 0))[:, None]
        else:
            f = f[:, : self.value.shape[1]]
        return f * self.factor.reshape(-1, *(1,) * (f.ndim - 1))

    def residuals(self, f: Array) -> Array:
        """Residuals of a model's BRDF, (samples, 3) -> (count,)."""
        scaled = self.residual.scaled
        return np.ravel(scaled(self.modelled(f), self.floor) - scaled(self.value, self.floor))

    def residuals_with_jacobian(self, f: Array, slopes: Array) -> tuple[Array, Array]:
        """Residuals, and their derivatives, from those of the BRDF: (samples, 3, numbers) -> (count, numbers)."""
        slope = self.residual.slope(self.modelled(f), self.floor)
        jacobian = self.modelled(slopes) * slope[..., None]
        return self.residuals(f), jacobian.reshape(-1, slopes.shape[-1])


def from_measurement(
    measured: Measurement,
    *,
    residual: Residual = LOG,
    largest: float = np.deg2rad(80.0),
    plane: bool = False,
    around: float | None = None,
    viewed: bool = False,
    seed: int = 0,
) -> Samples:
    """Samples of a measured BRDF.

    Parameters
    ----------
    measured
        With one channel or three.
    residual
        The scale of the comparison.
    largest
        Samples with a larger angle of l or v from the normal [rad] are left out: there, errors of the goniometer and
        edges of the sample show.
    plane
        Only the plane of incidence.
    around
        Only directions v that are no farther [rad] from l.
    viewed
        Whether the cosine that the file had in its values, and that its reader divided out as that of l, is that of v.
    seed
        Of the choice of `MAXIMUM` samples, where there are more.

    Raises
    ------
    ValueError
        If there are other channels, nothing is left, or the cosine of v is asked for and the values had none.
    """
    if measured.f.shape[1] not in (1, 3):
        msg = f"{measured.f.shape[1]} channels; a material has one (grey) or three (linear Rec.709)"
        raise ValueError(msg)
    if viewed and not measured.had_cosine:
        msg = "the values have no cosine in them that could be that of v (--cosine view): they are said to be a BRDF"
        raise ValueError(msg)
    v, l = directions(measured)
    kept = np.maximum(measured.theta_v, measured.theta_l) < min(largest, np.pi / 2 - 1e-3)
    if plane:
        kept &= np.abs(measured.theta_v * np.sin(measured.dphi)) <= IN_PLANE
    if around is not None:
        kept &= np.linalg.norm(v - l, axis=1) <= 2.0 * np.sin(0.5 * around)
    if not kept.any():
        msg = f"none of the {len(measured)} samples is among the directions that are asked for"
        raise ValueError(msg)
    if np.count_nonzero(kept) > MAXIMUM:
        every = np.flatnonzero(kept)
        kept = np.zeros(len(measured), dtype=bool)
        kept[np.random.default_rng(seed).choice(every, MAXIMUM, replace=False)] = True
    f = measured.f * (np.cos(measured.theta_l) / np.cos(measured.theta_v))[:, None] if viewed else measured.f
    return Samples(measured.name, v[kept], l[kept], np.ones((int(kept.sum()), 1)), f[kept], residual=residual)


def from_coefficients(measured: CoefficientSamples) -> Samples:
    """Samples of coefficients of retroreflection: luminance under illuminant A, residual ln R_A.

    Raises
    ------
    ValueError
        If a direction is below the horizon.
    """
    v, l = goniometer.directions(measured.observation, measured.beta1, measured.beta2)
    if np.min([v[:, 2], l[:, 2]]) < np.sin(GRAZING):
        i = int(np.argmin(np.minimum(v[:, 2], l[:, 2])))
        place = (
            f"observation {np.rad2deg(measured.observation[i]):g}, entrance {np.rad2deg(measured.beta1[i]):g} degrees"
        )
        msg = f"{place}: a direction is below the surface's horizon"
        raise ValueError(msg)
    factor = (v[:, 2] * l[:, 2])[:, None]
    return Samples(measured.name, v, l, factor, measured.ra[:, None], weights=luminance_weights("A"), floor=0.0)


def directions(measured: Measurement) -> tuple[Array, Array]:
    """Unit vectors v and l, (samples, 3), l at azimuth 0."""
    sin_v = np.sin(measured.theta_v)
    v = np.stack([sin_v * np.cos(measured.dphi), sin_v * np.sin(measured.dphi), np.cos(measured.theta_v)], axis=1)
    l = np.stack([np.sin(measured.theta_l), np.zeros(len(measured)), np.cos(measured.theta_l)], axis=1)
    return v, l


@dataclass(frozen=True)
class Reciprocity:
    """The distance between f(v, l) and f(l, v), where both were measured.

    `pairs` is how many were found; `factor` the median of their larger over their smaller; `as_view` the same with the
    cosine of v divided out in the place of that of l.
    """

    pairs: int
    factor: float
    as_view: float

    @property
    def broken(self) -> bool:
        """True if the values differ by more than errors of measurement."""
        return self.pairs >= 10 and self.factor > _NOT_RECIPROCAL

    @property
    def by_cosine(self) -> bool:
        """True if the other cosine explains most of it."""
        return self.broken and np.log(self.as_view) < 0.5 * np.log(self.factor)


# Samples count as of the same directions if no angle differs by more [rad]: a step of a coarse goniometer.
_SAME = np.deg2rad(1.0)
# Lights, of which all pairs are looked at.
_MAXIMUM_LIGHTS = 12


def reciprocity(measured: Measurement) -> Reciprocity:
    """Compare values with those of exchanged directions, f(v, l) = f(l, v) (Helmholtz)."""
    lights = measured.lights()
    lights = lights[:: max(1, -(-len(lights) // _MAXIMUM_LIGHTS))]
    f, dphi = np.mean(measured.f, axis=1), np.abs(measured.dphi)
    under = {i: np.flatnonzero(np.abs(measured.theta_l - light) <= SAME_LIGHT) for i, light in enumerate(lights)}
    logs, cosines = [], []
    for i, light in enumerate(lights):
        for k in range(i):
            there, back = (
                rows[np.abs(measured.theta_v[rows] - to) <= _SAME]
                for rows, to in ((under[i], lights[k]), (under[k], light))
            )
            if not len(back):
                continue
            back = back[np.argsort(dphi[back])]
            same = back[_nearest(dphi[back], dphi[there])]
            kept = (np.abs(dphi[same] - dphi[there]) <= _SAME) & (np.minimum(f[there], f[same]) > 0.0)
            logs.append(np.log(f[there[kept]] / f[same[kept]]))
            # The reader's f has 1 / cos(theta_l); exchanging the cosines multiplies by cos l / cos v.
            cosines.append(np.full(np.sum(kept), 2.0 * np.log(np.cos(light) / np.cos(lights[k]))))
    if not sum(map(len, logs)):
        return Reciprocity(0, 1.0, 1.0)
    found = np.concatenate(logs)
    other = found + np.concatenate(cosines)
    return Reciprocity(len(found), *(float(np.exp(np.median(np.abs(x)))) for x in (found, other)))


def _nearest(ascending: Array, wanted: Array) -> Array:
    """Indices of what is nearest to each wanted value, the lower one of two that are as near."""
    above = np.minimum(np.searchsorted(ascending, wanted), len(ascending) - 1)
    below = np.maximum(above - 1, 0)
    return np.where(np.abs(ascending[below] - wanted) <= np.abs(ascending[above] - wanted), below, above)


def doubts(measured: Measurement, *, viewed: bool = False) -> list[str]:
    """Signs that the numbers of a file are not what it says they are.

    `viewed`: the cosine was already read as that of v.
    """
    found = []
    largest = float(max(np.max(measured.theta_l), np.max(measured.theta_v)))
    if np.deg2rad(0.5) < largest < np.deg2rad(1.6):
        found.append(f"no angle is above {np.rad2deg(largest):.2f} degrees: are they in radians?")
    exchanged = reciprocity(measured)
    if not exchanged.broken:
        return found
    apart = f"{exchanged.pairs} pairs of exchanged directions differ by a factor of {exchanged.factor:.2f} (median)"
    if viewed:
        # What is read as the cosine of v is exactly the other case.
        if not exchanged.by_cosine:
            found.append(f"{apart}, with the cosine of l; with that of v by {exchanged.as_view:.2f}")
    elif exchanged.by_cosine and measured.had_cosine:
        found.append(
            f"{apart}, which a BRDF does not; with the cosine of v divided out instead of that of l by "
            f"{exchanged.as_view:.2f}: see --cosine view"
        )
    else:
        found.append(f"{apart}, which a BRDF does not: no parameters can fit both")
    return found
