"""The source of an input's value: a node or a file, with a graph's interface in the place of its names."""

from __future__ import annotations

from typing import Any

import MaterialX as mx

from mrm_mtlx.documents import graph as graphs


def resolved(document: mx.Document) -> mx.Document:
    """A copy in which nodes of graphs have the values that the graph's interface has in the place of its names.

    Names of what is connected to something else, or has no value, stay.
    """
    copy = document.copy()
    copy.setDataLibrary(document.getDataLibrary())
    for graph in (child for child in copy.getChildren() if child.isA(mx.NodeGraph)):  # not the library's
        for node in graph.getNodes():
            for given in node.getInputs():
                interface = given.getInterfaceInput()
                if interface is not None and interface.getValueString() and _source_of(interface) is None:
                    _take_over(given, interface)
    return copy


def _take_over(given: Any, interface: Any) -> None:
    """Give an input what its interface has: the value, and its colour space if it is said there.

    Generators convert no unit on the way, so that none is taken over.
    """
    given.removeAttribute("interfacename")
    given.setValueString(interface.getValueString())
    if interface.getColorSpace():
        given.setColorSpace(interface.getColorSpace())
    if given.getType() == "filename":
        given.removeAttribute("fileprefix")
        if interface.hasAttribute("fileprefix"):
            given.setAttribute("fileprefix", interface.getAttribute("fileprefix"))


def source(node: Any, name: str) -> tuple[Any, str] | None:
    """The node that an input is connected to, and the name of its output; None if it is not connected."""
    given = node.getInput(name)
    return None if given is None else _source_of(given)


def file_of(node: Any) -> str:
    """The file of an image node by its name in the document, "" for none."""
    file = node.getInput("file")
    return "" if file is None else str(file.getResolvedValueString())


def _source_of(given: Any) -> tuple[Any, str] | None:
    interface = given.getInterfaceInput() if given.getInterfaceName() else None
    if interface is not None:  # that of the graph, which is connected itself
        return _source_of(interface)
    found = graphs.source(given, graphs.Scope())
    return None if found is None else found[:2]
