"""Diffuse closures: broad lobes from the cosines of the directions."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import diffuse
from mrm_mtlx.bsdf.intermediates import EXACT
from mrm_mtlx.bsdf.subsurface import diffusion_profile
from mrm_mtlx.reference.closures.light import (
    EPSILON,
    Closure,
    Light,
    Mode,
    cosine,
    dot,
    environment,
    facing,
    opaque,
    unit,
)
from mrm_mtlx.reference.float32 import precision
from mrm_mtlx.reference.float32.intermediates import Perturbed
from mrm_mtlx.reference.float32.precision import ARCTANGENT_ERROR, SINE_ERROR, exponential_error, widened
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, Quantity
from mrm_mtlx.reference.models import Contents, Feature, Model

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# The sphere over which light diffuses has the surface's curvature, or this radius where it is flatter; and into so many
# steps its circumference is divided.
_FLAT_RADIUS = 100.0
_STEPS = 32
# Mean free paths are taken to be at least so long.
_SHORTEST_PATH = 0.1

_ROUGH = Contents(features=frozenset({Feature.ROUGH_DIFFUSE}))


def oren_nayar(
    light: Light, weight: Array, color: Array, roughness: Array, normal: Array, energy_compensation: Array
) -> Closure:
    """`oren_nayar_diffuse_bsdf`; throughput 0."""
    if _dark(light, weight):
        return opaque(np.zeros((3, 1)))
    n = facing(normal, light.v)
    cos_v = cosine(n, light.v)
    within = Perturbed(arc_cosine_error=precision.ARCCOS_ERROR) if light.perturbs(Quantity.REFLECTANCE) else EXACT
    if light.mode is Mode.INDIRECT:
        compensated = diffuse.compensated_oren_nayar_albedo(cos_v, roughness, color, intermediates=within)
        plain = color * light.numbers.oren_nayar_albedo.albedo(cos_v, roughness)
        seen = environment(light).irradiance(n) * np.where(energy_compensation, compensated, plain)
    else:
        cos_l, v_l = cosine(n, light.l), cosine(light.l, light.v)
        plain = color * diffuse.oren_nayar(cos_v, cos_l, v_l, roughness)
        compensated = diffuse.compensated_oren_nayar(cos_v, cos_l, v_l, roughness, color, intermediates=within)
        seen = np.where(energy_compensation, compensated, plain) * cos_l
    # Cycles has an Oren-Nayar model of its own, neither of these two; without roughness all are Lambert's.
    other = light.model is Model.CLOSURES and np.any(roughness != 0.0)
    return replace(_weighted(seen, weight), contents=_ROUGH) if other else _weighted(seen, weight)


def burley(light: Light, weight: Array, color: Array, roughness: Array, normal: Array) -> Closure:
    """`burley_diffuse_bsdf`; throughput 0."""
    if _dark(light, weight):
        return opaque(np.zeros((3, 1)))
    n = facing(normal, light.v)
    cos_v = cosine(n, light.v)
    if light.mode is Mode.INDIRECT:
        albedo = light.numbers.burley_albedo.albedo(cos_v, roughness)
        return _weighted(environment(light).irradiance(n) * albedo * color, weight)
    cos_l, l_h = cosine(n, light.l), cosine(light.l, unit(light.l + light.v))

    def lobe(beside: Array | float = 0.0) -> Array:
        return diffuse.burley(cos_v, cos_l, np.sqrt(np.maximum(np.square(l_h) + beside, 0.0)), roughness)

    if light.perturbs(Quantity.REFLECTANCE):
        # The square of l.h does not follow the half-vector in proportion where it is 0.
        seen = widened(lobe, beside=np.square(precision.half_vector_error(light.v, light.l)))
    else:
        seen = lobe()
    return _weighted(color * seen * cos_l, weight)


def translucent(light: Light, weight: Array, color: Array, normal: Array) -> Closure:
    """`translucent_bsdf`, diffuse light from the other side; throughput 0.

    The other side is that of the normal and not of the viewer: seen from behind, it reflects what it should let
    through.
    """
    if _dark(light, weight):
        return opaque(np.zeros((3, 1)))
    if light.mode is Mode.INDIRECT:
        return _weighted(environment(light).irradiance(-normal) * color, weight)
    return _weighted(color * np.clip(dot(-normal, light.l), 0.0, 1.0) / np.pi, weight)


def subsurface(light: Light, weight: Array, color: Array, radius: Array, normal: Array) -> Closure:
    """`subsurface_bsdf` of a flat surface; throughput 0.

    Diffusion over a sphere instead of transport through the volume; of an environment, plain diffuse reflection.
    """
    if _dark(light, weight):
        return opaque(np.zeros((3, 1)))
    n = facing(normal, light.v)
    if light.mode is Mode.INDIRECT:
        return _weighted(environment(light).irradiance(n) * color, weight)
    return _weighted(color * _diffused_cosine(light, dot(n, light.l), np.maximum(radius, _SHORTEST_PATH)), weight)


def _diffused_cosine(light: Light, cos_l: Array, path: Array) -> Array:
    """Cosine of the light over pi, diffused about a great circle of the sphere, shape (3, samples).

        sum over x of  R(d(x)) max(cos(theta + x), 0)  /  (pi sum over x of  R(d(x)))         d the chord of the arc x

    over the middles of the steps (after Penner 2011, "Pre-integrated skin shading", with another profile).
    """
    cos_l = np.clip(cos_l, -1.0, 1.0)
    sin_l = np.sqrt(1.0 - np.square(cos_l))
    arcs = (np.arange(_STEPS) + 0.5) * (2.0 * np.pi / _STEPS) - np.pi
    chords = 2.0 * _FLAT_RADIUS * np.abs(np.sin(0.5 * arcs))
    weights = [diffusion_profile(chord, 1.0 / path) for chord in chords]
    total = sum(weights)

    def lit(arc: float, turn: Array | float = 0.0) -> Array:
        return np.asarray(np.maximum(cos_l * np.cos(arc + turn) - sin_l * np.sin(arc + turn), 0.0))

    def mean(angle: Array | float = 0.0) -> Array:
        return np.asarray(sum(w * lit(arc, angle) for w, arc in zip(weights, arcs, strict=True)) / (total * np.pi))

    if not light.perturbs(Quantity.FUNCTIONS):
        return mean()
    # Of the steps, each on its own: the cosine, and the weight through the chord's sine and the profile's exponentials,
    # of which the slower one matters. A weight counts by how far its cosine is from the mean of all.
    exact = mean() * np.pi
    change = np.zeros_like(exact)
    for arc, chord, weight in zip(arcs, chords, weights, strict=True):
        nearer = diffusion_profile(chord * (1.0 - SINE_ERROR / np.abs(np.sin(0.5 * arc))), 1.0 / path)
        off = nearer - weight + weight * exponential_error(1.0 + chord / (3.0 * path))
        change = change + weight * SINE_ERROR + off * np.abs(lit(arc) - exact)
    by_angle = widened(mean, angle=ARCTANGENT_ERROR * np.arccos(cos_l))
    return by_angle + change / (total * np.pi * ROUNDING_FACTOR)


def _dark(light: Light, weight: Array) -> bool:
    """True if a diffuse lobe shows nothing at any sample; it is not evaluated."""
    return light.mode is Mode.TRANSMISSION or bool(np.all(weight < EPSILON))


def _weighted(seen: Array, weight: Array) -> Closure:
    return opaque(np.where(weight >= EPSILON, seen * weight, 0.0))
