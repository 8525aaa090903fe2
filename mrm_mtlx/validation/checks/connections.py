"""Connections of inputs and of graphs' outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.validation.checks.elements import has_output, is_connected, location, output_type
from mrm_mtlx.validation.findings import Finding, finding

if TYPE_CHECKING:
    from collections.abc import Iterator


def check_connection(given: Any, declared: Any) -> Iterator[Finding]:
    """Whether what an input is connected to is there, gives its type, and may be connected to it."""
    if not is_connected(given):
        return
    output = given.getConnectedOutput()
    node = given.getConnectedNode()
    named = given.getNodeName() or given.getNodeGraphString() or given.getOutputString()
    if node is None and output is None:
        yield finding("DOC_CONNECTION", location(given), f"nothing is named '{named}' there")
    elif given.getNodeName() and given.getOutputString() and not has_output(node, given.getOutputString()):
        message = f"'{given.getNodeName()}' has no output '{given.getOutputString()}'"
        yield finding("DOC_CONNECTION", location(given), message)
    else:
        source = given.getOutputString() and output_type(node, given.getOutputString())
        kind = source or (output.getType() if output is not None else node.getType())
        if kind not in (given.getType(), "multioutput"):
            message = f"'{named}' gives {kind}, expected {given.getType()}"
            yield finding("DOC_CONNECTION", location(given), message)
    if declared.getIsUniform():
        yield _uniform_connected(given)


def _uniform_connected(given: Any) -> Finding:
    hint = ""
    if given.getName() != "retroreflective":
        hint = "Give the input a value; it has to be known when the shader is compiled."
    message = f"'{given.getName()}' is uniform, but connected"
    return finding("DOC_UNIFORM_CONNECTED", location(given), message, hint)


def check_outputs(document: mx.Document) -> Iterator[Finding]:
    """Outputs of the document's graphs that nothing is connected to, and that have no value either."""
    for graph in document.getChildren():
        if not graph.isA(mx.NodeGraph):
            continue
        for output in graph.getOutputs():
            given = output.getValueString() or output.getInterfaceName() or is_connected(output)
            if not given:
                yield finding("DOC_CONNECTION", location(output), "nothing is connected to the graph's output")
