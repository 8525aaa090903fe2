"""Directional albedo of the GGX lobe, and the compensation for the energy that single scattering loses.

The albedo is the rational fit that MaterialX uses by default, so that compensated lobes of both agree. A
retroreflective lobe has the albedo of the ordinary one (Portsmouth et al. 2026, eq. 18): no table is added for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Rational fit in x = n.v, y = alpha (MaterialX 1.39.5, mx_microfacet_specular.glsl). Rows: the monomials below;
# columns: numerators of the factors on F0 and on F90, then their denominators.
_FIT = np.array(
    [
        [0.1003, 0.9345, 1.0, 1.0],
        [-0.6303, -2.323, -1.765, 0.2281],
        [9.748, 2.229, 8.263, 15.94],
        [-2.038, -3.748, 11.53, -55.83],
        [29.34, 1.424, 28.96, 13.08],
        [-8.245, -0.7684, -7.507, 41.26],
        [-26.44, 1.436, -36.11, 54.9],
        [19.99, 0.2913, 15.86, 300.2],
        [-5.448, 0.6286, 33.37, -285.1],
    ]
)


def _monomials(x: Array, y: Array) -> tuple[Array, ...]:
    x2, y2 = x * x, y * y
    return (np.ones_like(x * y), x, y, x * y, x2, y2, x2 * y, x * y2, x2 * y2)


def _sums(coefficients: Array, cos_v: ArrayLike, alpha: ArrayLike) -> list[Array]:
    monomials = _monomials(np.asarray(cos_v, dtype=float), np.asarray(alpha, dtype=float))
    # Plain sums, column by column: a product with the monomials stacked would copy them all.
    return [
        sum((float(c) * m for c, m in zip(column, monomials, strict=True)), start=np.zeros(()))
        for column in coefficients.T
    ]


def albedo_factors(cos_v: ArrayLike, alpha: ArrayLike) -> tuple[Array, Array]:
    """Factors A and B with directional albedo = A F0 + B F90, for a Schlick curve of exponent 5.

    Parameters
    ----------
    cos_v : array_like, shape (...)
        n.v, in [0, 1].
    alpha : array_like, shape (...)
        Isotropic width, in [0, 1].

    Returns
    -------
    tuple of ndarray, shape (...)
        Each in [0, 1].
    """
    a, b, under_a, under_b = _sums(_FIT, cos_v, alpha)
    return np.clip(a / under_a, 0.0, 1.0), np.clip(b / under_b, 0.0, 1.0)


def albedo_condition(cos_v: ArrayLike, alpha: ArrayLike) -> Array:
    """How far rounding of its terms moves A + B: the absolute error per unit of relative rounding of each term.

    The fit's polynomials cancel (terms up to 300 add to a value near 1), so that float32 arithmetic loses digits here.
    Shape (...), >= 0.
    """
    a, b, under_a, under_b = _sums(_FIT, cos_v, alpha)
    big = _sums(np.abs(_FIT), cos_v, alpha)
    error_a = (big[0] + np.abs(a / under_a) * big[2]) / np.abs(under_a)
    error_b = (big[1] + np.abs(b / under_b) * big[3]) / np.abs(under_b)
    return np.asarray(error_a + error_b)


def white_albedo(cos_v: ArrayLike, alpha: ArrayLike) -> Array:
    """Share of the light that a lobe with reflectance 1 returns by single scattering, A + B; shape (...), in (0, 1]."""
    a, b = albedo_factors(cos_v, alpha)
    return a + b


def compensation(reflectance: ArrayLike, white: ArrayLike) -> Array:
    """Factor that gives multiply scattered light back, 1 + F (1 - Ess) / Ess (Turquin 2019, eq. 14 and 16).

    `reflectance` is F, `white` the `white_albedo` Ess; broadcast.
    """
    white = np.asarray(white, dtype=float)
    return np.asarray(1.0 + np.asarray(reflectance) * ((1.0 - white) / white))
