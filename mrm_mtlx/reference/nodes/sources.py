"""Where values come from: constants and geometric properties."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.reference.nodes.registry import node

if TYPE_CHECKING:
    from mrm_mtlx.reference.nodes.registry import Inputs, Value

_CONSTANTS = ("float", "color3", "color4", "vector2", "vector3", "vector4", "boolean", "integer")


@node(*(f"ND_constant_{kind}" for kind in _CONSTANTS))
def _constant(inputs: Inputs) -> Value:
    return inputs.array("value")


@node(*(f"ND_geompropvalue_{kind}" for kind in ("float", "color3", "vector2", "vector3", "integer", "boolean")))
def _geometric_property(inputs: Inputs) -> Value:
    name = inputs.text("geomprop")
    return inputs.properties[name] if name in inputs.properties else inputs.array("default")
