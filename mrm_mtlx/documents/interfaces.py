"""Values through the interface of a graph: their colour space, and numbers that are passed over."""

from __future__ import annotations

from typing import Any

import MaterialX as mx

from mrm_mtlx.documents.graph import Scope, interface_input


def value_space(interface: Any, reader: Any) -> str:
    """The colour space of a value that an input of a graph holds and an input of a node in it reads.

    What holds the value says it; where that says nothing, what reads it.
    """
    return str(interface.getColorSpace() or reader.getActiveColorSpace())


def file_space(given: Any, scope: Scope) -> str:
    """The colour space in which a node of colours reads the file of this input.

    It is said where the file is named. A node of colours around it transforms what it gives itself.
    """
    own = str(given.getActiveColorSpace())
    name = given.getInterfaceName()
    if not name:
        return own
    if scope.node is None:
        interface = interface_input(given)
        return own if interface is None else value_space(interface, given)
    outer = scope.node.getInput(name)
    if outer is None or gives_colors(scope.node):
        return own
    return file_space(outer, scope.outer or Scope()) or own


def gives_colors(node: Any) -> bool:
    """True if generators transform what a node gives by the colour space of its files."""
    kind = str(node.getType())
    return kind.startswith("color") or kind == "multioutput"


def is_passed_over(interface: Any, declared: Any, scope: Scope) -> bool:
    """True if generators use a geometric default in the place of the number that an input of a graph holds.

    They do as they do with numbers given to a node; but not in the graph whose own output is shown.
    """
    graph = interface.getParent()
    is_default = bool(declared.getDefaultGeomPropString())
    return is_default and bool(graph.isA(mx.NodeGraph)) and bool(graph != scope.shown)
