"""Vectors from channels, channels from vectors, and numbers from other types."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.nodes.tables import CHANNELS, MATRICES, define, scalar, vector

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


def _extracted(in_: Array, index: Array) -> Array:
    """One channel of a vector, or one row of a matrix; the nearest that there is, where GLSL leaves it undefined."""
    chosen = np.clip(index.astype(int), 0, len(in_) - 1)
    if chosen.ndim == 0:
        return scalar(in_[chosen])
    places = np.expand_dims(chosen, tuple(range(in_.ndim - 1)))
    return np.asarray(np.take_along_axis(in_, places, axis=0)[0])


define({"extract": _extracted}, (*CHANNELS[1:], *MATRICES))

define({"combine2": lambda in1, in2: vector(in1, in2)}, ("vector2",))
define({"combine2": lambda in1, in2: vector(*in1, in2)}, ("color4CF", "vector4VF"))
define({"combine2": lambda in1, in2: vector(*in1, *in2)}, ("vector4VV",))
define({"combine3": lambda in1, in2, in3: vector(in1, in2, in3)}, ("color3", "vector3"))
define({"combine4": lambda in1, in2, in3, in4: vector(in1, in2, in3, in4)}, ("color4", "vector4"))

define({"convert": lambda in_: np.asarray(in_, dtype=float)}, ("boolean_float", "integer_float"))
