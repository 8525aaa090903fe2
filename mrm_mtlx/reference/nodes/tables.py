"""Tables of node functions: what a category of nodes computes, once for all of its types."""

from __future__ import annotations

from functools import wraps
from inspect import signature
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mrm_mtlx.reference.nodes.registry import node

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs, NodeFunction, Value

Table: TypeAlias = "Mapping[str, Callable[..., Value]]"

# Types of the standard library's nodes, as their definitions are named. FA: a vector, and floats for all its channels.
VECTORS = ("vector2", "vector3", "vector4")
CHANNELS = ("float", "color3", "color4", *VECTORS)
WITH_FLOAT = tuple(f"{kind}FA" for kind in CHANNELS[1:])
MATRICES = ("matrix33", "matrix44")


def define(table: Table, kinds: Iterable[str]) -> None:
    """Register each category's function under its node definitions of these types.

    A function's arguments are the node's inputs of the same names ("in_" is the input "in"); an argument "inputs" is
    the node's `Inputs`.
    """
    for category, function in table.items():
        node(*(f"ND_{category}_{kind}" for kind in kinds))(_of_inputs(function))


def _of_inputs(function: Callable[..., Value]) -> NodeFunction:
    names = [name.removesuffix("_") for name in signature(function).parameters]

    @wraps(function)
    def evaluate(inputs: Inputs) -> Value:
        return function(*(inputs if name == "inputs" else inputs.array(name) for name in names))

    return evaluate


def vector(*components: Array) -> Array:
    """Scalars as a vector, shape (components, 1) or (components, samples)."""
    return np.stack(np.broadcast_arrays(*(np.atleast_1d(component) for component in components)))


def scalar(values: Array) -> Array:
    """A scalar, shape (samples,), or () where it is the same at all samples."""
    return values.reshape(()) if values.shape == (1,) else values
