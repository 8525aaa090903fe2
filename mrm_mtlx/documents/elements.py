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
    """True if an input takes its value from elsewhere than a literal or an interface."""
    return bool(element.getNodeName() or element.getNodeGraphString() or element.getOutputString())
