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
# Their places between the ends of another interval: shares of its upper end, and of its lower one.
_UPPER = tuple(0.5 * (1.0 + node) for node in _NODES)
_LOWER = tuple(0.5 * (1.0 - node) for node in _NODES)

# Generators write constants with six decimals.
_TINY = 1e-6
# What is multiplied by it and has `_TINY` added keeps its value by a billionth.
_MUCH = 1000.0

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
    """The plane of incidence, seen from the side of the surface that n is on."""

    normal: Value
    view: Value  # the view direction or its opposite
    along: Value  # across the view direction, in the plane of incidence, pointing away from n
    cosine: Value
    sine: Value
    tangent: Value  # of the angle of incidence
    azimuth: Value  # of the plane of incidence from the surface's tangent: its cosine and sine
    across_azimuth: Value  # of the direction across that plane


class Widths(NamedTuple):
    """The lobe about n."""

    along: Value  # unit vector along the plane of incidence, by the widths of the surface's axes
    across: Value  # the same of that across it
    alpha: Value  # in the plane of incidence
    shear: Value  # slope across per slope along, for the most probable facet
    narrow: Value  # the smaller width
    area: Value  # product of the widths


class Stretched(NamedTuple):
    """Widths, and how many times as wide a lobe is along the plane of incidence and across it."""

    widths: Widths
    along: Value
    across: Value


class Facets(NamedTuple):
    """Four facets of the lobe: what v' sees of each."""

    cosine: Value  # v'.m
    weight: Value  # share of the lobe, not yet by their sum
    pull: Value  # how far the facet pulls the lobe along

    def mean(self, values: Value) -> Value:
        """The mean of values at the facets."""
        nodes = self.weight.nodes
        return nodes.dot(self.weight, values) / nodes.sum(self.weight)


class Reflectance(NamedTuple):
    """Of a lobe: the mean over its facets, as a vector of channels; and at each facet, the sum of the channels."""

    mean: Value
    curve: Value


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
    mean, curve = reflectance(nodes, facets, inputs)
    shift = widths.alpha * _SHIFT * (_pull(nodes, facets, curve) - facets.mean(facets.pull))
    excess = (frame.tangent * widths.alpha - _WING_FROM).at_least(0.0)
    wing = excess * _WING / (1.0 + excess * _WING)
    narrowed = 1.0 + excess * _NARROWED
    bent = frame.sine * (widths.narrow * _WIDENED**0.5)
    squeeze = nodes.vector([frame.cosine, bent]).length()
    moved = frame.along
    if not widths.shear.is_constant(0.0):
        # n x along is the direction across, times the cosine.
        moved = moved + nodes.cross(frame.normal, moved) * widths.shear
    turn = (widths.alpha * _WING_TURN).at_most(frame.tangent)
    core = Stretched(widths, 1.0 / narrowed, squeeze / narrowed)
    broad = Stretched(widths, core.along * _WING_ALONG, core.across * _WING_ACROSS)
    return AlignedLobe(
        mean.at_least(0.0),
        _part(nodes, frame, 1.0 - wing, moved * shift, core),
        _part(nodes, frame, wing, moved * shift - frame.along * turn, broad),
    )


