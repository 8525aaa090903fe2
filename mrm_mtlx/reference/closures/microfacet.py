"""The three microfacet nodes, in the three modes.

Each says what its interface reflects (`_Interface`); the lobe around it is the same for all (`_evaluate`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel, ggx
from mrm_mtlx.bsdf.compensation import compensation
from mrm_mtlx.bsdf.reflectance import conductor_reflectance, dielectric_reflectance, schlick_reflectance
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
from mrm_mtlx.reference.float32 import precision
from mrm_mtlx.reference.float32.intermediates import Perturbed
from mrm_mtlx.reference.float32.precision import ROOT_ERROR
from mrm_mtlx.reference.float32.rounding import UNIT, Quantity
from mrm_mtlx.reference.models import NOTHING, Contents, Feature, LobeKind, Model

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

_COLOR82 = Contents(features=frozenset({Feature.COLOR82}))


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
    def contents(self) -> Contents:
        """Contents of the lobe's response."""
        kinds = {
            LobeKind.RETROREFLECTIVE: np.any(self.retroreflective),
            LobeKind.ORDINARY: not np.all(self.retroreflective),
        }
        features = {
            Feature.THIN_FILM: np.any(self.thinfilm_thickness > 0.0),
            Feature.TRANSMISSION: self.scatter_mode != "R",
        }
        return Contents(
            frozenset(kind for kind, is_there in kinds.items() if is_there),
            frozenset(feature for feature, is_there in features.items() if is_there),
        )

    @property
    def off(self) -> bool:
        """True if the weight switches the lobe off at every sample."""
        return bool(np.all(self.weight < EPSILON))

    @property
    def widths(self) -> tuple[Array, Array]:
        """alpha_x and alpha_y as the shaders clamp them."""
        return np.clip(self.alpha_x, EPSILON, 1.0), np.clip(self.alpha_y, EPSILON, 1.0)


@dataclass(frozen=True)
class _Interface:
    """An interface: `reflectance(v.m)`; `white(A, B)` its albedo from the two fitted factors; how it refracts.

    `grazing` is what it is taken to reflect at grazing incidence.
    """

    reflectance: Callable[[Array], Array]
    white: Callable[[Array, Array], Array]
    grazing: Array | float = 1.0
    ior: Array | float = 1.5
    tint: Array | float = 1.0


def conductor(light: Light, facets: Facets, ior: Array, extinction: Array) -> Closure:
    """`conductor_bsdf`. Opaque: throughput 0, also at weight 0."""
    if facets.off or light.mode is Mode.TRANSMISSION:
        return opaque(np.zeros((3, 1)))

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        n, k = _over(c, ior), _over(c, extinction)
        return conductor_reflectance(c, n, k, *film, intermediates=_intermediates(light, facets, bare_modulus=True))

    seen = _evaluate(light, facets, _Interface(reflectance, lambda _a, _b: np.zeros(())))
    return Closure(seen.response, np.zeros((3, 1)), seen.contents)


def dielectric(light: Light, facets: Facets, tint: Array, ior: Array) -> Closure:
    """`dielectric_bsdf`; throughput 1 - albedo * weight, the tint left out."""
    if facets.off or (facets.scatter_mode == "T" and light.mode is not Mode.TRANSMISSION):
        return nothing()

    def reflectance(c: Array) -> Array:
        film = facets.thinfilm_thickness, facets.thinfilm_ior
        seen = dielectric_reflectance(c, ior, *film, intermediates=_intermediates(light, facets))
        return seen + precision.amplitude_error(seen, c, ior) if light.perturbs(Quantity.REFLECTANCE) else seen

    f0, tint = fresnel.reflectance_at_normal(ior), np.maximum(tint, 0.0)
    seen = _evaluate(light, facets, _Interface(reflectance, lambda a, b: a * f0 + b, ior=ior, tint=tint))
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
        at_0, at_82, at_90 = (_over(c, color) for color in (color0, color82, color90))
        return schlick_reflectance(c, at_0, at_82, at_90, exponent, *film, intermediates=_intermediates(light, facets))

    def reflectance(c: Array) -> Array:
        seen = with_film(c, facets.thinfilm_ior)
        if light.perturbs(Quantity.REFLECTANCE):
            rise, fast = _over(c, np.abs(color90 - color0)), light.model is Model.CLOSURES
            error = rise * precision.power_error(1.0 - c, exponent, fast=fast)
            # The reflectance at 82 degrees, of which the tint takes its share.
            at_82 = precision.power_error(np.asarray(1.0 - fresnel.COS_82), exponent, fast=fast)
            error = error + rise * at_82 * _over(c, np.abs(1.0 - color82)) * fresnel.tint_shape(c)
            if np.any(facets.thinfilm_thickness > 0.0):
                # The film's phase jumps by pi where its index is that of color0: there, a rounding decides.
                for step in (-2.0 * UNIT, 2.0 * UNIT):
                    error = error + np.abs(with_film(c, facets.thinfilm_ior * (1.0 + step)) - seen)
            seen = seen + error
        return seen

    def white(a: Array, b: Array) -> Array:
        return a * color0 + b * color90

    grazing = np.where(facets.thinfilm_thickness > 0.0, 1.0, color90)
    # The index for refraction is that of the mean colour.
    interface = _Interface(reflectance, white, grazing, fresnel.schlick_ior(np.mean(color0, axis=0)))
    seen = _evaluate(light, facets, interface, grey=True)
    # OSL's closure has no such parameter.
    tinted = light.model is Model.CLOSURES and not facets.off and np.any(color82 != 1.0)
    return replace(seen, contents=seen.contents | _COLOR82) if tinted else seen


