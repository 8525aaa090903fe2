"""Finds its way through MaterialX's graphs: what an element is connected to, and in which graph it stands."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import MaterialX as mx

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Scope:
    """The place of an element: inside which graph, and what is bound to the graph's interface.

    `path` tells apart two uses of one graph; `node` is the node that uses it, in the scope `outer`; `values` are given
    for interface names without a node, and are made of `needs` (see the reference's `Perturbation.touches`). `shown` is
    the graph of the document whose output is shown, if it is one's.
    """

    path: str = ""
    node: Any = None
    outer: Scope | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    shown: Any = None
    needs: frozenset[Any] = frozenset()


def shown(element: Any) -> tuple[Any, str] | None:
    """The node that gives what a renderable element shows, and the name of its output, "" for the first; or None.

    That is a material's surface shader, or a material of its own; of an output, whatever it is connected to.
    """
    port = element.getInput("surfaceshader") if element.getCategory() == "surfacematerial" else element
    if port is None or port.isA(mx.Node):
        return None if port is None else (port, "")
    found = source(port, Scope())
    return None if found is None else found[:2]


def shader_node(element: Any) -> Any:
    """The node of `shown`, or None."""
    found = shown(element)
    return None if found is None else found[0]


def connected_node(element: Any) -> Any:
    """The node that an input or output takes its value from, through graphs' outputs, or None."""
    found = source(element, Scope())
    return element.getConnectedNode() if found is None else found[0]


def source(element: Any, scope: Scope) -> tuple[Any, str, Scope] | None:
    """Node, output name and scope that an input is connected to."""
    node = element.getConnectedNode() if element.getNodeName() else None
    if node is not None:
        return node, str(element.getOutputString()), scope
    if element.getNodeGraphString() or (element.getOutputString() and not element.getNodeName()):
        output = element.getConnectedOutput()
        if output is not None and output.getConnectedNode() is not None:
            return output.getConnectedNode(), str(output.getOutputString()), scope
    return None


def binding(element: Any, scope: Scope) -> str | None:
    """The interface name that an input takes its value from, or None."""
    name = str(element.getInterfaceName())
    if not name or (scope.node is None and not scope.values and interface_input(element) is None):
        return None
    return name


def interface_input(element: Any) -> Any:
    """The element that gives the value of an input with an interface name, where nothing uses its graph, or None.

    The graph's own input, or that of the node definition which the graph implements.
    """
    given = element.getInterfaceInput()
    if given is not None:
        return given
    graph = element.getParent().getParent()
    definition = graph.getNodeDef() if graph is not None and graph.isA(mx.NodeGraph) else None
    return None if definition is None else definition.getActiveInput(element.getInterfaceName())


def defining_graph(definition: Any) -> Any:
    """The graph that defines a node, or None if its hardware implementation is in source, or there is none."""
    implementation = definition.getImplementation("genglsl")
    return implementation if implementation is not None and implementation.isA(mx.NodeGraph) else None
