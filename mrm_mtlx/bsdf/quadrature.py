"""Integrals over the unit square of random numbers, to a stated accuracy: directional albedos."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from mrm_mtlx.bsdf.vectors import components

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Absolute error that is stated by default. Integrands have a kink where directions reach the horizon, so that the error
# falls with a little more than the number of points along one side: 1024 x 1024 give about 1e-6.
ACCURACY = 1e-4
_FIRST, _LAST = 32, 1024
# How much smaller a change is than the one before, with twice the points: 2^1.5 at a kink, 4 where there is none.
_FALL = 4.0
# Points of Gauss's rule on each of the intervals that the first side is divided into.
_GAUSS = 8
_AT_ONCE = 1 << 18


class Sampled(Protocol):
    """Something to integrate: values, and samples with their density."""

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array: ...  # noqa: D102
    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array: ...  # noqa: D102
    def sample(self, v: ArrayLike, u: ArrayLike) -> Array: ...  # noqa: D102


def albedo_by_sampling(lobe: Sampled, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
    """Integral of f(v, l) |n.l| over l by the mean of f |n.l| / pdf over the samples of a lobe; shape (..., 3).

    The lobe's `sample` makes no use of the third random number: a choice has no place on the square.

    Raises
    ------
    ArithmeticError
        As `over_unit_square`.
    """
    v = components("v", v)

    def integrand(u: Array) -> Array:
        l = lobe.sample(v, u)
        pdf = lobe.pdf(v, l)
        cosine = np.where(pdf > 0.0, np.abs(l[..., 2]) / np.where(pdf > 0.0, pdf, 1.0), 0.0)
        return np.asarray(lobe.eval(v, l) * cosine[..., None])

    return over_unit_square(integrand, v.shape[:-1], accuracy)


def over_unit_square(integrand: Callable[[Array], Array], shape: tuple[int, ...], accuracy: float) -> Array:
    """Integral over u[0] and u[1] in [0, 1], shape (*shape, 3).

    Gauss's rule along the first, which in samples makes the distance from the peak, and even spacing along the second,
    their azimuth. Points are doubled along both until the result changes by less than the accuracy, after a change that
    was small too: one alone can be small by chance.

    Parameters
    ----------
    integrand
        From points (k, *1s, 3), the third component being 1/2, to values (k, *shape, 3).
    shape
        Of the integrals that are made together.
    accuracy
        Absolute.

    Raises
    ------
    ArithmeticError
        If 1024 x 1024 points do not reach the accuracy.
    """
    previous, change_before = _mean(integrand, shape, _FIRST), np.inf
    count = 2 * _FIRST
    while count <= _LAST:
        current = _mean(integrand, shape, count)
        change = float(np.max(np.abs(current - previous), initial=0.0))
        if change < accuracy and change_before < _FALL * accuracy:
            return current
        previous, change_before, count = current, change, 2 * count
    msg = f"the integral does not reach an accuracy of {accuracy:g} with {_LAST} x {_LAST} points"
    raise ArithmeticError(msg)


def _mean(integrand: Callable[[Array], Array], shape: tuple[int, ...], count: int) -> Array:
    points, weights = _side(count)
    rows = max(1, _AT_ONCE // (count * max(1, int(np.prod(shape)))))
    total = np.zeros((*shape, 3))
    for start in range(0, count, rows):
        part = slice(start, start + rows)
        u1, u2 = np.meshgrid(points[part], points, indexing="ij")
        u = np.stack([u1.ravel(), u2.ravel(), np.full(u1.size, 0.5)], axis=-1)
        values = integrand(u.reshape(-1, *(1,) * len(shape), 3)).reshape(*u1.shape, *shape, 3)
        total += np.einsum("i,j,ij...->...", weights[part], weights, values)
    return total


def _side(count: int) -> tuple[Array, Array]:
    """Points and weights on one side: Gauss's rule on each of its intervals, dense at both ends.

    The ends stand for infinite slopes, where integrands are bounded but steep: with u = 3 t^2 - 2 t^3, du / dt vanishes
    there.
    """
    x, weight = np.polynomial.legendre.leggauss(_GAUSS)
    t = ((np.arange(count // _GAUSS)[:, None] + 0.5 * (x + 1.0)) * (_GAUSS / count)).ravel()
    weights = np.tile(0.5 * weight * (_GAUSS / count), count // _GAUSS)
    return t * t * (3.0 - 2.0 * t), weights * 6.0 * t * (1.0 - t)
