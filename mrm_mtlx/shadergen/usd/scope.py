"""The siblings in a material or graph that is being written, and their connections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx
from pxr import UsdShade

from mrm_mtlx.shadergen.usd import values
from mrm_mtlx.shadergen.usd.values import SDF_TYPES, sdf_type

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pxr import Usd

# The kind of material output, by the input of a material node or the type of a shader.
TERMINALS = {given: terminal for terminal, (given, _) in values.TERMINALS.items()}


class Scope:
    """A Material or NodeGraph that is being written, and the prims of the elements in it by their names."""

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = prim
        self.prims: dict[str, Usd.Prim] = {}

    def source(self, element: Any) -> Any:
        """The source of an input or output: an output beside it, or an input of the interface; None for none."""
        name = element.getInterfaceName()
        if name:
            interface = UsdShade.NodeGraph(self.prim).GetInput(name)
            return interface if interface else None
        node = element.getConnectedNode() if element.getNodeName() else None
        if node is not None:
            return self.output(node, element.getOutputString())
        output = element.getConnectedOutput()
        if output is None:
            return None
        graph = output.getParent()
        if graph.isA(mx.NodeGraph) and graph.getName() in self.prims:
            return UsdShade.NodeGraph(self.prims[graph.getName()]).GetOutput(output.getName())
        return self.source(output)

    def shader(self, element: Any) -> Any:
        """The output that a renderable element without a material is: of a node, or of a graph."""
        if element.isA(mx.Node):
            return self.output(element)
        graph = element.getParent()
        if graph.isA(mx.NodeGraph):
            return UsdShade.NodeGraph(self.prims[graph.getName()]).GetOutput(element.getName())
        return self.source(element)

    def output(self, node: mx.Node, name: str = "") -> Any:
        """A node's output, or its only one; None for a node that is not here, as one inside of the graph it feeds."""
        if node.getName() not in self.prims:
            return None
        outputs = UsdShade.ConnectableAPI(self.prims[node.getName()]).GetOutputs()
        return next((output for output in outputs if output.GetBaseName() == name), outputs[0] if outputs else None)


def create_outputs(connectable: Any, outputs: Iterable[mx.Output]) -> None:
    """Outputs of a shader or graph, of the types that they have in MaterialX."""
    for output in outputs:
        kind = output.getType()
        written = connectable.CreateOutput(output.getName(), sdf_type(kind))
        if kind not in SDF_TYPES and kind not in TERMINALS:
            written.SetRenderType(kind)


def reached_from(document: mx.Document, sources: Iterable[Any]) -> list[Any]:
    """Nodes and graphs of the document itself that these elements need, in file order."""
    found: dict[str, Any] = {}
    waiting = list(sources)
    while waiting:
        element = waiting.pop()
        if element.isA(mx.Node) or element.isA(mx.NodeGraph):
            if element.getName() in found:
                continue
            found[element.getName()] = element
            waiting += element.getInputs()
            continue
        if element.isA(mx.Output) and element.getParent().isA(mx.NodeGraph):
            waiting.append(element.getParent())
            continue
        node = element.getConnectedNode() if element.getNodeName() else None
        output = None if node is not None else element.getConnectedOutput()
        if node is not None:
            waiting.append(node)
        elif output is not None:
            waiting.append(output)
    return [element for element in document.getChildren() if element.getName() in found]


def is_connected(given: mx.Input) -> bool:
    """True if an input takes its value from elsewhere."""
    return bool(
        given.getNodeName() or given.getNodeGraphString() or given.getOutputString() or given.getInterfaceName()
    )
