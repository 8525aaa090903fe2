"""Residuals: the scales on which a model's values are held against those of samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array


@dataclass(frozen=True)
class Residual:
    """A difference of scaled values, model less data; its functions take values and a floor for the darkest.

    Attributes
    ----------
    formula
        As reports have it, with a place for the `floor`.
    loss_scale
        Where `soft_l1` turns from squares to absolute values.
    scaled
        Values on the scale.
    slope
        Derivative of `scaled`.
    """

    formula: str
    loss_scale: float
    scaled: Callable[[Array, float], Array]
    slope: Callable[[Array, float], Array]


def _log(value: Array, floor: float) -> Array:
    with np.errstate(divide="ignore"):  # without a floor, black is infinitely far from any value
        return np.asarray(np.log(np.maximum(value, 0.0) + floor))


def _log_slope(value: Array, floor: float) -> Array:
    return np.asarray(1.0 / (value + floor))


def _root(value: Array, _floor: float) -> Array:
    return np.asarray(np.sqrt(np.maximum(value, 0.0)))


def _root_slope(value: Array, floor: float) -> Array:
    return np.asarray(0.5 / np.sqrt(np.maximum(value, floor**2)))


def _same(value: Array, _floor: float) -> Array:
    return value


def _same_slope(value: Array, _floor: float) -> Array:
    return np.ones_like(value)


LOG = Residual("ln(model + {floor:g}) - ln(data + {floor:g})", 0.3, _log, _log_slope)
ROOT = Residual("sqrt(model) - sqrt(data)", 0.1, _root, _root_slope)
LINEAR = Residual("model - data", 1.0, _same, _same_slope)
# By the name that callers use.
RESIDUALS = {"log": LOG, "root": ROOT, "linear": LINEAR}
