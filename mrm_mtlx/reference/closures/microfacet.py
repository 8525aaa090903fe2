"""The three microfacet nodes, in the three modes.

Each says what its interface reflects (`_Interface`); the lobe around it is the same for all (`_evaluate`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import albedo, fresnel, ggx
from mrm_mtlx.bsdf.reflectance import conductor_reflectance, dielectric_reflectance, schlick_reflectance
from mrm_mtlx.reference import precision
from mrm_mtlx.reference.closures.glossy import reflected_radiance, refracted_radiance
from mrm_mtlx.reference.closures.light import (
    EPSILON,
    Closure,
    Light,
    Mode,
    cosine,
    dot,
    environment,
    facing,
    nothing,
    opaque,
    unit,
)
from mrm_mtlx.reference.models import Model
from mrm_mtlx.reference.rounding import UNIT

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array


# Kinds of lobes, among the `foreign` of closures: OSL's renderers have each as the same model, not both in one surface.
ORDINARY, RETROREFLECTIVE = "ordinary lobe", "retroreflective lobe"


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

    @property
    def foreign(self) -> frozenset[str]:
        """What OSL's renderers have as other models of their own, and the kind of lobe; see `Closure`."""
        names = {RETROREFLECTIVE} if np.any(self.retroreflective) else set()
        names |= set() if np.all(self.retroreflective) else {ORDINARY}
        names |= {"thin film"} if np.any(self.thinfilm_thickness > 0.0) else set()
        return frozenset(names | ({"transmission"} if self.scatter_mode != "R" else set()))

    @property
    def off(self) -> bool:
        """Whether the weight switches the lobe off at every sample."""
        return bool(np.all(self.weight < EPSILON))

    @property
    def widths(self) -> tuple[Array, Array]:
        """alpha_x and alpha_y as the shaders clamp them."""
        return np.clip(self.alpha_x, EPSILON, 1.0), np.clip(self.alpha_y, EPSILON, 1.0)


@dataclass(frozen=True)
class _Interface:
    """What reflects: `reflectance(v.m)`; `white(A, B)` its albedo from the two fitted factors; how it refracts."""

    reflectance: Callable[[Array], Array]
    white: Callable[[Array, Array], Array]
    ior: Array | float = 1.5
    tint: Array | float = 1.0


def conductor(light: Light, facets: Facets, ior: Array, extinction: Array) -> Closure:
    """`conductor_bsdf`. Opaque: throughput 0, also at weight 0."""
    if facets.off or light.mode is Mode.TRANSMISSION:
        return opaque(np.zeros((3, 1)))

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        return conductor_reflectance(c, ior, extinction, *film, rounding=light.rounding)

    seen = _evaluate(light, facets, _Interface(reflectance, lambda _a, _b: np.zeros(())))
    return Closure(seen.response, np.zeros((3, 1)), seen.foreign)


def dielectric(light: Light, facets: Facets, tint: Array, ior: Array) -> Closure:
    """`dielectric_bsdf`; throughput 1 - albedo * weight, the tint left out."""
    if facets.off or (facets.scatter_mode == "T" and light.mode is not Mode.TRANSMISSION):
        return nothing()

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        seen = dielectric_reflectance(c, ior, *film, rounding=light.rounding)
        return seen + precision.amplitude_error(seen, c, ior) if light.part == "reflectance" else seen

    f0, tint = fresnel.reflectance_at_normal(ior), np.maximum(tint, 0.0)
    seen = _evaluate(light, facets, _Interface(reflectance, lambda a, b: a * f0 + b, ior, tint))
    return replace(seen, response=seen.response * (1.0 if light.mode is Mode.TRANSMISSION else tint))


def generalized_schlick(
    light: Light, facets: Facets, color0: Array, color82: Array, color90: Array, exponent: Array
) -> Closure:
    """`generalized_schlick_bsdf`; its throughput is grey, 1 - mean albedo * weight."""
    if facets.off or (facets.scatter_mode == "T" and light.mode is not Mode.TRANSMISSION):
        return nothing()
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

    def white(a: Array, b: Array) -> Array:
        return a * color0 + b * color90

    # The index for refraction is that of the mean colour.
    interface = _Interface(reflectance, white, fresnel.schlick_ior(np.mean(color0, axis=0)))
    seen = _evaluate(light, facets, interface, grey=True)
    # OSL's closure has no such parameter.
    tinted = light.model is Model.CLOSURES and not facets.off and np.any(color82 != 1.0)
    return replace(seen, foreign=seen.foreign | {"color82"}) if tinted else seen


