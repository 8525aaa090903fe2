"""How BSDFs are put together: layered, mixed, added, scaled; each on the pair (response, throughput)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import Closure

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


def layer(top: Closure, base: Closure) -> Closure:
    """Albedo scaling: the base is seen through what the top lets pass."""
    return Closure(top.response + base.response * top.throughput, top.throughput * base.throughput)


def layer_medium(top: Closure, medium: Closure) -> Closure:
    """A BSDF over the medium below its surface, which dims what comes through."""
    return Closure(top.response * medium.throughput, top.throughput * medium.throughput)


def mix(foreground: Closure, background: Closure, amount: Array) -> Closure:
    """`(1 - amount) background + amount foreground`, of response and throughput."""
    rest = 1.0 - amount
    return Closure(
        background.response * rest + foreground.response * amount,
        background.throughput * rest + foreground.throughput * amount,
    )


def add(first: Closure, second: Closure) -> Closure:
    """The sum of two BSDFs; their albedos add, so the throughput is t1 + t2 - 1, not below 0."""
    return Closure(first.response + second.response, np.maximum(first.throughput + second.throughput - 1.0, 0.0))


def multiply(closure: Closure, factor: Array) -> Closure:
    """The response times a factor, clamped to [0, 1]; the throughput stays."""
    return Closure(closure.response * np.clip(factor, 0.0, 1.0), closure.throughput)
