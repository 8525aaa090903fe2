"""Light of an environment in a glossy lobe: the estimator of MaterialX's filtered importance sampling.

    L = 1/(N G1(v)) sum over i of  Li(l_i) F(v.m_i) G2(v, l_i)         m_i drawn from the visible normals of GGX

(Krivanek and Colbert 2008; visible normals by spherical caps, Dupuy and Benyoub 2023.) The points of the sum are
Fibonacci's, so that the same N gives the same sum here and in a shader. The choice of a level of detail, by which a
shader blurs the environment, is not part of it: the environment is looked up as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import ggx
from mrm_mtlx.bsdf.blocks import BLOCK
from mrm_mtlx.reference.closures.light import EPSILON, Environment, dot, unit
from mrm_mtlx.reference.float32.precision import SINE_ERROR
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, UNIT

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

_GOLDEN_RATIO = 1.6180339887498948


def reflected_radiance(
    environment: Environment,
    v: Array,
    frame: tuple[Array, Array, Array],
    alpha_x: Array,
    alpha_y: Array,
    reflectance: Callable[[Array], Array],
    *,
    functions: bool = False,
) -> Array:
    """Radiance that a lobe reflects to v, shape (3, samples); `frame` is tangent, bitangent, normal, in world space.

    `functions`: with the built-in functions at the edge of their error.
    """
    local, cos_v, alpha, g1 = _prepare(v, frame, alpha_x, alpha_y)
    every = local[:, None]

    def reflected(m: Array) -> Array:
        along = dot(every, m)
        l = 2.0 * along * m - every
        g2 = ggx.masking_shadowing_isotropic(cos_v, np.clip(l[2], EPSILON, 1.0), alpha)
        f = reflectance(np.clip(along, EPSILON, 1.0))
        return _radiance(environment, l, frame) * f * g2

    return _mean(reflected, local, (alpha_x, alpha_y), environment.samples, functions=functions) / g1


def refracted_radiance(
    environment: Environment,
    v: Array,
    frame: tuple[Array, Array, Array],
    alpha_x: Array,
    alpha_y: Array,
    reflectance: Callable[[Array], Array],
    ior: Array | float,
    *,
    functions: bool = False,
) -> Array:
    """Radiance that comes to v through a solid sphere, shape (3, samples): each facet lets 1 - F through, unmasked."""
    local, _, _, g1 = _prepare(v, frame, alpha_x, alpha_y)
    every = local[:, None]

    def refracted(m: Array) -> Array:
        l = through_sphere(-every, m, ior)
        f = reflectance(np.clip(dot(every, m), EPSILON, 1.0))
        return _radiance(environment, l, frame) * (1.0 - f)

    return _mean(refracted, local, (alpha_x, alpha_y), environment.samples, functions=functions) / g1


def refract(incident: Array, n: Array, eta: Array | float) -> Array:
    """Direction of a refracted ray, `eta` the ratio of indices before over after; zero under total reflection.

    The formula of GLSL's built-in function of this name (GLSL 4.60, section 8.5); shapes (3, samples).
    """
    along = dot(n, incident)
    k = 1.0 - eta * eta * (1.0 - along * along)
    bent = eta * incident - (eta * along + np.sqrt(np.maximum(k, 0.0))) * n
    return np.where(k < 0.0, 0.0, bent)


def through_sphere(incident: Array, n: Array, ior: Array | float) -> Array:
    """Direction behind a solid sphere that a ray enters where the outward normal is `n`; shapes (3, samples)."""
    inside = refract(incident, n, 1.0 / ior)
    exit_normal = unit(inside * dot(inside, n) - 0.5 * n)
    return refract(inside, exit_normal, ior)


def _prepare(
    v: Array, frame: tuple[Array, Array, Array], alpha_x: Array, alpha_y: Array
) -> tuple[Array, Array, Array, Array]:
    """v in the frame, its cosine, the mean width, and the masking of v for it."""
    local = np.stack([dot(v, axis) for axis in frame])
    cos_v = np.clip(local[2], EPSILON, 1.0)
    alpha = np.sqrt(alpha_x * alpha_y)
    squared_tangent = (1.0 - cos_v * cos_v) / (cos_v * cos_v)
    return local, cos_v, alpha, np.asarray(2.0 / (1.0 + np.sqrt(1.0 + alpha * alpha * squared_tangent)))


def _mean(
    term: Callable[[Array], Array], v: Array, widths: tuple[Array, Array], count: int, *, functions: bool
) -> Array | float:
    """Mean of what facets of GGX as seen from v show, by their normals in the local frame; of none, 0.

    Normals are drawn from spherical caps (Dupuy and Benyoub 2023) at Fibonacci's points; as many at once, shape
    (3, facets, samples), as come to a block of samples.
    """
    alpha_x, alpha_y = widths
    stretched = unit(np.stack([v[0] * alpha_x, v[1] * alpha_y, v[2]]))[:, None]

    def at(cos_phi: Array, sin_phi: Array, u: Array) -> Array:
        z = (1.0 - u) * (1.0 + stretched[2]) - stretched[2]
        radius = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
        cap = np.stack([radius * cos_phi, radius * sin_phi, z]) + stretched
        return term(unit(np.stack([cap[0] * alpha_x, cap[1] * alpha_y, np.maximum(cap[2], 0.0)])))

    total = np.zeros(())
    together = max(BLOCK // v.shape[-1], 1)
    for first in range(0, count, together):
        index = np.arange(first, min(first + together, count))[:, None]
        phi = 2.0 * np.pi * (index + 0.5) / count
        turns = (index + 1.0) * _GOLDEN_RATIO
        point = np.cos(phi), np.sin(phi), turns % 1.0
        value = at(*point)
        total = total + np.sum(value, axis=1)
        if functions:
            # Besides the built-in functions, the fraction: what is left of a number that has been rounded twice.
            errors: list[Array | float] = [SINE_ERROR, SINE_ERROR, 2.0 * UNIT * turns]
            for place, error in enumerate(errors):
                displaced = (p + error * (k == place) for k, p in enumerate(point))
                total = total + np.sum(np.abs(at(*displaced) - value), axis=1) / ROUNDING_FACTOR
    return total / max(count, 1)


def _radiance(environment: Environment, l: Array, frame: tuple[Array, Array, Array]) -> Array:
    """Radiance from directions in the frame, shape (3, facets, samples), or (3, 1, 1) if all are alike."""
    x, y, n = (axis[:, None] for axis in frame)
    world = l[0] * x + l[1] * y + l[2] * n
    seen = environment.radiance(world.reshape(3, -1))
    return np.reshape(seen, world.shape) if seen.shape[-1] > 1 else seen[..., None]
