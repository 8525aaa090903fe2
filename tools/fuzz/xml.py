"""Mutations of MaterialX documents: their elements, attributes, values and text."""

from __future__ import annotations

import copy
import re
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from tools.fuzz import odd, raw

if TYPE_CHECKING:
    from collections.abc import Callable
    from random import Random

Element = ET.Element
_ATTRIBUTES = (
    "name", "type", "value", "nodename", "nodegraph", "output", "interfacename", "nodedef", "node", "version",
    "fileprefix", "colorspace", "unit", "unittype", "uniform", "channels", "member", "defaultgeomprop", "inherit",
    "isdefaultversion", "target", "file", "function", "sourcecode", "implname", "enum", "enumvalues", "uimin",
    "uimax", "namespace", "geom", "xpos", "hint", "which", "default", "uifolder", "semantic", "context", "cms",
    "valuerange", "doc", "import", "material",
)  # fmt: skip
_TAGS = (
    "nodegraph", "nodedef", "implementation", "input", "output", "token", "look", "materialassign", "variant",
    "variantset", "variantassign", "collection", "geominfo", "geomprop", "geompropdef", "typedef", "member",
    "targetdef", "unittypedef", "unitdef", "unit", "backdrop", "property", "propertyset", "propertyassign",
    "propertysetassign", "visibility", "comment", "attributedef", "lookgroup", "materialx", "surfacematerial",
    "volumematerial", "parameter", "xi:include", "surface", "displacement", "light", "switch", "dot", "constant",
    "image", "tiledimage", "mix", "layer", "add", "multiply", "extract", "convert", "normalmap", "noise2d",
    "artistic_ior", "conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf", "subsurface_bsdf", "sheen_bsdf",
    "translucent_bsdf", "uniform_edf", "measured_edf", "standard_surface", "open_pbr_surface", "gltf_pbr",
    "UsdPreviewSurface", "UsdUVTexture", "disney_principled", "my_node", "texcoord", "geompropvalue", "swizzle",
)  # fmt: skip
_INCLUDE = "{http://www.w3.org/2001/XInclude}include"


def mutated(data: bytes, rng: Random, other: bytes) -> bytes:
    """A document with one to five changes, to its elements where it can be parsed; `other` is one to take parts of."""
    if rng.random() < 0.15:
        return _bytes(data, rng, other)
    try:
        root, donor = ET.fromstring(data), ET.fromstring(other)
    except ET.ParseError:
        return _bytes(data, rng, other)
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5))):
        rng.choice(_CHANGES)(root, donor, rng)
    text = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return _bytes(text, rng, other) if rng.random() < 0.05 else text


def _bytes(data: bytes, rng: Random, other: bytes) -> bytes:
    for _ in range(rng.choice((1, 1, 2, 4))):
        data = raw.mutated(data, rng, other) if rng.random() < 0.5 else _token(data, rng)
    return data


def _token(data: bytes, rng: Random) -> bytes:
    """Another text between quotation marks somewhere."""
    found = list(re.finditer(rb'"([^"<]*)"', data))
    if not found:
        return data
    chosen = rng.choice(found)
    words = rng.choice((odd.NUMBERS, odd.NAMES, odd.TYPES, odd.FILES))
    return data[: chosen.start(1)] + rng.choice(words).encode() + data[chosen.end(1) :]


def _pick(root: Element, rng: Random) -> Element:
    return rng.choice(list(root.iter()))


def _parent(root: Element, child: Element) -> Element:
    return next((e for e in root.iter() if child in list(e)), root)


