"""Connections of inputs and of graphs' outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import is_connected, location
from mrm_mtlx.findings import rules
from mrm_mtlx.library.load import definitions_for
from mrm_mtlx.library.surface_models import FLAG

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding


def check_connection(port: Any) -> Iterator[Finding]:
    """Findings on a connection to what is not there, leaves open which output is meant, or is of another type."""
    if not is_connected(port):
        return
    named, output = port.getNodeName() or port.getNodeGraphString() or port.getOutputString(), port.getOutputString()
    source = _source(port)
    if source is None:
        yield _nothing_named(named, port)
        return
    outputs = _outputs(source)
    if names_only_output(port):
        yield rules.DOC_OUTPUT_IGNORED.at(location(port), f"'{named}' has one output, and output '{output}' is named")
        output = ""
    if output not in outputs and output:
        yield rules.DOC_CONNECTION.at(location(port), f"'{named}' has no output '{output}'")
    elif not output and len(outputs) > 1:
        message = f"'{named}' has several outputs, and none is named"
        hint = f"Name one of {', '.join(outputs)} with the attribute 'output'."
        yield rules.DOC_CONNECTION.at(location(port), message, hint)
    else:
        kind = outputs[output or next(iter(outputs))] if outputs else port.getType()
        if kind != port.getType():
            yield rules.DOC_CONNECTION.at(location(port), f"'{named}' gives {kind}, expected {port.getType()}")


def names_only_output(port: Any) -> bool:
    """True if a port names an output of a node that has one alone, by that name or another."""
    node = port.getConnectedNode() if port.getNodeName() and port.getOutputString() else None
    return node is not None and len(_outputs(node)) == 1


def _nothing_named(name: str, port: Any) -> Finding:
    document = port.getDocument()
    if port.getNodeName() and document.getNodeGraph(name) is not None:
        message = f"'{name}' is a graph, but connected as a node"
        return rules.DOC_CONNECTION.at(location(port), message, "Name it with the attribute 'nodegraph'.")
    if document.getChild(name) is not None and definitions_for(document).getChild(name) is not None:
        message = f"MaterialX does not find '{name}': an element of its libraries has the same name"
        return rules.DOC_CONNECTION.at(location(port), message, "Give the node another name.")
    return rules.DOC_CONNECTION.at(location(port), f"nothing is named '{name}' there")


def check_uniform(given: Any, declared: Any) -> Iterator[Finding]:
    """A connection of an input that its definition declares uniform to what is not."""
    if not declared.getIsUniform() or not is_connected(given) or _is_uniform(given):
        return
    hint = "" if given.getName() == FLAG else "Give the input a value, or connect a constant."
    message = f"'{given.getName()}' is uniform, but connected to what may vary"
    yield rules.DOC_UNIFORM_CONNECTED.at(location(given), message, hint)


def check_graph_output(output: Any) -> Iterator[Finding]:
    """An output of a graph that nothing is connected to, and that has no value either."""
    if not (output.getValueString() or output.getInterfaceName() or is_connected(output)):
        yield rules.DOC_CONNECTION.at(location(output), "nothing is connected to the graph's output")


def _source(port: Any) -> Any:
    """The node, graph or output of the document that a port is connected to, or None if there is none of the name."""
    name = port.getNodeGraphString()
    if not name:
        return port.getConnectedNode() if port.getNodeName() else port.getConnectedOutput()
    scope = port.getParent().getParent()
    inside = scope.getChild(name) if scope is not None else None
    return inside if inside is not None and inside.isA(mx.NodeGraph) else port.getDocument().getNodeGraph(name)


def _outputs(source: Any) -> dict[str, str]:
    """Types of a source's outputs by their names; an output is its own, and an undefined node has those it states."""
    if source.isA(mx.Output):
        return {str(source.getName()): str(source.getType())}
    declaring = source.getNodeDef() if source.isA(mx.Node) else source
    outputs = source.getOutputs() if declaring is None else declaring.getActiveOutputs()
    return {str(output.getName()): str(output.getType()) for output in outputs}


def _is_uniform(port: Any) -> bool:
    """True if a port is connected to a constant, to what is declared uniform, to one of these through dots, or not."""
    source = _source(port)
    if source is None or source.isA(mx.Output):
        return source is None or bool(source.getIsUniform())
    if source.getCategory() == "constant":
        return True
    if source.getCategory() == "dot":
        given = source.getInput("in")
        return given is None or not is_connected(given) or _is_uniform(given)
    declaring = source.getNodeDef() if source.isA(mx.Node) else source
    outputs = [] if declaring is None else declaring.getActiveOutputs()
    return any(o.getIsUniform() for o in outputs if port.getOutputString() in ("", o.getName()))
