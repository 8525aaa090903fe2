"""Noise over the plane and space, as MaterialX's hardware targets define it; to the bit where integers are hashed.

Positions have shape (dimensions, samples), with two or three dimensions, and magnitudes below 2^24: beyond, float32 has
no fractions, and beyond 2^31 GLSL does not say what its conversion to integers gives. Errors are what float32 may miss
a value by, in full.
"""

from __future__ import annotations

from itertools import product
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.float32.rounding import UNIT
from mrm_mtlx.reference.textures.hashing import hashed, unit_interval

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# Gradients by the lowest bits of a hash: the two coordinates that count and the weight of the second; bit 0 turns the
# sign of the first, bit 1 that of the second. In the plane the eight vectors (+-1, +-2) and (+-2, +-1), in space those
# to the middles of a cube's edges, four of them twice (Perlin 2002, "Improving Noise").
_AXES = {
    2: ((0, 1),) * 4 + ((1, 0),) * 4,
    3: ((0, 1),) * 4 + ((0, 2),) * 4 + ((1, 2),) * 4 + ((1, 0), (1, 2)) * 2,
}
_SECOND_WEIGHT = {2: 2.0, 3: 1.0}


def _gradients(dimensions: int) -> Array:
    """All gradients, shape (dimensions, number)."""
    table = np.zeros((dimensions, len(_AXES[dimensions])))
    for bits, (first, second) in enumerate(_AXES[dimensions]):
        table[first, bits] = -1.0 if bits & 1 else 1.0
        table[second, bits] = (-1.0 if bits & 2 else 1.0) * _SECOND_WEIGHT[dimensions]
    return table


GRADIENTS = {dimensions: _gradients(dimensions) for dimensions in _AXES}

# By which gradient noise fills [-1, 1].
_SCALE = {2: 0.6616, 3: 0.9820}

# Bits of a hash per channel.
_CHANNEL_BITS = 8

# Error of gradient noise at a given position: the polynomial that fades, of terms up to 15, is off by some 20 units,
# and fades between gradients' products up to 3 apart, once per dimension.
GRADIENT_ERROR = 3 * 20.0 * UNIT

# Steepest slope of gradient noise along an axis: 3.03 is the most found at a million positions (a test looks again).
SLOPE = 4.0


def gradient_noise(position: Array, channels: int) -> Array:
    """Perlin's gradient noise, one to three channels, shape (channels, samples), within [-1, 1].

    Continuous, and so are its first two derivatives: to which cell a position on an edge is counted does not matter.
    """
    cell = np.floor(position)
    inside = position - cell
    fade = inside**3 * (inside * (inside * 6.0 - 15.0) + 10.0)
    shares = (1.0 - fade, fade)
    table = GRADIENTS[len(position)]
    result = np.zeros((channels, 1))
    for step in product((0, 1), repeat=len(position)):
        corner = np.array(step)[:, None]
        bits = hashed(*(cell + corner))
        chosen = [(bits >> np.uint32(_CHANNEL_BITS * k)) & np.uint32(table.shape[1] - 1) for k in range(channels)]
        along = inside - corner
        slope = sum(gradient[np.stack(chosen)] * way for gradient, way in zip(table, along, strict=True))
        result = result + prod(shares[place][axis] for axis, place in enumerate(step)) * slope
    return np.asarray(_SCALE[len(position)] * result)


def fractal_noise(
    position: Array, channels: int, octaves: Array, lacunarity: Array, diminish: Array, roundings: int = 0
) -> tuple[Array, Array]:
    """Octaves of gradient noise, each `lacunarity` times finer and `diminish` times weaker than the one before.

    Returns the sum, shape (channels, samples), and its error, shape (samples,), for a position that has already been
    rounded so many times.
    """
    value, error, amplitude = np.zeros((channels, 1)), np.zeros(1), np.ones(1)
    for octave in range(int(np.max(octaves))):
        share = np.where(octave < octaves, amplitude, 0.0)
        value = value + share * gradient_noise(position, channels)
        shift = (octave + roundings) * UNIT * np.sum(np.abs(position), axis=0)
        error = error + np.abs(share) * (GRADIENT_ERROR + np.minimum(SLOPE * shift, 2.0))
        amplitude = amplitude * diminish
        position = position * lacunarity
    return value, error


def cell_noise(*coordinates: Array) -> Array:
    """A random number in [0, 1] per cell of whole coordinates, shape (samples,); exactly as float32 has it."""
    return unit_interval(hashed(*coordinates))


def cell_noises(*coordinates: Array) -> Array:
    """Three random numbers per cell, shape (3, samples)."""
    return np.stack(np.broadcast_arrays(*(cell_noise(*coordinates, np.asarray(float(k))) for k in range(3))))


def nearest_points(position: Array, jitter: Array, count: int) -> tuple[Array, Array]:
    """The nearest of the points that lie one in each cell, at random about its middle (Worley 1996).

    Looked for in the cells around. Returns the distances, nearest first, shape (count, samples), and the ways there,
    shape (count, dimensions, samples). Distances beyond 1000 are cut off.
    """
    cell = np.floor(position)
    inside = position - cell
    ways = []
    for step in product((-1.0, 0.0, 1.0), repeat=len(position)):
        corner = np.array(step)[:, None]
        random = cell_noises(*(cell + corner))[: len(position)]
        ways.append(corner + (random - 0.5) * jitter + 0.5 - inside)
    every = np.stack(ways)
    squared = np.minimum(np.sum(np.square(every), axis=1), 1e6)
    order = np.argsort(squared, axis=0, kind="stable")[:count]  # of points equally far, the first in the loop's order
    return np.sqrt(np.take_along_axis(squared, order, 0)), np.take_along_axis(every, order[:, None], 0)


def distance_error(jitter: Array) -> Array:
    """Error of such a distance: some eight roundings of coordinates up to 2 and the jitter."""
    return np.asarray(8.0 * UNIT * (2.0 + np.abs(jitter)))
