"""Vectors as such: lengths, products, rotations, changes of space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.float32.function_errors import displaced, sine_error, summed
from mrm_mtlx.reference.nodes.tables import VECTORS, define, scalar, vector

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table


def _length(in_: Array) -> Array:
    return scalar(np.sqrt(np.sum(np.square(in_), axis=0)))


def _dot(inputs: Inputs, in1: Array, in2: Array) -> Array:
    return scalar(summed(inputs, in1 * in2))


def _cross(inputs: Inputs, in1: Array, in2: Array) -> Array:
    left, right = [1, 2, 0], [2, 0, 1]
    return summed(inputs, np.stack([in1[left] * in2[right], -in1[right] * in2[left]]))


_OF_VECTORS: Table = {
    "normalize": lambda in_: in_ / _length(in_),
    "magnitude": _length,
    "dotproduct": _dot,
}
define(_OF_VECTORS, VECTORS)


def _rotated_in_plane(inputs: Inputs, in_: Array, amount: Array) -> Array:
    """Rotated by an angle in degrees; clockwise, as all targets have it, where the specification has the opposite."""
    cos, sin, error = _turn(amount)
    x, y = in_
    terms = np.stack([vector(cos * x, cos * y), vector(sin * y, -sin * x)])
    return displaced(inputs, summed(inputs, terms), error * (np.abs(x) + np.abs(y)))


def _rotated_in_space(inputs: Inputs, in_: Array, amount: Array, axis: Array) -> Array:
    """Rotated about an axis by an angle in degrees, Rodrigues' formula; as `_rotated_in_plane` about z."""
    cos, sin, error = _turn(amount)
    axis = axis / _length(axis)
    along = axis * _dot(inputs, axis, in_)
    terms = (in_ * cos, _cross(inputs, in_, axis) * sin, along * (1.0 - cos))
    rotated = summed(inputs, np.stack(np.broadcast_arrays(*terms)))
    return displaced(inputs, rotated, 3.0 * error * _length(in_))


def _turn(degrees: Array) -> tuple[Array, Array, Array]:
    """Cosine, sine and the error of both."""
    angle = np.deg2rad(degrees)
    return np.cos(angle), np.sin(angle), sine_error(angle)


define({"rotate2d": _rotated_in_plane}, ("vector2",))

_IN_SPACE: Table = {
    "crossproduct": _cross,
    "rotate3d": _rotated_in_space,
    "transformpoint": lambda in_: in_,
    "transformvector": lambda in_: in_,
    "transformnormal": lambda in_: in_ / _length(in_),
}
define(_IN_SPACE, ("vector3",))
