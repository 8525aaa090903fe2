"""Understands what a document's input is, as far as glTF can say it: a number times channels of an image, plus one."""

from __future__ import annotations

from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.formats.gltf.exporter.placement import InexpressibleError, Placement, placed_by, through
from mrm_mtlx.formats.gltf.exporter.value_sources import file_of, source
from mrm_mtlx.formats.gltf.properties import ENCODED
from mrm_mtlx.library.color_spaces import canonical, is_linear
from mrm_mtlx.reference import constant_input

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

_CHANNELS = {"outr": 0, "outg": 1, "outb": 2, "outa": 3, "outx": 0, "outy": 1, "outz": 2, "outw": 3}
_COMPONENTS = {"float": 1, "vector2": 2, "color3": 3, "vector3": 3, "color4": 4, "vector4": 4}


class Lookup(NamedTuple):
    """A lookup of an image.

    Attributes
    ----------
    file
        Its name in the document.
    encoded
        Whether its colours are sRGB.
    modes, filter
        As MaterialX names them.
    texcoord
        Set of texture coordinates.
    placement
        From these to where the image is read.
    """

    file: str
    encoded: bool
    modes: tuple[str, str]
    filter: str
    texcoord: int
    placement: Placement


@dataclass(frozen=True)
class Term:
    """offset + scale * channels of an image; arrays of shape (components,). Without a lookup it is the offset alone."""

    offset: Array
    scale: Array
    lookup: Lookup | None = None
    channels: tuple[int, ...] = ()

    @staticmethod
    def constant(value: Array | float | tuple[float, ...]) -> Term:
        """A number, or a colour."""
        offset = np.atleast_1d(np.asarray(value, dtype=float))
        return Term(offset, np.zeros_like(offset), None, (0,) * len(offset))

    @property
    def value(self) -> Array | None:
        """The constant that it is, or None."""
        return self.offset if self.lookup is None else None

    def __mul__(self, factor: Array | float) -> Term:
        return replace(self._wide(factor), offset=self.offset * factor, scale=self.scale * factor)

    def __add__(self, number: Array | float) -> Term:
        wide = self._wide(number)
        return replace(wide, offset=wide.offset + number)

    def select(self, components: tuple[int, ...]) -> Term:
        """Some of the components."""
        chosen = list(components)
        if max(chosen) >= len(self.offset):
            msg = "it reads a component that is not there"
            raise InexpressibleError(msg)
        channels = tuple(self.channels[c] for c in chosen)
        return replace(self, offset=self.offset[chosen], scale=self.scale[chosen], channels=channels)

    def _wide(self, other: Array | float) -> Term:
        """With as many components as another."""
        count = np.size(other)
        return self.select((0,) * count) if len(self.offset) == 1 < count else self


def term(node: Any, name: str) -> Term:
    """The term that a node's input is.

    `node` stands in a document whose data library is set; interfaces of graphs are resolved, see `interfaces`.

    Raises
    ------
    InexpressibleError
        If it is not of the form of a term.
    """
    if _known.get(None) is None:
        token = _known.set({})
        try:
            return term(node, name)
        finally:
            _known.reset(token)
    value = constant_input(node, name)
    if isinstance(value, np.ndarray):
        return Term.constant(value)
    upstream = source(node, name)
    if upstream is None:
        msg = "its value depends on the geometry"
        raise InexpressibleError(msg)
    return _of_node(*upstream)


def scalar(node: Any, name: str) -> float:
    """A number that is the same everywhere.

    Raises
    ------
    InexpressibleError
        If it varies.
    """
    value = constant_input(node, name)
    if not isinstance(value, np.ndarray) or value.ndim:
        msg = f"{name} of {node.getCategory()} varies, or is no number"
        raise InexpressibleError(msg)
    return float(value)


# What nodes give, by path and output, while one input is followed: each node once, however often it is used.
_known: ContextVar[dict[tuple[str, str], Term]] = ContextVar("known")


def _of_node(node: Any, output: str) -> Term:
    known, key = _known.get(), (node.getNamePath(), output)
    if key not in known:
        known[key] = _made(node, output)
    return known[key]


def _made(node: Any, output: str) -> Term:
    category = node.getCategory()
    if category in _IMAGES:
        return _image(node)
    if category.startswith("separate") and output in _CHANNELS:
        return term(node, "in").select((_CHANNELS[output],))
    if category.startswith("combine"):
        return _joined([term(node, f"in{k + 1}") for k in range(int(category[-1]))])
    if category == "gltf_colorimage":
        return _color_image(node).select((3,) if output == "outa" else (0, 1, 2))
    if category in _FUNCTIONS:
        return _FUNCTIONS[category](node)
    msg = f"its value comes from {category}, which has no form in glTF"
    raise InexpressibleError(msg)


def _image(node: Any) -> Term:
    file = node.getInput("file")
    space = "" if file is None else canonical(file.getActiveColorSpace())
    count = _COMPONENTS[node.getType()]
    is_color = node.getType().startswith("color")
    if not file_of(node):
        msg = f"{node.getCategory()} has no file"
        raise InexpressibleError(msg)
    if is_color and space != ENCODED and not is_linear(space):
        msg = f"the image is in the colour space {space}; glTF has sRGB and numbers as they are"
        raise InexpressibleError(msg)
    encoded = is_color and space == ENCODED
    factor = np.ones(count)
    if node.getCategory() == "gltf_image" and node.getNodeDef().getActiveInput("factor") is not None:
        factor = _constant(term(node, "factor"))
        if encoded and np.any(factor != 1.0):
            msg = "the factor of an encoded gltf_image is applied to encoded colours"
            raise InexpressibleError(msg)
    lookup = look_up(node, encoded)
    return Term(np.zeros(count), factor, lookup, tuple(range(count)))


