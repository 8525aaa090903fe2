"""Sampling of visible facets by their slopes, where there is no closed form (Heitz and d'Eon 2014).

Stretched to unit widths and seen along the x axis, from the angle theta, a facet of slope q along x is visible in
proportion to max(cos - q sin, 0): its slope across does not matter. What remains is one cumulative function,

    V(q) = cos P(q) + sin M(q)        P(q) = integral of p below q        M(q) = integral of -t p(t) below q

of the slope's own density p, to be inverted between minus infinity and cot theta, where visibility ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# Newton's method, halving the interval where it would leave it: 60 halvings alone exhaust double precision.
_STEPS = 60
# Relative error of V(q) that ends the search: some hundred times the roundings of its terms.
_PRECISION = 1e-13

# What a random number of 0 is taken for, half of the next one: the slope would be infinite.
LEAST = 2.0**-54


class Marginal(NamedTuple):
    """Distribution of the slope q along one axis, as functions of a parameter s that rises with q."""

    slope: Callable[[Array], Array]  # q(s)
    cumulative: Callable[[Array], Array]  # P(q(s))
    moment: Callable[[Array], Array]  # M(q(s)), >= 0
    density: Callable[[Array], Array]  # p(q(s)) dq/ds
    lowest: float  # s below which nothing counts in double precision


def sample_visible(u: Array, cos_theta: Array, sin_theta: Array, end: Array, marginal: Marginal) -> Array:
    """Slopes q with density (cos - q sin) p(q), normalised over q <= cot theta; shape (...).

    `u` in [0, 1) is the share of what is visible that lies below q; `end` is the s of cot theta.
    """

    def visible(s: Array) -> Array:
        return np.asarray(cos_theta * marginal.cumulative(s) + sin_theta * marginal.moment(s))

    goal = np.maximum(u, LEAST) * visible(end)
    low, high = np.full_like(end, marginal.lowest), end.copy()
    s = 0.5 * (low + high)
    for _ in range(_STEPS):
        excess = visible(s) - goal
        found = np.abs(excess) <= _PRECISION * goal
        if np.all(found):
            break
        low, high = np.where(excess < 0.0, s, low), np.where(excess < 0.0, high, s)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            step = s - excess / ((cos_theta - marginal.slope(s) * sin_theta) * marginal.density(s))
        step = np.where((step > low) & (step < high), step, 0.5 * (low + high))
        s = np.where(found, s, step)
    return np.asarray(marginal.slope(s))


def seen_along_x(v: Array, stretch_x: Array, stretch_y: Array) -> tuple[Array, Array, Array, Array]:
    """The view over facets stretched to unit width: cos theta, sin theta, cos phi, sin phi, each (...)."""
    x, y, z = stretch_x * v[0], stretch_y * v[1], v[2]
    across = np.sqrt(x * x + y * y)
    length = np.sqrt(across * across + z * z)
    safe = np.where(across > 0.0, across, 1.0)
    return z / length, across / length, np.where(across > 0.0, x / safe, 1.0), np.where(across > 0.0, y / safe, 0.0)
