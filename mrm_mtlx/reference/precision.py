"""How far float32 shaders may be off in the quantities that cancel, from the precisions that GLSL and Vulkan state.

Each function gives the error of one quantity per unit of `rounding.ROUNDING_FACTOR`, which multiplies every move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import thin_film
from mrm_mtlx.bsdf.lobes import Rounding
from mrm_mtlx.reference.rounding import ROUNDING_FACTOR, UNIT

if TYPE_CHECKING:
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

# By the name of the moved part, see rounding.PARTS.
ROUNDINGS = {"modulus": Rounding(modulus=ROOT_ERROR), "product": Rounding(product=ROOT_ERROR)}


def amplitude_error(reflectance: Array, cos_theta: Array, ior: Array) -> Array:
    """Error of a dielectric's reflectance per unit roundoff of g^2 = ior^2 + cos^2 - 1, which cancels for ior near 1.

    The amplitude r = (g - c) / (g + c) moves by 2 c dg / (g + c)^2, the reflectance is its square.
    """
    squared = np.square(ior)
    g = np.sqrt(np.maximum(squared - 1.0 + np.square(cos_theta), UNIT))
    moved = cos_theta * UNIT * (squared + 1.0) / (g * np.square(g + cos_theta))
    return np.asarray(2.0 * np.sqrt(reflectance) * moved + moved * moved)


def film_error(reflectance: Array, thickness_nm: Array, *, fast: bool) -> Array | float:
    """Error of a film's reflectance per unit roundoff: its XYZ values, near 1 or below, cancel in the RGB matrix.

    Not relative to a colour that is clamped to 0, which may be a hair above it in float32: relative to the brightest
    channel, and at least to the 0.04 that a bare surface of glass reflects. `fast`: the exponentials are OSL's.
    """
    if not np.any(thickness_nm > 0.0):
        return 0.0
    amplification = np.sum(np.abs(thin_film.XYZ_TO_RGB), axis=1)[:, None]
    amplification = amplification * (UNIT + (FAST_EXPONENTIAL / ROUNDING_FACTOR if fast else 0.0))
    brightest = np.maximum(np.max(reflectance, axis=0, keepdims=True), 0.04)
    return np.asarray(np.where(thickness_nm > 0.0, amplification, 0.0) * brightest)


def power_error(base: Array, exponent: Array, *, fast: bool) -> Array:
    """Error of pow(base, exponent) per unit of `ROUNDING_FACTOR`; `fast` for OSL.

    GLSL 4.60, section 4.7.1: pow(x, y) is exp2(y log2(x)); log2 has an absolute error of 2^-21 or 3 ulp, exp2 one of
    3 + 2 |its argument| ulp. Divided by the factor that multiplies every move.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        argument = np.abs(exponent * np.log2(np.maximum(base, np.finfo(np.float32).tiny)))
        relative = np.log(2.0) * exponent * (2.0**-21) + (3.0 + 2.0 * argument + 3.0 * argument) * 2.0 * UNIT
        power = np.maximum(base, 0.0) ** exponent
    return np.asarray(power * (relative + (FAST_EXPONENTIAL if fast else 0.0)) / ROUNDING_FACTOR)
