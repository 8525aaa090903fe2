"""The lobe that stands for a retroreflective one where nothing but the standard library is known.

An ordinary lobe in a frame that is turned toward the viewer; the theory is in docs/osl.md, under "The aligned lobe".
Light from below the surface is not cut off here as renderers of OSL do, so that a lobe which is made wider, to follow
the bend of the exact one, would send too much of it. In its place a second lobe follows the bend, the wing: broader
across the plane of incidence, turned toward n, and without weight for narrow lobes, which bend little.

The sign of the view direction does not matter: targets differ in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mrm_mtlx.library.portable.expressions import Expressions, Value

# Gauss-Legendre nodes and weights on [-1, 1]; as many as a vector has components.
_NODES = (-0.861136, -0.339981, 0.339981, 0.861136)
_SHARES = (0.347855, 0.652145, 0.652145, 0.347855)

# Generators write constants with six decimals.
_TINY = 1e-6

# Widths that are told apart, and the smallest cosine of the view direction.
_NARROWEST, _GRAZING = 1e-4, 1e-3

# What is fitted, to the L1 error and the albedo over alpha 0.04 to 0.25 and 30 to 70 degrees, light from below the
# surface counted as an error (docs/portable.md). x = alpha tan(theta), beyond the value of _WING_FROM.
_WING_FROM = 0.035  # below, there is no wing: real retroreflectors are narrower
_WING = 0.8  # weight of the wing: _WING x / (1 + _WING x)
_WING_TURN = 0.75  # its turn toward n, in widths
_WING_ALONG, _WING_ACROSS = 0.9, 2.0  # its widths, relative to those of the core
_NARROWED = 0.7  # the core is narrower by 1 + _NARROWED x
_WIDENED = 2.5  # across the plane of incidence: c -> sqrt(c^2 + _WIDENED alpha^2 s^2)
_SHIFT = 1.5  # the slope of the reflectance turns the lobe by so much more than its first moment


class Frame(NamedTuple):
    """The plane of incidence, seen from the side of the surface that the view direction (or its opposite) is on."""

    view: Value
    side: Value  # n.view for the given n: the sign tells which side it is
    along: Value  # across the view direction, in the plane of incidence, pointing away from n
    across: Value
    cosine: Value
    sine: Value
    tangent: Value  # of the angle of incidence
    azimuth: Value  # of the plane of incidence from the surface's tangent: its cosine
    azimuth_sine: Value


class Widths(NamedTuple):
    """The lobe about n: inverse squared widths along the plane of incidence, mixed, and across it."""

    along: Value
    mixed: Value
    across: Value
    alpha: Value  # in the plane of incidence
    shear: Value  # slope across per slope along, for the most probable facet
    narrow: Value  # square of the smaller width


class Facets(NamedTuple):
    """Four facets of the lobe: what v' sees of each."""

    cosine: Value  # v'.m
    weight: Value  # share of the lobe, sums to 1
    pull: Value  # times how far the facet pulls the lobe along
    centre: Value  # sum of `pull`


class Reflectance(NamedTuple):
    """Of a lobe, as vectors: the mean over its facets, and the sum over them with their pull."""

    mean: Value
    pulled: Value


@dataclass(frozen=True)
class Part:
    """An ordinary lobe, one of two: its share of the weight, its frame and its widths."""

    share: Value
    normal: Value
    tangent: Value
    roughness: Value


class AlignedLobe(NamedTuple):
    """The two parts, and the colour that both reflect at every angle."""

    color: Value
    core: Part
    wing: Part


def aligned_lobe(
    nodes: Expressions, inputs: Mapping[str, Value], reflectance: Callable[..., Reflectance]
) -> AlignedLobe:
    """The ordinary lobes that stand for a retroreflective one.

    Parameters
    ----------
    nodes
        Where it is written.
    inputs
        Of the microfacet node: normal, tangent, roughness, and those of its reflectance.
    reflectance
        `conductor`, `dielectric` or `schlick`.
    """
    frame = _frame(nodes, inputs["normal"], inputs["tangent"])
    widths = _widths(nodes, frame, inputs["roughness"])
    facets = _facets(nodes, frame, widths)
    mean, pulled = reflectance(nodes, facets, inputs)
    grey = nodes.sum(mean).at_least(_TINY)
    shift = widths.alpha * (nodes.sum(pulled) / grey - facets.centre) * _SHIFT
    excess = (widths.alpha * frame.tangent - _WING_FROM).at_least(0.0)
    wing = excess * _WING / (1.0 + excess * _WING)
    narrowed = (1.0 + excess * _NARROWED) * (1.0 + excess * _NARROWED)
    squeeze = (frame.cosine * frame.cosine + widths.narrow * frame.sine * frame.sine * _WIDENED).root()
    core = (widths.along * narrowed, widths.mixed * narrowed / squeeze, widths.across * narrowed / (squeeze * squeeze))
    broad = (
        core[0] * (1.0 / _WING_ALONG**2),
        core[1] * (1.0 / (_WING_ALONG * _WING_ACROSS)),
        core[2] * (1.0 / _WING_ACROSS**2),
    )
    sideways = frame.across * (frame.cosine * shift * widths.shear)
    turn = (widths.alpha * _WING_TURN).at_most(frame.tangent)
    return AlignedLobe(
        mean.at_least(0.0),
        _part(nodes, frame, 1.0 - wing, frame.along * shift + sideways, core),
        _part(nodes, frame, wing, frame.along * (shift - turn) + sideways, broad),
    )


