"""Ramps and splits over the texture coordinates; v is 1 at the top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.function_errors import mixed
from mrm_mtlx.reference.nodes.tables import CHANNELS, define

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table


def _ramp(inputs: Inputs, at_0: Array, at_1: Array, t: Array) -> Array:
    return mixed(inputs, at_0, at_1, np.clip(t, 0.0, 1.0))


def _split(inputs: Inputs, below: Array, above: Array, center: Array, t: Array) -> Array:
    """A hard step: samples have no neighbours, over which a shader could smooth it."""
    return mixed(inputs, below, above, np.where(inputs.discrete(np.greater_equal(t, center)), 1.0, 0.0))


def _vertical(inputs: Inputs, top: Array, bottom: Array) -> tuple[Array, Array]:
    """The values at 0 and at 1."""
    return (top, bottom) if inputs.deviates(Deviation.VERTICAL_RAMPS) else (bottom, top)


_RAMPS: Table = {
    "ramplr": lambda inputs, valuel, valuer, texcoord: _ramp(inputs, valuel, valuer, texcoord[0]),
    "ramptb": lambda inputs, valuet, valueb, texcoord: _ramp(inputs, *_vertical(inputs, valuet, valueb), texcoord[1]),
    "splitlr": lambda inputs, valuel, valuer, center, texcoord: _split(inputs, valuel, valuer, center, texcoord[0]),
    "splittb": lambda inputs, valuet, valueb, center, texcoord: _split(
        inputs, *_vertical(inputs, valuet, valueb), center, texcoord[1]
    ),
}
define(_RAMPS, CHANNELS)
