"""Sheen of cloth: the lobe of Conty and Kulla 2017, and that of Zeltner, Burley and Chiang 2022.

"Production friendly microfacet sheen BRDF"; "Practical multiple-scattering sheen using linearly transformed cosines".
The rational fits are those of MaterialX 1.39.5 (mx_microfacet_sheen.glsl).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Roughness below which the exponent of the distribution grows no more, and the range of the fits of the second lobe.
LEAST_FIBRE_ROUGHNESS = 0.005
LEAST_LTC_ROUGHNESS = 0.01

# Fit of the directional albedo in c = n.v, r = roughness. Rows: numerator and denominator; columns: the monomials
# 1, c, r, c r, c^2, r^2.
_ALBEDO = np.array(
    [
        [13.67300, -68.78018, 799.08825, -905.00061, 60.28956, 1086.96473],
        [1.0, 61.57746, 442.78211, 2597.49308, 121.81241, 3045.55075],
    ]
)


def fibre_distribution(sin2_h: ArrayLike, roughness: ArrayLike) -> Array:
    """Distribution of facet normals about the tangent plane (Conty and Kulla 2017, eq. 2), shape (...), 1/sr.

        D = (2 + 1/r) sin^(1/r) / (2 pi)

    Parameters
    ----------
    sin2_h : array_like, shape (...)
        Squared sine between facet normal and n, in [0, 1].
    roughness : array_like, shape (...)
        r; below 0.005 it is taken as that.

    Examples
    --------
    >>> round(float(fibre_distribution(1.0, 0.5) * 2 * np.pi), 12)
    4.0
    """
    inverse = fibre_exponent(roughness)
    return np.asarray((2.0 + inverse) * np.asarray(sin2_h, dtype=float) ** (0.5 * inverse) / (2.0 * np.pi))


def fibre_exponent(roughness: ArrayLike) -> Array:
    """Exponent 1/r of the sine in `fibre_distribution`, shape (...), at most 200."""
    return np.asarray(1.0 / np.maximum(np.asarray(roughness, dtype=float), LEAST_FIBRE_ROUGHNESS))


def fibre_visibility(cos_v: ArrayLike, cos_l: ArrayLike) -> Array:
    """What stands for masking and 1 / (4 n.v n.l): 1 / (4 (n.l + n.v - n.l n.v)) (Neubelt and Pettineo 2013); (...)."""
    cos_v, cos_l = np.asarray(cos_v, dtype=float), np.asarray(cos_l, dtype=float)
    return np.asarray(0.25 / (cos_l + cos_v - cos_l * cos_v))


def fibre_albedo(cos_v: ArrayLike, roughness: ArrayLike, *, rounding: float = 0.0) -> Array:
    """Directional albedo of the lobe `fibre_distribution` * `fibre_visibility`, a rational fit, shape (...), in [0, 1].

    Below zero, which the fit's numerator is for small roughness near n.v 0.5, it is 0. `rounding` is a relative error
    given to each of the fit's terms, which partly cancel, so that the result is the largest possible.
    """
    above, below = _sums(_ALBEDO, cos_v, roughness)
    ratio = above / below
    if rounding:
        big_above, big_below = _sums(np.abs(_ALBEDO), cos_v, roughness)
        ratio = ratio + rounding * (big_above + np.abs(ratio) * big_below) / below
    return np.clip(ratio, 0.0, 1.0)


def _sums(coefficients: Array, cos_v: ArrayLike, roughness: ArrayLike) -> list[Array]:
    c, r = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
    monomials = (1.0, c, r, c * r, c * c, r * r)
    return [np.asarray(sum(float(k) * m for k, m in zip(row, monomials, strict=True))) for row in coefficients]


def ltc_density(x: ArrayLike, y: ArrayLike, z: ArrayLike, a: ArrayLike, b: ArrayLike) -> Array:
    """Density of a linearly transformed cosine (Heitz et al. 2016, eq. 1) in direction (x, y, z), shape (...), 1/sr.

        wo = (a x + b z, a y, z)        D = max(z, 0) a^2 / (pi |wo|^4)

    Parameters
    ----------
    x, y, z : array_like, shape (...)
        Components of a unit direction; z along n, x in the plane of n and v on v's side.
    a, b : array_like, shape (...)
        Coefficients of the inverse transformation, `ltc_scale` and `ltc_shear`; a > 0.

    Returns
    -------
    ndarray, shape (...)
        The integral over the hemisphere is 1; the cosine of l is included.

    Examples
    --------
    >>> round(float(ltc_density(0.0, 0.0, 1.0, 1.0, 0.0) * np.pi), 12)
    1.0
    """
    x, y, z, a = (np.asarray(w, dtype=float) for w in (x, y, z, a))
    squared = np.square(a * x + np.asarray(b) * z) + np.square(a * y) + np.square(z)
    return np.asarray(np.maximum(z, 0.0) / np.pi * np.square(a / squared))


def ltc_scale(cos_v: ArrayLike, roughness: ArrayLike) -> Array:
    """Coefficient a of the transformation (Zeltner et al. 2022, section 3), a rational fit, shape (...), > 0."""
    x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
    return np.asarray((2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y))


def ltc_shear(cos_v: ArrayLike, roughness: ArrayLike, *, lost: ArrayLike = 0.0) -> Array:
    """Coefficient b of the transformation, a rational fit times sqrt(1 - n.v), shape (...), <= 0.

    `lost` is added to 1 - n.v, which cancels near the normal; 0 is exact.
    """
    x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
    root = np.sqrt(np.maximum(1.0 - x + np.asarray(lost), 0.0))
    return np.asarray(root * (y - 1.0) * y**3 / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y))


def ltc_albedo(
    cos_v: ArrayLike, roughness: ArrayLike, *, rounding: float = 0.0, exponential_error: float = 0.0
) -> Array:
    """Directional albedo of the lobe: a Gaussian in n.v with fitted width s, mean m and offset o, shape (...).

        exp(-((n.v - m) / s)^2 / 2) / (s sqrt(2 pi)) + o

    The offset's fit is below zero, to -2e-5, for roughness from 0.04 to 0.13. `rounding` is a relative error given to
    each term of the fits, `exponential_error` one given to the exponential per unit of its exponent plus one, so that
    the result is the largest possible.
    """
    x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
    s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    m = _quotient(y, (-0.193854, -1.14885, 1.7932, 0.0, -0.95943), (0.046391, 1.0))
    o = _quotient(y, (0.000654023, -0.0207818, 0.119681), (1.26264, -1.92021, 1.0))
    exponent = 0.5 * np.square((x - m[0]) / s)
    # Of the exponent: the mean's error in units of s, and s itself, which has no terms that cancel but enters squared.
    moved = rounding * (np.sqrt(2.0 * exponent) * (m[1] + np.abs(x)) / s + 2.0 * exponent)
    peak = np.exp(-exponent) / (s * np.sqrt(2.0 * np.pi))
    return np.asarray(peak * (np.exp(moved) + exponential_error * (1.0 + exponent)) + o[0] + rounding * o[1])


def _quotient(y: Array, above: tuple[float, ...], below: tuple[float, ...]) -> tuple[Array, Array]:
    """y times a quotient of polynomials in y, and its absolute error per relative error of their terms."""
    p, q = (np.polynomial.polynomial.polyval(y, c) for c in (above, below))
    big_p, big_q = (np.polynomial.polynomial.polyval(y, np.abs(c)) for c in (above, below))
    value = y * p / q
    return np.asarray(value), np.asarray(np.abs(y * big_p / q) + np.abs(value) * big_q / np.abs(q))
