"""The closure of `chiang_hair_bsdf`.

MaterialX 1.39.5 departs from the model (`mrm_mtlx.bsdf.hair`) in this: the response is divided by pi once more, and the
rest lobe has pi / 2 where it should have 1 / (2 pi) (known upstream, MaterialX issue 2960 and pull request 3018); this
module does so where it is asked to (`Deviation.HAIR_CONSTANTS`). A light that the tilt of the cuticle takes beyond the
fibre's end keeps its negative cosine, here too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel, hair
from mrm_mtlx.reference.closures.light import EPSILON, Closure, Light, Mode, dot, facing, opaque, unit
from mrm_mtlx.reference.closures.microfacet import Facets, dielectric
from mrm_mtlx.reference.float32.precision import (
    ARCTANGENT_ERROR,
    SINE_ERROR,
    ULP,
    amplitude_error,
    exponential_error,
    logarithm_error,
    widened,
)
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, SMALLEST, UNIT, Quantity

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# The azimuthal constant of the rest lobe.
_REST_AZIMUTHAL = 0.5 / np.pi
# How many times the cuticle's tilt shifts the paths R, TT and TRT.
_TILTS = (2.0, -1.0, -4.0)
_LEAST_ROUGHNESS = 0.001
_NARROWEST, _WIDEST = -88.0, 88.0  # exponents that float32 has

# Relative, in full: of a product of directions, or of a quotient of such.
_ROUNDED = ROUNDING_FACTOR * UNIT
# Absolute, in full, of 1 - x^2 for x so rounded.
_CANCELLED = 2.0 * _ROUNDED


@dataclass(frozen=True)
class Fibre:
    """The inputs of `chiang_hair_bsdf`; roughnesses (2, samples) are the variance of M_p and the scale of N_p.

    `as_written`: with the constants of MaterialX's code and not with the model's.
    """

    tint_r: Array
    tint_tt: Array
    tint_trt: Array
    ior: Array
    roughness_r: Array
    roughness_tt: Array
    roughness_trt: Array
    cuticle_angle: Array
    absorption: Array
    normal: Array
    direction: Array
    as_written: bool = False


@dataclass(frozen=True)
class _Geometry:
    """Directions about a fibre: sines of theta, cosine and side of gamma at the viewer's side, azimuth of l from v."""

    sin_o: Array
    sin_i: Array
    cos_gamma: Array
    side: Array
    phi: Array


def chiang_hair(light: Light, fibre: Fibre) -> Closure:
    """`chiang_hair_bsdf`; throughput 0.

    In an environment, the reflection of a dielectric, whose widths are the mean roughnesses, tinted by the mean tint.
    """
    if light.mode is Mode.TRANSMISSION:
        return opaque(np.zeros((3, 1)))
    if light.mode is Mode.INDIRECT:
        width = (fibre.roughness_r + fibre.roughness_tt + fibre.roughness_trt) / 3.0
        none = np.zeros(())
        facets = Facets(np.ones(()), width[0], width[1], none, none, none + 1.0, fibre.normal, fibre.direction)
        tint = (fibre.tint_r + fibre.tint_tt + fibre.tint_trt) / 3.0
        return opaque(dielectric(light, facets, np.ones((3, 1)), fibre.ior).response * tint)
    at = _geometry(light, fibre)
    # Each path on its own, so that what one loses by an error does not hide what another gains.
    rest = light.numbers.hair_rest_azimuthal if fibre.as_written else _REST_AZIMUTHAL
    paths = (widened(partial(_path, at, fibre, path, rest), **_errors(light, at, fibre, path)) for path in range(4))
    return opaque(np.asarray(sum(paths) / (np.pi if fibre.as_written else 1.0)))


def _geometry(light: Light, fibre: Fibre) -> _Geometry:
    n = facing(fibre.normal, light.v)
    x = unit(fibre.direction - dot(fibre.direction, n) * n)
    y = np.cross(n, x, axis=0)
    sin_o, sin_i = dot(light.v, x), dot(light.l, x)
    v_n, v_y, l_n, l_y = (dot(w, axis) for w in (light.v, light.l) for axis in (n, y))
    across = unit(light.v - x * sin_o)
    return _Geometry(
        sin_o=sin_o,
        sin_i=sin_i,
        cos_gamma=dot(n, across),
        side=np.where(dot(across, y) > 0.0, -1.0, 1.0),
        phi=np.arctan2(l_n * v_y - v_n * l_y, l_y * v_y + l_n * v_n),
    )


