"""Sources of values: constants, geometric properties, the application; and nodes that pass values on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.nodes.tables import CHANNELS, MATRICES, define, vector

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table

_VALUES: Table = {
    "constant": lambda value: value,
    "dot": lambda in_: in_,
}
define(_VALUES, (*CHANNELS, "boolean", "integer", *MATRICES))

_OF_TEXTS: Table = {
    "constant": lambda inputs: inputs.text("value"),
    "dot": lambda inputs: inputs.text("in"),
    "geompropvalueuniform": lambda inputs: inputs.text("default"),  # samples have numbers alone
}
define(_OF_TEXTS, ("string", "filename"))

define({"dot": lambda inputs: inputs.shader("in")}, ("surfaceshader",))


def _property(inputs: Inputs) -> Array:
    name, default = inputs.text("geomprop"), inputs.array("default")
    return inputs.geometric_property(name, default)


# An evaluation rounds properties like any number; whole ones stay whole.
define({"geompropvalue": _property}, CHANNELS)
define({"geompropvalue": lambda inputs: np.round(_property(inputs))}, ("integer",))
define({"geompropvalue": lambda inputs: np.not_equal(_property(inputs), 0.0)}, ("boolean",))

# Vertices are white in the engines, and every set of texture coordinates is the same.
define({"geomcolor": lambda: np.asarray(1.0)}, ("float",))
define({"geomcolor": lambda: np.ones((3, 1))}, ("color3",))
define({"geomcolor": lambda: np.ones((4, 1))}, ("color4",))
define({"texcoord": lambda inputs: inputs.frame["UV0"]}, ("vector2",))
define({"texcoord": lambda inputs: vector(*inputs.frame["UV0"], np.asarray(0.0))}, ("vector3",))

# The specification's defaults, for hosts that have no frames.
_APPLICATION: Table = {
    "frame": lambda: np.asarray(1.0),
    "time": lambda: np.asarray(0.0),
}
define(_APPLICATION, ("float",))
