"""Compositing: blends, merges by alpha, masks. F and f are the foreground's channel and alpha, B and b the other's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures import EPSILON
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.function_errors import mixed, summed
from mrm_mtlx.reference.nodes.tables import CHANNELS, define, vector

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table

_COLORS = ("float", "color3", "color4")


def _mix(result: Array, bg: Array, mix: Array) -> Array:
    return result * mix + bg * (1.0 - mix)


def _mixed(function: Callable[..., Array]) -> Callable[..., Array]:
    """The function of fg and bg, mixed with bg."""

    def blend(inputs: Inputs, fg: Array, bg: Array, mix: Array) -> Array:
        return _mix(function(inputs, fg, bg), bg, mix)

    return blend


def _from_one(inputs: Inputs, a: Array) -> Array:
    """1 - a, whose error is relative to 1 also where it is near 0."""
    return summed(inputs, np.stack(np.broadcast_arrays(1.0, -a)))


def _burn(inputs: Inputs, fg: Array, bg: Array, mix: Array) -> Array:
    """1 - (1 - B) / F; 0 where there is no F to divide by."""
    return _divided(inputs, _from_one(inputs, (1.0 - bg) / fg), np.less(np.abs(fg), EPSILON), bg, mix)


def _dodge(inputs: Inputs, fg: Array, bg: Array, mix: Array) -> Array:
    """B / (1 - F); 0 where there is no 1 - F to divide by."""
    nothing = inputs.discrete(np.less(np.abs(1.0 - fg), EPSILON))
    return _divided(inputs, bg / (1.0 - fg), nothing, bg, mix)


def _divided(inputs: Inputs, quotient: Array, nothing: Array, bg: Array, mix: Array) -> Array:
    mixed = _mix(np.where(nothing, 0.0, quotient), bg, mix)
    if np.any(nothing) and inputs.deviates(Deviation.UNMIXED_ZERO):
        return np.where(nothing, 0.0, mixed)
    return mixed


_BLENDS: Mapping[str, Callable[..., Array]] = {
    "plus": lambda _inputs, fg, bg: bg + fg,
    "minus": lambda _inputs, fg, bg: bg - fg,
    "difference": lambda _inputs, fg, bg: np.abs(bg - fg),
    "screen": lambda inputs, fg, bg: _from_one(inputs, (1.0 - fg) * (1.0 - bg)),
}
define({name: _mixed(function) for name, function in _BLENDS.items()}, _COLORS)
define({"burn": _burn, "dodge": _dodge}, _COLORS)


def _times_alpha(in_: Array) -> Array:
    return vector(*(in_[:3] * in_[3]), in_[3])


def _over_alpha(in_: Array) -> Array:
    return vector(*np.where(in_[3] == 0.0, in_[:3], in_[:3] / in_[3]), in_[3])


def _disjoint_over(_inputs: Inputs, fg: Array, bg: Array) -> Array:
    """F + B, or F + B (1 - f) / b where the alphas overlap; there black where b is 0."""
    alpha = fg[3] + bg[3]
    apart = alpha <= 1.0
    share = np.where(apart, 1.0, (1.0 - fg[3]) / bg[3])
    color = np.where(~apart & (np.abs(bg[3]) < EPSILON), 0.0, fg[:3] + bg[:3] * share)
    return vector(*color, np.minimum(alpha, 1.0))


_MERGES: Mapping[str, Callable[..., Array]] = {
    "in": lambda _inputs, fg, bg: fg * bg[3],
    "out": lambda _inputs, fg, bg: fg * (1.0 - bg[3]),
    "mask": lambda _inputs, fg, bg: bg * fg[3],
    "over": lambda _inputs, fg, bg: fg + bg * (1.0 - fg[3]),
    "matte": lambda _inputs, fg, bg: _times_alpha(fg) + bg * (1.0 - fg[3]),
    "disjointover": _disjoint_over,
}
define({name: _mixed(function) for name, function in _MERGES.items()}, ("color4",))
define({"premult": _times_alpha, "unpremult": _over_alpha}, ("color4",))

_MASKS: Table = {
    "inside": lambda in_, mask: in_ * mask,
    "outside": lambda in_, mask: in_ * (1.0 - mask),
}
define(_MASKS, _COLORS)

define(
    {"mix": lambda inputs, fg, bg, mix: mixed(inputs, bg, fg, mix)},
    (*CHANNELS, *(f"{kind}_{kind}" for kind in CHANNELS[1:])),
)
