"""Beckmann microfacets (Gaussian slopes): distribution of normals, Smith masking, sampling of (visible) normals.

The same functions as `ggx`. The error function is SciPy's, loaded when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import slopes
from mrm_mtlx.bsdf.ggx import from_slopes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Slope over width beyond which a Gaussian holds nothing that double precision could add: exp(-7^2) < 1e-21.
_TAIL = 7.0


def distribution(mx: ArrayLike, my: ArrayLike, mz: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Density of facet normals, anisotropic Beckmann (Walter et al. 2007, eq. 25, with stretched slopes).

        D(m) = exp(-((mx/ax)^2 + (my/ay)^2) / mz^2) / (pi ax ay mz^4)

    Parameters and result as `ggx.distribution`; 0 where mz is 0.

    Examples
    --------
    >>> round(float(distribution(0.0, 0.0, 1.0, 0.5, 0.5)), 4)
    1.2732
    """
    z2 = np.square(np.asarray(mz, dtype=float))
    tilted = np.square(np.asarray(mx) / np.asarray(alpha_x)) + np.square(np.asarray(my) / np.asarray(alpha_y))
    safe = np.where(z2 > 0.0, z2, 1.0)
    density = np.exp(-tilted / safe) / (np.pi * np.asarray(alpha_x, dtype=float) * np.asarray(alpha_y) * safe * safe)
    return np.asarray(np.where(z2 > 0.0, density, 0.0))


def smith_lambda(x: ArrayLike, y: ArrayLike, z: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Smith's Lambda of a direction for Beckmann (Heitz 2014, eq. 66), exact, not the usual rational fit.

        Lambda = (exp(-a^2) / (a sqrt(pi)) - erfc(a)) / 2        a = z / sqrt(ax^2 x^2 + ay^2 y^2)

    Parameters and result as `ggx.smith_lambda`.
    """
    from scipy import special

    across = np.sqrt(np.square(np.asarray(alpha_x) * x) + np.square(np.asarray(alpha_y) * y))
    with np.errstate(divide="ignore"):
        a = np.asarray(z, dtype=float) / across  # infinite where the direction is n, and Lambda 0
    with np.errstate(invalid="ignore", over="ignore"):
        rest = np.exp(-a * a) / (np.sqrt(np.pi) * a) - special.erfc(a)
    return np.asarray(np.maximum(0.5 * rest, 0.0))


def sample_normal(u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals with density D(m) mz (Walter et al. 2007, eq. 28-29); as `ggx.sample_normal`."""
    radius, phi = np.sqrt(-np.log1p(-np.asarray(u1, dtype=float))), 2.0 * np.pi * np.asarray(u2)
    return from_slopes(np.asarray(alpha_x) * radius * np.cos(phi), np.asarray(alpha_y) * radius * np.sin(phi))


def sample_visible(v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals that `v` sees (Heitz and d'Eon 2014), by numerical inversion; as `ggx.sample_visible`."""
    from scipy import special

    cos_theta, sin_theta, cos_phi, sin_phi = slopes.seen_along_x(v, np.asarray(alpha_x), np.asarray(alpha_y))
    u1, u2 = np.asarray(u1, dtype=float), np.asarray(u2, dtype=float)
    marginal = slopes.Marginal(
        slope=lambda s: s,
        cumulative=lambda s: 0.5 * special.erfc(-s),
        moment=lambda s: np.exp(-s * s) * (0.5 / np.sqrt(np.pi)),
        density=lambda s: np.exp(-s * s) / np.sqrt(np.pi),
        lowest=-_TAIL,
    )
    end = np.broadcast_to(
        np.minimum(cos_theta, _TAIL * sin_theta) / np.where(sin_theta > 0.0, sin_theta, 1.0), u1.shape
    )
    end = np.where(cos_theta >= _TAIL * sin_theta, _TAIL, end)
    q = slopes.sample_visible(u1, cos_theta, sin_theta, end, marginal)
    # Across, the slope is Gaussian whatever q: variance 1/2. u2 = 0 would be infinite.
    r = special.erfinv(2.0 * np.maximum(u2, np.finfo(float).tiny) - 1.0).clip(-_TAIL, _TAIL)
    return from_slopes(alpha_x * (cos_phi * q - sin_phi * r), alpha_y * (sin_phi * q + cos_phi * r))
