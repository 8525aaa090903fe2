"""Coverage of a data library: the node definitions that the reference can evaluate."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.graph import defining_graph
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.reference.survey import Survey

if TYPE_CHECKING:
    import MaterialX as mx

# Why the reference has no function, where that is not plain from the definition.
_REASONS = {
    "volumeshader": "a volume, not a surface",
    "displacementshader": "moves the surface before it is shaded",
    "lightshader": "a light, not a surface",
    "VDF": "participating media have no hardware implementation",
}
_NO_IMPLEMENTATION = "MaterialX has no hardware implementation of it"


class How(StrEnum):
    """By what a node definition is covered: a function, or a graph of covered nodes. Empty if it is not."""

    FUNCTION = "function"
    GRAPH = "graph"
    NOT_AT_ALL = ""


@dataclass(frozen=True)
class Coverage:
    """One node definition.

    Attributes
    ----------
    name, library
        Of the definition, and of the library that it belongs to ("stdlib", "pbrlib", "bxdf", ...).
    how
        By what it is covered.
    reason
        Why it is not covered, "" if it is.
    """

    name: str
    library: str
    how: How
    reason: str = ""


def coverage(library: mx.Document) -> list[Coverage]:
    """Every node definition of a data library, in its order."""
    return [_covered(definition) for definition in library.getNodeDefs()]


def _covered(definition: Any) -> Coverage:
    name, library = str(definition.getName()), _library(definition)
    if name in NODES:
        return Coverage(name, library, How.FUNCTION)
    graph = defining_graph(definition)
    if graph is None:
        return Coverage(name, library, How.NOT_AT_ALL, _reason(definition))
    survey = Survey()
    for output in graph.getOutputs():
        survey.visit(output.getConnectedNode())
    if survey.unknown:
        return Coverage(name, library, How.NOT_AT_ALL, f"its graph needs {', '.join(sorted(survey.unknown))}")
    return Coverage(name, library, How.GRAPH)


def _reason(definition: Any) -> str:
    if definition.getImplementation("genglsl") is None:
        return _NO_IMPLEMENTATION
    kinds = [str(out.getType()) for out in definition.getActiveOutputs()]
    return next((_REASONS[kind] for kind in kinds if kind in _REASONS), "no function yet")


def _library(definition: Any) -> str:
    """The folder of the library's file: `libraries/<library>/...`."""
    parts = PurePosixPath(definition.getActiveSourceUri().replace("\\", "/")).parts
    below = parts[parts.index("libraries") + 1 :] if "libraries" in parts else parts
    return below[0] if len(below) > 1 else "other"
