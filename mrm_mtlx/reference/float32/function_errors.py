"""Errors of float32 in the functions of nodes, beyond the rounding of their inputs and of their values.

`Evaluation` perturbs every number of the document and every node's value, a vector as a whole. That leaves two errors:
those of built-in functions that are not precise to a few roundings, and those of sums over a vector's channels, which
cancel. Both are `rounding.Quantity.FUNCTIONS`: a node function gives its value through `displaced`. Errors are per unit
of `rounding.ROUNDING_FACTOR`, which multiplies every perturbation.

exp, log, sqrt, division and normalize need nothing here: their (3 + 2 |x|) ulp, their 2^-21 near 1, and their few ulp
(GLSL 4.60, section 4.7.1) are less than what the rounding of their inputs does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.float32.precision import ARCTANGENT_ERROR, FAST_EXPONENTIAL, SINE_ERROR, power_error
from mrm_mtlx.reference.float32.rounding import CHANNEL_SIGNS, ROUNDING_FACTOR, UNIT, Quantity
from mrm_mtlx.reference.models import Model

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs


def displaced(inputs: Inputs, value: Array, error: Array) -> Array:
    """The value, or where functions are perturbed one that is off by `error`, its channels with several signs."""
    if inputs.light.perturbs(Quantity.FUNCTIONS):
        return value + error
    if value.ndim == 2 and 1 < len(value) <= 4:
        for quantity, signs in CHANNEL_SIGNS.items():
            if inputs.light.perturbs(quantity):
                return np.asarray(value + error * np.array(signs[: len(value)])[:, None])
    return value


def summed(inputs: Inputs, terms: Array) -> Array:
    """The sum over the first axis; its error is relative to the terms and not to the sum, in which they may cancel."""
    return displaced(inputs, np.sum(terms, axis=0), UNIT * np.sum(np.abs(terms), axis=0))


def mixed(inputs: Inputs, at_0: Array, at_1: Array, amount: Array) -> Array:
    """GLSL's mix. Drivers (Mesa) also take at_0 + (at_1 - at_0) amount, which cancels where it is small."""
    value = at_0 * (1.0 - amount) + at_1 * amount
    return displaced(inputs, value, UNIT * (np.abs(at_0) + np.abs(at_1)))


def sine_error(angle: Array) -> Array:
    """Error of sin and cos. An angle of 0 has none: no implementation is known to miss 0 and 1 there."""
    return np.where(angle == 0.0, 0.0, SINE_ERROR / ROUNDING_FACTOR)


def tangent_error(angle: Array) -> Array:
    """Error of tan = sin / cos, (|d sin| cos + |sin| |d cos|) / cos^2."""
    tangent = np.abs(np.tan(angle))
    return sine_error(angle) * (1.0 + tangent) * np.sqrt(1.0 + np.square(tangent))


def arc(inputs: Inputs, angle: Array) -> Array:
    """asin, acos and atan2, which are all built on atan, and may be taken from pi/2: Mesa's asin is, also near 0."""
    return displaced(inputs, angle, ARCTANGENT_ERROR / ROUNDING_FACTOR * np.abs(angle) + UNIT * 0.5 * np.pi)


def exponential(inputs: Inputs, value: Array) -> Array:
    """exp: where it needs anything at all, see `precision.FAST_EXPONENTIAL`."""
    fast = inputs.light.model is Model.CLOSURES
    return displaced(inputs, value, value * FAST_EXPONENTIAL / ROUNDING_FACTOR) if fast else value


def power(inputs: Inputs, base: Array, exponent: Array) -> Array:
    """base ** exponent; 0 for roots of negative numbers, as in OSL: GLSL leaves all their powers undefined."""
    value = np.where((base < 0.0) & (exponent % 1.0 != 0.0), 0.0, np.power(base, exponent))
    return displaced(inputs, value, power_error(base, exponent, fast=inputs.light.model is Model.CLOSURES))
