"""Elements of a document: where they are, and what they are connected to."""

from __future__ import annotations

from typing import Any

import MaterialX as mx


def nodes_of(document: mx.Document) -> list[Any]:
    """All nodes of the document, those inside its graphs included, in file order; not those of the library."""
    return [element for element in document.traverseTree() if element.isA(mx.Node)]


def location(element: Any) -> str:
    """Path of an element, "/graph/node/input"."""
    return f"/{element.getNamePath()}"


def is_connected(element: Any) -> bool:
    """Whether an input takes its value from elsewhere than a literal or an interface."""
    return bool(element.getNodeName() or element.getNodeGraphString() or element.getOutputString())


def library_of(element: Any) -> Any:
    """The document of the libraries' definitions; the element's own if it has no data library."""
    document = element.getDocument()
    return document.getDataLibrary() if document.hasDataLibrary() else document


def has_output(node: Any, name: str) -> bool:
    """Whether a node has an output of this name."""
    return bool(output_type(node, name))


def output_type(node: Any, name: str) -> str:
    """Type of a node's output, by its definition or as the node itself states it; "" if it has none of the name."""
    definition = node.getNodeDef() if node is not None and node.isA(mx.Node) else None
    output = definition.getActiveOutput(name) if definition is not None else None
    if output is None and node is not None:
        output = node.getOutput(name)
    return str(output.getType()) if output is not None else ""
