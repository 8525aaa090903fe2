"""Matrices, of which MaterialX writes one row after the other, and which vectors multiply from the left: v' = v M."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.function_errors import displaced, summed
from mrm_mtlx.reference.float32.rounding import UNIT, Quantity
from mrm_mtlx.reference.nodes.tables import MATRICES, define, scalar, vector

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs
    from mrm_mtlx.reference.nodes.tables import Table

    _Lines = tuple[int, ...]  # which rows or columns


# Signs of the terms of a determinant's expansion, and of a permanent's, which has the determinant's magnitudes.
_DETERMINANT, _PERMANENT = -1.0, 1.0


def _product(inputs: Inputs, in1: Array, in2: Array) -> Array:
    """Terms (k, row, column, samples), summed over k."""
    return summed(inputs, in1.swapaxes(0, 1)[:, :, None] * in2[:, None])


def _transformed(inputs: Inputs, in_: Array, mat: Array) -> Array:
    return summed(inputs, in_[:, None] * mat)


def _point(inputs: Inputs, in_: Array, mat: Array) -> Array:
    """Transformed as a point: with a last component of 1, and without it again."""
    return _transformed(inputs, _extended(in_, 1.0), mat)[:-1]


def _extended(v: Array, last: float) -> Array:
    return vector(*v, np.asarray(last))


def _rows(*rows: Array) -> Array:
    return np.stack(np.broadcast_arrays(*rows))


def _expansion(matrix: Array, sign: float, rows: _Lines, columns: _Lines) -> Array:
    """Laplace's expansion of these rows and columns along the first of the rows."""
    row, *others = rows
    if not others:
        return np.asarray(matrix[row, columns[0]])
    minors = (_expansion(matrix, sign, tuple(others), _without(columns, column)) for column in columns)
    factors = (sign**k * matrix[row, column] for k, column in enumerate(columns))
    return np.asarray(sum(factor * minor for factor, minor in zip(factors, minors, strict=True)))


def _without(lines: _Lines, line: int) -> _Lines:
    return tuple(other for other in lines if other != line)


def _expanded(matrix: Array, sign: float) -> Array:
    lines = tuple(range(len(matrix)))
    return _expansion(matrix, sign, lines, lines)


def _adjugate(matrix: Array, sign: float) -> Array:
    """The matrix of the minors, transposed."""
    lines = tuple(range(len(matrix)))

    def minor(row: int, column: int) -> Array:
        return sign ** (row + column) * _expansion(matrix, sign, _without(lines, row), _without(lines, column))

    return np.array([[minor(row, column) for row in lines] for column in lines])


def _inverse(inputs: Inputs, in_: Array) -> Array:
    """The adjugate over the determinant, as GPUs have it; the products of either may cancel in its sum."""
    determinant = _expanded(in_, _DETERMINANT)
    inverse = _adjugate(in_, _DETERMINANT) / determinant
    if not inputs.light.perturbs(Quantity.FUNCTIONS):  # the rest takes its time
        return inverse
    error = _adjugate(np.abs(in_), _PERMANENT) + np.abs(inverse) * _expanded(np.abs(in_), _PERMANENT)
    return displaced(inputs, inverse, UNIT * error / np.abs(determinant))


def _determinant(inputs: Inputs, in_: Array) -> Array:
    determinant = _expanded(in_, _DETERMINANT)
    return scalar(displaced(inputs, determinant, UNIT * _expanded(np.abs(in_), _PERMANENT)))


def _multiplied(inputs: Inputs, in1: Array, in2: Array) -> Array:
    return _product(inputs, in2, in1) if inputs.deviates(Deviation.MATRIX_PRODUCTS) else _product(inputs, in1, in2)


def _divided(inputs: Inputs, in1: Array, in2: Array) -> Array:
    if inputs.deviates(Deviation.MATRIX_PRODUCTS):
        return in1 / in2
    return _product(inputs, in1, _inverse(inputs, in2))


_OF_MATRICES: Table = {
    "multiply": _multiplied,
    "divide": _divided,
    "transpose": lambda in_: in_.swapaxes(0, 1),
    "determinant": _determinant,
    "invertmatrix": _inverse,
}
define(_OF_MATRICES, MATRICES)

define({"transformmatrix": _transformed}, ("vector3", "vector4"))
define({"transformmatrix": _point}, ("vector2M3", "vector3M4"))

_FROM_ROWS: Table = {
    "vector3_matrix33": lambda in1, in2, in3: _rows(in1, in2, in3),
    "vector3_matrix44": lambda in1, in2, in3, in4: _rows(
        *(_extended(row, 0.0) for row in (in1, in2, in3)), _extended(in4, 1.0)
    ),
    "vector4_matrix44": lambda in1, in2, in3, in4: _rows(in1, in2, in3, in4),
}
for _kind, _function in _FROM_ROWS.items():
    define({"creatematrix": _function}, (_kind,))
