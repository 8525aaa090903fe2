"""Nodes of the libraries for which a target has no code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

if TYPE_CHECKING:
    from collections.abc import Iterator


def without_code(element: Any, target: str) -> list[str]:
    """Categories of the nodes below an element that the libraries define, and implement for other targets alone.

    `target` is named as MaterialX's libraries name it, such as "genglsl". Nodes of the document's own definitions are
    not meant: their implementation is the document's to give.
    """
    document = element.getDocument()
    own = {str(child.getName()) for child in document.getChildren() if child.isA(mx.NodeDef)}
    missing: set[str] = set()
    seen: set[str] = set()
    waiting = [element.getConnectedNode() if element.isA(mx.Output) else element]
    while waiting:
        node = waiting.pop()
        definition = node.getNodeDef() if node is not None else None
        if definition is None or f"{node.getNamePath()} {definition.getName()}" in seen:
            continue
        seen.add(f"{node.getNamePath()} {definition.getName()}")
        waiting += _sources(node)
        implementation = definition.getImplementation(target)
        if implementation is None:
            missing |= {str(node.getCategory())} if definition.getName() not in own else set()
        elif implementation.isA(mx.NodeGraph):
            waiting += [output.getConnectedNode() for output in implementation.getOutputs()]
    return sorted(missing)


def _sources(node: Any) -> Iterator[Any]:
    """What a node's inputs are connected to."""
    for given in node.getInputs():
        yield given.getConnectedNode()
