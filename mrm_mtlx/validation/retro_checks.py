"""Checks of what makes a document's lobes retroreflective, visible and sharp enough to compute."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.reference import constant_input
from mrm_mtlx.validation.catalogue import NARROWEST_ALPHA
from mrm_mtlx.validation.findings import Finding, finding
from mrm_mtlx.validation.graph_checks import location, nodes_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

MICROFACET_NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")
# Of the node library: the same with an amount in the place of the flag.
PARTIAL_NODES = tuple(f"mrm_{name}" for name in MICROFACET_NODES)


def microfacet_nodes(document: mx.Document) -> list[Any]:
    """Nodes of the three BSDFs that have the flag, and of those that have an amount, in file order."""
    names = (*MICROFACET_NODES, *PARTIAL_NODES)
    return [n for n in nodes_of(document) if n.getCategory() in names and n.getNodeDef() is not None]


def is_retroreflective(node: Any) -> bool:
    """Whether the node's flag is on, as a literal or through an interface, or its amount is anything but 0."""
    if node.getCategory() in PARTIAL_NODES:
        return not _is_zero(node, "retroreflectivity")
    value = constant_input(node, "retroreflective")
    return isinstance(value, np.ndarray) and bool(value)


def check_retroreflection(document: mx.Document) -> list[Finding]:
    """Findings about the microfacet lobes, in document order."""
    findings: list[Finding] = []
    for node in microfacet_nodes(document):
        findings += _check_width(node)
        if is_retroreflective(node):
            findings += _check_flag(node)
    return findings


def _check_flag(node: Any) -> Iterator[Finding]:
    if _kind(node) != "conductor_bsdf" and constant_input(node, "scatter_mode") == "T":
        yield finding("RETRO_TRANSMISSION", location(node), "scatter_mode is T, so nothing is reflected")
    reason = _invisible(node)
    if reason:
        yield finding("RETRO_INVISIBLE", location(node), reason)


def _invisible(node: Any) -> str:
    if _is_zero(node, "weight"):
        return "its weight is 0"
    if _kind(node) == "dielectric_bsdf":
        if _is_zero(node, "tint"):
            return "its tint is black"
        ior = constant_input(node, "ior")
        film = _is_zero(node, "thinfilm_thickness")
        return "its ior is 1, which reflects nothing" if isinstance(ior, np.ndarray) and ior == 1.0 and film else ""
    if _kind(node) == "generalized_schlick_bsdf" and _is_zero(node, "color0") and _is_zero(node, "color90"):
        return "its color0 and color90 are black"
    return ""


def _check_width(node: Any) -> Iterator[Finding]:
    width = constant_input(node, "roughness")
    # In float32, as the document's number is: the bound itself is not below the bound.
    if isinstance(width, np.ndarray) and width.min() < np.float32(NARROWEST_ALPHA):
        message = f"its width alpha is {width.min():.3g}, below {NARROWEST_ALPHA:g}"
        yield finding("LOBE_TOO_NARROW", location(node), message)


def _kind(node: Any) -> str:
    return str(node.getCategory()).removeprefix("mrm_")


def _is_zero(node: Any, name: str) -> bool:
    value = constant_input(node, name)
    return isinstance(value, np.ndarray) and bool(np.all(value <= 0.0))
