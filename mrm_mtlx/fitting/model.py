"""The material that is fitted to measurements: layers, their parameters, and what they reflect.

From the top: a clear coat (`dielectric_bsdf`), retroreflective lobes (`generalized_schlick_bsdf`), a diffuse base
(`oren_nayar_diffuse_bsdf`), each laid over the next with `layer`. A coat can be of two widths, gloss and haze, which a
`mix` with the share of the haze puts together: one surface still. They are the closures of the reference, so that a
document that is written with the parameters has the fitted values. Layers share out the light: no parameters within
their bounds reflect more grey light than arrives.

A retroreflective lobe is level in the entrance angle, color90 = color0, or falls with it: color90 = 0 and exponent e,

    F(c) = color0 (1 - (1 - c)^e)        c = v'.b, the cosine at the facet,

which is reciprocal and stands in every MaterialX host. An exponent of 0.5 falls off as prismatic tape does.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, StrEnum, auto
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.fresnel import reflectance_at_normal
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.closures import Closure, Facets, Light, dielectric, generalized_schlick, layer, mix, oren_nayar

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.bsdf.arrays import Array

# Index of the clear coats; their weight is free in its place, which is what dirt, texture and gloss leave of it.
COAT_IOR = 1.5
# Narrowest lobe: real retroreflectors have 0.003 and more, and single precision keeps its digits there.
NARROWEST = 0.003
# Broadest lobe: what is broader is for the diffuse base to show.
BROADEST = 0.5
# Relative distance from a bound within which a search has come to rest at it.
_NEAR = 1e-4
# Digits of the numbers in a document.
DIGITS = 6

_NORMAL, _TANGENT = np.array([[0.0], [0.0], [1.0]]), np.array([[1.0], [0.0], [0.0]])
# Bounds of the parameters, and whether they are sought as logarithms.
_BOUNDS = {
    "weight": (0.0, 1.0, False),
    "share": (0.0, 1.0, False),
    "alpha": (NARROWEST, BROADEST, True),
    "color": (0.0, 1.0, False),
    "color0": (0.0, 1.0, False),
    "color82": (0.0, 1.0, False),
    "exponent": (0.05, 20.0, True),
    "roughness": (0.0, 1.0, False),
}
_COLORS = ("color", "color0", "color82")


class Kind(Enum):
    """Ways in which a part of a stack reflects."""

    CLEAR = auto()
    RETROREFLECTIVE = auto()
    DIFFUSE = auto()


class Part(StrEnum):
    """The parts that a stack can have, from the top, by the names that parameters and nodes have."""

    COAT = "coat"
    HAZE = "haze"
    LOBE = "lobe"
    LOBE2 = "lobe2"
    DIFFUSE = "diffuse"

    @property
    def kind(self) -> Kind:
        """Its way of reflecting."""
        return _KINDS[self]


_KINDS = {
    Part.COAT: Kind.CLEAR,
    Part.HAZE: Kind.CLEAR,
    Part.LOBE: Kind.RETROREFLECTIVE,
    Part.LOBE2: Kind.RETROREFLECTIVE,
    Part.DIFFUSE: Kind.DIFFUSE,
}
_COATS, _LOBES = (Part.COAT, Part.HAZE), (Part.LOBE, Part.LOBE2)


@dataclass(frozen=True)
class Parameter:
    """A number that is fitted: `name` is that of a part and its input, `channel` -1 where there is but one."""

    name: str
    channel: int
    lower: float
    upper: float
    logarithmic: bool

    @property
    def part(self) -> Part:
        """The part that it is named for."""
        return Part(self.name.partition(".")[0])

    @property
    def label(self) -> str:
        """Its name in a table."""
        return self.name if self.channel < 0 else f"{self.name}.{'rgb'[self.channel]}"


@dataclass(frozen=True)
class LayerStack:
    """The layers of a material, and the choice of its free numbers.

    Attributes
    ----------
    coats, lobes
        Widths of the clear coat (0: no coat, 2: gloss and haze), and number of retroreflective lobes.
    falling
        Whether the lobes fall with the entrance angle, each with an exponent, or are level.
    diffuse, rough
        Whether there is a diffuse base, and whether its roughness is free, or 0: Lambert's.
    paper
        Whether the lobes are those of Portsmouth et al. 2026, Figure 4: color82 is free, color90 is 1.
    channels
        1 or 3.
    tint
        Factor on the colour of the lobes, for one channel; the largest is 1.
    fixed
        Values of parameters that are not free, by name.
    """

    coats: int = 0
    lobes: int = 0
    falling: bool = False
    diffuse: bool = True
    rough: bool = False
    paper: bool = False
    channels: int = 1
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    fixed: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def parts(self) -> list[Part]:
        """The coats, the lobes and the base, from the top."""
        return [*_COATS[: self.coats], *self.retroreflective, *([Part.DIFFUSE] if self.diffuse else [])]

    @property
    def retroreflective(self) -> list[Part]:
        """Its retroreflective lobes."""
        return list(_LOBES[: self.lobes])

    def inputs(self, part: Part) -> list[str]:
        """Names of the inputs that describe a part."""
        if part.kind is Kind.CLEAR:
            return ["weight" if part is Part.COAT else "share", "alpha"]
        if part.kind is Kind.DIFFUSE:
            return ["color", "roughness"] if self.rough else ["color"]
        return ["color0", "alpha", *(["color82"] if self.paper else []), *(["exponent"] if self.falling else [])]

    @property
    def parameters(self) -> list[Parameter]:
        """The free numbers, in order."""
        found = []
        for part in self.parts:
            for name in self.inputs(part):
                if f"{part}.{name}" in self.fixed:
                    continue
                channels = range(3) if name in _COLORS and self.channels == 3 else (-1,)
                found += [Parameter(f"{part}.{name}", channel, *_BOUNDS[name]) for channel in channels]
        return found

    def values(self, vector: Array) -> dict[str, Array]:
        """Values by parameter, shape (1,) or (3,), the fixed ones among them."""
        found: dict[str, list[float]] = {}
        for parameter, x in zip(self.parameters, vector, strict=True):
            found.setdefault(parameter.name, []).append(float(np.exp(x) if parameter.logarithmic else x))
        return {name: np.array(value) for name, value in (found | dict(self.fixed)).items()}

    def vector(self, values: Mapping[str, Array]) -> Array:
        """The inverse of `values`, put into the bounds."""
        numbers = [values[p.name][max(p.channel, 0)] for p in self.parameters]
        return np.array([_within(p, x) for p, x in zip(self.parameters, numbers, strict=True)])

    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the vector."""
        ends = [(np.log((p.lower, p.upper)) if p.logarithmic else (p.lower, p.upper)) for p in self.parameters]
        lower, upper = zip(*ends, strict=True)
        return np.array(lower), np.array(upper)

    def snapped(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """The same with free numbers that are next to a bound, where a search comes to rest, at it."""
        found = {name: value.copy() for name, value in values.items()}
        for p in self.parameters:
            value, i = found[p.name], max(p.channel, 0)
            for bound in (p.lower, p.upper):
                if abs(value[i] - bound) <= _NEAR * (bound or 1.0):
                    value[i] = bound
        return found

    def rounded(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """Values as a document has them."""
        return {name: np.array([float(f"{x:.{DIGITS}g}") for x in value]) for name, value in values.items()}

    def ordered(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """The same material with the narrower of two lobes of a kind first.

        Two retroreflective lobes in the other order are nearly the same material, gloss and haze exactly: in one order,
        they can be told by name.
        """
        found = dict(values)
        if self.lobes == 2 and found["lobe.alpha"][0] > found["lobe2.alpha"][0]:
            for name in self.inputs(Part.LOBE):
                found[f"lobe.{name}"], found[f"lobe2.{name}"] = found[f"lobe2.{name}"], found[f"lobe.{name}"]
        if self.coats == 2 and found["coat.alpha"][0] > found["haze.alpha"][0]:
            found["coat.alpha"], found["haze.alpha"] = found["haze.alpha"], found["coat.alpha"]
            found["haze.share"] = 1.0 - found["haze.share"]
        return found

    def color0(self, values: Mapping[str, Array], part: Part) -> Array:
        """Colour of a retroreflective lobe, shape (3,)."""
        return np.asarray(values[f"{part}.color0"] * np.array(self.tint))


def _within(parameter: Parameter, value: float) -> float:
    clipped = float(np.clip(value, parameter.lower, parameter.upper))
    return float(np.log(clipped)) if parameter.logarithmic else clipped


class Evaluator:
    """A stack under given directions.

    Parameters
    ----------
    stack
        What is evaluated.
    v, l : shape (samples, 3)
        Unit, above the surface, in the local frame.
    """

    def __init__(self, stack: LayerStack, v: Array, l: Array) -> None:
        self.stack = stack
        self._light = Light(np.ascontiguousarray(v.T), np.ascontiguousarray(l.T))
        self._cosine = l[:, 2]

    def eval(self, values: Mapping[str, Array]) -> Array:
        """BRDF [1/sr], without the cosine, shape (samples, 3)."""
        return self._f(self._layers(values), values)

    def eval_with_jacobian(self, vector: Array) -> tuple[Array, Array]:
        """BRDF, shape (samples, 3), and its derivatives by the vector of free numbers, (samples, 3, numbers).

        Differences of one layer at a time, with the others kept.
        """
        values, parts = self.stack.values(vector), self.stack.parts
        layers = self._layers(values)
        f = self._f(layers, values)
        slopes = np.empty((*f.shape, len(vector)))
        lower, upper = self.stack.bounds()
        for i, parameter in enumerate(self.stack.parameters):
            step = _STEP if vector[i] + _STEP <= upper[i] or vector[i] - _STEP < lower[i] else -_STEP
            moved = vector.copy()
            moved[i] += step
            there = self.stack.values(moved)
            changed = _SHARED.get(parameter.name, (parameter.part,))
            at = [self._layer(p, there) if p in changed else known for p, known in zip(parts, layers, strict=True)]
            slopes[..., i] = (self._f(at, there) - f) / step
        return f, slopes

    def _layers(self, values: Mapping[str, Array]) -> list[Closure]:
        return [self._layer(part, values) for part in self.stack.parts]

    def _f(self, layers: list[Closure], values: Mapping[str, Array]) -> Array:
        if self.stack.coats == 2:
            layers = [mix(layers[1], layers[0], values["haze.share"]), *layers[2:]]
        whole = reduce(lambda base, top: layer(top, base), reversed(layers))
        return np.broadcast_to(whole.response / self._cosine, (3, len(self._cosine))).T

    def _layer(self, part: Part, values: Mapping[str, Array]) -> Closure:
        own = {name: values[f"{part}.{name}"] for name in self.stack.inputs(part)}
        if part.kind is Kind.DIFFUSE:
            rough = own.get("roughness", np.zeros(1))[0]
            return oren_nayar(self._light, np.array(1.0), _color(own["color"]), rough, _NORMAL, np.array(False))
        if part.kind is Kind.CLEAR:
            own["weight"] = values["coat.weight"]
            return dielectric(self._light, _facets(own, False), np.ones((3, 1)), np.array(COAT_IOR))
        color0 = _color(self.stack.color0(values, part))
        tint = _color(own.get("color82", np.ones(1)))
        facets = _facets(own, True)
        color90, exponent = falloff(self.stack, color0, own)
        return generalized_schlick(self._light, facets, color0, tint, color90, np.array(exponent))


# Parameters that are not of the one layer that they are named for: what they change.
_SHARED: dict[str, tuple[Part, ...]] = {"coat.weight": _COATS, "haze.share": ()}
# Step of the differences: half of the digits of float64.
_STEP = 1e-7


def falloff(stack: LayerStack, color0: Array, inputs: Mapping[str, Array]) -> tuple[Array, float]:
    """color90 and exponent of a lobe."""
    if stack.falling:
        return np.zeros_like(color0), float(inputs["exponent"][0])
    return (np.ones_like(color0) if stack.paper else color0), 5.0


def albedos(stack: LayerStack, values: Mapping[str, Array], cos_v: Array) -> Array:
    """Directional albedo of each channel by the albedos that MaterialX's layers use, shape (angles, 3).

    It is that of level lobes; a falling lobe reflects less.
    """
    total, through = np.zeros((len(cos_v), 3)), np.ones((len(cos_v), 1))
    albedo_factors = versions.installed().microfacet_albedo.factors
    if stack.coats:
        a, b = albedo_factors(cos_v, values["coat.alpha"][0])  # the haze has much the same albedo
        total = total + values["coat.weight"][0] * (a * reflectance_at_normal(COAT_IOR) + b)[:, None]
        through = 1.0 - total[:, :1]
    for part in stack.retroreflective:
        a, b = albedo_factors(cos_v, values[f"{part}.alpha"][0])
        share = (a + b)[:, None] * stack.color0(values, part)
        total = total + through * share
        through = through * (1.0 - share.mean(axis=1, keepdims=True))
    return total + through * _color(values["diffuse.color"]).T if stack.diffuse else total


def _color(value: Array) -> Array:
    return np.broadcast_to(np.asarray(value, dtype=float), (3,))[:, None]


def _facets(inputs: Mapping[str, Array], retroreflective: bool) -> Facets:
    alpha = np.asarray(inputs["alpha"][0])
    return Facets(
        weight=np.asarray(inputs.get("weight", np.ones(1))[0]),
        alpha_x=alpha,
        alpha_y=alpha,
        retroreflective=np.asarray(retroreflective),
        thinfilm_thickness=np.zeros(()),
        thinfilm_ior=np.asarray(1.5),
        normal=_NORMAL,
        tangent=_TANGENT,
    )