def _duplicate(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    if chosen is not root:
        twin = copy.deepcopy(chosen)
        if rng.random() < 0.5:
            twin.set("name", chosen.get("name", "") + "_2")
        _parent(root, chosen).append(twin)


def _delete(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    if chosen is not root:
        _parent(root, chosen).remove(chosen)


def _move(root: Element, _donor: Element, rng: Random) -> None:
    chosen, target = _pick(root, rng), _pick(root, rng)
    if chosen is not root and target not in list(chosen.iter()):
        _parent(root, chosen).remove(chosen)
        target.insert(rng.randrange(len(target) + 1), chosen)


def _nest(root: Element, _donor: Element, rng: Random) -> None:
    """An element in copies of itself, some few or more than any reader takes."""
    chosen = _pick(root, rng)
    if chosen is root or len(list(chosen.iter())) > 40:
        return
    inner = copy.deepcopy(chosen)
    for _ in range(rng.choice((1, 2, 5, 70, 300))):
        outer = Element(chosen.tag, chosen.attrib)
        outer.append(inner)
        inner = outer
    root.append(inner)


def _adopt(root: Element, donor: Element, rng: Random) -> None:
    """An element of another document."""
    _pick(root, rng).append(copy.deepcopy(_pick(donor, rng)))


def _adopt_all(root: Element, donor: Element, _rng: Random) -> None:
    root.extend(copy.deepcopy(list(donor)))


def _swap_values(root: Element, _donor: Element, rng: Random) -> None:
    a, b = _pick(root, rng), _pick(root, rng)
    common = sorted(set(a.attrib) & set(b.attrib))
    if common:
        key = rng.choice(common)
        a.attrib[key], b.attrib[key] = b.attrib[key], a.attrib[key]


def _set_value(root: Element, _donor: Element, rng: Random) -> None:
    valued = [e for e in root.iter() if "value" in e.attrib]
    if valued:
        rng.choice(valued).set("value", rng.choice((*odd.NUMBERS, *odd.NAMES[:8])))


def _set_file(root: Element, _donor: Element, rng: Random) -> None:
    files = [e for e in root.iter() if e.get("type") == "filename" or "file" in e.attrib]
    if files:
        chosen = rng.choice(files)
        chosen.set("file" if "file" in chosen.attrib else "value", rng.choice(odd.FILES))


def _set_type(root: Element, _donor: Element, rng: Random) -> None:
    typed = [e for e in root.iter() if "type" in e.attrib]
    if typed:
        rng.choice(typed).set("type", rng.choice(odd.TYPES))


def _set_tag(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    if chosen is not root:
        chosen.tag = rng.choice(_TAGS)


def _rename(root: Element, _donor: Element, rng: Random) -> None:
    """An odd name, here alone or wherever it is used."""
    named = [e for e in root.iter() if e.get("name")]
    if not named:
        return
    chosen = rng.choice(named)
    old, new = chosen.attrib["name"], rng.choice((*odd.NAMES, *(e.attrib["name"] for e in named)))
    if rng.random() < 0.5:
        for element in root.iter():
            for key, value in element.attrib.items():
                if value == old:
                    element.set(key, new)
    chosen.set("name", new)


def _set_attribute(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    key = rng.choice((*_ATTRIBUTES, *chosen.attrib, *chosen.attrib))
    values = [v for e in root.iter() for v in e.attrib.values()]
    words = rng.choice((odd.NUMBERS, odd.NAMES, odd.TYPES, odd.FILES, odd.COLOR_SPACES, odd.UNITS, values or [""]))
    chosen.set(key, rng.choice(words))


def _drop_attribute(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    if chosen.attrib:
        del chosen.attrib[rng.choice(sorted(chosen.attrib))]


def _rename_attribute(root: Element, _donor: Element, rng: Random) -> None:
    chosen = _pick(root, rng)
    if chosen.attrib:
        value = chosen.attrib.pop(rng.choice(sorted(chosen.attrib)))
        chosen.set(rng.choice(_ATTRIBUTES), value)


def _connect(root: Element, _donor: Element, rng: Random) -> None:
    """An input or output to any element: circles and wrong types among them."""
    ports = [e for e in root.iter() if e.tag in ("input", "output")]
    names = [e.attrib["name"] for e in root.iter() if e.get("name")]
    if ports and names:
        port = rng.choice(ports)
        port.attrib.pop("value", None)
        port.set(rng.choice(("nodename", "nodename", "nodegraph", "interfacename", "output")), rng.choice(names))


def _include(root: Element, _donor: Element, rng: Random) -> None:
    href = rng.choice(("part.mtlx", "parts/deep.mtlx", "m.mtlx", *odd.FILES))
    root.insert(rng.randrange(len(root) + 1), Element(_INCLUDE, {"href": href}))


def _prefix(root: Element, _donor: Element, rng: Random) -> None:
    _pick(root, rng).set(
        "fileprefix", rng.choice(("parts/", "parts", "../outside/", "/", "a\\", "x" * 200 + "/", *odd.FILES))
    )


def _define(root: Element, _donor: Element, rng: Random) -> None:
    """A definition with its graph, which may be wrong, and a node of it, which may be inside."""
    kind, name = rng.choice(odd.TYPES), rng.choice(("my_node", "mix", "standard_surface", *odd.NAMES))
    definition = ET.SubElement(root, "nodedef", {"name": "ND_mine", "node": name})
    ET.SubElement(definition, "input", {"name": "in", "type": rng.choice(odd.TYPES), "value": rng.choice(odd.NUMBERS)})
    ET.SubElement(definition, "output", {"name": rng.choice(("out", "other")), "type": kind})
    graph = ET.SubElement(root, "nodegraph", {"name": "NG_mine", "nodedef": rng.choice(("ND_mine", "ND_none"))})
    inner = rng.choice(("my_node", name, "constant", "dot"))
    node = ET.SubElement(graph, inner, {"name": "n", "type": kind})
    ET.SubElement(node, "input", {"name": rng.choice(("in", "value")), "type": kind, "interfacename": "in"})
    ET.SubElement(graph, "output", {"name": "out", "type": kind, "nodename": "n"})
    ET.SubElement(rng.choice((root, graph)), name if name.isidentifier() else "my_node", {"name": "used", "type": kind})


def _implement(root: Element, _donor: Element, rng: Random) -> None:
    definition = rng.choice(("ND_mine", "ND_mix_bsdf", "ND_image_color3", "ND_conductor_bsdf", "ND_surface"))
    attributes = {"name": "IM_mine", "nodedef": definition, "target": rng.choice(("genglsl", "genosl", "", "nonsense"))}
    attributes[rng.choice(("file", "file", "sourcecode"))] = rng.choice(
        ("code.glsl", "{{in}}", '#include "x"', *odd.FILES)
    )
    if rng.random() < 0.7:
        attributes["function"] = rng.choice(("mx_mine", "", "main", "a b"))
    ET.SubElement(root, "implementation", attributes)


def _assign(root: Element, _donor: Element, rng: Random) -> None:
    look = ET.SubElement(root, "look", {"name": "l", "inherit": rng.choice(("", "l", "none"))})
    ET.SubElement(look, "materialassign", {"name": "a", "material": rng.choice(odd.NAMES), "geom": "/"})


_CHANGES: tuple[Callable[[Element, Element, Random], None], ...] = (
    _duplicate, _delete, _delete, _move, _nest, _adopt, _adopt_all, _swap_values, _swap_values, _set_value,
    _set_value, _set_value, _set_file, _set_type, _set_type, _set_tag, _rename, _set_attribute, _set_attribute,
    _set_attribute, _drop_attribute, _drop_attribute, _rename_attribute, _connect, _connect, _connect, _include,
    _prefix, _define, _implement, _assign,
)  # fmt: skip
