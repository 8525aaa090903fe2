"""Networks of an earlier MaterialX, upgraded as hosts do it.

A Material says by `config:mtlx:version` which MaterialX its network is of; one that says nothing is of 1.38, the last
before there was such a thing. Storm (hdMtlx) makes a document of that version of the network and lets MaterialX upgrade
it; so does this.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import MaterialX as mx

if TYPE_CHECKING:
    from pxr import UsdShade

# The version of a network that states none.
UNSTATED = "1.38"
# What hosts say it by.
ATTRIBUTE = "config:mtlx:version"
# Nodes that the upgrade from 1.38 changes.
_CHANGED = {"swizzle", "normalmap", "atan2", "switch", "thin_film_bsdf", "subsurface_bsdf"}
_TYPES = ("float", "color3", "color4", "vector2", "vector3", "vector4")


def version_of(material: UsdShade.Material) -> str:
    """The version of MaterialX that a material's network is of, as it is stated or by default."""
    stated = material.GetPrim().GetAttribute(ATTRIBUTE).Get() if material.GetPrim().HasAttribute(ATTRIBUTE) else None
    return str(stated) if stated else UNSTATED


def earlier_definition(identifier: str) -> Any:
    """The definition that 1.38 has of a node and later versions have not, or have with other inputs; None for none."""
    return _definitions().getNodeDef(identifier)


@cache
def _definitions() -> mx.Document:
    """Those of MaterialX 1.38 whose nodes its upgrade knows."""
    document = mx.createDocument()

    def define(name: str, category: str, kind: str, **inputs: str) -> None:
        definition = document.addNodeDef(name, kind, category)
        for given, type_of in inputs.items():
            definition.addInput(given, type_of)

    normal = {"space": "string", "normal": "vector3", "tangent": "vector3"}
    define("ND_normalmap", "normalmap", "vector3", **{"in": "vector3", "scale": "float"}, **normal)
    define("ND_normalmap_vector2", "normalmap", "vector3", **{"in": "vector3", "scale": "vector2"}, **normal)
    define("ND_thin_film_bsdf", "thin_film_bsdf", "BSDF", thickness="float", ior="float")
    for kind in _TYPES:
        if kind[:5] != "color":
            define(f"ND_atan2_{kind}", "atan2", kind, in1=kind, in2=kind)
        for target in _TYPES:
            if (kind, target) != ("float", "float"):
                inputs = {"in": kind, "channels": "string"}
                define(f"ND_swizzle_{kind}_{target}", "swizzle", target, **inputs)
    return document


def upgraded(document: mx.Document, version: str, source_locations: dict[str, str]) -> mx.Document:
    """A document of a version as the one that is installed has it; `source_locations` get those of what is new in it.

    What the upgrade adds comes from where the node stands that it is for.
    """
    nodes = [element for element in document.traverseTree() if element.isA(mx.Node)]
    if _CHANGED.isdisjoint(node.getCategory() for node in nodes):
        return document
    document.setVersionString(version)
    text = mx.writeToXmlString(document)
    found = mx.createDocument()
    mx.readFromXmlString(found, text)
    waiting = [
        node for node in found.traverseTree() if node.isA(mx.Node) and node.getNamePath() not in source_locations
    ]
    for _ in range(len(waiting)):
        for node in waiting:
            users = [port.getParent().getNamePath() for port in node.getDownstreamPorts()]
            known = next((source_locations[user] for user in users if user in source_locations), None)
            if known is not None:
                source_locations.setdefault(node.getNamePath(), known)
    return found
