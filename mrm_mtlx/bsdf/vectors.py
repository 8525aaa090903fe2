"""Directions in the local frame: mirror image, half-vector, back-vector."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# How far the length of a direction may be from 1: what three decimal digits of its components leave, as people write
# them. The values of a lobe follow: a cosine is off by as much at most.
UNIT = 1e-3
# Names of what is a direction among the vectors that lobes are evaluated at; the others are random numbers.
DIRECTIONS = ("v", "l")


def components(name: str, value: ArrayLike) -> Array:
    """Directions as an array (..., 3). Raises ValueError, naming them, for another shape."""
    array = np.asarray(value, dtype=float)
    if array.shape[-1:] != (3,):
        msg = f"{name} must have shape (..., 3), got {array.shape}"
        raise ValueError(msg)
    return array


def direction(name: str, value: ArrayLike) -> Array:
    """Unit directions as an array (..., 3). Raises ValueError, naming them, for another shape or length."""
    array = components(name, value)
    check_unit(name, array)
    return array


def check_unit(name: str, array: Array, axis: int = -1) -> None:
    """Raise ValueError, naming the directions, if the length of one is not 1 to within `UNIT`; zero vectors pass.

    A sample that is lost is the zero vector (`lobe.Lobe.sample`), and may be handed on.
    """
    x, y, z = np.moveaxis(array, axis, 0)
    square = x * x + y * y + z * z
    wrong = ~(np.abs(square - 1.0) <= 2.0 * UNIT) & (square != 0.0)
    if np.any(wrong):
        length = np.sqrt(square[wrong][0])
        msg = f"{name} must be a unit vector, got one of length {length:g}; divide it by its length"
        raise ValueError(msg)


def color(name: str, value: ArrayLike) -> Array:
    """A colour as an array (..., 3); a scalar is grey. Raises ValueError, naming it, for another shape."""
    array = np.asarray(value, dtype=float)
    if array.ndim == 0:
        return np.full(3, array)
    if array.shape[-1] != 3:
        msg = f"{name} must be a scalar or have shape (..., 3), got {array.shape}"
        raise ValueError(msg)
    return array


def dot(a: ArrayLike, b: ArrayLike) -> Array:
    """Scalar product over the last axis, shape (...)."""
    return np.asarray(np.einsum("...i,...i->...", np.asarray(a, dtype=float), np.asarray(b, dtype=float)))


def normalize(a: ArrayLike) -> Array:
    """Unit vector along `a`, shape (..., 3). A zero vector gives NaN, since it has no direction."""
    a = np.asarray(a, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        return a / np.sqrt(dot(a, a))[..., None]


def mirror(v: ArrayLike) -> Array:
    """View direction mirrored about the normal, v' = 2 (n.v) n - v (Portsmouth et al. 2026, eq. 3).

    Parameters
    ----------
    v : array_like, shape (..., 3)
        In the local frame.

    Returns
    -------
    ndarray, shape (..., 3)
        Of the same length; mirroring twice gives v back.

    Examples
    --------
    >>> mirror([0.6, 0.0, 0.8]).tolist()
    [-0.6, -0.0, 0.8]
    """
    return np.asarray(np.asarray(v, dtype=float) * np.array([-1.0, -1.0, 1.0]))


def half_vector(v: ArrayLike, l: ArrayLike) -> Array:
    """Half-vector h = (v + l) / |v + l|, shape (..., 3); NaN where v = -l."""
    return normalize(np.asarray(v, dtype=float) + np.asarray(l, dtype=float))


def back_vector(v: ArrayLike, l: ArrayLike) -> Array:
    """Back-vector b = half-vector of v' and l, shape (..., 3) (Portsmouth et al. 2026, eq. 3).

    It is n wherever l = v.

    Examples
    --------
    >>> back_vector([0.6, 0.0, 0.8], [0.6, 0.0, 0.8]).tolist()
    [0.0, 0.0, 1.0]
    """
    return half_vector(mirror(v), l)
