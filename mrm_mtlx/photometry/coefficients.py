"""Coefficients of retroreflection of any BRDF, and the share of light that comes back.

With E_perp the illuminance at the sample on a plane perpendicular to the light, beta the angle of l and nu that of v
from the normal, and collimated light (CIE e-ILV 17-24-103, -104):

    R_A = I / (E_perp A) = f cos(beta) cos(nu)        cd/(lx m^2)        R_I = R_A A
    R_L = L / E_perp     = f cos(beta)                cd/(m^2 lx); road markings: times 1000, mcd

A real source and a real receiver are discs, as seen from the sample: what is read is the mean over both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from mrm_mtlx.bsdf.vectors import components, normalize
from mrm_mtlx.photometry import goniometer

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


class Brdf(Protocol):
    """Function from unit directions v and l in the local frame, (..., 3), to f [1/sr] without the cosine, (..., 3)."""

    def __call__(self, v: Array, l: Array, /) -> Array: ...  # noqa: D102


# The geometry of road markings (ASTM E1710 and CEN; the classes of EN 1436), as printed [rad].
MARKING_OBSERVATION, MARKING_ENTRANCE = np.deg2rad(1.05), np.deg2rad(88.76)
# Largest observation angle of any class that is known here, 2 degrees (46 CFR 164.018) [rad].
WITHIN = float(np.deg2rad(2.0))

# The rule over a disc: Gauss's rule in the solid angle, and even spacing around. Exact for polynomials of degree 7 in
# the directions; a disc of 0.1 degrees about the peak of a lobe of width 0.004 is met to 1e-9 and better.
_RINGS, _SPOKES = 4, 12
# Directions that are evaluated at once.
_AT_ONCE = 1 << 17


def coefficient(
    brdf: Brdf,
    observation: ArrayLike,
    beta1: ArrayLike,
    beta2: ArrayLike = 0.0,
    epsilon: ArrayLike = 0.0,
    *,
    source_aperture: float = 0.0,
    receiver_aperture: float = 0.0,
) -> Array:
    """Coefficient of retroreflection R_A of each channel.

    Parameters
    ----------
    brdf
        What is measured.
    observation, beta1, beta2, epsilon : array_like, shape (...)
        See `goniometer.directions` [rad].
    source_aperture, receiver_aperture
        Diameters of the discs, as angles seen from the sample [rad], in [0, pi); 0 is a point. They are of even
        radiance and responsivity, and stand square to l and v.

    Returns
    -------
    ndarray, shape (..., 3)
        R_A [cd/(lx m^2)]; 0 where v or l is below the surface.

    Raises
    ------
    ValueError
        If an aperture is negative, or pi and more.

    Examples
    --------
    >>> from mrm_mtlx.bsdf import Lambert
    >>> coefficient(Lambert().eval, 0.0, 0.0).round(6).tolist()
    [0.31831, 0.31831, 0.31831]
    """
    v, l = goniometer.directions(observation, beta1, beta2, epsilon)

    def at(v: Array, l: Array) -> Array:
        return _above(brdf, v, l) * (l[..., 2:] * v[..., 2:])

    return _mean_over_discs(at, v, l, source_aperture, receiver_aperture)


def r_l(
    brdf: Brdf,
    observation: ArrayLike = MARKING_OBSERVATION,
    beta1: ArrayLike = MARKING_ENTRANCE,
    beta2: ArrayLike = 0.0,
    epsilon: ArrayLike = 0.0,
    *,
    source_aperture: float = 0.0,
    receiver_aperture: float = 0.0,
) -> Array:
    """Coefficient of retroreflected luminance R_L of each channel, by default of road markings at 30 m.

    Parameters and errors as `coefficient`.

    Returns
    -------
    ndarray, shape (..., 3)
        R_L [mcd/(m^2 lx)].

    Examples
    --------
    >>> from mrm_mtlx.bsdf import Lambert
    >>> r_l(Lambert().eval).round(2).tolist()  # a perfect diffuser
    [6.89, 6.89, 6.89]
    """
    v, l = goniometer.directions(observation, beta1, beta2, epsilon)

    def at(v: Array, l: Array) -> Array:
        return 1000.0 * _above(brdf, v, l) * l[..., 2:]

    return _mean_over_discs(at, v, l, source_aperture, receiver_aperture)


def marking_geometry(distance_m: float = 30.0, headlamp_m: float = 0.65, eye_m: float = 1.2) -> tuple[float, float]:
    """Observation angle and beta1 [rad] of a level marking under a headlamp, seen by an eye right above it.

    beta1 = pi/2 - atan(headlamp / distance), observation = atan(eye / distance) - atan(headlamp / distance). The
    defaults are those of ASTM E1710 and CEN, which print 1.05 and 88.76 degrees.

    Examples
    --------
    >>> [round(float(np.rad2deg(angle)), 4) for angle in marking_geometry()]
    [1.0494, 88.7588]
    """
    lamp, eye = np.arctan2(headlamp_m, distance_m), np.arctan2(eye_m, distance_m)
    return float(eye - lamp), float(np.pi / 2 - lamp)


def retroreflected_fraction(
    brdf: Brdf, beta1: ArrayLike, beta2: ArrayLike = 0.0, epsilon: ArrayLike = 0.0, *, within: float = WITHIN
) -> Array:
    """Share of the light that comes back within an angle of where it came from.

    The integral of f cos(nu) over the cone of v about l, which is that of R_A / cos(beta). Near the normal it includes
    what a smooth surface mirrors; take an entrance angle beyond half of `within` to leave that out.

    Parameters
    ----------
    brdf
        What is measured; no part of it narrower than 1e-4.
    beta1, beta2, epsilon : array_like, shape (...)
        See `goniometer.directions` [rad].
    within
        Largest observation angle [rad], in (0, pi/2].

    Returns
    -------
    ndarray, shape (..., 3)
        Of each channel, in [0, 1] if energy is conserved.

    Raises
    ------
    ValueError
        If `within` is out of range.
    """
    if not 0.0 < within <= np.pi / 2:
        msg = f"within must be in (0, pi/2], got {within:g} (in radians)"
        raise ValueError(msg)
    _, l = goniometer.directions(0.0, beta1, beta2, epsilon)
    depth, solid_angle = _rings(within)
    total = np.zeros(l.shape)
    at_once = max(1, _AT_ONCE // (_AROUND * l[..., 0].size))
    for start in range(0, len(depth), at_once):
        part = slice(start, start + at_once)
        v, weight = _cone(l, depth[part], _AROUND), np.repeat(solid_angle[part] / _AROUND, _AROUND)
        total += np.einsum("k,k...->...", weight, _above(brdf, v, l) * np.maximum(v[..., 2:], 0.0))
    return total


# Panels of the cone, graded towards l: a lobe of any width above 1e-4 rad lies over several of them.
_INNERMOST, _PANELS = 1e-5, 32
_AROUND = 32


def _rings(within: float) -> tuple[Array, Array]:
    """Rings of a cone, shape (rings,) each: 1 - cos of their angle, and their solid angle.

    Gauss's rule on each panel in 1 - cos, in which the solid angle is even.
    """
    node, weight = np.polynomial.legendre.leggauss(_RINGS)
    # Written by the half-angle: small angles would lose their digits in 1 - cos.
    edges = 2.0 * np.sin(0.5 * np.concatenate([[0.0], np.geomspace(_INNERMOST, within, _PANELS)])) ** 2
    half = 0.5 * np.diff(edges)[:, None]
    depth, solid_angle = edges[:-1, None] + half * (1.0 + node), 2.0 * np.pi * half * weight
    return depth.ravel(), solid_angle.ravel()


def _cone(l: Array, depth: Array, around: int) -> Array:
    """Directions on circles about l, (rings * around, ..., 3); depth is 1 - cos of a circle's angle."""
    phi = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    sine, cosine = (np.repeat(part, around) for part in (np.sqrt(depth * (2.0 - depth)), 1.0 - depth))
    phi = np.tile(phi, len(depth))
    a, b = _frame(l)
    shape = (-1, *(1,) * l.ndim)
    x, y, z = (part.reshape(shape) for part in (sine * np.cos(phi), sine * np.sin(phi), cosine))
    return np.asarray(x * a + y * b + z * l)


