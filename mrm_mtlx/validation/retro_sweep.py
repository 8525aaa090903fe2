"""The retroreflective sweep: a document's specular nodes, one at a time, with the flag switched on.

Real documents seldom have the flag. Switched on in each of their lobes in turn, it meets every layer, mixture and
throughput that they are made of. It is done on a copy whose graphs are flattened, so that the nodes inside of surface
models are nodes of the copy, and the flag of each is a uniform of one shader.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.flattening import flatten
from mrm_mtlx.library.surface_models import FLAG, MICROFACET_NODES
from mrm_mtlx.validation.checks.retroreflection import is_retroreflective

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.shadergen import Shader


@dataclass(frozen=True)
class Variant:
    """A renderable element and one of its specular nodes, whose flag is off as the document has it."""

    element: Any
    node: Any

    @property
    def name(self) -> str:
        """Path of the node in the flattened copy."""
        return str(self.node.getNamePath())

    def switched(self) -> mx.Document:
        """Another copy of the document, with the flag of the node on."""
        copy = self.element.getDocument().copy()
        node = copy.getDescendant(self.name)
        if node.getInput(FLAG) is None and node.getChild(FLAG) is not None:
            node.removeChild(FLAG)  # of the name, and no input
        node.setInputValue(FLAG, True)
        return copy

    def uniform(self, shader: Shader) -> str | None:
        """Variable of the flag in a shader of the copy, or None if it has none."""
        path = f"{self.name}/{FLAG}"
        return next((port.variable for port in shader.uniforms if port.path == path), None)


def flattened(document: mx.Document) -> mx.Document:
    """A copy in which every node that a graph defines is replaced by the nodes of that graph.

    Raises
    ------
    ValueError
        As `documents.flattening`.
    """
    copy = document.copy()
    for graph in [copy, *(c for c in copy.getChildren() if c.isA(mx.NodeGraph) and not c.getNodeDefString())]:
        flatten(graph)
    return copy


def variants(element: Any) -> list[Variant]:
    """The specular nodes that an element depends on and whose flag is off, in the order of the document.

    Not those that partial retroreflection is mixed of: the flag of their other part is on already.
    """
    nodes = {str(node.getNamePath()): node for node in _upstream(element)}
    order = [str(e.getNamePath()) for e in element.getDocument().traverseTree() if e.isA(mx.Node)]
    found = [nodes[path] for path in order if path in nodes and nodes[path].getCategory() in MICROFACET_NODES]
    return [Variant(element, node) for node in found if _is_off(node)]


def _is_off(node: Any) -> bool:
    given = node.getInput(FLAG)
    connected = given is not None and not given.getValueString()
    return not connected and not is_retroreflective(node) and not _has_twin(node)


def _has_twin(node: Any) -> bool:
    """True if the node is the ordinary part of a lobe whose other part has the flag on: that is swept as it is."""
    mixtures = [port.getParent() for port in node.getDownstreamPorts()]
    others = [m.getConnectedNode(name) for m in mixtures if m.getCategory() == "mix" for name in ("fg", "bg")]
    return any(o is not None and o.getCategory() == node.getCategory() and is_retroreflective(o) for o in others)


def _upstream(element: Any) -> Iterator[Any]:
    for edge in element.traverseGraph():
        upstream = edge.getUpstreamElement()
        if upstream.isA(mx.Node):
            yield upstream
