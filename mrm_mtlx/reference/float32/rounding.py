"""Perturbations of an evaluation by float32 roundings, and the tolerance that they make.

A tolerance is not a chosen constant. The oracle itself is perturbed by float32 roundings, and the sum of the changes of
its result, times one stated factor, is what a shader may differ by: narrow lobes, where one rounding of the half-vector
changes the result by a thousandth, and broad ones are judged alike.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mrm_mtlx.reference.models import Model

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# Unit roundoff of float32: the relative error of one correctly rounded operation.
UNIT = 2.0**-24

# The perturbations below are of one unit roundoff each; this is how many roundings a quantity collects on its way, at
# worst, with the precisions that GLSL 4.60 section 4.7.1 asks of an implementation (inversesqrt 2 ulp, division
# 2.5 ulp; one ulp is two units). A direction is interpolated (1), squared and summed (3), normalised (4 + 1), the
# half-vector is summed (1) and normalised (3 + 4 + 1), then projected on the frame (3): 21. Frame vectors, normalised
# as well, turn both directions together. Rounded up to
ROUNDING_FACTOR = 24.0

# Well-conditioned arithmetic at the end of the path: D, G2, F and the weights are some 16 products and 4 divisions
# (16 + 4 * 5 units), and each closure above adds a product and a sum; they enter relative to the result.
OUTPUT_ROUNDINGS = 40.0


class Direction(Enum):
    """A direction that an evaluation is made for; the value is its name in `closures.Light`."""

    VIEW = "v"
    LIGHT = "l"


class Quantity(Enum):
    """An intermediate result that float32 has worse than by a rounding, with an error of its own.

    `REFLECTANCE`: that of a facet. `MODULUS`, `PRODUCT`: what stands under square roots in it, see
    `intermediates.Perturbed`. `FUNCTIONS`: built-in functions, all up; `CHANNELS_1` to `CHANNELS_3`: these with the
    signs of `CHANNEL_SIGNS`. `TEXTURE`: the weights of texture filters. `ALBEDO`: the fitted albedo of the hardware
    targets. `SLOPE`: that of an isotropic facet, as OSL's renderers have it. `LEAST`, `MOST`: the ends of a range, see
    `RANGE`.
    """

    REFLECTANCE = "reflectance"
    MODULUS = "modulus"
    PRODUCT = "product"
    FUNCTIONS = "functions"
    CHANNELS_1 = "channels +-+-"
    CHANNELS_2 = "channels ++--"
    CHANNELS_3 = "channels +--+"
    TEXTURE = "texture"
    ALBEDO = "albedo"
    SLOPE = "slope"
    LEAST = "least"
    MOST = "most"


# What a value may be made of, beside numbers of the document.
Ingredient: TypeAlias = Direction | Quantity

# Quantities that are perturbed each alone, so that one change cannot hide another.
QUANTITIES = {
    Model.HARDWARE: (
        Quantity.REFLECTANCE,
        Quantity.MODULUS,
        Quantity.PRODUCT,
        Quantity.FUNCTIONS,
        Quantity.TEXTURE,
        Quantity.ALBEDO,
    ),
    Model.CLOSURES: (
        Quantity.REFLECTANCE,
        Quantity.MODULUS,
        Quantity.PRODUCT,
        Quantity.FUNCTIONS,
        Quantity.TEXTURE,
        Quantity.SLOPE,
    ),
}

# Ends of the range of what is no number with a rounding: the last bits of a hash, and what is looked up by them. It is
# perturbed in full and counted once, by the farther of the two. What follows may rise and fall in between, as a lobe
# does over its width: where there are two ends, it is taken at eighths of the way to each as well.
RANGE = (Quantity.LEAST, Quantity.MOST)

# Patterns of signs by which the errors of functions change a value's channels, besides all up: of any two channels of
# four, some pattern takes one up and one down, so that no difference of them looks exact. The farthest change counts.
CHANNEL_SIGNS = {
    Quantity.CHANNELS_1: (1.0, -1.0, 1.0, -1.0),
    Quantity.CHANNELS_2: (1.0, 1.0, -1.0, -1.0),
    Quantity.CHANNELS_3: (1.0, -1.0, -1.0, 1.0),
}

# Patterns of signs by which the document's numbers and its nodes' values are rounded: all up, and by the lowest bits of
# their order. Any two of them within a stretch of eight differ in a pattern, so that none cancels another in all.
PATTERNS = (1, 2, 3, 4)


@dataclass(frozen=True)
class Perturbation:
    """One way in which float32 arithmetic can change an evaluation.

    Attributes
    ----------
    view, light
        Added to the directions, shape (3,), one unit roundoff long.
    values
        Pattern number of the signs with which the document's numbers and its nodes' values are rounded; 0 leaves them.
    step
        Relative size of these roundings. They are all that is allowed them at once, since a graph may bend or jump (a
        comparison, a floor) within it.
    quantity
        What is taken at the edge of its own error.
    factor
        How many times the change of the result is allowed.
    share
        Of an end of `RANGE`, how much of the way there.
    """

    view: Array | float = 0.0
    light: Array | float = 0.0
    values: int = 0
    step: float = ROUNDING_FACTOR * UNIT
    quantity: Quantity | None = None
    factor: float = ROUNDING_FACTOR
    share: float = 1.0

    def touches(self, needs: frozenset[Ingredient]) -> bool:
        """True if it changes something that is made of these, and of numbers of the document, which are in all."""
        return bool(self.values) or not needs.isdisjoint(self._changed)

    @property
    def level(self) -> float:
        """A number of its own in [0, 1] for each perturbation of the numbers, evenly: for what may be anything."""
        return (2 * (self.values - 1) + (self.step < 0.0)) / (2 * len(PATTERNS) - 1)

    @cached_property
    def _changed(self) -> frozenset[Ingredient]:
        directions = {Direction.VIEW: self.view, Direction.LIGHT: self.light}
        quantities = set() if self.quantity is None else {self.quantity}
        return frozenset(quantities | {direction for direction, by in directions.items() if np.any(by)})


EXACT = Perturbation()

# Below this, float32 has no relative precision left, and hardware may flush to zero.
SMALLEST = float(np.finfo(np.float32).tiny)


def perturbations(model: Model = Model.HARDWARE) -> Iterator[Perturbation]:
    """All of them: each axis of each direction, each pattern over the document's numbers, each quantity."""
    for axis in np.eye(3):
        yield Perturbation(view=UNIT * axis)
        yield Perturbation(light=UNIT * axis)
    for pattern in PATTERNS:
        yield Perturbation(values=pattern, factor=1.0)
    for quantity in QUANTITIES[model]:
        yield Perturbation(quantity=quantity)


