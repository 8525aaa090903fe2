"""Arithmetic and functions of each channel, and sums of matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.float32.function_errors import arc, displaced, exponential, power, sine_error, tangent_error
from mrm_mtlx.reference.nodes.tables import CHANNELS, MATRICES, VECTORS, WITH_FLOAT, define

if TYPE_CHECKING:
    from mrm_mtlx.reference.nodes.tables import Table

_SUMS: Table = {
    "add": lambda in1, in2: in1 + in2,
    "subtract": lambda in1, in2: in1 - in2,
}
define(_SUMS, (*CHANNELS, *WITH_FLOAT, "integer", *MATRICES, *(f"{kind}FA" for kind in MATRICES)))

_OF_TWO: Table = {
    "multiply": lambda in1, in2: in1 * in2,
    "divide": lambda in1, in2: in1 / in2,
    "modulo": lambda inputs, in1, in2: in1 - in2 * inputs.discrete(np.floor(in1 / in2)),
    "power": lambda inputs, in1, in2: power(inputs, in1, in2),
    "invert": lambda in_, amount: amount - in_,
    "min": lambda in1, in2: np.minimum(in1, in2),
    "max": lambda in1, in2: np.maximum(in1, in2),
    "clamp": lambda in_, low, high: np.minimum(np.maximum(in_, low), high),
}
define(_OF_TWO, (*CHANNELS, *WITH_FLOAT))

# GLSL leaves open to which side it rounds what is half-way.
_WHOLE: Table = {
    "floor": lambda inputs, in_: inputs.discrete(np.floor(in_)),
    "ceil": lambda inputs, in_: inputs.discrete(np.ceil(in_)),
    "round": lambda inputs, in_: inputs.discrete(np.round(in_)),
}
define(_WHOLE, (*CHANNELS, "integer"))

_OF_ONE: Table = {
    "fract": lambda inputs, in_: in_ - inputs.discrete(np.floor(in_)),
    "absval": lambda in_: np.abs(in_),
    "sign": lambda inputs, in_: inputs.discrete(np.sign(in_)),
}
define(_OF_ONE, CHANNELS)

# Arguments that rounding takes across the end of a function's domain stay at the end.
_FUNCTIONS: Table = {
    "sin": lambda inputs, in_: displaced(inputs, np.sin(in_), sine_error(in_)),
    "cos": lambda inputs, in_: displaced(inputs, np.cos(in_), sine_error(in_)),
    "tan": lambda inputs, in_: displaced(inputs, np.tan(in_), tangent_error(in_)),
    "asin": lambda inputs, in_: arc(inputs, np.arcsin(np.clip(in_, -1.0, 1.0))),
    "acos": lambda inputs, in_: arc(inputs, np.arccos(np.clip(in_, -1.0, 1.0))),
    "atan2": lambda inputs, iny, inx: arc(inputs, np.arctan2(iny, inx)),
    "sqrt": lambda in_: np.sqrt(np.maximum(in_, 0.0)),
    "ln": lambda in_: np.log(in_),
    "exp": lambda inputs, in_: exponential(inputs, np.exp(in_)),
}
define(_FUNCTIONS, ("float", *VECTORS))
