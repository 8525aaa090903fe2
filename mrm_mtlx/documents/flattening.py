"""Replacing nodes that graphs define by the nodes of these graphs, and how many nodes that makes.

MaterialX replaces without a bound, and definitions that use each other twice double what is made with each of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.system.limits import MAXIMUM_NODES

if TYPE_CHECKING:
    from collections.abc import Callable

# What MaterialX names the nodes that it makes for geometric defaults while it replaces others.
_GEOMETRY = "geomNode_"
# Definitions inside of definitions, deeper than which none are counted out.
_MAXIMUM_DEPTH = 100


class TooManyNodesError(ValueError):
    """Replacing would make more than `MAXIMUM_NODES` nodes."""


def flatten(graph: Any, wanted: Callable[[Any], bool] = lambda _node: True) -> None:
    """Replace each node of a graph or document that a graph defines, and that is wanted, by the nodes of that graph.

    Raises
    ------
    TooManyNodesError
        If that would make more than `MAXIMUM_NODES` nodes.
    ValueError
        If MaterialX cannot do it; the message says what is in the way.
    """
    sizes = Sizes(graph.getDocument())
    if sum(sizes.of(node) for node in graph.getNodes() if wanted(node)) > MAXIMUM_NODES:
        msg = f"they come to more than {MAXIMUM_NODES} nodes"
        raise TooManyNodesError(msg)
    taken = next((name for c in graph.getChildren() if (name := str(c.getName())).startswith(_GEOMETRY)), "")
    if taken:  # MaterialX would take it for one of its own
        msg = f"the name '{taken}' is one that MaterialX makes itself"
        raise ValueError(msg)
    try:
        graph.flattenSubgraphs("", wanted)
    except Exception as error:  # MaterialX throws several unrelated types
        raise ValueError(str(error)) from error


class Sizes:
    """Numbers of nodes that nodes of a document come to when the graphs that define them are counted out.

    Of several graphs that may define a node, for different targets or by a definition of the document's own that a node
    inside of a library's graph may get, the largest counts. A number beyond `MAXIMUM_NODES` is not exact; that of a
    definition that contains itself is beyond.
    """

    def __init__(self, document: mx.Document) -> None:
        self._document = document
        self._known: dict[str, int] = {}
        self._own: dict[str, list[Any]] = {}
        for child in document.getChildren():  # getNodeDefs() would add those of the library
            if child.isA(mx.NodeDef):
                self._own.setdefault(child.getNodeString(), []).append(child)

    def of(self, node: Any, depth: int = 0) -> int:
        """Number of nodes that a node comes to; 1 for one that no graph defines."""
        found = {str(d.getName()) for d in (node.getNodeDef(), *self._own.get(node.getCategory(), ())) if d is not None}
        return max((self._of_definition(name, depth) for name in found), default=1)

    def _of_definition(self, name: str, depth: int) -> int:
        if name not in self._known:
            self._known[name] = MAXIMUM_NODES + 1  # of a definition inside of itself
            if depth < _MAXIMUM_DEPTH:
                self._known[name] = max((self._of_graph(graph, depth) for graph in self._graphs(name)), default=1)
        return self._known[name]

    def _of_graph(self, graph: Any, depth: int) -> int:
        found = 0
        for node in graph.getNodes():
            found += self.of(node, depth + 1)
            if found > MAXIMUM_NODES:
                break
        return max(found, 1)

    def _graphs(self, name: str) -> list[Any]:
        """The graphs that define nodes of a definition."""
        found = []
        for implementation in self._document.getMatchingImplementations(name):
            is_graph = implementation.isA(mx.NodeGraph)
            graph = implementation if is_graph else self._document.getNodeGraph(implementation.getNodeGraph())
            if graph is not None:
                found.append(graph)
        return found
