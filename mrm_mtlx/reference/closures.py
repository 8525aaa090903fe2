"""MaterialX's closures: what its hardware shaders compute for a light, built on the optics of `mrm_mtlx.bsdf`.

Everything that MaterialX 1.39.5 does and the papers do not say is in this module:

* a closure is a pair (response, throughput); the response has the cosine of l, which cancels against 1 / (4 n.v n.l);
* alpha is clamped to [1e-8, 1], n.v, n.l and v.m to [1e-8, 1]; light from below is not cut off, only clamped;
* masking and energy compensation use the mean width sqrt(alpha_x alpha_y), D both widths;
* colours are clamped from below at 0; a weight under 1e-8 switches a lobe off.

Where `light.part` names a quantity, it is taken at the edge of the error that float32 gives it (`precision`).

Arrays: directions, colours and frames have the component first, shape (3, samples); scalars (samples,) or ().
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import albedo, diffuse, fresnel, ggx
from mrm_mtlx.bsdf.lobes import EXACT, Rounding, conductor_reflectance, dielectric_reflectance, schlick_reflectance
from mrm_mtlx.reference import precision
from mrm_mtlx.reference.rounding import UNIT

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# MaterialX's M_FLOAT_EPS.
EPSILON = 1e-8


class Model(Enum):
    """Whose microfacet lobes are evaluated: the two families of targets differ by more than rounding.

    `HARDWARE` is what MaterialX writes for its hardware targets, as the head of this module says. `CLOSURES` are the
    closures of OSL as renderers have them: both widths in the masking, no multiply scattered light, and nothing from
    below the surface.
    """

    HARDWARE = "hardware"
    CLOSURES = "closures"


@dataclass(frozen=True)
class Closure:
    """A BSDF node's value: what it reflects of the light, and what it lets through to the layer below.

    `response` and `throughput` have shape (3, samples) or broadcast to it.
    """

    response: Array
    throughput: Array


@dataclass(frozen=True)
class Light:
    """The directions of an evaluation: `v`, `l`, shape (3, samples); `part`: see `rounding.Move`."""

    v: Array
    l: Array
    part: str = ""
    model: Model = Model.HARDWARE

    @property
    def rounding(self) -> Rounding:
        """Errors of what stands under a square root in the Fresnel terms and cancels, where that is what is moved."""
        return precision.ROUNDINGS.get(self.part, EXACT)


@dataclass(frozen=True)
class Facets:
    """The inputs that the three microfacet nodes share; scalars as arrays, `normal` and `tangent` (3, samples)."""

    weight: Array
    alpha_x: Array
    alpha_y: Array
    retroreflective: Array
    thinfilm_thickness: Array
    thinfilm_ior: Array
    normal: Array
    tangent: Array
    scatter_mode: str = "R"


def transparent() -> Closure:
    """The closure of nothing: no response, and everything below shows."""
    return Closure(np.zeros((3, 1)), np.ones((3, 1)))


def conductor(light: Light, facets: Facets, ior: Array, extinction: Array) -> Closure:
    """`conductor_bsdf` for one light. Opaque: throughput 0, also at weight 0."""

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        return conductor_reflectance(c, ior, extinction, *film, rounding=light.rounding)

    _, response = _microfacet(light, facets, reflectance, lambda _a, _b: np.zeros(()))
    return Closure(response, np.zeros((3, 1)))


def dielectric(light: Light, facets: Facets, tint: Array, ior: Array) -> Closure:
    """`dielectric_bsdf` for one light: the reflected part; throughput 1 - albedo * weight, the tint left out."""
    if facets.scatter_mode == "T":
        return transparent()

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        seen = dielectric_reflectance(c, ior, *film, rounding=light.rounding)
        return seen + precision.amplitude_error(seen, c, ior) if light.part == "reflectance" else seen

    f0 = fresnel.reflectance_at_normal(ior)
    lost, response = _microfacet(light, facets, reflectance, lambda a, b: a * f0 + b)
    on = facets.weight >= EPSILON
    return Closure(response * np.maximum(tint, 0.0), np.where(on, 1.0 - lost * facets.weight, 1.0))


def generalized_schlick(
    light: Light, facets: Facets, color0: Array, color82: Array, color90: Array, exponent: Array
) -> Closure:
    """`generalized_schlick_bsdf` for one light; its throughput is grey, 1 - mean albedo * weight."""
    if facets.scatter_mode == "T":
        return transparent()
    color0, color82, color90 = (np.maximum(c, 0.0) for c in (color0, color82, color90))

    def with_film(c: Array, film_ior: Array) -> Array:
        film = facets.thinfilm_thickness, film_ior
        return schlick_reflectance(c, color0, color82, color90, exponent, *film, rounding=light.rounding)

    def reflectance(c: Array) -> Array:
        seen = with_film(c, facets.thinfilm_ior)
        if light.part == "reflectance":
            rise, fast = np.abs(color90 - color0), light.model is Model.CLOSURES
            moved = rise * precision.power_error(1.0 - c, exponent, fast=fast)
            # The reflectance at 82 degrees, of which the tint takes its share.
            at_82 = precision.power_error(np.asarray(1.0 - fresnel.COS_82), exponent, fast=fast)
            moved = moved + rise * at_82 * np.abs(1.0 - color82) * fresnel.tint_shape(c)
            if np.any(facets.thinfilm_thickness > 0.0):
                # The film's phase jumps by pi where its index is that of color0: there, a rounding decides.
                for step in (-2.0 * UNIT, 2.0 * UNIT):
                    moved = moved + np.abs(with_film(c, facets.thinfilm_ior * (1.0 + step)) - seen)
            seen = seen + moved
        return seen

    lost, response = _microfacet(light, facets, reflectance, lambda a, b: a * color0 + b * color90)
    mean = np.mean(lost, axis=0, keepdims=True)
    on = facets.weight >= EPSILON
    return Closure(response, np.where(on, 1.0 - mean * facets.weight, 1.0))


def oren_nayar(
    light: Light, weight: Array, color: Array, roughness: Array, normal: Array, energy_compensation: Array
) -> Closure:
    """`oren_nayar_diffuse_bsdf` for one light; throughput 0."""
    n = _facing(normal, light.v)
    cos_v, cos_l, v_l = _cosine(n, light.v), _cosine(n, light.l), _cosine(light.l, light.v)
    plain = color * diffuse.oren_nayar(cos_v, cos_l, v_l, roughness)
    compensated = diffuse.compensated_oren_nayar(
        cos_v, cos_l, v_l, roughness, color, arccos_error=precision.ARCCOS_ERROR if light.part == "reflectance" else 0.0
    )
    f = np.where(energy_compensation, compensated, plain)
    response = np.where(weight >= EPSILON, f * weight * cos_l, 0.0)
    return Closure(response, np.zeros((3, 1)))


def layer(top: Closure, base: Closure) -> Closure:
    """Albedo scaling: the base is seen through what the top lets pass."""
    return Closure(top.response + base.response * top.throughput, top.throughput * base.throughput)


def mix(foreground: Closure, background: Closure, amount: Array) -> Closure:
    """`(1 - amount) background + amount foreground`, of response and throughput."""
    rest = 1.0 - amount
    return Closure(
        background.response * rest + foreground.response * amount,
        background.throughput * rest + foreground.throughput * amount,
    )


def add(first: Closure, second: Closure) -> Closure:
    """The sum of two BSDFs; their albedos add, so the throughput is t1 + t2 - 1, not below 0."""
    return Closure(first.response + second.response, np.maximum(first.throughput + second.throughput - 1.0, 0.0))


def multiply(closure: Closure, factor: Array) -> Closure:
    """The response times a factor, clamped to [0, 1]; the throughput stays."""
    return Closure(closure.response * np.clip(factor, 0.0, 1.0), closure.throughput)


def _microfacet(
    light: Light,
    facets: Facets,
    reflectance: Callable[[Array], Array],
    white: Callable[[Array, Array], Array],
) -> tuple[Array, Array]:
    """Directional albedo (for the throughput) and response of a lobe; `white(A, B)` combines the albedo factors."""
    # v' = 2 (n.v) n - v, and n is turned to face it: n.v' = n.v, so it is the same turn as for v.
    mirrored = 2.0 * _dot(facets.normal, light.v) * facets.normal - light.v
    v = np.where(facets.retroreflective, mirrored, light.v)
    n = _facing(facets.normal, v)
    x = facets.tangent - _dot(facets.tangent, n) * n
    x = x / np.sqrt(_dot(x, x))
    y = np.cross(n, x, axis=0)
    m = v + light.l
    m = m / np.sqrt(_dot(m, m))
    cos_v, cos_l, cos_m = _cosine(n, v), _cosine(n, light.l), _cosine(v, m)
    alpha_x, alpha_y = (np.clip(a, EPSILON, 1.0) for a in (facets.alpha_x, facets.alpha_y))
    mean_alpha = np.sqrt(alpha_x * alpha_y)

    if light.part == "reflectance":
        # v.m is a sum of three rounded products, also where it is nearly 1 and no longer moves with v and l.
        f = reflectance(cos_m - UNIT * cos_m)
        f = f + precision.film_error(f, facets.thinfilm_thickness, fast=light.model is Model.CLOSURES)
    else:
        f = reflectance(cos_m)
    mx, my = _dot(m, x), _dot(m, y)
    if light.part == "slope" and light.model is Model.CLOSURES:
        # Renderers take an isotropic facet's slope from cos(n, m) alone: its square is what 1 leaves of cos^2.
        mx = np.where(alpha_x == alpha_y, np.sqrt(mx * mx + UNIT), mx)
    d = ggx.distribution(mx, my, _dot(m, n), alpha_x, alpha_y)
    a, b = albedo.albedo_factors(cos_v, mean_alpha)
    if light.model is Model.CLOSURES:
        compensation: Array | float = 1.0
        lambda_v, lambda_l = (
            ggx.smith_lambda(_dot(w, x), _dot(w, y), cos_w, alpha_x, alpha_y)
            for w, cos_w in ((v, cos_v), (light.l, cos_l))
        )
        g = ggx.masking_shadowing(lambda_v, lambda_l) * (_dot(n, light.l) > 0.0)
    else:
        if light.part == "albedo":
            a = a + UNIT * albedo.albedo_condition(cos_v, mean_alpha)
        compensation = albedo.compensation(f, a + b)
        g = ggx.masking_shadowing_isotropic(cos_v, cos_l, mean_alpha)
    response = f * compensation * (d * g * facets.weight / (4.0 * cos_v))
    return white(a, b) * compensation, np.where(facets.weight >= EPSILON, response, 0.0)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cosine(a: Array, b: Array) -> Array:
    return np.clip(_dot(a, b), EPSILON, 1.0)


def _facing(n: Array, v: Array) -> Array:
    return np.where(_dot(n, v) < 0.0, -n, n)