def look_up(node: Any, encoded: bool = False) -> Lookup:
    """The lookup of an image node.

    Raises
    ------
    InexpressibleError
        If its place is no affine function of one set of texture coordinates.
    """
    placement, index = placed_by(node)
    texts = {}
    for name, default in (("uaddressmode", "periodic"), ("vaddressmode", "periodic"), ("filtertype", "linear")):
        value = constant_input(node, name) if node.getNodeDef().getActiveInput(name) is not None else default
        texts[name] = str(value)
    modes = (texts["uaddressmode"], texts["vaddressmode"])
    if "constant" in modes:
        msg = "an image that ends at its border (address mode constant)"
        raise InexpressibleError(msg)
    return Lookup(file_of(node), encoded, modes, texts["filtertype"], index, through(node, placement))


def _color_image(node: Any) -> Term:
    """The four channels of gltf_colorimage, whose image stands as it is stored: a multioutput has no colour space."""
    if not file_of(node):
        msg = "gltf_colorimage has no file"
        raise InexpressibleError(msg)
    lookup = look_up(node)
    factor = _constant(term(node, "color")) * _constant(term(node, "geomcolor"))
    # Inside, its image repeats, whatever its address modes are (MaterialX 1.39.5).
    return Term(np.zeros(4), factor, lookup._replace(modes=("periodic", "periodic")), (0, 1, 2, 3))


def _between(node: Any) -> Term:
    """Thickness by gltf_iridescence_thickness, whose ends are exchanged (MaterialX 1.39.5): thick where it is dark."""
    lookup = look_up(node)
    ends = [np.atleast_1d(scalar(node, name)) for name in ("thicknessMax", "thicknessMin")]
    return Term(ends[0], ends[1] - ends[0], lookup, (1,))


def _joined(terms: list[Term]) -> Term:
    lookups = {t.lookup for t in terms if t.lookup is not None}
    if len(lookups) > 1:
        msg = "it combines several images"
        raise InexpressibleError(msg)
    return Term(
        np.concatenate([t.offset for t in terms]),
        np.concatenate([t.scale for t in terms]),
        next(iter(lookups), None),
        tuple(channel for t in terms for channel in t.channels),
    )


def _pair(node: Any) -> tuple[Term, Term]:
    return term(node, "in1"), term(node, "in2")


def _constant(part: Term) -> Array:
    if part.value is None:
        msg = "it multiplies images, divides by one or compares one"
        raise InexpressibleError(msg)
    return part.value


def _multiply(node: Any) -> Term:
    first, second = _pair(node)
    return second * _constant(first) if first.lookup is None else first * _constant(second)


def _divide(node: Any) -> Term:
    first, second = _pair(node)
    return first * (1.0 / _constant(second))


def _add(node: Any) -> Term:
    first, second = _pair(node)
    return second + _constant(first) if first.lookup is None else first + _constant(second)


def _subtract(node: Any) -> Term:
    first, second = _pair(node)
    return second * -1.0 + _constant(first) if first.lookup is None else first + -_constant(second)


def _mix(node: Any) -> Term:
    amount = term(node, "mix")
    if amount.value is not None and (np.all(amount.value == 0.0) or np.all(amount.value == 1.0)):
        return term(node, "fg" if amount.value[0] else "bg")  # the other side may be anything
    return blended(term(node, "bg"), term(node, "fg"), amount)


def blended(low: Term, high: Term, amount: Term) -> Term:
    """(1 - amount) low + amount high.

    Raises
    ------
    InexpressibleError
        If two of them are images.
    """
    if low.lookup is None and high.lookup is None:
        step = np.atleast_1d(_constant(high) - _constant(low))
        if not np.any(step):
            return low
        return amount * step + _constant(low)
    share = _constant(amount)
    if low.lookup is None:
        return high * share + _constant(low) * (1.0 - share)
    return low * (1.0 - share) + _constant(high) * share


def _chosen(node: Any) -> Term:
    """The input that a comparison of constants chooses."""
    first, second = (_constant(term(node, name))[0] for name in ("value1", "value2"))
    holds = {"ifgreater": first > second, "ifgreatereq": first >= second, "ifequal": first == second}
    return term(node, "in1" if holds[node.getCategory()] else "in2")


def _extract(node: Any) -> Term:
    return term(node, "in").select((int(scalar(node, "index")),))


def _convert(node: Any) -> Term:
    count, given = _COMPONENTS[node.getType()], term(node, "in")
    if len(given.offset) == 1:
        return given.select((0,) * count)
    if len(given.offset) < count:
        msg = f"it converts {len(given.offset)} components to {count}"
        raise InexpressibleError(msg)
    return given.select(tuple(range(count)))


_IMAGES = ("image", "tiledimage", "gltf_image")
_FUNCTIONS: dict[str, Callable[[Any], Term]] = {
    "multiply": _multiply,
    "divide": _divide,
    "add": _add,
    "subtract": _subtract,
    "mix": _mix,
    "extract": _extract,
    "convert": _convert,
    "dot": lambda node: term(node, "in"),
    "gltf_iridescence_thickness": _between,
    "ifequal": _chosen,
    "ifgreater": _chosen,
    "ifgreatereq": _chosen,
}
