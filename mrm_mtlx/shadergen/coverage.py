"""Nodes that MaterialX cannot generate code of, said beforehand or better than by its generators."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.library.color_spaces import color_transform

if TYPE_CHECKING:
    from collections.abc import Iterator


def without_code(element: Any, target: str) -> list[str]:
    """Categories of the nodes below an element that the libraries define, and implement for other targets alone.

    `target` is named as MaterialX's libraries name it, such as "genglsl". Nodes of the document's own definitions are
    not meant: their implementation is the document's to give.
    """
    own = {str(child.getName()) for child in element.getDocument().getChildren() if child.isA(mx.NodeDef)}
    missing: set[str] = set()
    for node in _nodes_below(element, target):
        definition = node.getNodeDef()
        if definition.getName() not in own and definition.getImplementation(target) is None:
            missing.add(str(node.getCategory()))
    return sorted(missing)


def of_two_transforms(element: Any, target: str) -> str:
    """Path of a node below an element that takes two files in a colour space: MaterialX's generators die of it; or "".

    The colours of each file are transformed behind the node, by two transforms that get one name. Only in the document:
    the libraries have no such node.
    """
    nodes = (child for child in element.getDocument().traverseTree() if child.isA(mx.Node))
    meant = {str(node.getNamePath()) for node in nodes if _transforms(node) > 1}
    below = (str(node.getNamePath()) for node in (_nodes_below(element, target) if meant else ()))
    return next((path for path in below if path in meant), "")


def _transforms(node: Any) -> int:
    """Number of transforms that generators put behind a node for the colour spaces of its files."""
    if not (node.isColorType() or node.isMultiOutputType()):
        return 0
    files = [i for i in node.getInputs() if i.getType() == "filename" and (i.hasValueString() or i.getInterfaceName())]
    return sum(color_transform(node.getDocument(), i.getActiveColorSpace()) is not None for i in files)


def _nodes_below(element: Any, target: str) -> Iterator[Any]:
    """Nodes with definitions that an element is made of, through the graphs that define nodes for a target."""
    seen: set[str] = set()
    waiting = [element.getConnectedNode() if element.isA(mx.Output) else element]
    while waiting:
        node = waiting.pop()
        definition = node.getNodeDef() if node is not None else None
        if definition is None or f"{node.getNamePath()} {definition.getName()}" in seen:
            continue
        seen.add(f"{node.getNamePath()} {definition.getName()}")
        yield node
        waiting += _sources(node)
        implementation = definition.getImplementation(target)
        if implementation is not None and implementation.isA(mx.NodeGraph):
            waiting += [output.getConnectedNode() for output in implementation.getOutputs()]


def _sources(node: Any) -> Iterator[Any]:
    """The sources of a node's inputs, also through the interface of its graph."""
    for given in node.getInputs():
        yield given.getConnectedNode()
        interface = given.getInterfaceInput()
        if interface is not None:
            yield interface.getConnectedNode()
