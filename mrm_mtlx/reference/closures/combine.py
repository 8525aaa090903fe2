"""BSDFs put together: layered, mixed, added, scaled; each on the pair (response, throughput)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import Closure
from mrm_mtlx.reference.models import NOTHING, Contents, Feature, Model
from mrm_mtlx.reference.versions.combination import SPECIFIED, Throughputs

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

_LAYER = Contents(features=frozenset({Feature.LAYER}))


def layer(top: Closure, base: Closure, model: Model = Model.HARDWARE, throughputs: Throughputs = SPECIFIED) -> Closure:
    """Albedo scaling: the base is seen through what the top lets pass.

    Renderers of OSL scale by albedos of their own, so that only a top that is not there is the same with them.
    """
    contents = top.contents | base.contents
    if model is Model.CLOSURES and np.any(top.throughput != 1.0):
        contents |= _LAYER
    throughput = throughputs.layered(top.throughput, base.throughput)
    return Closure(top.response + base.response * top.throughput, throughput, contents)


def layer_medium(
    top: Closure, medium: Closure, model: Model = Model.HARDWARE, throughputs: Throughputs = SPECIFIED
) -> Closure:
    """A BSDF over the medium below its surface, which dims what comes through."""
    contents = top.contents | _LAYER if model is Model.CLOSURES else top.contents
    throughput = throughputs.over_medium(top.throughput, medium.throughput)
    return Closure(top.response * medium.throughput, throughput, contents)


def mix(foreground: Closure, background: Closure, amount: Array) -> Closure:
    """`(1 - amount) background + amount foreground`, of response and throughput."""
    rest = 1.0 - amount
    return Closure(
        background.response * rest + foreground.response * amount,
        background.throughput * rest + foreground.throughput * amount,
        _seen(foreground, amount) | _seen(background, rest),
    )


def premultiplied_mix(foreground: Closure, background: Closure, amount: Array, weighted: tuple[bool, bool]) -> Closure:
    """`mix` as `Deviation.PREMULTIPLIED_MIX` has it; `weighted` says which of the two have a weight to multiply."""
    parts = _premultiplied(foreground, amount, weighted[0]), _premultiplied(background, 1.0 - amount, weighted[1])
    return add(*parts)


def _premultiplied(closure: Closure, amount: Array, weighted: bool) -> Closure:
    """A BSDF whose weight is multiplied, and below 0 is none; one without a weight is multiplied itself.

    One that is opaque stays so at any weight.
    """
    if not weighted:
        return multiply(closure, amount)
    weight = np.maximum(amount, 0.0)
    dimmed = closure.throughput if np.all(closure.throughput == 0.0) else 1.0 - weight * (1.0 - closure.throughput)
    return Closure(closure.response * weight, np.asarray(dimmed), _seen(closure, weight))


def add(first: Closure, second: Closure, throughputs: Throughputs = SPECIFIED) -> Closure:
    """The sum of two BSDFs; their albedos add."""
    throughput = throughputs.added(first.throughput, second.throughput)
    return Closure(first.response + second.response, throughput, first.contents | second.contents)


def multiply(closure: Closure, factor: Array, throughputs: Throughputs = SPECIFIED) -> Closure:
    """The response times a factor, clamped to [0, 1]; the throughput stays."""
    tint = np.clip(factor, 0.0, 1.0)
    return Closure(closure.response * tint, throughputs.multiplied(closure.throughput, tint), _seen(closure, tint))


def _seen(closure: Closure, amount: Array) -> Contents:
    return closure.contents if np.any(amount != 0.0) else NOTHING
