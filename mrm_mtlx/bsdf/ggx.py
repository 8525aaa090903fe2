"""GGX microfacets: distribution of normals, height-correlated Smith masking, sampling of (visible) normals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


def distribution(mx: ArrayLike, my: ArrayLike, mz: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Density of facet normals, anisotropic GGX (Burley 2012, eq. 13; Walter et al. 2007, eq. 33).

        D(m) = 1 / (pi ax ay ((mx/ax)^2 + (my/ay)^2 + mz^2)^2)

    Parameters
    ----------
    mx, my, mz : array_like, shape (...)
        Components of the unit facet normal in the local frame.
    alpha_x, alpha_y : array_like, shape (...)
        Widths along x and y, > 0.

    Returns
    -------
    ndarray, shape (...)
        [1/sr]; the integral of D(m) mz over the hemisphere is 1.

    Examples
    --------
    >>> round(float(distribution(0.0, 0.0, 1.0, 0.5, 0.5)), 4)
    1.2732
    """
    alpha_x, alpha_y = np.asarray(alpha_x, dtype=float), np.asarray(alpha_y, dtype=float)
    slope = np.square(np.asarray(mx) / alpha_x) + np.square(np.asarray(my) / alpha_y) + np.square(np.asarray(mz))
    return np.asarray(1.0 / (np.pi * alpha_x * alpha_y * np.square(slope)))


def smith_lambda(x: ArrayLike, y: ArrayLike, z: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Smith's Lambda of a direction for GGX (Heitz 2014, eq. 72, 86): (-1 + sqrt(1 + a^2 tan^2)) / 2.

    `x, y, z` are the direction's components, z > 0; `a^2 tan^2 = (ax^2 x^2 + ay^2 y^2) / z^2`. Shape (...), >= 0.
    """
    stretched = np.square(np.asarray(alpha_x) * x) + np.square(np.asarray(alpha_y) * y)
    return np.asarray(0.5 * (np.sqrt(1.0 + stretched / np.square(np.asarray(z, dtype=float))) - 1.0))


def masking_shadowing(lambda_v: ArrayLike, lambda_l: ArrayLike) -> Array:
    """Height-correlated masking and shadowing, G2 = 1 / (1 + Lambda(v) + Lambda(l)) (Heitz 2014, eq. 99); in (0, 1]."""
    return np.asarray(1.0 / (1.0 + np.asarray(lambda_v) + np.asarray(lambda_l)))


def masking_shadowing_isotropic(cos_v: ArrayLike, cos_l: ArrayLike, alpha: ArrayLike) -> Array:
    """Height-correlated G2 for one width, from the cosines alone (Heitz 2014, eq. 72 and 99).

    The same function as `masking_shadowing` of the two `smith_lambda`, multiplied through by the cosines, so that it
    stays finite where a cosine vanishes. Shape (...), in [0, 1].
    """
    cos_v, cos_l, squared = np.asarray(cos_v, dtype=float), np.asarray(cos_l, dtype=float), np.square(alpha)
    root_v = np.sqrt(squared + (1.0 - squared) * np.square(cos_v))
    root_l = np.sqrt(squared + (1.0 - squared) * np.square(cos_l))
    return np.asarray(2.0 * cos_v * cos_l / (root_l * cos_v + root_v * cos_l))


def sample_normal(u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals with density D(m) mz (Walter et al. 2007, eq. 35-36), components first; u in [0, 1); (3, ...)."""
    u1, phi = np.asarray(u1, dtype=float), 2.0 * np.pi * np.asarray(u2)
    radius = np.sqrt(u1 / (1.0 - u1))
    return from_slopes(np.asarray(alpha_x) * radius * np.cos(phi), np.asarray(alpha_y) * radius * np.sin(phi))


def sample_visible(v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals that `v` sees, with density D_v(m) = G1(v) <v.m> D(m) / (n.v), components first, (3, ...).

    In the space where the facets are a hemisphere, the half-vectors of v and of directions uniform on a spherical cap
    (Dupuy and Benyoub 2023). v is unit with z >= 0; u in [0, 1).
    """
    return _cap_normal(v, u1, u2, alpha_x, alpha_y, 1.0)


def sample_bounded(v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """As `sample_visible`, on the smaller cap of Eto and Tokuyoshi (2023), which fewer reflections leave downwards.

    Their density is `bounded_density`. It holds for reflected directions alone.
    """
    return _cap_normal(v, u1, u2, alpha_x, alpha_y, _cap_bound(v, alpha_x, alpha_y))


def bounded_density(v: Array, d: Array, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Density of directions reflected by `sample_bounded` [1/sr], where D of their half-vector is `d`; shape (...).

        D(h) / (2 (k n.v + sqrt((ax vx)^2 + (ay vy)^2 + vz^2)))         (Eto and Tokuyoshi 2023)

    With k = 1 it is that of all visible normals, D_v(h) / (4 v.h).
    """
    stretched = np.sqrt(np.square(alpha_x * v[0]) + np.square(alpha_y * v[1]) + np.square(v[2]))
    return np.asarray(d / (2.0 * (_cap_bound(v, alpha_x, alpha_y) * v[2] + stretched)))


def from_slopes(x: Array, y: Array) -> Array:
    """Unit normals (-x, -y, 1) / |...| of facets with slopes x and y, components first, (3, ...)."""
    z = 1.0 / np.sqrt(1.0 + x * x + y * y)
    return np.stack(np.broadcast_arrays(-x * z, -y * z, z))


def _cap_bound(v: Array, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """k, by which the cap is lower than the whole one (Eto and Tokuyoshi 2023); in (0, 1]."""
    a2 = np.square(np.minimum(alpha_x, alpha_y))
    s2 = np.square(1.0 + np.sqrt(v[0] * v[0] + v[1] * v[1]))
    return np.asarray((1.0 - a2) * s2 / (s2 + a2 * np.square(v[2])))


def _cap_normal(
    v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike, bound: ArrayLike
) -> Array:
    stretched = np.stack([alpha_x * v[0], alpha_y * v[1], np.broadcast_to(v[2], v[0].shape)])
    stretched /= np.sqrt(np.sum(np.square(stretched), axis=0))
    phi = 2.0 * np.pi * np.asarray(u2)
    # The height on the cap, 1 - u (1 + k vz): its complement keeps the digits of narrow lobes.
    fall = np.asarray(u1) * (1.0 + bound * stretched[2])
    sine = np.sqrt(np.clip(fall * (2.0 - fall), 0.0, 1.0))
    m = np.stack([stretched[0] + sine * np.cos(phi), stretched[1] + sine * np.sin(phi), stretched[2] + 1.0 - fall])
    m = np.stack([alpha_x * m[0], alpha_y * m[1], np.maximum(m[2], 0.0)])
    return np.asarray(m / np.sqrt(np.sum(np.square(m), axis=0)))
