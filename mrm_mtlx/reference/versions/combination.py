"""What shaders take for the throughput of BSDFs that are put together, by version of MaterialX.

The reference has what MaterialX has since 1.39.4: where albedos add, as they do in a sum, what is let through is
t1 + t2 - 1; a factor on a response takes nothing off it; and two layers let the product through.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# Of two throughputs, or of a throughput and a factor, to what they make together; they broadcast.
Rule: TypeAlias = "Callable[[Array, Array], Array]"


def albedos_add(first: Array, second: Array) -> Array:
    """What two BSDFs let through whose albedos add, t1 + t2 - 1, not below 0."""
    return np.maximum(first + second - 1.0, 0.0)


def product(first: Array, second: Array) -> Array:
    """The product: of layers, what both let through."""
    return first * second


def total(first: Array, second: Array) -> Array:
    """The sum, which is above 1 for BSDFs that let most of the light through."""
    return first + second


def unchanged(throughput: Array, _factor: Array) -> Array:
    """The throughput itself."""
    return throughput


@dataclass(frozen=True)
class Throughputs:
    """The throughput of a sum, of a BSDF times a factor, of two layers, and of a BSDF over a medium."""

    added: Rule
    multiplied: Rule
    layered: Rule
    over_medium: Rule


SPECIFIED = Throughputs(albedos_add, unchanged, product, product)