def opposite_perturbations() -> Iterator[Perturbation]:
    """The patterns over the document's numbers with the opposite signs."""
    for pattern in PATTERNS:
        yield Perturbation(values=pattern, step=-ROUNDING_FACTOR * UNIT, factor=1.0)


def channel_perturbations() -> Iterator[Perturbation]:
    """The perturbation of functions with the patterns of `CHANNEL_SIGNS`."""
    for quantity in CHANNEL_SIGNS:
        yield Perturbation(quantity=quantity)


def range_perturbations() -> Iterator[Perturbation]:
    """Both ends of `RANGE`."""
    for end in RANGE:
        yield Perturbation(quantity=end, factor=1.0)


def on_the_way(end: Perturbation) -> Iterator[Perturbation]:
    """An end of `RANGE`, after the places at eighths of the way there."""
    for eighth in range(1, 9):
        yield replace(end, share=eighth / 8.0)


def farthest(off: Array) -> Array:
    """The most by which something is off on its way, from where it is at even steps, the first axis.

    Between steps, a parabola through three of them is by an eighth of their second difference beyond the farthest.
    """
    steps = np.concatenate([np.zeros_like(off[:1]), off])
    with np.errstate(invalid="ignore"):
        between = np.abs(np.diff(steps, n=2, axis=0)) / 8.0
        found = np.max(np.abs(off), axis=0) + np.max(between, axis=0)
    return np.where(np.isnan(found), np.inf, found)


def value_sign(pattern: int, index: int) -> float:
    """Sign of the rounding of number `index` under a pattern: all up, or by one bit of the index."""
    return 1.0 if pattern == 1 or (index >> (pattern - 2)) & 1 == 0 else -1.0


@dataclass(frozen=True)
class Tolerance:
    """Difference that a float32 result may have, per sample and channel.

    `expected` and `allowed` have shape (samples, channels); `scale` is the largest expected value, the
    lobe's own scale.
    """

    expected: Array
    allowed: Array

    @property
    def scale(self) -> float:
        """Largest expected magnitude over the samples."""
        return float(np.max(np.abs(self.expected), initial=0.0))

    def relative_errors(self, found: NDArray[np.floating]) -> Array:
        """Largest channel error per sample, relative to the sample's largest expected channel, shape (samples,).

        Where the oracle is below one float32 rounding unit of the lobe's own scale, relative to that unit.
        """
        size = np.maximum(np.max(np.abs(self.expected), axis=-1), UNIT * self.scale)
        with np.errstate(over="ignore"):  # of nothing, any light is infinitely much
            return np.asarray(np.max(np.abs(found - self.expected), axis=-1) / np.maximum(size, np.finfo(float).tiny))

    def relative_allowed(self) -> Array:
        """The allowance per sample on the scale of `relative_errors`, shape (samples,): its largest channel's."""
        return self.relative_errors(self.expected + self.allowed)

    def excess(self, found: NDArray[np.floating]) -> Array:
        """Error over allowance, largest channel, shape (samples,); above 1 is a difference.

        NaN counts as infinite; an infinite value where it is expected is none.
        """
        with np.errstate(invalid="ignore"):
            ratio = np.where(found == self.expected, 0.0, np.abs(found - self.expected) / self.allowed)
        return np.asarray(np.max(np.where(np.isnan(ratio), np.inf, ratio), axis=-1))