def _over(cosine: Array, color: Array) -> Array:
    """A colour of each sample, to go with cosines of each sample, shape (samples,), or of many, (facets, samples)."""
    return color if cosine.ndim < 2 else color[:, None]


def _intermediates(light: Light, facets: Facets, *, bare_modulus: bool = False) -> Perturbed:
    """Errors of what stands under a square root in the Fresnel terms and cancels, where that is what is perturbed.

    That is under a film, and in a metal (`bare_modulus`) without one as well.
    """
    filmed = bool(np.any(facets.thinfilm_thickness > 0.0))
    return Perturbed(
        modulus_error=ROOT_ERROR if (filmed or bare_modulus) and light.perturbs(Quantity.MODULUS) else 0.0,
        product_error=ROOT_ERROR if filmed and light.perturbs(Quantity.PRODUCT) else 0.0,
    )


def _evaluate(light: Light, facets: Facets, interface: _Interface, *, grey: bool = False) -> Closure:
    """Response and throughput of a lobe in the light's mode; `grey`: the throughput is the mean of the channels."""
    v, cos_v, frame = light.kept("frame", lambda: _frame(light, facets))
    widths = facets.widths
    mean_alpha = np.sqrt(widths[0] * widths[1])
    albedo = light.numbers.microfacet_albedo
    a, b = light.kept("albedo", lambda: albedo.factors(cos_v, mean_alpha))
    reflectance = partial(_perturbed_reflectance, light, facets, interface)
    if light.mode is Mode.REFLECTION:
        cos_m, lobe = light.kept("lobe", lambda: _distributed(light, v, cos_v, frame, widths))
    else:
        cos_m, lobe = cos_v, light.kept("lobe", lambda: _around(light, facets, interface, v, frame))
    f = light.kept("reflectance", lambda: reflectance(cos_m))
    if light.perturbs(Quantity.ALBEDO) and light.model is Model.HARDWARE:
        a = a + UNIT * albedo.condition(cos_v, mean_alpha)
    mean = light.numbers.mean_reflectance(f, lambda: reflectance(np.ones_like(cos_m)), interface.grazing)
    gain = compensation(mean, a + b) if light.model is Model.HARDWARE else 1.0
    match light.mode:
        case Mode.REFLECTION:
            response = f * gain * lobe
        case Mode.INDIRECT:
            response = gain * lobe
        case Mode.TRANSMISSION:
            response = lobe
    lost = interface.white(a, b) * gain
    lost = np.mean(lost, axis=0, keepdims=True) if grey else lost
    on = facets.weight >= EPSILON
    return Closure(
        np.where(on, response * facets.weight, 0.0),
        np.where(on, 1.0 - lost * facets.weight, 1.0),
        facets.contents if light.model is Model.CLOSURES and np.any(on) else NOTHING,
    )