def _section(
    at: _Geometry,
    ior: Array,
    cos2_o: Array | float = 0.0,
    sin2_gamma: Array | float = 0.0,
    bend: Array | float = 0.0,
) -> tuple[Array, Array]:
    """Sines of gamma outside and inside of the fibre, in its round section; displaced as `_errors` says."""
    squared = 1.0 - at.cos_gamma * at.cos_gamma + sin2_gamma
    # An error beyond 0 comes out on the other side of the fibre.
    outside = np.clip(at.side * np.sign(squared) * np.sqrt(np.abs(squared)), -1.0, 1.0)
    eta = _root(ior * ior - at.sin_o * at.sin_o) / np.maximum(_root(1.0 - at.sin_o * at.sin_o + cos2_o), EPSILON)
    return outside, np.clip(outside / eta * (1.0 + bend), -1.0, 1.0)


def _path(
    at: _Geometry,
    fibre: Fibre,
    path: int,
    rest_azimuthal: float,
    *,
    cos2_o: float = 0.0,
    cos2_i: float = 0.0,
    sin2_gamma: float = 0.0,
    bend: Array | float = 0.0,
    crossing: Array | float = 0.0,
    reflected: Array | float = 0.0,
    azimuth: Array | float = 0.0,
    exponent: float = 0.0,
    switch: float = 0.0,
    sine: float = 0.0,
    cosine: float = 0.0,
    exponentials: float = 0.0,
) -> Array:
    """M_p N_p A_p of a path, tinted, shape (3, samples); its intermediate results displaced as `_errors` says."""
    cos_o, cos_i = (_root(1.0 - s * s + lost) for s, lost in ((at.sin_o, cos2_o), (at.sin_i, cos2_i)))
    f = np.clip(fresnel.dielectric(cos_o * at.cos_gamma, fibre.ior) + reflected, 0.0, 1.0)
    _, inside = _section(at, fibre.ior, cos2_o, sin2_gamma, bend)
    length = 2.0 * _root(1.0 - np.square(inside)) / _root(1.0 - np.square(at.sin_o / fibre.ior))
    depth = fibre.absorption * length * (1.0 + crossing)
    transmitted = np.exp(-depth) * (1.0 + exponentials * exponential_error(depth))
    # Besides, whatever is too small for float32 is 0: the factors, and their products.
    flushed = exponentials * SMALLEST
    share = hair.attenuations(f, transmitted)[path] + flushed

    tint = np.maximum((fibre.tint_r, fibre.tint_tt, fibre.tint_trt, fibre.tint_trt)[path], 0.0)
    roughness = (fibre.roughness_r, fibre.roughness_tt, fibre.roughness_trt, fibre.roughness_trt)[path]
    variance, scale = np.clip(roughness, _LEAST_ROUGHNESS, 1.0)
    shifted = _shifted(path, at.sin_i, cos_i, fibre.cuticle_angle, sine, cosine)
    along = _longitudinal(shifted, (at.sin_o, cos_o), variance, exponent, switch, exponentials)
    if path == 3:
        return np.asarray(along * rest_azimuthal * tint * share + 3.0 * flushed)
    # Of the exponential 3 + 2 x ulp, of its argument's division and constants four more per unit.
    apart, error = at.phi - _exit_azimuth(at, fibre.ior, path), exponentials * 6.0 * ULP
    about = _azimuthal(apart, scale, azimuth, error) + 2.0 * flushed / scale
    return np.asarray(along * about * tint * share + 3.0 * flushed)


def _azimuthal(phi: Array, scale: Array, azimuth: Array | float, exponential_error: float) -> Array:
    """N_p: the distance from the path's azimuth displaced, not beyond 0, and the exponential off by a relative error.

    `exponential_error` is per unit of the exponent plus one.
    """
    s = hair.logistic_scale(scale)
    apart = np.clip(hair.angle_between(phi) + azimuth, 0.0, np.pi)
    falling = np.maximum(np.exp(-apart / s) * (1.0 + exponential_error * (1.0 + apart / s)), 0.0)
    return hair.trimmed_logistic(falling, s)


def _exit_azimuth(at: _Geometry, ior: Array, path: int, **displaced: Array | float) -> Array:
    outside, inside = _section(at, ior, **displaced)
    return hair.exit_azimuth(path, np.arcsin(outside), np.arcsin(inside))


