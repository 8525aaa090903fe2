"""Looks: whether the materials, looks and sets that they name are there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import location
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding


def check_look(element: Any) -> Iterator[Finding]:
    """Findings on names in a look, or a group of looks or of geometry, that the document lacks.

    A collection that geometry is assigned by, and a look that is inherited, are MaterialX's own to check.
    """
    if element.isA(mx.MaterialAssign):
        yield from _check_material(element)
    elif element.isA(mx.LookGroup):
        yield from _check_names(element, "look", element.getLooks(), mx.Look)
    elif element.isA(mx.Collection):
        yield from _check_names(element, "collection", element.getIncludeCollectionString(), mx.Collection)
    elif element.isA(mx.PropertySetAssign):
        yield from _check_names(element, "propertyset", element.getPropertySetString(), mx.PropertySet)
    elif element.isA(mx.VariantAssign):
        yield from _check_names(element, "variantset", element.getVariantSetString(), mx.VariantSet)


def _check_material(assignment: Any) -> Iterator[Finding]:
    name = assignment.getMaterial()
    # MaterialX does not find what shares its name with an element of its libraries, such as the type "material".
    child = assignment.getDocument().getChild(name)
    node = child if child is not None and child.isA(mx.Node) else assignment.getReferencedMaterial()
    if node is None and not assignment.getMaterialOutputs():
        yield rules.DOC_CONNECTION.at(location(assignment), f"no material is named '{name}'")
    elif node is not None and node.getType() != "material":
        message = f"'{name}' is of type {node.getType()}, expected a material"
        yield rules.DOC_CONNECTION.at(location(assignment), message)


def _check_names(element: Any, what: str, names: str, kind: type) -> Iterator[Finding]:
    document = element.getDocument()
    there = {str(child.getName()) for child in document.getChildren() if child.isA(kind)}
    there |= {str(child.getQualifiedName(child.getName())) for child in document.getChildren() if child.isA(kind)}
    for name in filter(None, map(str.strip, names.split(","))):
        if name not in there:
            yield rules.DOC_CONNECTION.at(location(element), f"no {what} is named '{name}'")
