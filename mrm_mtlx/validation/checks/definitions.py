"""Definitions of the document's own, and what implements them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import location
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding


def check_definition(element: Any) -> Iterator[Finding]:
    """Findings on outputs without a type, graphs with other outputs than their definition, units without a scale."""
    if element.isA(mx.NodeDef):
        for output in element.getOutputs():
            if not output.getType():
                yield rules.DOC_DEFINITION.at(location(output), f"the output '{output.getName()}' has no type")
    elif element.isA(mx.NodeGraph) and element.getNodeDef() is not None:  # which may be said by an implementation
        yield from _check_graph(element, element.getNodeDef())
    elif element.isA(mx.Implementation) and element.getNodeGraph():
        if element.getDocument().getNodeGraph(element.getNodeGraph()) is None:
            yield rules.DOC_DEFINITION.at(location(element), f"no graph is named '{element.getNodeGraph()}'")
    elif element.isA(mx.Unit):
        yield from _check_scale(element)


def _check_graph(graph: Any, definition: Any) -> Iterator[Finding]:
    """Names of outputs count where there are several; one output is that of the definition, whatever its name."""
    found, wanted = _types(graph), _types(definition)
    by_name = len(wanted) > 1
    if (found if by_name else list(found.values())) != (wanted if by_name else list(wanted.values())):
        message = f"it has the outputs {_listed(found)}, expected {_listed(wanted)} as '{definition.getName()}' has"
        yield rules.DOC_DEFINITION.at(location(graph), message)


def _types(element: Any) -> dict[str, str]:
    return {str(output.getName()): str(output.getType()) for output in element.getActiveOutputs()}


def _listed(types: dict[str, str]) -> str:
    return ", ".join(f"{name} ({kind or 'without a type'})" for name, kind in types.items()) or "none"


def _check_scale(unit: Any) -> Iterator[Finding]:
    """A unit whose scale is no number, or none that can be divided by."""
    text = unit.getAttribute("scale")
    try:
        scale = float(text)
    except ValueError:
        scale = 0.0
    if scale == 0.0 or not math.isfinite(scale):
        message = f"the scale '{text}' of the unit '{unit.getName()}' is not a number other than 0"
        yield rules.DOC_DEFINITION.at(location(unit), message)