def conductor(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Fresnel's equations with a complex index, per channel."""
    index, extinction = (inputs[name] for name in ("ior", "extinction"))
    red, green, blue = (_metal(index.component(i), extinction.component(i), facets.cosine) for i in range(3))
    share = nodes.vector(nodes.dot(facets.weight, curve) for curve in (red, green, blue))
    return Reflectance(share / nodes.sum(facets.weight), red + green + blue)


def dielectric(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Fresnel's equations; total beyond the critical angle."""
    cosine, index = facets.cosine, inputs["ior"]
    square = index * index
    g = (cosine.square() + (square - 1.0)).at_least(0.0).root()
    # (g - c) / (g + c) and (n^2 c - g) / (n^2 c + g)
    perpendicular = 1.0 - 2.0 / (1.0 + g / cosine)
    parallel = 1.0 - 2.0 / (1.0 + cosine * square / g.at_least(_TINY))
    curve = (perpendicular.absolute().square() + parallel.absolute().square()) * 0.5
    return Reflectance(inputs["tint"] * facets.mean(curve), curve * nodes.sum(inputs["tint"]))


def schlick(nodes: Expressions, facets: Facets, inputs: Mapping[str, Value]) -> Reflectance:
    """Schlick's curve between two colours, with the tint at 82 degrees of Hoffman (2023) if it is given."""
    grazing = 1.0 - facets.cosine
    curve = grazing.to_the(inputs["exponent"])
    normal, edge = (inputs[name].at_least(0.0) for name in ("color0", "color90"))
    rise = edge - normal
    mean = normal + rise * facets.mean(curve)
    total = curve * nodes.sum(rise) + nodes.sum(normal)
    if "color82" not in inputs:
        return Reflectance(mean, total)
    dip = facets.cosine * grazing.to_the(6.0) * (7.0 * (7.0 / 6.0) ** 6)  # 1 at cos 1/7
    there = normal + rise * nodes.constant(6.0 / 7.0).to_the(inputs["exponent"])
    depth = there * (1.0 - inputs["color82"].at_least(0.0))
    return Reflectance(mean - depth * facets.mean(dip), total - dip * nodes.sum(depth))


def _metal(index: Value, extinction: Value, cosine: Value) -> Value:
    """Mean of both polarisations, Rs (1 + Rp / Rs) / 2; without a division by the cosine squared."""
    cosine2 = cosine.square()
    sine2 = 1.0 - cosine2
    product = index * extinction * 2.0
    offset = index * index - extinction * extinction - 1.0
    modulus = ((cosine2 + offset).absolute().square() + product * product).root()
    sum_s = modulus + cosine2
    real = ((sum_s + offset) * 0.5).at_least(0.0).root()
    twice_s = (real * cosine * 2.0).at_least(_TINY)
    # modulus cosine2 + sine2^2
    sum_p = (sum_s - 2.0) * cosine2 + 1.0
    # Rs = (sum_s - twice_s) / (sum_s + twice_s), and 1 + Rp / Rs = 2 sum_p / (sum_p + twice_p)
    perpendicular = 1.0 - 2.0 / (1.0 + sum_s / twice_s)
    return perpendicular / (1.0 + twice_s * sine2 / sum_p.at_least(_TINY))


def _pull(nodes: Expressions, facets: Facets, curve: Value) -> Value:
    """How far the facets pull the lobe, by what each reflects."""
    reflected = facets.weight * curve
    return nodes.dot(reflected, facets.pull) / nodes.sum(reflected).at_least(_TINY)


def _frame(nodes: Expressions, normal: Value, tangent: Value) -> Frame:
    view = nodes.node("viewdirection", "vector3", {}, space="world")
    n = normal if normal.is_node("normal") else normal.normalized()
    side = nodes.dot(n, view)
    cosine = side.absolute().at_least(_GRAZING)
    sine = nodes.cross(n, view).length()
    y = nodes.cross(n, tangent).normalized()
    x = nodes.cross(y, n)
    # Where the view direction is n, the plane of incidence is that of the tangent.
    along = ((view * side - n) * _MUCH + tangent * _TINY).normalized()
    lean = nodes.dot(view, x) * _MUCH + _TINY, nodes.dot(view, y) * _MUCH
    azimuth = nodes.vector(lean).normalized()
    across = nodes.vector([-lean[1], lean[0]]).normalized()
    toward = nodes.where(side, 0.0, view, -view)
    return Frame(n, toward, along, cosine, sine, sine / cosine, azimuth, across)


def _widths(nodes: Expressions, frame: Frame, roughness: Value) -> Widths:
    roughness = roughness.at_least(_NARROWEST).at_most(1.0)
    alpha_x, alpha_y = (roughness.component(i) for i in range(2))
    if alpha_x.number is not None and alpha_x.number == alpha_y.number:
        zero = nodes.constant(0.0)
        return Widths(frame.azimuth, frame.across_azimuth, alpha_x, zero, alpha_x, alpha_x * alpha_x)
    along, across = frame.azimuth * roughness, frame.across_azimuth * roughness
    return Widths(
        along=frame.azimuth / roughness,
        across=frame.across_azimuth / roughness,
        alpha=along.length(),
        shear=nodes.dot(along, across) / nodes.dot(along, along),
        narrow=alpha_x.at_most(alpha_y),
        area=alpha_x * alpha_y,
    )


def _facets(nodes: Expressions, frame: Frame, widths: Widths) -> Facets:
    """Facets m = (X, 0, 1) / |.| in the plane of incidence, X away from v': Gauss-Legendre in X / sqrt(a^2 + X^2)."""
    alpha = widths.alpha
    # From -1 / sqrt(1 + a^2 b^2) to b / sqrt(a^2 + b^2), where the slope b = cosine / (1 + sine) is the steepest.
    beyond = frame.sine + 1.0
    top = nodes.vector([frame.cosine, beyond * alpha]).normalized().component(0)
    bottom = nodes.vector([beyond, frame.cosine * alpha]).normalized().component(0)
    xi = nodes.constant(_UPPER, "vector4") * top - nodes.constant(_LOWER, "vector4") * bottom
    xi2 = xi.absolute().square()
    root = (1.0 - xi2).root()
    # m = (alpha xi, 0, root) / stretch
    stretch = (1.0 - xi2 * (1.0 - alpha * alpha)).root()
    seen = (root - xi * (frame.tangent * alpha)).at_least(0.0)  # v'.m, by cosine / stretch
    cosine = (seen / stretch * frame.cosine).at_least(_TINY).at_most(1.0)
    to_light = (cosine * root * 2.0 / stretch - frame.cosine).at_least(_NARROWEST)
    # Smith's auxiliary function for v' and for l, plus 1/2: G2 / G1 is the former by their sum.
    shadow = nodes.vector([nodes.constant(1.0), frame.tangent * alpha]).length() * 0.5
    lit = (to_light.to_the(-2.0) * (alpha * alpha) + (1.0 - alpha * alpha)).root() * 0.5
    weight = nodes.constant(_SHARES, "vector4") * (seen / (root * (lit + shadow)))
    return Facets(cosine, weight, xi * root)


def _part(nodes: Expressions, frame: Frame, share: Value, turn: Value, shape: Stretched) -> Part:
    """A lobe about the view direction turned by a small vector.

    Its tangent is made perpendicular to the normal by who evaluates it, as that of every surface with a normal map.
    """
    normal = (frame.view + turn).normalized()
    widths = shape.widths
    if widths.shear.is_constant(0.0):
        along, across_width = widths.alpha * shape.along, widths.alpha * shape.across
        return Part(share, normal, frame.along, nodes.vector([along.at_most(1.0), across_width.at_most(1.0)]))
    # Principal axes of the inverse squared widths.
    first, second = widths.along / shape.along, widths.across / shape.across
    one, other = nodes.dot(first, first), nodes.dot(second, second)
    double = nodes.vector([(one - other) * 0.5, nodes.dot(first, second)])
    largest = (one + other) * 0.5 + double.length()
    axis = _half_angle(nodes, double)
    tangent = frame.along * axis.component(0) + nodes.cross(frame.view, frame.along) * axis.component(1)
    narrow = 1.0 / largest.root()
    wide = widths.area * shape.along * shape.across * largest.root()
    return Part(share, normal, tangent, nodes.vector([narrow.at_most(1.0), wide.at_most(1.0)]))


def _half_angle(nodes: Expressions, vector: Value) -> Value:
    """Unit vector in the direction of half the angle of a vector of two, or its opposite; across, for no vector."""
    unit = (vector - nodes.constant((_TINY, 0.0), "vector2")).normalized()
    half = unit.component(1) * _MUCH + _TINY, (1.0 - unit.component(0)) * _MUCH
    return nodes.vector(half).normalized()
