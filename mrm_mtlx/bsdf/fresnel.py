"""Reflectance of a smooth interface. All functions work element by element and broadcast."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.intermediates import EXACT

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.intermediates import Intermediates

# The F82 curve is anchored where the cosine is 1/7, about 82 degrees (Hoffman 2023; Kutz et al. 2021).
COS_82 = 1.0 / 7.0
_TINT_SCALE = 1.0 / (COS_82 * (1.0 - COS_82) ** 6)


def tint_shape(cos_theta: ArrayLike) -> Array:
    """c (1 - c)^6, scaled to 1 at cosine 1/7: the shape of the tint in `generalized_schlick`; (...), in [0, 1]."""
    c = np.asarray(cos_theta, dtype=float)
    return np.asarray(_TINT_SCALE * c * (1.0 - c) ** 6)


def dielectric_polarized(cos_theta: ArrayLike, eta: ArrayLike) -> tuple[Array, Array]:
    """Reflectances (parallel, perpendicular) of an interface between dielectrics; 1 under total internal reflection.

        r_s = (c - g) / (c + g)        r_p = (eta^2 c - g) / (eta^2 c + g)        g = sqrt(eta^2 - sin^2)

    (Born and Wolf, section 1.5.2.)

    Parameters
    ----------
    cos_theta : array_like, shape (...)
        Cosine of the incidence angle, in [0, 1].
    eta : array_like, shape (...)
        Index of refraction of the far side over that of the near side, > 0.

    Returns
    -------
    tuple of ndarray, shape (...)
        In [0, 1].
    """
    c, eta2 = np.asarray(cos_theta, dtype=float), np.square(np.asarray(eta, dtype=float))
    g = np.sqrt(np.maximum(eta2 - 1.0 + np.square(c), 0.0))
    with np.errstate(invalid="ignore"):
        parallel = np.square((eta2 * c - g) / (eta2 * c + g))
        perpendicular = np.square((c - g) / (c + g))
    # At c = g = 0 (grazing under total reflection) the quotients are 0/0; the limit is 1.
    return np.where(np.isnan(parallel), 1.0, parallel), np.where(np.isnan(perpendicular), 1.0, perpendicular)


def dielectric(cos_theta: ArrayLike, eta: ArrayLike) -> Array:
    """Unpolarised reflectance of an interface between dielectrics, shape (...), in [0, 1].

    Examples
    --------
    >>> round(float(dielectric(1.0, 1.5)), 6)
    0.04
    """
    parallel, perpendicular = dielectric_polarized(cos_theta, eta)
    return 0.5 * (parallel + perpendicular)


def conductor_polarized(
    cos_theta: ArrayLike, ior: ArrayLike, extinction: ArrayLike, *, intermediates: Intermediates = EXACT
) -> tuple[Array, Array]:
    """Reflectances (parallel, perpendicular) of a metal with complex index ior + i extinction.

    With a^2 + b^2 = |(ior + i extinction)^2 - sin^2| and a the real part of its root (Born and Wolf, section 14.2;
    Lagarde 2013, "Memo on Fresnel equations"):

        R_s = (a^2 + b^2 - 2 a c + c^2) / (a^2 + b^2 + 2 a c + c^2)
        R_p = R_s (c^2 (a^2 + b^2) - 2 a c s^2 + s^4) / (c^2 (a^2 + b^2) + 2 a c s^2 + s^4)

    Parameters
    ----------
    cos_theta : array_like, shape (...)
        Cosine of the incidence angle, in [0, 1].
    ior, extinction : array_like, shape (...)
        Real and imaginary part of the index, relative to the near side, >= 0 and not both 0.
    intermediates
        Has the modulus a^2 + b^2, from which a^2 is left by cancellation.

    Returns
    -------
    tuple of ndarray, shape (...)
        In [0, 1].
    """
    c = np.asarray(cos_theta, dtype=float)
    c2 = c * c
    s2 = 1.0 - c2
    n2, k2 = np.square(ior), np.square(extinction)
    real = n2 - k2 - s2
    modulus = intermediates.modulus(np.sqrt(real * real + 4.0 * n2 * k2))
    ac = np.sqrt(np.maximum(2.0 * (modulus + real), 0.0)) * c  # 2 a c
    sum_s = modulus + c2
    perpendicular = (sum_s - ac) / (sum_s + ac)
    sum_p = c2 * modulus + s2 * s2
    ac *= s2
    return perpendicular * (sum_p - ac) / (sum_p + ac), perpendicular


def conductor(
    cos_theta: ArrayLike, ior: ArrayLike, extinction: ArrayLike, *, intermediates: Intermediates = EXACT
) -> Array:
    """Unpolarised reflectance of a metal, shape (...), in [0, 1]; parameters as `conductor_polarized`.

    Examples
    --------
    >>> round(float(conductor(1.0, 0.183, 3.424)), 6)
    0.944221
    """
    parallel, perpendicular = conductor_polarized(cos_theta, ior, extinction, intermediates=intermediates)
    return 0.5 * (parallel + perpendicular)


def generalized_schlick(
    cos_theta: ArrayLike, color0: ArrayLike, color82: ArrayLike, color90: ArrayLike, exponent: ArrayLike
) -> Array:
    """Schlick's curve with free end points, exponent and a tint at 82 degrees (Hoffman 2023; "F82-tint").

        S(c) = F0 + (F90 - F0) (1 - c)^p
        F(c) = S(c) - c (1 - c)^6 (1 - F82) S(1/7) / ((1/7) (6/7)^6)

    Not clamped: a low `color82` can push the curve below zero near 82 degrees (F0 0.19, F82 0: from 71 to 82 degrees).

    Parameters
    ----------
    cos_theta : array_like, shape (...)
        Cosine of the incidence angle, in [0, 1].
    color0, color90 : array_like, shape (...)
        Reflectance at normal and at grazing incidence, in [0, 1].
    color82 : array_like, shape (...)
        Factor on S at cosine 1/7; 1 leaves Schlick's curve.
    exponent : array_like, shape (...)
        p, > 0; 5 is Schlick's.

    Returns
    -------
    ndarray, shape (...)

    Examples
    --------
    >>> bool(abs(generalized_schlick(1 / 7, 0.19, 0.0, 1.0, 5.0)) < 1e-15)
    True
    """
    c = np.asarray(cos_theta, dtype=float)
    rest = 1.0 - c
    color0, rise = np.asarray(color0, dtype=float), np.asarray(color90, dtype=float) - color0
    tint = (color0 + rise * (1.0 - COS_82) ** np.asarray(exponent)) * (1.0 - np.asarray(color82))
    return np.asarray(color0 + rise * rest ** np.asarray(exponent) - tint * tint_shape(c))


def schlick_ior(color0: ArrayLike) -> Array:
    """Index of refraction whose reflectance at normal incidence is `color0`, taken in [0.01, 0.99]; (...), > 1."""
    root = np.sqrt(np.clip(np.asarray(color0, dtype=float), 0.01, 0.99))
    return np.asarray((1.0 + root) / (1.0 - root))


def reflectance_at_normal(ior: ArrayLike) -> Array:
    """Reflectance of a dielectric at normal incidence, ((ior - 1) / (ior + 1))^2; shape (...)."""
    ior = np.asarray(ior, dtype=float)
    return np.asarray(np.square((ior - 1.0) / (ior + 1.0)))
