"""Hex tiling: three overlapping copies of an image, each turned, scaled and shifted at random, blended.

Mikkelsen 2022, "Practical Real-Time Hex-Tiling", JCGT 11(2); the details are those of MaterialX's hardware targets.
Arrays have the tile first, shape (3, ...), and the sample last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import EPSILON, dot, unit
from mrm_mtlx.reference.float32.precision import SINE_ERROR
from mrm_mtlx.reference.float32.rounding import UNIT

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# Triangles per unit of the texture's coordinates, and the skew that makes squares of their grid: tan and 1 / cos of 30
# degrees, as float32 has MaterialX's decimals.
GRID = 2.0 * np.sqrt(3.0)
_TANGENT = float(np.float32(0.57735027))
_SECANT = float(np.float32(1.15470054))

# Of the random numbers by Dave Hoskins' "Hash without Sine" (2014), as float32 has them.
_FACTORS = np.array([[0.1031], [0.1030], [0.0973]], dtype=np.float32).astype(float)
_SHIFT = float(np.float32(33.33))
_SEED = float(np.float32(0.12345))

TILES = 3  # that overlap at a sample

# The power of the distance weights.
SHARPNESS = 7.0


@dataclass(frozen=True)
class Spread:
    """Differences between the tiles.

    Attributes
    ----------
    rotation, scale, offset
        How much of each range is used, in [0, 1].
    rotation_range, scale_range, offset_range : shape (2, ...)
        The ranges, rotation in degrees.
    """

    rotation: Array
    rotation_range: Array
    scale: Array
    scale_range: Array
    offset: Array
    offset_range: Array


@dataclass(frozen=True)
class Errors:
    """By how much quantities of the tiles are off, each of shape (3, ...) with the tile first.

    `random` of the two random numbers, (3, 2, samples); `angle` [rad]; `stretch`, relative, of the scale.
    """

    random: Array | float = 0.0
    angle: Array | float = 0.0
    stretch: Array | float = 0.0


EXACT = Errors()


@dataclass(frozen=True)
class Tiles:
    """The three tiles at each sample.

    Attributes
    ----------
    coordinates : shape (3, 2, samples)
        Where each looks up the image.
    weights : shape (3, samples)
        How much each counts, before luminance; not normalised.
    angles : shape (3, samples)
        How far each is turned [rad].
    """

    coordinates: Array
    weights: Array
    angles: Array


def tiles(coord: Array, spread: Spread, errors: Errors = EXACT) -> Tiles:
    """The tiles at texture coordinates, shape (2, samples)."""
    corners, weights = _triangle(coord)
    pair = np.moveaxis(random_pair(corners) + errors.random, 1, 0)  # (2, tile, sample)
    low, high = np.deg2rad(spread.rotation_range)
    angles = low + (high - low) * pair[0] * spread.rotation + errors.angle
    low, high = spread.scale_range
    scale = 1.0 + (low + (high - low) * pair[1] - 1.0) * spread.scale
    scale = scale * (1.0 + errors.stretch)
    low, high = spread.offset_range
    offset = low + (high - low) * pair * spread.offset
    centre = np.stack([corners[:, 0] + 0.5 * corners[:, 1], corners[:, 1] / _SECANT]) / GRID
    x, y = coord[:, None] - centre
    c, s = np.cos(angles), np.sin(angles)
    turned = np.stack([c * x - s * y, s * x + c * y]) / scale + centre + offset
    return Tiles(np.moveaxis(turned, 0, 1), weights**SHARPNESS, angles)


def _triangle(coord: Array) -> tuple[Array, Array]:
    """Corners of the triangle around each sample, whole numbers, (3, 2, samples), and their weights, (3, samples).

    Where a sample changes its triangle, the weight of the corner that is exchanged is zero: nothing jumps.
    """
    x, y = coord * GRID
    skewed = np.stack([x - _TANGENT * y, _SECANT * y])
    base = np.floor(skewed)
    x, y = skewed - base
    rest = 1.0 - x - y
    upper = np.where(rest <= 0.0, 1.0, 0.0)
    sign = 1.0 - 2.0 * upper
    weights = np.stack([rest * sign, upper + y * sign, upper + x * sign])
    steps = np.stack([[upper, upper], [upper, 1.0 - upper], [1.0 - upper, upper]])
    return base + steps, weights


def random_pair(corners: Array) -> Array:
    """Two random numbers in [0, 1) per corner, shape as given: (3, 2, samples)."""
    return _hashed(corners)[0] % 1.0


def random_error(corners: Array) -> Array:
    """Error of float32 in the random numbers, in full, shape (3, 2, samples).

    They are the fraction of a product near 10,000, whose rounding alone is 6e-4: the hash keeps the last bits of its
    arithmetic, of which GLSL fixes neither the order nor the fusing.
    """
    return _hashed(corners)[1]


def _hashed(corners: Array) -> tuple[Array, Array]:
    """The numbers whose fraction is random, and their largest error in float32, to first order."""
    p = np.moveaxis(corners, 1, 0)[[0, 1, 0]] + _SEED
    scaled = p * _FACTORS[:, :, None]
    each = scaled % 1.0
    error = 2.0 * UNIT * np.abs(scaled)
    other, other_error = (each + _SHIFT)[[1, 2, 0]], (error + UNIT * (1.0 + _SHIFT))[[1, 2, 0]]
    inner = np.sum(each * other, axis=0)
    inner_error = np.sum(error * other + each * other_error, axis=0) + 3.0 * UNIT * inner
    each, error = each + inner, error + inner_error + UNIT * (1.0 + inner)
    total, total_error = each[:1] + each[1:], error[:1] + error[1:] + UNIT * (each[:1] + each[1:])
    factor, factor_error = each[[2, 1]], error[[2, 1]]
    found = total * factor
    found_error = total * factor_error + factor * total_error + UNIT * found
    return np.moveaxis(found, 0, 1), np.moveaxis(found_error, 0, 1)


def coordinate_error(coord: Array) -> Array:
    """Error of float32 in texture coordinates on their way into a triangle and out of it, shape (samples,).

    Some eight roundings of u and v together: times the grid's constant, skewed, from a corner's position and back.
    """
    return np.asarray(8.0 * UNIT * np.sum(np.abs(coord), axis=0))


def reach(coord: Array, spread: Spread) -> Array:
    """Error of float32 in the coordinates at which the tiles look up the image, in full, shape (3, 2, samples).

    By the random numbers, and by the sines and the scale that follow from them.
    """
    random = random_error(_triangle(coord)[0])
    none = np.zeros_like(random[:, 0])
    exact = tiles(coord, spread).coordinates
    displaced = (
        Errors(random=np.stack([random[:, 0], none], axis=1)),
        Errors(random=np.stack([none, random[:, 1]], axis=1)),
        Errors(angle=SINE_ERROR),
        Errors(stretch=SINE_ERROR),
    )
    return np.asarray(sum(np.abs(tiles(coord, spread, errors).coordinates - exact) for errors in displaced))


def wrapped(coord: Array) -> Array:
    """Turn of a random number that may come out at the other end of [0, 1): -1 or 1, elsewhere 0, (3, 2, samples)."""
    corners, _ = _triangle(coord)
    random, error = random_pair(corners), random_error(corners)
    return np.where(random + error >= 1.0, -1.0, np.where(random - error < 0.0, 1.0, 0.0))


def angle_error(coord: Array, spread: Spread) -> Array:
    """Error of float32 in the tiles' angles, in full, shape (3, samples)."""
    low, high = np.deg2rad(spread.rotation_range)
    return np.asarray(random_error(_triangle(coord)[0])[:, 0] * np.abs((high - low) * spread.rotation) + SINE_ERROR)


