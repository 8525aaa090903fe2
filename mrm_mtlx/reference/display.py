"""The picture of a renderable element: the colour of a surface, or the value of any other output as a colour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.nodes import ShaderValue

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes import Value

# Types of what reflects light; everything else is a pattern, shown as it is.
SHADERS = ("surfaceshader", "material")
# Channels of each type of pattern that generators show; only the last have an alpha of their own, elsewhere it is 1.
CHANNELS = {
    **dict.fromkeys(("float", "integer", "boolean", "vector2", "vector3", "color3"), 3),
    **dict.fromkeys(("vector4", "color4"), 4),
}


def displayed(value: Value | None, kind: str) -> Array:
    """Colour that a shader writes for the value of an element of this type, shape (channels, 1) or (channels, samples).

    A number is a grey, a vector2 has no blue; nothing, as of a material without a shader, is black.
    """
    if kind in SHADERS:
        return value.color if isinstance(value, ShaderValue) else np.zeros((3, 1))
    numbers = np.atleast_2d(np.asarray(value, dtype=float))
    if kind == "vector2":
        return np.concatenate([numbers, np.zeros_like(numbers[:1])])
    return np.broadcast_to(numbers, (CHANNELS[kind], numbers.shape[-1]))
