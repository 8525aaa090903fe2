"""Closures of volumes, as far as the hardware targets have them: what lies below a surface dims what comes through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import Closure, Light, Mode, nothing
from mrm_mtlx.reference.float32.precision import exponential_error, widened
from mrm_mtlx.reference.float32.rounding import Quantity

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


def absorbing(light: Light, absorption: Array) -> Closure:
    """`anisotropic_vdf`: transmits exp(-absorption), over a unit of length; in reflection it is not there."""
    if light.mode is not Mode.TRANSMISSION:
        return nothing()

    def transmitted(relative: Array | float = 0.0) -> Array:
        return np.asarray(np.exp(-absorption) * (1.0 + relative))

    errors = {"relative": exponential_error(absorption)} if light.perturbs(Quantity.FUNCTIONS) else {}
    return Closure(np.zeros((3, 1)), widened(transmitted, **errors))
