"""Comparisons, what they choose, and logic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.nodes.tables import CHANNELS, MATRICES, define

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table

_COMPARISONS = {"ifgreater": np.greater, "ifgreatereq": np.greater_equal, "ifequal": np.equal}


def _chosen(comparison: Callable[..., Array]) -> Callable[..., Array]:
    def choose(inputs: Inputs, value1: Array, value2: Array, in1: Array, in2: Array) -> Array:
        return np.where(inputs.discrete(comparison(value1, value2)), in1, in2)

    return choose


def _compared(comparison: Callable[..., Array]) -> Callable[..., Array]:
    def compare(inputs: Inputs, value1: Array, value2: Array) -> Array:
        return inputs.discrete(comparison(value1, value2))

    return compare


_KINDS = (*CHANNELS, "integer", *MATRICES)

# Suffixes of the definitions by what is compared: floats, integers; and booleans, of which only equality is asked.
for _suffix, _names in {"": _COMPARISONS, "I": _COMPARISONS, "B": ("ifequal",)}.items():
    define({name: _chosen(_COMPARISONS[name]) for name in _names}, [f"{kind}{_suffix}" for kind in _KINDS])
    define({name: _compared(_COMPARISONS[name]) for name in _names}, [f"boolean{_suffix}"])

_LOGIC: Table = {
    "and": lambda in1, in2: np.logical_and(in1, in2),
    "or": lambda in1, in2: np.logical_or(in1, in2),
    "not": lambda in_: np.logical_not(in_),
}
for _name, _function in _LOGIC.items():
    define({"logical": _function}, (_name,))
