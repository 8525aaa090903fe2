"""Values that are written in a document: as arrays, and in the unit that is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx
import numpy as np

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# The unit that generators are asked for, see shadergen.generate.
_TARGET_DISTANCE = "meter"


def numbers(element: Any) -> Array:
    """The value of an element as `nodes.Value` has it: a boolean, or numbers with the component first."""
    kind, value = element.getType(), element.getValue()
    if kind == "boolean":
        return np.asarray(bool(value))
    if kind in ("integer", "float"):
        return np.asarray(float(value))
    if kind.startswith("matrix"):
        size = range(value.numRows())
        return np.array([[[value[row, column]] for column in size] for row in size])
    return np.array([[x] for x in value.asTuple()])


def nothing_given(kind: str) -> Array | None:
    """The value that generators give an input that has none anywhere: zeros, a matrix of unity; None for closures."""
    if kind.startswith("matrix"):
        return np.eye(int(kind[-1]))[:, :, None]
    if kind.startswith(("color", "vector")):
        return np.zeros((int(kind[-1]), 1))
    return np.asarray(False) if kind == "boolean" else np.zeros(()) if kind in ("float", "integer") else None


def unit_scale(element: Any, declared: Any) -> float:
    """Factor from the unit that a number is given in to the one it is wanted in, as MaterialX's generators convert it.

    That is the unit of the definition, or for distances without one the metre.
    """
    given, kind = element.getUnit(), declared.getUnitType() or element.getUnitType()
    wanted = declared.getUnit() or (_TARGET_DISTANCE if kind == "distance" else "")
    if not given or not wanted or given == wanted:
        return 1.0
    units = _unit_scales(element.getDocument(), kind)
    return units[given] / units[wanted]


def _unit_scales(document: Any, kind: str) -> dict[str, float]:
    converter = mx.LinearUnitConverter.create(document.getUnitTypeDef(kind))
    return dict(converter.getUnitScale())
