"""Understands what a document's input is, as far as glTF can say it: a number times channels of an image, plus one."""

from __future__ import annotations

from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.formats.pbr.placement import InexpressibleError, placed_by, through
from mrm_mtlx.formats.pbr.term import ENCODED, Lookup, Term, blended, constant_of, joined
from mrm_mtlx.formats.pbr.value_sources import file_of, source
from mrm_mtlx.library.color_spaces import canonical, is_linear
from mrm_mtlx.reference import constant_input

if TYPE_CHECKING:
    from collections.abc import Callable

_CHANNELS = {"outr": 0, "outg": 1, "outb": 2, "outa": 3, "outx": 0, "outy": 1, "outz": 2, "outw": 3}
_COMPONENTS = {"float": 1, "vector2": 2, "color3": 3, "vector3": 3, "color4": 4, "vector4": 4}


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
        return joined([term(node, f"in{k + 1}") for k in range(int(category[-1]))])
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
        factor = constant_of(term(node, "factor"))
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
    factor = constant_of(term(node, "color")) * constant_of(term(node, "geomcolor"))
    # Inside, its image repeats, whatever its address modes are (MaterialX 1.39.5).
    return Term(np.zeros(4), factor, lookup._replace(modes=("periodic", "periodic")), (0, 1, 2, 3))


def _between(node: Any) -> Term:
    """Thickness by gltf_iridescence_thickness, whose ends are exchanged (MaterialX 1.39.5): thick where it is dark."""
    lookup = look_up(node)
    ends = [np.atleast_1d(scalar(node, name)) for name in ("thicknessMax", "thicknessMin")]
    return Term(ends[0], ends[1] - ends[0], lookup, (1,))


def _pair(node: Any) -> tuple[Term, Term]:
    return term(node, "in1"), term(node, "in2")


def _multiply(node: Any) -> Term:
    first, second = _pair(node)
    return second * constant_of(first) if first.lookup is None else first * constant_of(second)


def _divide(node: Any) -> Term:
    first, second = _pair(node)
    return first * (1.0 / constant_of(second))


def _add(node: Any) -> Term:
    first, second = _pair(node)
    return second + constant_of(first) if first.lookup is None else first + constant_of(second)


def _subtract(node: Any) -> Term:
    first, second = _pair(node)
    return second * -1.0 + constant_of(first) if first.lookup is None else first + -constant_of(second)


def _mix(node: Any) -> Term:
    amount = term(node, "mix")
    if amount.value is not None and (np.all(amount.value == 0.0) or np.all(amount.value == 1.0)):
        return term(node, "fg" if amount.value[0] else "bg")  # the other side may be anything
    return blended(term(node, "bg"), term(node, "fg"), amount)


def _chosen(node: Any) -> Term:
    """The input that a comparison of constants chooses."""
    first, second = (constant_of(term(node, name))[0] for name in ("value1", "value2"))
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
