"""The shading frame, and normals from maps and heights. Object, model and world space are the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.float32.function_errors import summed
from mrm_mtlx.reference.nodes.tables import define

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table


_FRAME: Table = {
    "position": lambda inputs: inputs.frame["Pworld"],
    "normal": lambda inputs: inputs.frame["Nworld"],
    "tangent": lambda inputs: inputs.frame["Tworld"],
    "bitangent": lambda inputs: inputs.frame["Bworld"],
    "viewdirection": lambda inputs: inputs.frame["Vworld"],  # from the eye to the surface
    "heighttonormal": lambda: np.array([[0.5], [0.5], [1.0]]),  # samples have no neighbours of another height
}
define(_FRAME, ("vector3",))


def _mapped(inputs: Inputs, in_: Array, scale: Array, normal: Array, tangent: Array, bitangent: Array) -> Array:
    """The normal that a map encodes as 0.5 + 0.5 n; black encodes n itself."""
    black = np.all(in_ == 0.0, axis=0)
    x, y, z = summed(inputs, np.stack(np.broadcast_arrays(2.0 * np.where(black, [[0.5], [0.5], [1.0]], in_), -1.0)))
    scale_x, scale_y = (scale, scale) if scale.ndim < 2 else scale
    parts = np.broadcast_arrays(tangent * (x * scale_x), bitangent * (y * scale_y), normal * z)
    return unit(summed(inputs, np.stack(parts)))


define({"normalmap": _mapped}, ("float", "vector2"))
