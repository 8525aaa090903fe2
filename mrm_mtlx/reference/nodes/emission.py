"""Nodes of emitted light: EDFs, colours of radiance towards the viewer, and how they are put together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures import EPSILON
from mrm_mtlx.reference.closures.light import dot
from mrm_mtlx.reference.float32.precision import power_error, widened
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, UNIT, Quantity
from mrm_mtlx.reference.nodes.registry import node

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs, Value


@node("ND_uniform_edf")
def _uniform(inputs: Inputs) -> Value:
    return inputs.array("color")


@node("ND_generalized_schlick_edf")
def _generalized_schlick(inputs: Inputs) -> Value:
    """An EDF times Schlick's curve from `color0` to `color90`, about the surface's own normal."""
    light, exponent = inputs.light, inputs.array("exponent")
    normal = inputs.frame["Nworld"]
    cos_v = np.abs(dot(normal, light.v))
    color0, color90 = inputs.array("color0"), inputs.array("color90")
    x = 1.0 - np.clip(cos_v, EPSILON, 1.0)

    def factor(lost: float = 0.0, power: Array | float = 0.0) -> Array:
        rise = np.clip(x + lost, 0.0, 1.0) ** exponent + power
        return np.asarray(color0 * (1.0 - rise) + color90 * rise)

    # 1 - n.v cancels where the surface is seen along its normal.
    errors: dict[Quantity, dict[str, Array | float]] = {
        Quantity.REFLECTANCE: {"lost": ROUNDING_FACTOR * UNIT},
        Quantity.FUNCTIONS: {"power": ROUNDING_FACTOR * power_error(x, exponent, fast=False)},
    }
    given = next((errors[quantity] for quantity in errors if light.perturbs(quantity)), {})
    return np.asarray(inputs.emission("base") * widened(factor, **given))


@node("ND_mix_edf")
def _mix(inputs: Inputs) -> Value:
    amount = inputs.array("mix")
    return inputs.emission("bg") * (1.0 - amount) + inputs.emission("fg") * amount


@node("ND_add_edf")
def _add(inputs: Inputs) -> Value:
    return inputs.emission("in1") + inputs.emission("in2")


@node("ND_multiply_edfF", "ND_multiply_edfC")
def _multiply(inputs: Inputs) -> Value:
    return inputs.emission("in1") * inputs.array("in2")
