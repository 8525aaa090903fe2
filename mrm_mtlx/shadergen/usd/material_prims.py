"""A document's materials as prims of a stage, in the form that UsdMtlx gives them.

Each Material holds all that its network consists of: USD allows no connection that leads out of it (encapsulation).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx
from pxr import Sdf, Tf, Usd, UsdShade

from mrm_mtlx.documents.constants import unit_scale
from mrm_mtlx.documents.graph import defining_graph
from mrm_mtlx.findings import rules
from mrm_mtlx.library.color_spaces import is_linear
from mrm_mtlx.library.dialects import version_of
from mrm_mtlx.shadergen.usd.scope import TERMINALS, Scope, create_outputs, is_connected, reached_from
from mrm_mtlx.shadergen.usd.values import COLORED, SDF_TYPES, sdf_type, to_usd

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from mrm_mtlx.findings.finding import Finding

# Nodes whose definition lies in the document become graphs within graphs; beyond this they are no material.
MAXIMUM_PRIMS = 100_000


def material_behind(element: Any) -> Any:
    """The material that an output shows; any other element itself, and None for an output that shows nothing."""
    return element.getConnectedNode() if element.isA(mx.Output) and element.getType() == "material" else element


class MaterialWriter:
    """Writes the materials of one document, and notes what of it was used.

    Parameters
    ----------
    document
        A valid document whose data library is set.
    stage
        Where they are written.
    anchored
        Function from a file's name in the document to its name on the stage.

    Attributes
    ----------
    lost
        What of the materials that were written has no form in USD.
    nodes
        The nodes that were written as shaders, and their prims.
    """

    def __init__(self, document: mx.Document, stage: Usd.Stage, anchored: Callable[[str], str]) -> None:
        self._document, self._stage, self._anchored = document, stage, anchored
        self._version = version_of(document)
        self._own = {element.getName() for element in document.getChildren()}  # getChild() knows the library's, too
        self._used: set[str] = set()
        self.lost: list[Finding] = []
        self.nodes: list[tuple[mx.Node, Usd.Prim]] = []
        self._prims = 0

    def material(self, parent: Usd.Prim, element: Any) -> Usd.Prim:
        """A material of a renderable element: a material node, or a shader node or output that no material uses."""
        prim = self._define(UsdShade.Material, parent, element.getNamePath().replace("/", "_"), element)
        material = UsdShade.Material(prim)
        prim.AddAppliedSchema("MaterialXConfigAPI")  # unknown to a USD without UsdMtlx, which ApplyAPI would not take
        prim.CreateAttribute("config:mtlx:version", Sdf.ValueTypeNames.String, custom=False).Set(self._version)
        scope = Scope(prim)
        is_material = element.getType() == "material"
        self._used.add(element.getName())
        sources = [given for given in element.getInputs() if self._has_form(given)] if is_material else [element]
        reached = reached_from(self._document, sources)
        self._used |= {upstream.getName() for upstream in reached}
        self._fill(scope, reached)
        for given in sources:
            source = scope.source(given) if is_material else scope.shader(given)
            if source is not None:
                name = f"mtlx:{TERMINALS[given.getType()]}"
                material.CreateOutput(name, Sdf.ValueTypeNames.Token).ConnectToSource(source)
        return prim

    def findings(self) -> list[Finding]:
        """Findings about what was lost, of the materials and of the document beside them."""
        for element in self._document.getChildren():
            name, category = element.getName(), element.getCategory()
            if name in self._used or category in ("backdrop", "output"):
                continue
            is_graph = any(element.isA(kind) for kind in (mx.Node, mx.NodeGraph, mx.NodeDef))
            message = f"a {category} has no form in a USD material"
            self._lose(element, "nothing that can be rendered uses it" if is_graph else message)
        return self.lost

    def _lose(self, element: Any, message: str) -> None:
        self.lost.append(rules.INTERCHANGE_LOST.at(f"/{element.getNamePath()}", message))

    def _has_form(self, given: Any) -> bool:
        if given.getName() in TERMINALS:
            return True
        if is_connected(given):
            self._lose(given, "a USD material has no back of its own; the front is on both sides")
        return False

    def _define(self, schema: Any, parent: Usd.Prim, name: str, element: Any) -> Usd.Prim:
        """A prim of a name that is free and valid."""
        self._prims += 1
        if self._prims > MAXIMUM_PRIMS:
            msg = f"its definitions make more than {MAXIMUM_PRIMS} prims"
            raise ValueError(msg)
        wanted = valid = Tf.MakeValidIdentifier(name)
        count = 1
        while parent.GetChild(valid):
            count += 1
            valid = f"{wanted}_{count}"
        prim = schema.Define(self._stage, parent.GetPath().AppendChild(valid)).GetPrim()
        if element is not None and element.getDocString():
            prim.SetDocumentation(element.getDocString())
        return prim

    def _fill(self, scope: Scope, elements: Iterable[Any]) -> None:
        """Write nodes and graphs that stand beside each other: first themselves, then their inputs and connections."""
        elements = list(elements)
        for element in elements:
            scope.prims[element.getName()] = self._element(scope, element)
        for element in elements:
            prim = scope.prims[element.getName()]
            if element.isA(mx.NodeGraph):
                self._graph(scope, element, prim)
            elif prim.IsA(UsdShade.NodeGraph):
                self._defined(scope, element, prim)
            else:
                definition = element.getNodeDef()
                for given in element.getInputs():
                    self._input(scope, UsdShade.Shader(prim), given, definition.getActiveInput(given.getName()))

    def _element(self, scope: Scope, element: Any) -> Usd.Prim:
        """The prim of a node or a graph, with its outputs."""
        if element.isA(mx.NodeGraph):
            prim = self._define(UsdShade.NodeGraph, scope.prim, element.getName(), element)
            create_outputs(UsdShade.NodeGraph(prim), element.getOutputs())
            return prim
        definition = element.getNodeDef()
        graph = self._own_graph(definition)
        if graph is not None:
            prim = self._define(UsdShade.NodeGraph, scope.prim, element.getName(), element)
            create_outputs(UsdShade.NodeGraph(prim), definition.getActiveOutputs())
            self._used |= {definition.getName(), graph.getName()}
            return prim
        prim = self._define(UsdShade.Shader, scope.prim, element.getName(), element)
        shader = UsdShade.Shader(prim)
        shader.CreateIdAttr(definition.getName())
        self.nodes.append((element, prim))
        terminal = TERMINALS.get(element.getType()) if scope.prim.IsA(UsdShade.Material) else None
        if terminal is not None:  # so does UsdMtlx: "surface" of a material's shaders, "out" of those in graphs
            shader.CreateOutput(terminal, Sdf.ValueTypeNames.Token)
        else:
            create_outputs(shader, definition.getActiveOutputs())
        return prim

    def _own_graph(self, definition: mx.NodeDef) -> Any:
        """The graph by which the document itself defines a node, or None."""
        if definition.getName() not in self._own:
            return None
        graph = defining_graph(definition)
        if graph is None and definition.getName() not in self._used:
            self._used.add(definition.getName())
            self._lose(definition, "the node's definition in source code stays behind; a host has to know it")
        return graph

    def _graph(self, scope: Scope, graph: mx.NodeGraph, prim: Usd.Prim) -> None:
        """The inside of a graph of the document, and what its interface is connected to."""
        definition = graph.getNodeDef()
        if definition is None:
            for given in graph.getInputs():
                self._input(scope, UsdShade.NodeGraph(prim), given, given, graph)
        else:  # it defines a node, and is rendered by itself
            self._interface(scope, definition, graph, graph, prim)
        self._inside(graph, prim)

    def _defined(self, scope: Scope, node: mx.Node, prim: Usd.Prim) -> None:
        """The inside of a node that the document defines."""
        graph = self._own_graph(node.getNodeDef())
        self._interface(scope, node.getNodeDef(), graph, node, prim)
        self._inside(graph, prim)

    def _interface(self, scope: Scope, definition: mx.NodeDef, graph: mx.NodeGraph, node: Any, prim: Usd.Prim) -> None:
        """The inputs of the graph that defines a node, with the node's values in the place of the definition's."""
        connectable = UsdShade.NodeGraph(prim)
        for declared in definition.getActiveInputs():
            given = node.getInput(declared.getName())
            if given is not None and (given.getValueString() or is_connected(given)):
                self._input(scope, connectable, given, declared, graph)
            elif declared.getDefaultGeomPropString():
                self._geometry(scope, connectable, declared)
            else:
                self._input(scope, connectable, declared, declared, graph)

    def _inside(self, graph: mx.NodeGraph, prim: Usd.Prim) -> None:
        inner = Scope(prim)
        self._fill(inner, graph.getNodes())
        for output in graph.getOutputs():
            written = UsdShade.NodeGraph(prim).GetOutput(output.getName())
            source = inner.source(output)
            if source is not None:
                written.ConnectToSource(source)
            elif output.getValueString():
                written.Set(to_usd(output.getType(), output.getValue()))

    def _geometry(self, scope: Scope, connectable: UsdShade.NodeGraph, declared: mx.Input) -> None:
        """The node that gives an input its value where nothing else does, such as the normal."""
        kind = declared.getType()
        written = connectable.CreateInput(declared.getName(), sdf_type(kind))
        geometry = self._document.getGeomPropDef(declared.getDefaultGeomPropString())
        category = "" if geometry is None else geometry.getGeomProp()
        definition = next((d for d in self._document.getMatchingNodeDefs(category) if d.getType() == kind), None)
        if definition is None:
            self._lose(declared, f"its default '{declared.getDefaultGeomPropString()}' has no node")
            return
        name = f"{connectable.GetPrim().GetName()}_{declared.getName()}"
        shader = UsdShade.Shader(self._define(UsdShade.Shader, scope.prim, name, None))
        shader.CreateIdAttr(definition.getName())
        for attribute in ("space", "index"):
            value, into = geometry.getAttribute(attribute), definition.getActiveInput(attribute)
            if value and into is not None:
                kind_of = into.getType()
                typed = int(value) if kind_of == "integer" else value
                shader.CreateInput(attribute, sdf_type(kind_of)).Set(typed)
        create_outputs(shader, definition.getActiveOutputs())
        written.ConnectToSource(shader.GetOutput(definition.getActiveOutputs()[0].getName()))

    def _input(
        self, scope: Scope, connectable: Any, given: mx.Input, declared: mx.Input, graph: mx.NodeGraph | None = None
    ) -> None:
        """An input with its value or connection; `graph` is the one whose interface it is."""
        kind = given.getType()
        written = connectable.CreateInput(given.getName(), sdf_type(kind))
        if kind not in SDF_TYPES:
            written.SetRenderType(kind)
        space = self._color_space(given, graph)
        if space:
            written.GetAttr().SetColorSpace(space)
        source = scope.source(given)
        if source is not None:
            written.ConnectToSource(source)
            return
        if kind not in SDF_TYPES:
            if given.getValueString():
                self._lose(given, f"values of type {kind} have no form in USD")
            return
        text = given.getResolvedValueString()
        if kind in ("string", "geomname"):
            written.Set(text)
        elif kind == "filename":
            if text:
                written.Set(Sdf.AssetPath(self._anchored(text)))
        elif given.getValueString():
            written.Set(to_usd(kind, given.getValue(), unit_scale(given, declared)))

    def _color_space(self, given: mx.Input, graph: mx.NodeGraph | None) -> str:
        """The colour space that has to be said with an input's value, "" for none.

        An image whose file's name comes through an interface is in the space that is said there, or else in that of
        the node that reads it; in USD, in the space of what has the name. What is linear is so wherever the material
        goes.
        """
        if given.getType() not in COLORED or not (given.getValueString() or given.getInterfaceName()):
            return ""
        readers = [given]
        if graph is not None and given.getType() == "filename" and not given.getColorSpace():
            inputs = [i for node in graph.getNodes() for i in node.getInputs()]
            readers = [i for i in inputs if i.getInterfaceName() == given.getName()]
        active = [reader.getActiveColorSpace() for reader in readers]
        spaces = {space for space in active if not is_linear(space)}
        if len(spaces) > 1 or (spaces and any(is_linear(space) for space in active)):
            self._lose(given, "its image is read in several colour spaces; one of them is written")
        # Read back, what says nothing is in the document's space, whatever its graph was in.
        is_said = not is_linear(self._document.getColorSpace())
        linear = active if is_said else [reader.getColorSpace() for reader in readers]
        return min(spaces, default=max(linear, default=""))