def _shifted(
    path: int, sin_i: Array, cos_i: Array, cuticle_angle: Array, sine: float, cosine: float
) -> tuple[Array, Array]:
    """Sine and cosine of theta_i after the cuticle's tilt; the tilt's own displaced by `sine` and `cosine`."""
    if path == 3:
        return sin_i, cos_i
    tilt = cuticle_angle * np.pi - 0.5 * np.pi  # from [0, 1] to a right angle to either side
    # Without a tilt nothing is computed.
    s = np.where(tilt == 0.0, 0.0, np.sin(_TILTS[path] * tilt) + sine)
    c = np.where(tilt == 0.0, 1.0, np.cos(_TILTS[path] * tilt) + cosine)
    return sin_i * c + cos_i * s, cos_i * c - sin_i * s


def _longitudinal(
    i: tuple[Array, Array], o: tuple[Array, Array], variance: Array, exponent: float, switch: float, exponentials: float
) -> Array:
    a, b = i[1] * o[1] / variance, i[0] * o[0] / variance
    # The series of log I0 change at 12, with a step: it is shifted by as much as a is uncertain.
    with np.errstate(divide="ignore"):
        uncertain = np.minimum(_ROUNDED * (2.0 + 1.0 / np.square(i[1]) + 1.0 / np.square(o[1])), 0.5)
    bessel_switch = hair.BESSEL_SWITCH * (1.0 + switch * uncertain)
    value = hair.longitudinal(
        *i, *o, variance, bessel_switch=bessel_switch, variance_switch=hair.VARIANCE_SWITCH * (1.0 + switch * _ROUNDED)
    )
    # Terms as large as 1 / variance cancel in the exponent.
    value = value * np.exp(exponent * (np.abs(a) + np.abs(b) + 1.0 / variance))
    if not exponentials:
        return value
    with np.errstate(divide="ignore"):
        total = np.clip(np.log(value), _NARROWEST, _WIDEST)
    series = logarithm_error(hair.bessel_i0(np.minimum(a, hair.BESSEL_SWITCH)))
    asymptotic = logarithm_error(np.asarray(2.0 * np.pi)) + logarithm_error(1.0 / np.maximum(a, 1.0))
    logarithms = np.maximum(series, asymptotic) + logarithm_error(0.5 / variance)
    narrow = exponential_error(total) + logarithms
    rough = exponential_error(b) + exponential_error(1.0 / variance)
    relative = np.where(variance < hair.VARIANCE_SWITCH, narrow, rough)
    return np.asarray(value * (1.0 + exponentials * relative) + exponentials * SMALLEST)


def _errors(light: Light, at: _Geometry, fibre: Fibre, path: int) -> dict[str, Array | float]:
    """Errors of what `_path` displaces, in full, for the perturbed quantity.

    Those of the azimuth are joined to one: the lobe falls exponentially, so that their changes would multiply, and it
    may peak between them.
    """
    arcs = np.abs(at.phi)
    for times, sine in zip((2.0, 2.0 * path), _section(at, fibre.ior), strict=True):
        arcs = arcs + times * np.abs(np.arcsin(sine))
    if light.perturbs(Quantity.FUNCTIONS):
        # Of sines and cosines of the cuticle's tilt; beyond pi, to which it goes for TRT, no bound is stated.
        tilt = {"sine": SINE_ERROR, "cosine": SINE_ERROR}
        return {"azimuth": ARCTANGENT_ERROR * arcs, "exponentials": 1.0, **tilt}
    if not light.perturbs(Quantity.REFLECTANCE):
        return {}
    sin2, ior2 = np.square(at.sin_o), np.square(fibre.ior)
    cos_d = _root(1.0 - sin2) * at.cos_gamma
    f = fresnel.dielectric(cos_d, fibre.ior)
    with np.errstate(divide="ignore"):
        inside = np.minimum((ior2 + sin2) / np.abs(ior2 - sin2), 1.0 / _ROUNDED)
    # The index seen across the fibre cancels for an index near 1, and with it the path through the fibre.
    section: dict[str, Array | float] = {"cos2_o": _CANCELLED, "sin2_gamma": _CANCELLED, "bend": _ROUNDED * inside}
    exit_azimuth = partial(_exit_azimuth, at, fibre.ior, path)
    turned = ROUNDING_FACTOR * (widened(exit_azimuth, **section) - exit_azimuth())
    return {
        **section,
        "cos2_i": _CANCELLED,
        "crossing": _ROUNDED * inside,
        "reflected": ROUNDING_FACTOR * amplitude_error(f, cos_d, fibre.ior) + _ROUNDED * f,
        "azimuth": turned + _ROUNDED * (arcs + path * np.pi),
        "exponent": _ROUNDED,
        "switch": 1.0,
    }


def _root(x: Array) -> Array:
    return np.sqrt(np.maximum(x, 0.0))