def _evaluate(light: Light, facets: Facets, interface: _Interface, *, grey: bool = False) -> Closure:
    """Response and throughput of a lobe in the light's mode; `grey`: the throughput is the mean of the channels."""
    turned = np.logical_and(facets.retroreflective, light.mode is not Mode.TRANSMISSION)
    # v' = 2 (n.v) n - v, and n is turned to face it: n.v' = n.v, so it is the same turn as for v.
    mirrored = 2.0 * dot(facets.normal, light.v) * facets.normal - light.v
    v = np.where(turned, mirrored, light.v)
    n = facing(facets.normal, v)
    cos_v = cosine(n, v)
    alpha_x, alpha_y = facets.widths
    mean_alpha = np.sqrt(alpha_x * alpha_y)
    a, b = albedo.albedo_factors(cos_v, mean_alpha)
    if light.part == "albedo" and light.model is Model.HARDWARE:
        a = a + UNIT * albedo.albedo_condition(cos_v, mean_alpha)
    h = unit(v + light.l) if light.mode is Mode.REFLECTION else None
    reflectance = partial(_moved_reflectance, light, facets, interface)
    f = reflectance(cos_v if h is None else cosine(v, h))
    compensation = albedo.compensation(f, a + b) if light.model is Model.HARDWARE else 1.0

    x = unit(facets.tangent - dot(facets.tangent, n) * n)
    y = np.cross(n, x, axis=0)
    if h is not None:
        response = f * compensation * _distributed(light, v, h, cos_v, (x, y, n), (alpha_x, alpha_y))
    elif light.mode is Mode.INDIRECT:
        at = environment(light)
        response = compensation * reflected_radiance(at, v, (x, y, n), alpha_x, alpha_y, reflectance, light.part)
    elif facets.scatter_mode == "R":
        response = np.zeros((3, 1))
    else:
        at, turn = environment(light), (reflectance, interface.ior, light.part)
        response = interface.tint * refracted_radiance(at, v, (x, y, n), alpha_x, alpha_y, *turn)

    lost = interface.white(a, b) * compensation
    lost = np.mean(lost, axis=0, keepdims=True) if grey else lost
    on = facets.weight >= EPSILON
    return Closure(
        np.where(on, response * facets.weight, 0.0),
        np.where(on, 1.0 - lost * facets.weight, 1.0),
        facets.foreign if light.model is Model.CLOSURES and np.any(on) else frozenset(),
    )


def _moved_reflectance(light: Light, facets: Facets, interface: _Interface, cos_m: Array) -> Array:
    if light.part != "reflectance":
        return interface.reflectance(cos_m)
    # v.m is a sum of three rounded products, also where it is nearly 1 and no longer moves with v and l.
    f = interface.reflectance(cos_m - UNIT * cos_m)
    return f + precision.film_error(f, facets.thinfilm_thickness, fast=light.model is Model.CLOSURES)


def _distributed(
    light: Light,
    v: Array,
    h: Array,
    cos_v: Array,
    frame: tuple[Array, Array, Array],
    widths: tuple[Array, Array],
) -> Array:
    """D G2 / (4 n.v): the lobe without its Fresnel term, times the cosine of l."""
    x, y, n = frame
    alpha_x, alpha_y = widths
    hx, hy = dot(h, x), dot(h, y)
    if light.part == "slope" and light.model is Model.CLOSURES:
        # Renderers take an isotropic facet's slope from cos(n, m) alone: its square is what 1 leaves of cos^2.
        hx = np.where(alpha_x == alpha_y, np.sqrt(hx * hx + UNIT), hx)
    d = ggx.distribution(hx, hy, dot(h, n), alpha_x, alpha_y)
    if light.model is Model.CLOSURES:
        lambda_v, lambda_l = (
            ggx.smith_lambda(dot(w, x), dot(w, y), cos_w, alpha_x, alpha_y)
            for w, cos_w in ((v, cos_v), (light.l, cosine(n, light.l)))
        )
        g = ggx.masking_shadowing(lambda_v, lambda_l) * (dot(n, light.l) > 0.0)
    else:
        g = ggx.masking_shadowing_isotropic(cos_v, cosine(n, light.l), np.sqrt(alpha_x * alpha_y))
    return np.asarray(d * g / (4.0 * cos_v))
