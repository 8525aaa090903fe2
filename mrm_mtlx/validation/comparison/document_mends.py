"""Documents written in another way, with the same meaning, that a known deviation of MaterialX's generators spares."""

from __future__ import annotations

from itertools import chain, count
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.interfaces import value_space
from mrm_mtlx.reference.deviations import Deviation

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping


def with_names_of_their_own(document: mx.Document) -> None:
    """Give every node and interface inside of a graph a name that nothing else in the document has."""
    taken = {str(element.getName()) for element in document.traverseTree()}
    unused = (name for name in map("mrm{}".format, count()) if name not in taken)
    for graph in _compound_graphs(document):
        nodes = {str(n.getName()): next(unused) for n in graph.getNodes()}
        inputs = {str(i.getName()): next(unused) for i in graph.getInputs()}
        for port in chain(graph.getOutputs(), _read(graph)):
            _rename(port, "nodename", nodes)
            _rename(port, "interfacename", inputs)
        for element in chain(graph.getNodes(), graph.getInputs()):
            element.setName((nodes if element.isA(mx.Node) else inputs)[element.getName()])
    for definition, users in _definitions_with_files(document):
        files = {str(i.getName()): next(unused) for i in _files(definition)}
        graph = definition.getImplementation()
        for port in _read(graph):
            _rename(port, "interfacename", files)
        for element in chain.from_iterable(_files(holder) for holder in (definition, *users)):
            element.setName(files.get(element.getName(), element.getName()))


def with_spaces_where_values_are_read(document: mx.Document) -> None:
    """Write colours and files that a graph's interface holds, with their colour space, where they are read."""
    for graph in _compound_graphs(document):
        for port in _read(graph):
            interface = graph.getInput(port.getInterfaceName()) if port.getInterfaceName() else None
            if interface is None or not interface.getValueString() or not _has_space(port):
                continue
            space = value_space(interface, port)
            port.removeAttribute("interfacename")
            port.setValueString(interface.getValueString())
            if space:
                port.setAttribute("colorspace", space)


def with_outputs_in_the_order_of_their_definition(document: mx.Document) -> None:
    """Give graphs that define nodes their outputs in the order in which the definitions have them."""
    for graph in _own(document, mx.NodeGraph):
        definition = graph.getNodeDef()
        for output in [] if definition is None else definition.getActiveOutputs():
            if graph.getOutput(output.getName()) is not None:
                graph.setChildIndex(output.getName(), len(graph.getChildren()) - 1)


MENDS: Mapping[Deviation, Callable[[mx.Document], None]] = {
    Deviation.SHARED_NAMES: with_names_of_their_own,
    Deviation.INTERFACE_COLOR_SPACE: with_spaces_where_values_are_read,
    Deviation.OUTPUT_ORDER: with_outputs_in_the_order_of_their_definition,
}


def _compound_graphs(document: mx.Document) -> list[Any]:
    """Graphs of the document that define no node."""
    return [graph for graph in _own(document, mx.NodeGraph) if graph.getNodeDef() is None]


def _definitions_with_files(document: mx.Document) -> Iterator[tuple[Any, list[Any]]]:
    """Definitions of the document by graphs that have inputs for files, and the nodes of each."""
    nodes = [e for e in document.traverseTree() if e.isA(mx.Node)]
    for definition in _own(document, mx.NodeDef):
        graph = definition.getImplementation()
        if _files(definition) and graph is not None and graph.isA(mx.NodeGraph):
            yield definition, [n for n in nodes if n.getNodeDef() == definition]


def _own(document: mx.Document, kind: type) -> list[Any]:
    """Elements of the document itself; its data library, which all documents share, is not to be changed."""
    return [element for element in document.getChildren() if element.isA(kind)]


def _files(element: Any) -> list[Any]:
    return [given for given in element.getInputs() if given.getType() == "filename"]


def _read(graph: Any) -> Iterator[Any]:
    """The inputs of a graph's nodes."""
    return chain.from_iterable(node.getInputs() for node in graph.getNodes())


def _has_space(port: Any) -> bool:
    return bool(port.getType() in ("color3", "color4", "filename"))


def _rename(port: Any, attribute: str, names: Mapping[str, str]) -> None:
    name = port.getAttribute(attribute)
    if name in names:
        port.setAttribute(attribute, names[name])
