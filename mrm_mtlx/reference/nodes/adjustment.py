"""Adjustments of values, and colours by hue, saturation and value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.function_errors import displaced, summed
from mrm_mtlx.reference.float32.rounding import UNIT
from mrm_mtlx.reference.nodes.tables import CHANNELS, WITH_FLOAT, define, vector

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table

# Below this saturation MaterialX's targets, as OSL, take a colour to be grey.
_GREY = 1e-4


def _smoothstep(in_: Array, low: Array, high: Array) -> Array:
    """Hermite's step from low to high; where there is nothing between them, a hard step at high."""
    t = (in_ - low) / (high - low)
    return np.where(in_ >= high, 1.0, np.where(in_ <= low, 0.0, t * t * (3.0 - 2.0 * t)))


def _luminance(inputs: Inputs, in_: Array, lumacoeffs: Array) -> Array:
    luminance = summed(inputs, in_[:3] * lumacoeffs)
    return vector(luminance, luminance, luminance, *in_[3:])


def _hsv(inputs: Inputs, in_: Array) -> Array:
    """Hue, saturation and value (Smith 1978, "Color Gamut Transform Pairs"); the hue of grey is 0."""
    red, green, blue = in_[:3]
    high, low = np.max(in_[:3], axis=0), np.min(in_[:3], axis=0)
    chroma, size = high - low, np.sum(np.abs(in_[:3]), axis=0)
    colored = (high > 0.0) & (chroma > 0.0)
    span, top = np.where(colored, chroma, 1.0), np.where(colored, high, 1.0)
    sixths = np.select(
        [red >= high, green >= high],
        [(green - blue) / span, 2.0 + (blue - red) / span],
        4.0 + (red - green) / span,
    )
    hue = np.where(colored, sixths / 6.0, 0.0)
    # Moved towards 0, across which it jumps to 1.
    hue = displaced(inputs, hue, np.where(colored, -np.copysign(UNIT * size / (3.0 * span), hue), 0.0))
    saturation = displaced(inputs, chroma / top, np.where(colored, UNIT * size / top, 0.0))
    hue = hue + inputs.discrete(np.less(hue, 0.0))
    return vector(hue, np.where(colored, saturation, 0.0), high, *_alpha(inputs, in_))


def _rgb(inputs: Inputs, in_: Array) -> Array:
    """From hue, saturation and value: each channel a trapezium over the hue, as `_hsv` has it."""
    hue, saturation, value = in_[:3]
    saturation = np.where(saturation < _GREY, 0.0, saturation)
    away = ((6.0 * hue + start) % 6.0 for start in (5.0, 3.0, 1.0))  # from where the channel begins to fade, in sixths
    channels = vector(*(value * (1.0 - saturation * np.clip(np.minimum(a, 4.0 - a), 0.0, 1.0)) for a in away))
    error = UNIT * np.abs(value) * (1.0 + np.abs(saturation) * (1.0 + 6.0 * np.abs(hue)))
    return vector(*displaced(inputs, channels, error), *_alpha(inputs, in_))


def _alpha(inputs: Inputs, in_: Array) -> Array:
    """The fourth channel of a colour that has one, which stays."""
    lost = len(in_) > 3 and inputs.deviates(Deviation.HSV_ALPHA)
    return np.ones_like(in_[3:]) if lost else in_[3:]


_OF_COLORS: Table = {
    "luminance": _luminance,
    "rgbtohsv": _hsv,
    "hsvtorgb": _rgb,
}
define(_OF_COLORS, ("color3", "color4"))

_REMAP: Table = {
    "remap": lambda in_, inlow, inhigh, outlow, outhigh: outlow + (in_ - inlow) * (outhigh - outlow) / (inhigh - inlow),
}
define(_REMAP, (*CHANNELS, *WITH_FLOAT))

define({"smoothstep": _smoothstep}, ("float",))