# Relative, in full: pow(w, 7) is exp2(7 log2(w)), of which log2 is off by 2^-21 (GLSL 4.60, section 4.7.1).
WEIGHT_ERROR = SHARPNESS * 2.0**-21


def blend_weights(luminance: Array, weights: Array, falloff: Array) -> Array:
    """Shares of the tiles, which add up to 1, from the luminance of what each shows and the tiles' own weights."""
    shares = luminance * weights
    shares = gain(shares / np.sum(shares, axis=0), falloff)
    return np.asarray(shares / np.sum(shares, axis=0))


def gain(x: Array, falloff: Array) -> Array:
    """Schlick 1994, "Fast Alternatives to Perlin's Bias and Gain Functions": for a falloff of 0.5 the identity."""
    bend = (1.0 / np.clip(falloff, 0.001, 0.999) - 2.0) * (1.0 - 2.0 * x)
    return np.where(x < 0.5, x / (bend + 1.0), (bend - x) / (bend - 1.0))


def turned(vector: Array, axis: Array, angle: Array) -> Array:
    """A vector (3, samples) turned about a unit axis (3, samples) by an angle (samples,) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(axis * dot(axis, vector) * (1.0 - c) + vector * c + np.cross(axis, vector, axis=0) * s)


def blend_normals(normal: Array, others: Array, shares: Array) -> Array:
    """The unit normal whose surface gradient is the mean of the others', shape (3, samples); `others` (3, 3, samples).

    Mikkelsen 2020, "Surface Gradient-Based Bump Mapping Framework", JCGT 9(3).
    """
    gradient = np.zeros(1)
    for other, share in zip(others, np.clip(shares, 0.0, 1.0), strict=True):
        cosine = dot(normal, other)
        gradient = gradient + share * (cosine * normal - other) / np.maximum(np.abs(cosine), EPSILON)
    return unit(normal - gradient)
