"""Directional albedo by quadrature over the square of random numbers that samples a lobe."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from mrm_mtlx.bsdf.vectors import components

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Absolute error that is stated by default, and directions at most: what a wide lobe needs at grazing incidence, where
# the horizon cuts it, for ten times less.
ACCURACY = 1e-4
_FIRST, _LAST = 16, 1024
_AT_ONCE = 1 << 18


class Sampled(Protocol):
    """What can be integrated: values, and samples with their density."""

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array: ...  # noqa: D102
    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array: ...  # noqa: D102
    def sample(self, v: ArrayLike, u: ArrayLike) -> Array: ...  # noqa: D102


def albedo_by_sampling(lobe: Sampled, v: ArrayLike, *, scale: ArrayLike = 1.0, accuracy: float = ACCURACY) -> Array:
    """Integral of f(v, l) |n.l| over l, times `scale` (...); shape (..., 3).

    The mean of f |n.l| / pdf over the square of the two random numbers that `lobe.sample` turns into l: Gauss's rule
    along the first, which makes the distance from the peak, and even spacing along the second, its azimuth. Points are
    doubled along both until the result moves by less than the accuracy.

    Raises
    ------
    ArithmeticError
        If 1024 x 1024 points do not reach the accuracy.
    """
    v = components("v", v)
    scale = np.asarray(scale, dtype=float)[..., None]
    previous = scale * _mean(lobe, v, _FIRST)
    count = 2 * _FIRST
    while count <= _LAST:
        current = scale * _mean(lobe, v, count)
        if np.max(np.abs(current - previous), initial=0.0) < accuracy:
            return np.asarray(current)
        previous, count = current, 2 * count
    msg = f"the albedo does not reach an accuracy of {accuracy:g} with {_LAST} x {_LAST} directions"
    raise ArithmeticError(msg)


def _mean(lobe: Sampled, v: Array, count: int) -> Array:
    x, weight = np.polynomial.legendre.leggauss(count)
    first, second = 0.5 * (x + 1.0), (np.arange(count) + 0.5) / count
    rows = max(1, _AT_ONCE // (count * max(1, v[..., 0].size)))
    total: Array | float = 0.0
    for start in range(0, count, rows):
        part = slice(start, start + rows)
        u = np.stack(
            [*np.meshgrid(first[part], second, indexing="ij"), np.full((len(first[part]), count), 0.5)], axis=-1
        )
        u = u.reshape(len(first[part]), count, *(1,) * (v.ndim - 1), 3)
        l = lobe.sample(v, u)
        pdf = lobe.pdf(v, l)
        kept = np.where(pdf > 0.0, np.abs(l[..., 2]) / np.where(pdf > 0.0, pdf, 1.0), 0.0)
        values = (lobe.eval(v, l) * kept[..., None]).mean(axis=1)
        total = total + np.tensordot(0.5 * weight[part], values, axes=1)
    return np.asarray(total)
