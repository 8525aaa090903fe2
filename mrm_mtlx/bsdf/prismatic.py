"""Prismatic sheeting: how much light cube corners send back, from geometry (model of Guo, Guo and Pan 2018).

A cube corner is three perpendicular mirrors under a triangular aperture whose corners lie on the three edges where the
mirrors meet. Its axes are those edges, away from the apex; d is a unit vector inside of the material, towards the
aperture, and light travels along -d.

Unfolding the mirrors makes the path a straight line through an octahedron: |x| + |y| + |z| <= 1. Light comes back if
that line ends on the face opposite of the aperture. Seen along d, it enters at p and leaves at -p from the apex, so the
aperture that works is the aperture cut with its own point reflection. In barycentric coordinates of the aperture the
apex is at c = d / (d_x + d_y + d_z), and what works is 0 <= b_i <= 2 c_i. Inclusion and exclusion of the three corners
that are cut away, of area (1 - 2 c_i)^2 each, gives

    share = 1 + sum of x_i |x_i|,   x_i = 2 c_i - 1

which is 8 p q / s^2 where p + q <= r and 2 - 4 / s^2 elsewhere, for cosines p <= q <= r and their sum s.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel
from mrm_mtlx.bsdf.vectors import components, mirror

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

BACKINGS = ("air", "metal")

# Rotations over which a sheet of many orientations is averaged. Two orientations, half a turn apart, repeat every
# 60 degrees, so that an even rule over 60 degrees is one over the circle. Against 8192: within 1e-4.
_ROTATIONS = 512


def effective_area(d: ArrayLike) -> Array:
    """Share of a cube corner's aperture whose light comes back, if all three mirrors reflect all of it.

    Parameters
    ----------
    d : array_like, shape (..., 3)
        Direction inside of the material, away from the apex, in the corner's axes; any length above 0.

    Returns
    -------
    ndarray, shape (...)
        In [0, 2/3]; 0 where a component is not positive.

    Examples
    --------
    >>> round(float(effective_area([1.0, 1.0, 1.0])), 6)
    0.666667
    """
    d = np.maximum(components("d", d), 0.0)
    total = np.sum(d, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = 2.0 * d / total[..., None] - 1.0
        share = 1.0 + np.sum(x * np.abs(x), axis=-1)
    # Differences of nearly equal numbers leave a rounding error where the share ends.
    return np.where(np.all(d > 0.0, axis=-1), np.clip(share, 0.0, 2.0 / 3.0), 0.0)


def face_reflectance(d: ArrayLike, ior: ArrayLike, backing: str = "air") -> Array:
    """Share of the light that is left after the three mirrors.

    A mirror turns the sign of one component of d, so each is met at its own cosine |d_i|, whatever the order. Backed by
    air it reflects by Fresnel's equations, all of the light where |d_i| < sqrt(1 - 1 / ior^2). The product of
    unpolarised reflectances leaves out that the mirrors polarise; it is exact where at most one is not total.

    Parameters
    ----------
    d : array_like, shape (..., 3)
        As `effective_area`, unit length.
    ior : array_like, shape (...)
        Index of refraction of the material, >= 1.
    backing : {"air", "metal"}
        What is behind the mirrors. Metal is taken as perfect; a colour of its own is the caller's factor.

    Returns
    -------
    ndarray, shape (...)
        In [0, 1].

    Raises
    ------
    ValueError
        If `ior` is below 1 or `backing` is none of the two.
    """
    d, ior = components("d", d), _index(ior)
    if backing not in BACKINGS:
        msg = f"backing must be one of {', '.join(BACKINGS)}, got {backing!r}"
        raise ValueError(msg)
    if backing == "metal":
        return np.ones(np.broadcast_shapes(d.shape[:-1], ior.shape))
    cosines = np.minimum(np.abs(d), 1.0)
    return np.asarray(np.prod(fresnel.dielectric(cosines, 1.0 / ior[..., None]), axis=-1))


def retroreflected_share(v: ArrayLike, ior: ArrayLike, backing: str = "air", rotation: ArrayLike | None = 0.0) -> Array:
    """Share of the light inside of a sheet that its cube corners send back, w(v).

    Entry and exit are left out: each costs 1 - F. The corners' axis is the normal. Half of them are turned by half a
    turn, as in a sheet without gaps; so w(v) = w(v'), which a reciprocal lobe with this weight needs.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Unit direction outside, in the local frame; refracted by Snell's law.
    ior, backing
        As `face_reflectance`.
    rotation : array_like, shape (...), or None
        Azimuth of an edge from the tangent [rad]; None averages over all, to 1e-4.

    Returns
    -------
    ndarray, shape (...)
        In [0, 2/3]; 0 for v below the surface.

    Raises
    ------
    ValueError
        As `face_reflectance`; also if v has no three components.

    Examples
    --------
    >>> round(float(retroreflected_share([0.0, 0.0, 1.0], 1.5)), 6)
    0.666667
    """
    v, ior = components("v", v), _index(ior)
    if rotation is None:
        turns = (np.arange(_ROTATIONS) + 0.5) * (np.pi / 3.0 / _ROTATIONS)
        each = retroreflected_share(v[..., None, :], ior[..., None], backing, turns)
        return np.asarray(np.mean(each, axis=-1))
    inside = refracted(v, ior)
    shares = [_share(_corner_axes(turned, np.asarray(rotation, dtype=float)), ior, backing)
              for turned in (inside, mirror(inside))]  # fmt: skip
    return np.asarray(np.where(v[..., 2] > 0.0, 0.5 * (shares[0] + shares[1]), 0.0))


def refracted(v: ArrayLike, ior: ArrayLike) -> Array:
    """Direction inside of the sheet, towards the surface, of what is seen along v through a smooth plane; (..., 3)."""
    v, ior = components("v", v), _index(ior)
    across = v[..., :2] / ior[..., None]
    up = np.sqrt(np.maximum(1.0 - np.sum(np.square(across), axis=-1), 0.0))
    return np.concatenate([across, up[..., None]], axis=-1)


def retroreflective_width(alpha: ArrayLike, cos_theta: ArrayLike, ior: ArrayLike) -> Array:
    """Width of the lobe that comes back through a rough front plane, to first order in alpha.

    A facet of slope s changes the component along the surface of ior times the direction by -G s, with
    G = sqrt(ior^2 - sin^2) - cos. The corner reverses it, another facet adds its own: G (s1 - s2). Two independent
    Beckmann slopes of width alpha differ by one of width sqrt(2) alpha. A mirror lobe of width a adds 2 cos s, so

        a = alpha (sqrt(ior^2 - sin^2 theta) - cos theta) / (sqrt(2) cos theta)

    At normal incidence, a = alpha (ior - 1) / sqrt(2).

    Parameters
    ----------
    alpha : array_like, shape (...)
        Beckmann width of the front plane, > 0.
    cos_theta : array_like, shape (...)
        Cosine of v or l, in (0, 1].
    ior : array_like, shape (...)
        Index of refraction of the sheet, >= 1.

    Returns
    -------
    ndarray, shape (...)
        Not clamped: it grows without bound towards grazing.
    """
    c, ior = np.asarray(cos_theta, dtype=float), _index(ior)
    bend = np.sqrt(np.square(ior) - 1.0 + np.square(c)) - c
    return np.asarray(np.asarray(alpha, dtype=float) * bend / (np.sqrt(2.0) * c))


def _share(d: Array, ior: Array, backing: str) -> Array:
    return effective_area(d) * face_reflectance(d, ior, backing)


def _corner_axes(d: Array, rotation: Array) -> Array:
    """Components of a local direction along a corner's edges, which lean by acos(1 / sqrt 3) from the normal."""
    azimuths = rotation[..., None] + np.array([0.0, 2.0, 4.0]) * (np.pi / 3.0)
    leaning = d[..., 0, None] * np.cos(azimuths) + d[..., 1, None] * np.sin(azimuths)
    return np.asarray(d[..., 2, None] / np.sqrt(3.0) + np.sqrt(2.0 / 3.0) * leaning)


def _index(ior: ArrayLike) -> Array:
    ior = np.asarray(ior, dtype=float)
    if not np.all(ior >= 1.0):
        msg = f"ior must be >= 1, got {np.min(ior):g}; it is the index of the sheet relative to the air before it"
        raise ValueError(msg)
    return ior
