"""Circles of connections, and chains that are too long to be followed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import is_connected, location, nodes_of
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding

# Generators recurse along connections; chains that real graphs never reach are refused before they do.
MAXIMUM_CHAIN = 200


def check_cycles(document: mx.Document) -> Iterator[Finding]:
    """A circle of connections, or a chain beyond `MAXIMUM_CHAIN`; the first one found."""
    graphs = _defining_graphs(document)
    depth: dict[str, int] = {}
    for start in nodes_of(document):
        if start.getNamePath() in depth:
            continue
        open_nodes: list[tuple[Any, Iterator[Any]]] = [(start, iter(upstream(start, graphs)))]
        on_path = {start.getNamePath()}
        while open_nodes:
            node, waiting = open_nodes[-1]
            path = node.getNamePath()
            following = next(waiting, None)
            if following is None:
                open_nodes.pop()
                on_path.discard(path)
                depth[path] = 1 + max((depth.get(n.getNamePath(), 0) for n in upstream(node, graphs)), default=0)
                if depth[path] > MAXIMUM_CHAIN:
                    message = f"the node ends a chain of more than {MAXIMUM_CHAIN} nodes"
                    yield rules.DOC_CYCLE.at(location(node), message)
                    return
                continue
            name = following.getNamePath()
            if name in on_path:
                circle = [n.getName() for n, _ in open_nodes]
                circle = circle[[n.getNamePath() for n, _ in open_nodes].index(name) :]
                message = f"the nodes feed each other: {' <- '.join((*circle, following.getName()))}"
                yield rules.DOC_CYCLE.at(location(node), message)
                return
            if name not in depth:
                open_nodes.append((following, iter(upstream(following, graphs))))
                on_path.add(name)


def _defining_graphs(document: mx.Document) -> dict[str, list[Any]]:
    """The document's graphs that define nodes, by the name of the definition."""
    graphs: dict[str, list[Any]] = {}
    for graph in document.getChildren():  # getNodeGraphs() would add those of the library
        if graph.isA(mx.NodeGraph) and graph.getNodeDefString():
            graphs.setdefault(graph.getNodeDefString(), []).append(graph)
        elif graph.isA(mx.Implementation) and document.getNodeGraph(graph.getNodeGraph()) is not None:
            graphs.setdefault(graph.getNodeDefString(), []).append(document.getNodeGraph(graph.getNodeGraph()))
    return graphs


def upstream(node: Any, graphs: dict[str, list[Any]]) -> list[Any]:
    """Nodes that a node depends on: through its connections, its graph's interface, and the graph that defines it."""
    found = []
    for given in node.getInputs():
        for element in (given, given.getInterfaceInput()):
            if element is None:
                continue
            output = element.getConnectedOutput() if is_connected(element) else None
            source = output.getConnectedNode() if output is not None else element.getConnectedNode()
            if source is not None:
                found.append(source)
    definition = node.getNodeDef() if graphs else None
    if definition is not None:
        for graph in graphs.get(definition.getName(), ()):
            found += [o.getConnectedNode() for o in graph.getOutputs() if o.getConnectedNode() is not None]
    return [n for n in found if n.isA(mx.Node)]
