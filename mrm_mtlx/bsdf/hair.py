"""The factors of a model of hair fibres (Chiang et al. 2016, over d'Eon et al. 2011).

The papers: "A practical and controllable hair and fur model for production path tracing"; "An energy-conserving hair
reflectance model". Pharr 2016 is "The implementation of a hair scattering model".

A fibre lies along x. `theta` is the angle of a direction from the plane across the fibre, `phi` its azimuth about it,
`gamma` the angle at which a ray meets the fibre's round section; `o` is the viewer's side, `i` the light's. Light takes
paths p = 0 (R, reflected), 1 (TT), 2 (TRT), and 3 for all with more reflections inside (Chiang et al. 2016, eq. 1):

    f(v, l) |cos theta_i| = sum over p of  M_p(theta_o, theta_i) N_p(phi) A_p
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Where log I0 changes from its power series to its asymptotic series, and M_p from one form to the other.
BESSEL_SWITCH = 12.0
VARIANCE_SWITCH = 0.1
# Coefficients of `absorption_fit`, lowest power first; its terms partly cancel.
ABSORPTION_FIT = (5.969, -0.215, 2.532, -10.73, 5.574, 0.245)
# ln 2 as the implementations of M_p write it.
_LN_2 = 0.6931
# Logistic scale per azimuthal scale (Chiang et al. 2016, appendix A).
_LOGISTIC_SCALE = np.sqrt(np.pi / 8.0)


def bessel_i0(x: ArrayLike) -> Array:
    """Modified Bessel function I0, ten terms of its power series, shape (...), >= 1.

    2e-4 of it low at |x| = 8, 2 % at 12, useless beyond.
    """
    quarter = 0.25 * np.square(np.asarray(x, dtype=float))
    term, total = np.ones_like(quarter), np.ones_like(quarter)
    for k in range(1, 10):
        term = term * quarter / (k * k)
        total = total + term
    return np.asarray(total)


def log_bessel_i0(x: ArrayLike, *, switch: ArrayLike = BESSEL_SWITCH) -> Array:
    """log I0(x) for x >= 0, as implementations of the model have it (Pharr 2016), shape (...).

    Good to 2 % of I0. Above `switch` an asymptotic series, of whose second term there is half. Below it, and for every
    negative x, the power series.
    """
    x = np.asarray(x, dtype=float)
    large = np.maximum(x, 1.0)
    asymptotic = large + 0.5 * (-np.log(2.0 * np.pi) - np.log(large) + 1.0 / (8.0 * large))
    return np.where(x > switch, asymptotic, np.log(bessel_i0(x)))


def longitudinal(
    sin_i: ArrayLike,
    cos_i: ArrayLike,
    sin_o: ArrayLike,
    cos_o: ArrayLike,
    variance: ArrayLike,
    *,
    bessel_switch: ArrayLike = BESSEL_SWITCH,
    variance_switch: ArrayLike = VARIANCE_SWITCH,
) -> Array:
    """Longitudinal scattering M_p (d'Eon et al. 2011, eq. 7), shape (...), > 0.

        M_p = exp(-sin_i sin_o / v) I0(cos_i cos_o / v) / (2 v sinh(1 / v))

    evaluated through logarithms for variances below `variance_switch` (Pharr 2016).

    Parameters
    ----------
    sin_i, cos_i, sin_o, cos_o : array_like, shape (...)
        Sines and cosines of theta; cosines >= 0.
    variance : array_like, shape (...)
        v, > 0.
    bessel_switch, variance_switch
        Where the formulas change; each has a step there, of 1.5 % and 5e-5.

    Returns
    -------
    ndarray, shape (...)
        Its integral over theta_i with cos_i is 1, but for the error of `log_bessel_i0` and the digits of ln 2.
    """
    v = np.asarray(variance, dtype=float)
    a = np.asarray(cos_i, dtype=float) * cos_o / v
    b = np.asarray(sin_i, dtype=float) * sin_o / v
    log_i0 = log_bessel_i0(a, switch=bessel_switch)
    narrow = np.exp(log_i0 - b - 1.0 / v + _LN_2 + np.log(0.5 / v))
    inverse = 1.0 / np.maximum(v, 0.5 * VARIANCE_SWITCH)  # so that nothing overflows where the other form is taken
    rough_b = np.clip(b, -inverse, inverse)
    rough = np.exp(-rough_b) * bessel_i0(a) / (2.0 * v * np.sinh(inverse))
    return np.asarray(np.where(v < variance_switch, narrow, rough))


def azimuthal(phi: ArrayLike, scale: ArrayLike) -> Array:
    """Azimuthal scattering N_p at an angle phi from the path's own azimuth, shape (...), 1/rad.

    A logistic distribution trimmed to [-pi, pi] (Chiang et al. 2016, appendix A), whose integral over a full turn is 1.
    """
    s = logistic_scale(scale)
    return trimmed_logistic(np.exp(-angle_between(phi) / s), s)


def logistic_scale(scale: ArrayLike) -> Array:
    """Scale s of the logistic distribution in `azimuthal`, shape (...)."""
    return np.asarray(np.asarray(scale, dtype=float) * _LOGISTIC_SCALE)


def angle_between(phi: ArrayLike) -> Array:
    """The smaller of the two angles that a difference of azimuths makes, shape (...), in [0, pi]."""
    return np.asarray(np.abs(np.remainder(np.asarray(phi, dtype=float) + np.pi, 2.0 * np.pi) - np.pi))


def trimmed_logistic(falling: ArrayLike, s: Array) -> Array:
    """Density of `azimuthal` at an angle x of which `falling` is exp(-x / s), shape (...), 1/rad."""
    falling = np.asarray(falling, dtype=float)
    trimmed = 1.0 / (1.0 + np.exp(-np.pi / s)) - 1.0 / (1.0 + np.exp(np.minimum(np.pi / s, 700.0)))
    return np.asarray(falling / (s * np.square(1.0 + falling)) / trimmed)


def exit_azimuth(path: int, gamma_o: ArrayLike, gamma_t: ArrayLike) -> Array:
    """Azimuth at which a path leaves, 2 p gamma_t - 2 gamma_o + p pi (Marschner et al. 2003, eq. 2), shape (...)."""
    return np.asarray(2.0 * path * np.asarray(gamma_t) - 2.0 * np.asarray(gamma_o) + path * np.pi)


def attenuations(reflectance: ArrayLike, transmittance: ArrayLike) -> tuple[Array, Array, Array, Array]:
    """Shares A_p of light on the four paths (Chiang et al. 2016, section 3; Pharr 2016).

        f,  (1 - f)^2 T,  (1 - f)^2 T^2 f,  (1 - f)^2 T^3 f^2 / (1 - T f)

    Parameters
    ----------
    reflectance : array_like, shape (...)
        Fresnel reflectance f of the surface, in [0, 1].
    transmittance : array_like, broadcasts against it
        T of one crossing of the fibre, in [0, 1].

    Returns
    -------
    tuple of ndarray
        Their sum is 1 if T is 1.
    """
    f, t = np.asarray(reflectance, dtype=float), np.asarray(transmittance, dtype=float)
    through = np.square(1.0 - f) * t
    returned = through * t * f
    # Where nothing enters and nothing is absorbed, 0 / 0; nothing is left.
    lost = np.where(t * f < 1.0, 1.0 - t * f, 1.0)
    return f, through, returned, np.asarray(returned * t * f / lost)


def variances(
    longitudinal_roughness: ArrayLike,
    azimuthal_roughness: ArrayLike,
    *,
    high_powers: tuple[ArrayLike, ArrayLike] | None = None,
) -> tuple[Array, Array]:
    """Variance v of M_p and scale of N_p from roughnesses (Chiang et al. 2016, section 4.1), shape (...).

        v = (0.726 r + 0.812 r^2 + 3.7 r^20)^2        s = 0.265 r + 1.194 r^2 + 5.372 r^22

    Parameters
    ----------
    longitudinal_roughness, azimuthal_roughness : array_like, shape (...)
        In (0, 1].
    high_powers
        r^20 and r^22, where they are known.
    """
    l, a = np.asarray(longitudinal_roughness, dtype=float), np.asarray(azimuthal_roughness, dtype=float)
    l20, a22 = (l**20, a**22) if high_powers is None else map(np.asarray, high_powers)
    return np.square(0.726 * l + 0.812 * l * l + 3.7 * l20), np.asarray(0.265 * a + 1.194 * a * a + 5.372 * a22)


def absorption_fit(azimuthal_roughness: ArrayLike) -> Array:
    """Denominator of the absorption that gives a colour (Chiang et al. 2016, section 4.2), shape (...).

    sigma_a = (ln C / (5.969 - 0.215 r + 2.532 r^2 - 10.73 r^3 + 5.574 r^4 + 0.245 r^5))^2
    """
    return np.asarray(np.polynomial.polynomial.polyval(np.asarray(azimuthal_roughness, dtype=float), ABSORPTION_FIT))