def _frame(l: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to l and each other."""
    flat = np.abs(l[..., :1]) < 0.5
    a = normalize(np.cross(l, np.where(flat, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])))
    return a, np.cross(l, a)


def _above(brdf: Brdf, v: Array, l: Array) -> Array:
    """f where both directions are above the surface, else 0."""
    v, l = np.broadcast_arrays(components("v", v), components("l", l))
    above = (v[..., 2] > 0.0) & (l[..., 2] > 0.0)
    # What is below is evaluated along the normal, and thrown away: a BRDF need not have a value there.
    normal = np.array([0.0, 0.0, 1.0])
    f = brdf(np.where(above[..., None], v, normal), np.where(above[..., None], l, normal))
    return np.where(above[..., None], f, 0.0)


def _mean_over_discs(function: Brdf, v: Array, l: Array, source: float, receiver: float) -> Array:
    """Mean of a function of v and l over the disc of the receiver about v and that of the source about l."""
    lights, light_weights = _disc(l, source, "source_aperture")
    views, view_weights = _disc(v, receiver, "receiver_aperture")
    total = np.zeros(v.shape)
    pairs = len(lights) * len(views)
    rows = max(1, _AT_ONCE * len(lights) // max(1, pairs * v[..., 0].size))
    for start in range(0, len(lights), rows):
        part = slice(start, start + rows)
        values = function(views[None], lights[part, None])
        total += np.einsum("i,k,ik...->...", light_weights[part], view_weights, values)
    return total


def _disc(axis: Array, diameter: float, name: str) -> tuple[Array, Array]:
    """Directions (k, ..., 3) over a disc about an axis and their weights, which sum to 1; one of no size is a point."""
    if not 0.0 <= diameter < np.pi:
        msg = f"{name} must be in [0, pi), got {diameter:g} (in radians)"
        raise ValueError(msg)
    if diameter == 0.0:
        return axis[None], np.ones(1)
    node, weight = np.polynomial.legendre.leggauss(_RINGS)
    depth = 2.0 * np.sin(0.25 * diameter) ** 2 * 0.5 * (1.0 + node)  # 1 - cos of the radius
    return _cone(axis, depth, _SPOKES), np.repeat(0.5 * weight / _SPOKES, _SPOKES)
