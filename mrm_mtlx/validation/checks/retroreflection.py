"""Checks of what makes a document retroreflective, visible and sharp enough to compute."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.elements import location, nodes_of
from mrm_mtlx.documents.graph import defining_graph
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.rules.optics import NARROWEST_ALPHA
from mrm_mtlx.library.surface_models import FLAG, MICROFACET_NODES, PARTIAL_NODES, amount_input
from mrm_mtlx.reference import constant_input, narrowest_width

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

    from mrm_mtlx.findings.finding import Finding

# Inputs of surface models whose values leave nothing of the base's reflection: all of a row together, and why.
UNSEEN = {
    "open_pbr_surface": (
        ({"specular_weight": 0.0, "thin_film_weight": 0.0}, "its specular_weight is 0"),
        ({"base_metalness": 0.0, "specular_color": 0.0}, "it is no metal and its specular_color is black"),
        (
            {"base_metalness": 0.0, "specular_ior": 1.0, "thin_film_weight": 0.0, "coat_weight": 0.0},
            "it is no metal and its specular_ior is 1, which reflects nothing",
        ),
    ),
    "standard_surface": (
        ({"metalness": 0.0, "specular": 0.0}, "it is no metal and its specular is 0"),
        ({"metalness": 0.0, "specular_color": 0.0}, "it is no metal and its specular_color is black"),
        (
            {"metalness": 0.0, "specular_IOR": 1.0, "thin_film_thickness": 0.0},
            "it is no metal and its specular_IOR is 1, which reflects nothing",
        ),
    ),
    "gltf_pbr": (({"metallic": 0.0, "specular": 0.0, "iridescence": 0.0}, "it is no metal and its specular is 0"),),
}

# What to do about a lobe too narrow of a surface model, where a roughness of 0 is how a mirror is written.
_MIRROR = "Use roughnesses of at least 0.005; where a mirror is meant, pass over it by --ignore LOBE_TOO_NARROW."


def retroreflecting_nodes(document: mx.Document) -> list[Any]:
    """Nodes that have the flag or an amount, of BSDFs and of surface models, in file order; on or off."""
    found = []
    for node in nodes_of(document):
        microfacets = node.getCategory() in MICROFACET_NODES and node.getNodeDef() is not None
        if microfacets or amount_input(node):
            found.append(node)
    return found


def is_retroreflective(node: Any) -> bool:
    """True if the node's flag is on, as a literal or through an interface, or its amount is anything but 0."""
    amount = amount_input(node)
    if amount:
        return not _is(node, amount, 0.0)
    value = constant_input(node, FLAG)
    return isinstance(value, np.ndarray) and bool(value)


def check_retroreflection(document: mx.Document) -> list[Finding]:
    """Findings about the microfacet lobes and the surface models, in document order."""
    findings: list[Finding] = []
    for model in nodes_of(document):
        definition = model.getNodeDef() if model.getType() == "surfaceshader" else None
        if definition is not None and defining_graph(definition) is not None:  # the others' lobes are the document's
            findings += _too_narrow(model, narrowest_width(model), _MIRROR)
    for node in retroreflecting_nodes(document):
        is_lobe = node.getCategory() in (*MICROFACET_NODES, *PARTIAL_NODES)
        if is_lobe:
            findings += _check_width(node)
        if is_retroreflective(node):
            findings += _check_flag(node) if is_lobe else _check_model(node)
    return findings


def _check_model(node: Any) -> Iterator[Finding]:
    for values, reason in UNSEEN[node.getCategory()]:
        if all(_is(node, name, value) for name, value in values.items()):
            yield rules.RETRO_INVISIBLE.at(location(node), reason)
            return


def _check_flag(node: Any) -> Iterator[Finding]:
    if _kind(node) != "conductor_bsdf" and constant_input(node, "scatter_mode") == "T":
        yield rules.RETRO_TRANSMISSION.at(location(node), "scatter_mode is T, so nothing is reflected")
    reason = _invisible(node)
    if reason:
        yield rules.RETRO_INVISIBLE.at(location(node), reason)


def _invisible(node: Any) -> str:
    if _is(node, "weight", 0.0):
        return "its weight is 0"
    if _kind(node) == "dielectric_bsdf":
        if _is(node, "tint", 0.0):
            return "its tint is black"
        nothing = _is(node, "ior", 1.0) and _is(node, "thinfilm_thickness", 0.0)
        return "its ior is 1, which reflects nothing" if nothing else ""
    if _kind(node) == "generalized_schlick_bsdf" and _is(node, "color0", 0.0) and _is(node, "color90", 0.0):
        return "its color0 and color90 are black"
    return ""


def _check_width(node: Any) -> Iterator[Finding]:
    width = constant_input(node, "roughness")
    yield from _too_narrow(node, float(width.min()) if isinstance(width, np.ndarray) else None)


def _too_narrow(node: Any, width: float | None, hint: str = "") -> Iterator[Finding]:
    # In float32, as the document's number is: the bound itself is not below the bound.
    if width is not None and width < np.float32(NARROWEST_ALPHA):
        message = f"its narrowest width alpha is {width:.3g}, below {NARROWEST_ALPHA:g}"
        yield rules.LOBE_TOO_NARROW.at(location(node), message, hint)


def _kind(node: Any) -> str:
    return str(node.getCategory()).removeprefix("mrm_")


def _is(node: Any, name: str, number: float) -> bool:
    """True if an input is this number in every component, everywhere; what is below 0 counts as 0."""
    value = constant_input(node, name)
    return isinstance(value, np.ndarray) and bool(np.all(np.maximum(value, 0.0) == number))