def conductor(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Fresnel's equations with a complex index, per channel."""
    index, extinction = (inputs[name] for name in ("ior", "extinction"))
    channels = [_metal(index.component(i), extinction.component(i), facets.cosine) for i in range(3)]
    return Reflectance(
        nodes.vector(nodes.dot(facets.weight, curve) for curve in channels),
        nodes.vector(nodes.dot(facets.pull, curve) for curve in channels),
    )


def dielectric(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Fresnel's equations; total beyond the critical angle."""
    cosine, index = facets.cosine, inputs["ior"]
    g = (cosine * cosine + (index * index - 1.0)).at_least(0.0).root()
    perpendicular = (g - cosine) / (g + cosine).at_least(_TINY)
    parallel = ((g + cosine) * cosine - 1.0) / ((g - cosine) * cosine + 1.0).at_least(_TINY)
    curve = perpendicular * perpendicular * (1.0 + parallel * parallel) * 0.5
    tint = inputs["tint"]
    return Reflectance(tint * nodes.dot(facets.weight, curve), tint * nodes.dot(facets.pull, curve))


def schlick(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Schlick's curve between two colours, with the tint at 82 degrees of Hoffman (2023) if it is given."""
    grazing = 1.0 - facets.cosine
    curve = grazing.to_the(inputs["exponent"])
    normal, edge = (inputs[name].at_least(0.0) for name in ("color0", "color90"))
    mean = normal + (edge - normal) * nodes.dot(facets.weight, curve)
    pulled = normal * facets.centre + (edge - normal) * nodes.dot(facets.pull, curve)
    if "color82" not in inputs:
        return Reflectance(mean, pulled)
    cubed = grazing * grazing * grazing
    dip = facets.cosine * cubed * cubed * (7.0 * (7.0 / 6.0) ** 6)  # 1 at cos 1/7
    there = normal + (edge - normal) * nodes.constant(6.0 / 7.0).to_the(inputs["exponent"])
    depth = there * (1.0 - inputs["color82"].at_least(0.0))
    return Reflectance(
        mean - depth * nodes.dot(facets.weight, dip),
        pulled - depth * nodes.dot(facets.pull, dip),
    )


def _metal(index: Value, extinction: Value, cosine: Value) -> Value:
    """Mean of both polarisations, Rs (1 + Rp / Rs) / 2; without a division by the cosine."""
    cosine2 = cosine * cosine
    sine2 = 1.0 - cosine2
    difference = index * index - extinction * extinction - sine2
    product = index * extinction * 2.0
    modulus = (difference * difference + product * product).root()
    real = ((modulus + difference) * 0.5).at_least(0.0).root()
    sum_s, twice_s = modulus + cosine2, real * cosine * 2.0
    sum_p, twice_p = modulus * cosine2 + sine2 * sine2, real * cosine * sine2 * 2.0
    # 1 + (sum_p - twice_p) / (sum_p + twice_p) = 2 sum_p / (sum_p + twice_p)
    return (sum_s - twice_s) / (sum_s + twice_s) * sum_p / (sum_p + twice_p).at_least(_TINY)


def _frame(nodes: Expressions, normal: Value, tangent: Value) -> Frame:
    view = nodes.node("viewdirection", "vector3", {}, space="world")
    outward = normal.normalized()
    side = nodes.dot(outward, view)
    n = nodes.where(side, 0.0, outward, -outward)
    x = (tangent - n * nodes.dot(tangent, n)).normalized()
    y = nodes.cross(n, x)
    cosine = side.absolute().at_least(_GRAZING).at_most(1.0)
    sine = (1.0 - cosine * cosine).root()
    lean = view - n * side.absolute()
    length = lean.length()
    plane = nodes.where(length, 1e-5, lean / length.at_least(_TINY), x)
    along = plane * cosine - n * sine
    azimuth = nodes.dot(plane, x), nodes.dot(plane, y)
    return Frame(view, side, along, nodes.cross(n, plane), cosine, sine, sine / cosine, *azimuth)


def _widths(nodes: Expressions, frame: Frame, roughness: Value) -> Widths:
    alpha_x, alpha_y = (roughness.component(i).at_least(_NARROWEST).at_most(1.0) for i in range(2))
    square_x, square_y = alpha_x * alpha_x, alpha_y * alpha_y
    if alpha_x.number is not None and alpha_x.number == alpha_y.number:
        inverse, zero = 1.0 / square_x, nodes.constant(0.0)
        return Widths(along=inverse, mixed=zero, across=inverse, alpha=alpha_x, shear=zero, narrow=square_x)
    inverse_x, inverse_y = 1.0 / square_x, 1.0 / square_y
    cosine2, sine2 = frame.azimuth * frame.azimuth, frame.azimuth_sine * frame.azimuth_sine
    both = frame.azimuth * frame.azimuth_sine
    squared = cosine2 * square_x + sine2 * square_y
    return Widths(
        along=cosine2 * inverse_x + sine2 * inverse_y,
        mixed=both * (inverse_y - inverse_x),
        across=sine2 * inverse_x + cosine2 * inverse_y,
        alpha=squared.root(),
        shear=both * (square_y - square_x) / squared,
        narrow=square_x.at_most(square_y),
    )


def _facets(nodes: Expressions, frame: Frame, widths: Widths) -> Facets:
    """Facets m = (X, 0, 1) / |.| in the plane of incidence, X away from v': Gauss-Legendre in X / sqrt(a^2 + X^2)."""
    square = widths.alpha * widths.alpha
    steepest = frame.cosine / (1.0 + frame.sine)
    top = steepest / (square + steepest * steepest).root()
    bottom = -1.0 / (1.0 + square * steepest * steepest).root()
    xi = nodes.constant(_NODES, "vector4") * ((top - bottom) * 0.5) + (top + bottom) * 0.5
    root = (1.0 - xi * xi).at_least(_TINY).root()
    slope = xi / root * widths.alpha
    stretch = (1.0 + slope * slope).root()
    cosine = ((frame.cosine - frame.sine * slope) / stretch).at_least(0.0).at_most(1.0)
    to_light = (cosine * 2.0 / stretch - frame.cosine).at_least(_NARROWEST)
    # Smith's auxiliary function for v' and for l, plus 1/2: G2 / G1.
    seen = (1.0 + square * frame.tangent * frame.tangent).root() * 0.5
    lit = (1.0 + (1.0 / (to_light * to_light) - 1.0) * square).root() * 0.5
    share = nodes.constant(_SHARES, "vector4") * (1.0 - slope * frame.tangent).at_least(0.0)
    unscaled = share * ((seen + 0.5) / (seen + lit))
    weight = unscaled / nodes.sum(unscaled)
    pull = weight * xi * root
    return Facets(cosine, weight, pull, nodes.sum(pull))


def _part(nodes: Expressions, frame: Frame, share: Value, turn: Value, widths: tuple[Value, Value, Value]) -> Part:
    """A lobe about the view direction turned by a small vector, with these inverse squared widths across it."""
    along, mixed, across = widths
    seen = (frame.view + turn).normalized()
    normal = nodes.where(frame.side, 0.0, seen, -seen)

    def lobe(axis: Value, along: Value, across: Value) -> Part:
        tangent = (axis - normal * nodes.dot(axis, normal)).normalized()
        return Part(share, normal, tangent, nodes.vector([along.at_most(1.0), across.at_most(1.0)]))

    if mixed.is_constant(0.0):
        return lobe(frame.along, 1.0 / along.root(), 1.0 / across.root())
    half = (along - across) * 0.5
    radius = (half * half + mixed * mixed).root()
    unit = half / radius.at_least(_TINY)
    cosine = (0.5 + unit * 0.5).at_least(0.0).root()
    sine = (0.5 - unit * 0.5).at_least(0.0).root()
    axis = frame.along * cosine + frame.across * nodes.where(mixed, 0.0, sine, -sine)
    largest = (along + across) * 0.5 + radius
    other = (largest / (along * across - mixed * mixed)).root()
    return lobe(axis, 1.0 / largest.root(), other)
