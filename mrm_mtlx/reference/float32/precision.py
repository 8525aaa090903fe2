"""Errors of float32 shaders in the quantities that cancel, from the precisions that GLSL and Vulkan state.

Errors are given per unit of `rounding.ROUNDING_FACTOR`, which multiplies every perturbation; those for `widened`, which
divides by it, in full.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import thin_film
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, UNIT

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# Relative error of acos: 4096 ulp (an ulp is two units), by Vulkan 1.3, "Precision and Operation of SPIR-V
# Instructions" (acos is built on atan2); GLSL gives no bound.
ARCCOS_ERROR = 4096.0 * 2.0 * UNIT / ROUNDING_FACTOR

# Relative error of what is left under a square root by cancellation: 2 ulp of the root before it, by GLSL 4.60, section
# 4.7.1, and as many roundings of the squares that it adds.
ROOT_ERROR = 8.0 * UNIT / ROUNDING_FACTOR

# Relative error of exp and pow in OSL, which uses OpenImageIO's fast approximations and states none. Over 60,000
# arguments 1.6e-5 was measured (tests/engines/test_osl_measure.py measures it again), and three quarters more are
# allowed.
FAST_EXPONENTIAL = 2.8e-5

# In full, for `widened`. An ulp is two units. Of sin and cos Vulkan 1.3 (as above) bounds the absolute error, for
# arguments in [-pi, pi]; beyond, nothing is stated and the same is taken. That of atan2, asin and acos is relative.
ULP = 2.0 * UNIT
SINE_ERROR = 2.0**-11
ARCTANGENT_ERROR = 4096.0 * ULP


def amplitude_error(reflectance: Array, cos_theta: Array, ior: Array) -> Array:
    """Error of a dielectric's reflectance per unit roundoff of g^2 = ior^2 + cos^2 - 1, which cancels for ior near 1.

    The amplitude r = (g - c) / (g + c) changes by 2 c dg / (g + c)^2, the reflectance is its square.
    """
    squared = np.square(ior)
    g = np.sqrt(np.maximum(squared - 1.0 + np.square(cos_theta), UNIT))
    change = cos_theta * UNIT * (squared + 1.0) / (g * np.square(g + cos_theta))
    return np.asarray(2.0 * np.sqrt(reflectance) * change + change * change)


def half_vector_error(v: Array, l: Array) -> Array:
    """Error of a component of the half-vector across itself, in full, shape (samples,).

    The roundings of both directions along three axes, over the length of their sum: near v = -l, nothing else is left
    of it.
    """
    return np.asarray(2.0 * np.sqrt(3.0) * ROUNDING_FACTOR * UNIT / np.sqrt(np.sum(np.square(v + l), axis=0)))


def film_error(reflectance: Array, thickness_nm: Array, *, fast: bool) -> Array | float:
    """Error of a film's reflectance per unit roundoff: its XYZ values, near 1 or below, cancel in the RGB matrix.

    Not relative to a colour that is clamped to 0, which may be a hair above it in float32: relative to the brightest
    channel, and at least to the 0.04 that a bare surface of glass reflects. `fast`: the exponentials are OSL's.
    """
    if not np.any(thickness_nm > 0.0):
        return 0.0
    amplification = np.sum(np.abs(thin_film.XYZ_TO_RGB), axis=1).reshape(-1, *(1,) * (reflectance.ndim - 1))
    amplification = amplification * (UNIT + (FAST_EXPONENTIAL / ROUNDING_FACTOR if fast else 0.0))
    brightest = np.maximum(np.max(reflectance, axis=0, keepdims=True), 0.04)
    return np.asarray(np.where(thickness_nm > 0.0, amplification, 0.0) * brightest)


def power_error(base: Array, exponent: Array, *, fast: bool) -> Array:
    """Error of pow(base, exponent) per unit of `ROUNDING_FACTOR`; `fast` for OSL.

    GLSL 4.60, section 4.7.1: pow(x, y) is exp2(y log2(x)); log2 has an absolute error of 2^-21 or 3 ulp, exp2 one of
    3 + 2 |its argument| ulp. Divided by the factor that multiplies every perturbation.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        argument = np.abs(exponent * np.log2(np.maximum(base, np.finfo(np.float32).tiny)))
        relative = np.log(2.0) * np.abs(exponent) * (2.0**-21) + (3.0 + 2.0 * argument + 3.0 * argument) * 2.0 * UNIT
        power = np.maximum(base, 0.0) ** exponent
    return np.asarray(power * (relative + (FAST_EXPONENTIAL if fast else 0.0)) / ROUNDING_FACTOR)


def widened(function: Callable[..., Array], **errors: Array | float) -> Array:
    """A result with all that errors of intermediate quantities may add to it, per unit of `ROUNDING_FACTOR`.

    Each quantity is taken to either edge of its error, in full, since the result may bend within it; the larger changes
    of all are added, so that none cancels another. Always upward: what errs together must not look as if it cancelled.

    Parameters
    ----------
    function
        Takes displacements of its intermediate results by name, all 0 by default; called with one of them at a time.
    errors
        Largest errors of the quantities, by the name of the displacement.

    Examples
    --------
    >>> float(widened(lambda x=0.0: 1.0 - (2.0 + x) ** 2, x=0.5)) * ROUNDING_FACTOR == -3.0 * ROUNDING_FACTOR + 2.25
    True
    """
    exact = function()
    change = np.zeros(np.shape(exact))
    for name, error in errors.items():
        to_edges = (np.abs(function(**{name: edge}) - exact) for edge in (error, -np.asarray(error)))
        change = change + np.maximum(*to_edges)
    return np.asarray(exact + change / ROUNDING_FACTOR)


def exponential_error(argument: Array) -> Array:
    """Relative error of exp, in full: 3 + 2 |argument| ulp (GLSL 4.60, section 4.7.1)."""
    return np.asarray((3.0 + 2.0 * np.abs(argument)) * ULP)


def logarithm_error(argument: Array) -> Array:
    """Absolute error of log, in full: 3 ulp outside [0.5, 2], 2^-21 inside (GLSL 4.60, section 4.7.1)."""
    argument = np.asarray(argument, dtype=float)
    inside = (argument >= 0.5) & (argument <= 2.0)
    safe = np.maximum(argument, np.finfo(np.float32).tiny)
    return np.where(inside, 2.0**-21, 3.0 * ULP * np.abs(np.log(safe)))