def _frame(light: Light, facets: Facets) -> tuple[Array, Array, tuple[Array, Array, Array]]:
    """The direction that a lobe is seen from, its cosine, and the frame about the normal that faces it."""
    turned = np.logical_and(facets.retroreflective, light.mode is not Mode.TRANSMISSION)
    v = light.v
    if np.any(turned):
        # v' = 2 (n.v) n - v, and n is turned to face it: n.v' = n.v, so it is the same turn as for v.
        v = np.where(turned, 2.0 * dot(facets.normal, v) * facets.normal - v, v)
    n = facing(facets.normal, v)
    x = unit(facets.tangent - dot(facets.tangent, n) * n)
    return v, cosine(n, v), (x, np.cross(n, x, axis=0), n)


def _perturbed_reflectance(light: Light, facets: Facets, interface: _Interface, cos_m: Array) -> Array:
    if not light.perturbs(Quantity.REFLECTANCE):
        return interface.reflectance(cos_m)
    # v.m is a sum of three rounded products, also where it is nearly 1 and no longer follows v and l.
    f = interface.reflectance(cos_m - UNIT * cos_m)
    return f + precision.film_error(f, facets.thinfilm_thickness, fast=light.model is Model.CLOSURES)


def _distributed(
    light: Light, v: Array, cos_v: Array, frame: tuple[Array, Array, Array], widths: tuple[Array, Array]
) -> tuple[Array, Array]:
    """v.h, and D G2 / (4 n.v): the lobe without its Fresnel term, times the cosine of l."""
    x, y, n = frame
    alpha_x, alpha_y = widths
    h = unit(v + light.l)
    hx, hy = dot(h, x), dot(h, y)
    if light.perturbs(Quantity.SLOPE) and light.model is Model.CLOSURES:
        # Renderers take an isotropic facet's slope from cos(n, m) alone: its square is what 1 leaves of cos^2.
        hx = np.where(alpha_x == alpha_y, np.sqrt(hx * hx + UNIT), hx)
    hz = dot(h, n)
    d = ggx.distribution(hx, hy, hz, alpha_x, alpha_y)
    if light.perturbs(Quantity.MOST):
        d = d + light.share * _steeper(d, (hx, hy, hz), widths, precision.half_vector_error(v, light.l))
    if light.model is Model.CLOSURES:
        lambda_v, lambda_l = (
            ggx.smith_lambda(dot(w, x), dot(w, y), cos_w, alpha_x, alpha_y)
            for w, cos_w in ((v, cos_v), (light.l, cosine(n, light.l)))
        )
        g = ggx.masking_shadowing(lambda_v, lambda_l) * (dot(n, light.l) > 0.0)
    else:
        g = ggx.masking_shadowing_isotropic(cos_v, cosine(n, light.l), np.sqrt(alpha_x * alpha_y))
    return cosine(v, h), np.asarray(d * g / (4.0 * cos_v))


def _steeper(d: Array, h: tuple[Array, Array, Array], widths: tuple[Array, Array], error: Array) -> Array:
    """Rise of D beyond that in proportion to the half-vector's roundings, which come one at a time.

    It rises as the inverse fourth power of the slope: where this is no more than its error, without proportion.
    """
    (hx, hy, hz), (alpha_x, alpha_y) = h, widths
    x, y = (np.maximum(np.abs(slope) - error, 0.0) for slope in (hx, hy))
    square = np.square(hx / alpha_x) + np.square(hy / alpha_y) + np.square(hz)
    gradient = 4.0 * d / square * (np.abs(hx) / np.square(alpha_x) + np.abs(hy) / np.square(alpha_y))
    rise = ggx.distribution(x, y, hz, alpha_x, alpha_y) - d
    return np.asarray(np.maximum(rise - error * gradient, 0.0))


def _around(light: Light, facets: Facets, interface: _Interface, v: Array, frame: tuple[Array, Array, Array]) -> Array:
    """Light of the environment in the lobe, reflected without the compensation, or refracted."""
    if light.mode is Mode.TRANSMISSION and facets.scatter_mode == "R":
        return np.zeros((3, 1))
    at, functions = (environment(light), v, frame, *facets.widths), light.perturbs(Quantity.FUNCTIONS)
    reflectance = partial(_perturbed_reflectance, light, facets, interface)
    if light.mode is Mode.INDIRECT:
        return reflected_radiance(*at, reflectance, functions=functions)
    return np.asarray(interface.tint * refracted_radiance(*at, reflectance, interface.ior, functions=functions))
