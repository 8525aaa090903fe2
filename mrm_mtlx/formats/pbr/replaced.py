"""What stands for an input that has no form: its mean, where that can be evaluated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.formats.pbr.directions import points, upper
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.reference import input_at

if TYPE_CHECKING:
    from mrm_mtlx.formats.pbr.placement import InexpressibleError

# Directions, and places of each: the mean of a pattern of stripes is met to a few hundredths.
_DIRECTIONS, _PLACES, _SEED = 4, 256, 7


class Replaced(NamedTuple):
    """What stands for an input that has no form, None for the model's own default, and why it has none."""

    value: Term | None
    reason: str


def replaced(node: Any, name: str, error: InexpressibleError) -> Replaced:
    """The mean of a node's input over the surface, in the place of what has no form because of an error.

    There is none of what depends on images or on geometric properties, or is no number.
    """
    directions = upper(np.random.default_rng(_SEED), _DIRECTIONS, 0.0)
    found = input_at(node, name, points(directions, directions[::-1], _PLACES, _SEED))
    if found is None or found.dtype.kind != "f" or not np.all(np.isfinite(found)):
        return Replaced(None, str(error))
    mean = np.array([float(f"{x:.4g}") for x in found.mean(axis=1)])
    shown = ", ".join(f"{x:g}" for x in mean)
    return Replaced(Term.constant(mean), f"{error}; its mean, {shown}, stands for it")
