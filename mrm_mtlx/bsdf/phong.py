"""Phong microfacets: distribution of normals, Smith masking, sampling of (visible) normals.

The same functions as `ggx`. In slopes, Phong's cosine power is Student's distribution with nu = p + 2 degrees of
freedom,

    D(m) mz^4 = nu / (2 pi) (1 + x^2 + y^2)^(-(nu + 2) / 2)        x, y: slopes

which gives Smith's masking and the visible normals exactly, where the literature takes Beckmann's (Walter et al. 2007,
section 5.2). Widths along two axes stretch the slopes, as they do for GGX and Beckmann (Heitz 2014): with
one width this is Phong's, with two it is not the exponent of Ashikhmin and Shirley, whose masking has no closed form.
The functions of Student's distribution are SciPy's, loaded when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import slopes
from mrm_mtlx.bsdf.ggx import from_slopes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# asinh of the largest slope, over its width, that is told from infinity.
_TAIL = 40.0


def exponent(alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Phong's p = 2 / alpha^2 - 2 (Walter et al. 2007, section 5.2), alpha^2 = alpha_x alpha_y; (...), >= 0."""
    return np.asarray(2.0 / (np.asarray(alpha_x, dtype=float) * alpha_y) - 2.0)


def distribution(mx: ArrayLike, my: ArrayLike, mz: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Density of facet normals; with one width (p + 2) / (2 pi) mz^p (Walter et al. 2007, eq. 30).

    Parameters and result as `ggx.distribution`; 0 where mz is 0.

    Examples
    --------
    >>> round(float(distribution(0.6, 0.0, 0.8, 0.5, 0.5)), 6)  # p = 6: 8 / (2 pi) 0.8^6
    0.333772
    """
    nu, ratio = exponent(alpha_x, alpha_y) + 2.0, np.asarray(alpha_y, dtype=float) / alpha_x
    mz = np.asarray(mz, dtype=float)
    safe = np.where(mz > 0.0, mz, 1.0)
    squares = ratio * np.square(np.asarray(mx) / safe) + np.square(np.asarray(my) / safe) / ratio
    density = nu / (2.0 * np.pi) * np.exp(-0.5 * (nu + 2.0) * np.log1p(squares) - 4.0 * np.log(safe))
    return np.asarray(np.where(mz > 0.0, density, 0.0))


def smith_lambda(x: ArrayLike, y: ArrayLike, z: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Smith's Lambda of a direction for Phong, from the distribution p of slopes along it (Heitz 2014, section 5).

        Lambda = 1/c * integral of (q - c) p(q) dq above c        c: cotangent of the stretched direction

    Parameters and result as `ggx.smith_lambda`.
    """
    nu, ratio = exponent(alpha_x, alpha_y) + 2.0, np.asarray(alpha_y, dtype=float) / alpha_x
    across = np.sqrt(np.square(x) / ratio + np.square(y) * ratio)
    with np.errstate(divide="ignore"):
        end = np.arcsinh(np.sqrt(nu) * np.asarray(z, dtype=float) / across)
    s = np.minimum(end, _TAIL)
    student = _student(nu)
    above = student.moment(s) - student.slope(s) * student.cumulative(-s)
    return np.asarray(np.where(end < _TAIL, np.maximum(above / student.slope(s), 0.0), 0.0))


def sample_normal(u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals with density D(m) mz (Walter et al. 2007, eq. 31-32); as `ggx.sample_normal`."""
    nu, stretch = exponent(alpha_x, alpha_y) + 2.0, np.sqrt(np.asarray(alpha_x, dtype=float) / alpha_y)
    # Slope r from (1 + r^2)^(-nu / 2) = 1 - u.
    radius = np.sqrt(np.expm1(-2.0 / nu * np.log1p(-np.asarray(u1, dtype=float))))
    phi = 2.0 * np.pi * np.asarray(u2)
    return from_slopes(stretch * radius * np.cos(phi), radius * np.sin(phi) / stretch)


def sample_visible(v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Facet normals that `v` sees (Heitz and d'Eon 2014), by numerical inversion; as `ggx.sample_visible`."""
    from scipy import special

    nu, stretch = exponent(alpha_x, alpha_y) + 2.0, np.sqrt(np.asarray(alpha_x, dtype=float) / alpha_y)
    cos_theta, sin_theta, cos_phi, sin_phi = slopes.seen_along_x(v, stretch, 1.0 / stretch)
    u1, u2 = np.asarray(u1, dtype=float), np.asarray(u2, dtype=float)
    with np.errstate(divide="ignore"):
        end = np.minimum(np.arcsinh(np.sqrt(nu) * (cos_theta / sin_theta)), _TAIL)
    q = slopes.sample_visible(u1, cos_theta, sin_theta, np.broadcast_to(end, u1.shape), _student(nu))
    # Across, given q: Student with one more degree of freedom, wider by sqrt(1 + q^2).
    t = special.stdtrit(nu + 1.0, np.maximum(u2, slopes.LEAST))
    r = t * np.sqrt((1.0 + q * q) / (nu + 1.0))
    return from_slopes(stretch * (cos_phi * q - sin_phi * r), (sin_phi * q + cos_phi * r) / stretch)


def _student(nu: Array) -> slopes.Marginal:
    """Density C (1 + q^2)^(-(nu + 1) / 2) of one slope; C = Gamma((nu + 1) / 2) / (sqrt(pi) Gamma(nu / 2)).

    The parameter is s = asinh(q sqrt(nu)): the tails fall by powers.
    """
    from scipy import special

    scale = 1.0 / np.sqrt(nu)
    constant = 1.0 / special.beta(0.5, 0.5 * nu)

    def power(s: Array, by: Array) -> Array:
        return np.asarray(np.exp(-by * np.log1p(np.square(np.sinh(s) * scale))))

    return slopes.Marginal(
        slope=lambda s: np.sinh(s) * scale,
        cumulative=lambda s: special.stdtr(nu, np.sinh(s)),
        moment=lambda s: constant / (nu - 1.0) * power(s, 0.5 * (nu - 1.0)),
        density=lambda s: constant * power(s, 0.5 * (nu + 1.0)) * np.cosh(s) * scale,
        lowest=-_TAIL,
    )
