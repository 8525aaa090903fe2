"""The closure of `sheen_bsdf`, in its two modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import sheen as cloth
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
    unit,
)
from mrm_mtlx.reference.float32.precision import ULP, half_vector_error, power_error, widened
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, SMALLEST, UNIT, Quantity

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

CONTY_KULLA, ZELTNER = "conty_kulla", "zeltner"

# Roughness below which the exponent of the fibres' distribution grows no more, and the least of the transformed cosine.
LEAST_FIBRE_ROUGHNESS = 0.005
LEAST_COSINE_ROUGHNESS = 0.01

# Of a cosine near 1: three rounded products and their sum, of directions that have their own roundings. In full.
_COSINE_ERROR = ROUNDING_FACTOR * UNIT


def sheen(light: Light, mode: str, weight: Array, color: Array, roughness: Array, normal: Array) -> Closure:
    """`sheen_bsdf`; throughput 1 - albedo * weight, the colour left out. 1 in transmission."""
    if light.mode is Mode.TRANSMISSION or np.all(weight < EPSILON):
        return nothing()
    n = facing(normal, light.v)
    cos_v = cosine(n, light.v)
    if mode == ZELTNER:
        roughness = np.clip(roughness, LEAST_COSINE_ROUGHNESS, 1.0)
    albedo, error = _albedo(light, cos_v, roughness, mode)
    if light.mode is Mode.INDIRECT:
        lobe = environment(light).irradiance(n) * (albedo + error)
    elif mode == ZELTNER:
        lobe = (albedo + error) * _ltc(light, n, cos_v, roughness)
    else:
        lobe = _fibres(light, n, cos_v, roughness)
    on = weight >= EPSILON
    # Both taken up: what the top gains, a layer's base loses, and a sum of the two could hide it.
    through = 1.0 - albedo * weight + error * weight
    return Closure(np.where(on, lobe * color * weight, 0.0), np.where(on, through, 1.0) * np.ones((3, 1)))


def _albedo(light: Light, cos_v: Array, roughness: Array, mode: str) -> tuple[Array, Array]:
    """The fitted albedo, and its error where that is what is perturbed."""
    rounding = UNIT if light.perturbs(Quantity.ALBEDO) else 0.0
    if mode == CONTY_KULLA:
        fibres = light.numbers.fibre_albedo
        exact, perturbed = (fibres.albedo(cos_v, roughness, rounding=r) for r in (0.0, rounding))
        return exact, perturbed - exact
    # The exponential's error is 3 + 2 |exponent| ulp (GLSL 4.60, section 4.7.1).
    exponential = 3.0 * ULP / ROUNDING_FACTOR if light.perturbs(Quantity.FUNCTIONS) else 0.0
    cosine_fit = light.numbers.cloth_cosine
    exact = cosine_fit.albedo(cos_v, roughness)
    perturbed = cosine_fit.albedo(cos_v, roughness, rounding=rounding, exponential_error=exponential)
    return exact, perturbed - exact


def _fibres(light: Light, n: Array, cos_v: Array, roughness: Array) -> Array:
    """The lobe of Conty and Kulla times the cosine of l."""
    roughness = np.maximum(roughness, LEAST_FIBRE_ROUGHNESS)
    cos_l, cos_h = cosine(n, light.l), cosine(n, unit(light.l + light.v))
    exponent = 0.5 * cloth.fibre_exponent(roughness)
    sin2_h = 1.0 - np.square(cos_h)

    def distribution(lost: Array | float = 0.0, power: Array | float = 0.0, flushed: float = 0.0) -> Array:
        value = cloth.fibre_distribution(np.clip(sin2_h + lost, 0.0, 1.0), roughness)
        return np.asarray(value + power * (1.0 + exponent) / np.pi + flushed)

    if light.perturbs(Quantity.REFLECTANCE):
        # The sine is what 1 leaves of the squared cosine, and at 0 does not follow the half-vector in proportion.
        d = widened(distribution, lost=2.0 * _COSINE_ERROR + np.square(half_vector_error(light.v, light.l)))
    elif light.perturbs(Quantity.FUNCTIONS):
        # The exponent's own error, of a division (2.5 ulp) and of a number, counts by log(sin2).
        # What is too small for float32 is 0: the power, and what follows from it.
        power = ROUNDING_FACTOR * power_error(sin2_h, exponent, fast=False) + SMALLEST
        with np.errstate(divide="ignore", invalid="ignore"):
            by_exponent = np.nan_to_num(sin2_h**exponent * exponent * np.abs(np.log(sin2_h)) * 3.0 * ULP)
        d = widened(distribution, power=power + by_exponent, flushed=SMALLEST)
    else:
        d = distribution()
    return d * cloth.fibre_visibility(cos_v, cos_l) * cos_l


def _ltc(light: Light, n: Array, cos_v: Array, roughness: Array) -> Array:
    """The lobe of Zeltner et al. of albedo 1, the cosine of l included."""
    across = light.v - n * cos_v
    squared = dot(across, across)
    # Seen along the normal the lobe is round, and any tangent will do.
    x = np.where(squared > 0.0, across / np.sqrt(np.where(squared > 0.0, squared, 1.0)), 0.0)
    lx, lz = dot(light.l, x), dot(light.l, n)
    ly = np.sqrt(np.maximum(dot(light.l, light.l) - lx * lx - lz * lz, 0.0))
    fit = light.numbers.cloth_cosine
    a = fit.scale(cos_v, roughness)

    def density(lost: float = 0.0) -> Array:
        return cloth.ltc_density(lx, ly, lz, a, fit.shear(cos_v, roughness, lost=lost))

    return widened(density, lost=_COSINE_ERROR) if light.perturbs(Quantity.REFLECTANCE) else density()
