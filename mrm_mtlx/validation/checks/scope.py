"""Parts of documents that are not compared with the reference, beside those that cannot be."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.elements import location, nodes_of
from mrm_mtlx.findings import rules
from mrm_mtlx.shadergen import renderable_elements

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

    from mrm_mtlx.findings.finding import Finding

# Inputs of a material beside its surface, and what they give.
_BESIDE = {"displacementshader": "displacement", "backsurfaceshader": "back surface"}
# Types of shaders that are generated with no surface, or for a surface.
_OTHERS = {"volumeshader": "volumes", "lightshader": "lights", "displacementshader": "displacements"}


def nothing_to_render(document: mx.Document) -> Finding:
    """The finding that a document has nothing to generate a shader from, and what it has instead."""
    types = {str(node.getType()) for node in nodes_of(document)}
    others = [name for kind, name in _OTHERS.items() if kind in types]
    message = "no material with a surface, and no output to show"
    if others:
        message = f"{message}; {' and '.join(others)} alone are not compared"
    return rules.DOC_NO_RENDERABLE.at("", message)


def check_scope(document: mx.Document) -> Iterator[Finding]:
    """Parts of materials that are not compared, told once."""
    materials = [element for element in renderable_elements(document) if element.getCategory() == "surfacematerial"]
    found: dict[str, list[Any]] = {}
    for material in materials:
        for name, part in _BESIDE.items():
            if material.getConnectedNode(name) is not None:
                found.setdefault(part, []).append(material)
    for part, having in found.items():
        more = f" (nor that of {len(having) - 1} more)" if len(having) > 1 else ""
        message = f"the {part} of '{having[0].getName()}' is not compared{more}"
        yield rules.DOC_NOT_COMPARED.at(location(having[0]), message)
