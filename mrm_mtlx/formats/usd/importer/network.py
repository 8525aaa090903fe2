"""A Material's network as nodes of a document, and where each of them comes from."""

from __future__ import annotations

import difflib
from dataclasses import replace
from enum import Enum, auto
from typing import TYPE_CHECKING, Any, NamedTuple

import MaterialX as mx
from pxr import Sdf, Usd, UsdShade

from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.importer.versions import earlier_definition, upgraded, version_of
from mrm_mtlx.formats.usd.prims import is_closed, is_materialx, space_of, terminals
from mrm_mtlx.library.dialects import is_document_version, is_upgraded
from mrm_mtlx.shadergen.usd.values import COLORED, TERMINALS, materialx_type, outputs_of, to_text
from mrm_mtlx.system.text import shown

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.findings.finding import Rule
    from mrm_mtlx.formats.usd.importer.translation import Translation


def translate(into: Translation, material: UsdShade.Material, place: Callable[[Sdf.Path], str] = str) -> None:
    """Add the network of a material to a translation; `place` gives a path as it is reported."""
    version = version_of(material)
    if not is_document_version(version):
        message = f"its version of MaterialX is {shown(version)}; expected one such as '1.39', which is assumed"
        into.report(rules.INTERCHANGE_LOST, material.GetPath(), place(material.GetPath()), message)
    if not is_upgraded(version):
        Network(into, material, place).translate()
        return
    document = mx.createDocument()
    document.setDataLibrary(into.library.document)
    document.setColorSpace(into.document.getColorSpace())
    alone = replace(
        into, document=document, source_locations={}, last={}, definitions={}, is_earlier=True
    )  # with the same findings and sources
    Network(alone, material, place).translate()
    _add(into, upgraded(document, version, alone.source_locations), alone.source_locations)


def _add(into: Translation, document: mx.Document, source_locations: dict[str, str]) -> None:
    """Add the elements of a document to a translation, under names that are free there."""
    names = {}
    for element in document.getChildren():
        name = into.free(element.getName())
        copy = into.document.addChildOfCategory(element.getCategory(), name)
        copy.copyContentFrom(element)
        names[element.getName()] = name
    for name in names.values():
        for given in into.document.getChild(name).getInputs():
            for attribute in ("nodename", "nodegraph"):
                if given.hasAttribute(attribute):
                    given.setAttribute(attribute, names.get(given.getAttribute(attribute), ""))
    for path, found in source_locations.items():
        first, _, rest = path.partition("/")
        if first in names:
            into.source_locations[f"{names[first]}/{rest}" if rest else names[first]] = found


class _Kind(Enum):
    """Kinds of sources: the output of a shader or of a graph, an interface of the graph around, a value, or nothing.

    A connection that leads nowhere has nothing as its source.
    """

    NODE = auto()
    GRAPH = auto()
    INTERFACE = auto()
    VALUE = auto()
    NOTHING = auto()


class _Source(NamedTuple):
    """The source of an input's value.

    Attributes
    ----------
    kind
    prim, name
        What it is connected to; of nothing, the path.
    attribute
        The output or interface of a graph, what has the value, or what is connected.
    """

    kind: _Kind
    prim: Usd.Prim
    name: str
    attribute: Usd.Attribute


class Network:
    """The network of one material, in `translation`; `place` gives a path as it is reported."""

    def __init__(
        self, translation: Translation, material: UsdShade.Material, place: Callable[[Sdf.Path], str] = str
    ) -> None:
        self._into, self._material, self._place = translation, material, place
        self._stage = material.GetPrim().GetStage()
        self._document = translation.document
        self._graphs: dict[Sdf.Path, Any] = {}
        self._nodes: dict[Sdf.Path, tuple[Any, Any]] = {}
        self._names: dict[Sdf.Path, str] = {}  # of graphs' inputs and outputs
        self._waiting: list[tuple[Usd.Prim, Any, Any, Any]] = []

    def translate(self) -> None:
        """Add the material, all that it is made of, and what lies in it unused."""
        prim = self._material.GetPrim()
        for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies()):
            if child.IsA(UsdShade.NodeGraph) and is_closed(child):
                self._graphs[child.GetPath()] = None
        made: dict[str, Any] = {}
        for name, output in terminals(self._material).items():
            given_name, category = TERMINALS[name]
            if category not in made:
                made[category] = self._document.addNode(category, self._into.free(prim.GetName()), "material")
                self._document_text(prim, made[category])
                self._note(made[category], prim.GetPath())
            source = self._source(output.GetAttr(), None)
            if source.kind is _Kind.VALUE:
                self._report(rules.DOC_CONNECTION, output.GetAttr().GetPath(), "the material's output is not connected")
            elif source.kind is _Kind.NOTHING:
                self._dangling(source)
            else:
                given = made[category].addInput(given_name, given_name)
                self._note(given, output.GetAttr().GetPath())
                self._connect(given, source, given_name)
        self._finish()
        for child in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
            if is_materialx(child):
                self._node(child, "")
        self._finish()

    def _finish(self) -> None:
        """Add the inputs of the nodes that are there, and what they need."""
        while self._waiting:
            self._inputs(*self._waiting.pop())

    def _note(self, element: Any, path: Sdf.Path) -> None:
        self._into.source_locations[element.getNamePath()] = self._into.noted(path, self._place(path))

    def _report(self, rule: Rule, path: Sdf.Path, message: str, hint: str = "") -> None:
        self._into.report(rule, path, self._place(path), message, hint)

    def _home(self, prim: Usd.Prim) -> Sdf.Path | None:
        """The graph in which a shader stands in the document, None for the document itself."""
        path = prim.GetPath().GetParentPath()
        return path if path in self._graphs else None

    def _graph(self, path: Sdf.Path) -> Any:
        if self._graphs[path] is None:
            graph = self._document.addNodeGraph(self._into.free(path.name))
            self._graphs[path] = graph
            self._document_text(self._stage.GetPrimAtPath(path), graph)
            self._note(graph, path)
        return self._graphs[path]

    def _node(self, prim: Usd.Prim, expected: str) -> tuple[Any, Any]:
        """The node of a shader, and its definition or None; `expected` is the type if nothing says it."""
        path = prim.GetPath()
        if path in self._nodes:
            return self._nodes[path]
        identifier = str(UsdShade.Shader(prim).GetIdAttr().Get() or "")
        definition = self._into.definition(identifier) if identifier else None
        home = self._home(prim)
        parent = self._document if home is None else self._graph(home)
        category = str(definition.getNodeString()) if definition is not None else identifier or "unknown"
        kind = str(definition.getType()) if definition is not None else expected or "float"
        node = parent.addNode(_valid(category), self._into.free(prim.GetName(), parent), kind)
        self._document_text(prim, node)
        self._note(node, path)
        self._nodes[path] = (node, definition)
        if definition is None and not identifier:
            self._report(rules.DOC_UNKNOWN_NODE, path, "the shader has no info:id, by which MaterialX would know it")
        if definition is not None:
            self._waiting.append((prim, node, definition, home))
        return self._nodes[path]

    def _document_text(self, prim: Usd.Prim, element: Any) -> None:
        if prim.HasAuthoredDocumentation():
            element.setDocString(prim.GetDocumentation())

    def _inputs(self, prim: Usd.Prim, node: Any, definition: Any, home: Sdf.Path | None) -> None:
        for given in UsdShade.Shader(prim).GetInputs():
            name, attribute = given.GetBaseName(), given.GetAttr()
            declared = definition.getActiveInput(name)
            if declared is None:
                self._unknown_input(attribute, name, node, definition)
                continue
            kind = materialx_type(attribute.GetTypeName(), declared.getType())
            if kind != declared.getType():
                message = f"input '{name}' has type {kind}, expected {declared.getType()}"
                self._report(rules.DOC_INPUT_TYPE, attribute.GetPath(), message)
                continue
            self._input(node, attribute, name, kind, home)
        is_earlier = self._into.is_earlier and earlier_definition(definition.getName()) is not None
        if not is_earlier and self._definition_without_name(node) != definition.getName():
            node.setNodeDefString(definition.getName())

    def _definition_without_name(self, node: Any) -> str:
        """The definition that a node gets by its inputs, "" for none; the search reads the whole document anew."""
        inputs = tuple((str(given.getName()), str(given.getType())) for given in node.getInputs())
        key = (str(node.getCategory()), str(node.getType()), inputs)
        if key not in self._into.definitions:
            found = node.getNodeDef()
            self._into.definitions[key] = "" if found is None else str(found.getName())
        return self._into.definitions[key]

    def _unknown_input(self, attribute: Usd.Attribute, name: str, node: Any, definition: Any) -> None:
        inputs = [str(declared.getName()) for declared in definition.getActiveInputs()]
        near = difflib.get_close_matches(name, inputs, 1)
        message = f"'{node.getCategory()}' has no input '{name}'" + (f"; did you mean '{near[0]}'?" if near else "")
        rule = rules.RETRO_UNDEFINED if name == "retroreflective" else rules.DOC_UNKNOWN_INPUT
        hint = "" if name == "retroreflective" else f"Its inputs are {', '.join(inputs)}."
        self._report(rule, attribute.GetPath(), message, hint)

    def _input(self, parent: Any, attribute: Usd.Attribute, name: str, kind: str, home: Sdf.Path | None) -> None:
        """An input of a node or a graph, with its value or connection; none if it has neither."""
        source = self._source(attribute, home)
        if source.kind is _Kind.VALUE:
            value, space = self._value(source.attribute, kind), space_of(source.attribute) or space_of(attribute)
            if source.attribute.GetPath() != attribute.GetPath() and not self._fits(source.attribute, attribute, kind):
                return
            if value is None and not space:
                return
            given = parent.addInput(name, kind)
            if value is not None:
                given.setValueString(value)
            if space and kind in COLORED:
                given.setColorSpace(space)
        elif source.kind is _Kind.NOTHING:
            self._dangling(source)
            return
        else:
            given = parent.addInput(name, kind)
            space = space_of(attribute)
            if source.kind is _Kind.INTERFACE:  # MaterialX takes an image's space from what reads it
                origin = self._source(source.attribute, None)
                space = (origin.kind is _Kind.VALUE and space_of(origin.attribute)) or space
            if kind in COLORED and space:
                given.setColorSpace(space)
            self._connect(given, source, kind)
        self._note(given, attribute.GetPath())

    def _dangling(self, source: _Source) -> None:
        self._report(rules.DOC_CONNECTION, source.attribute.GetPath(), f"nothing gives a value at {source.name}")

    def _fits(self, source: Usd.Attribute, attribute: Usd.Attribute, kind: str) -> bool:
        found = materialx_type(source.GetTypeName(), kind)
        if found != kind:
            message = f"'{source.GetPath().name}' of {source.GetPrimPath().name} gives {found}, expected {kind}"
            self._report(rules.DOC_CONNECTION, attribute.GetPath(), message)
        return found == kind

    def _value(self, attribute: Usd.Attribute, kind: str) -> str | None:
        """The value of an attribute as text, None if it has none."""
        if attribute.GetNumTimeSamples() > 0:
            message = "the value is animated; that of its first time is taken"
            self._report(rules.INTERCHANGE_LOST, attribute.GetPath(), message)
        value = attribute.Get(Usd.TimeCode.EarliestTime())
        if value is None:
            return None
        if kind == "filename":
            return self._into.file_name(attribute) or None
        try:
            return to_text(value)
        except TypeError:  # USD's text may hold a path or a dictionary whatever the type is
            self._report(
                rules.DOC_INPUT_VALUE, attribute.GetPath(), f"its value is no {kind}, but a {type(value).__name__}"
            )
            return None

    def _connect(self, given: Any, source: _Source, kind: str) -> None:
        """Connect an input or output of the document."""
        if source.kind is _Kind.NODE:
            node, definition = self._node(source.prim, kind)
            given.setNodeName(node.getName())
            names = [] if definition is None else outputs_of(definition)
            shader_output = source.name in TERMINALS and len(names) == 1
            if definition is not None and not shader_output and (len(names) > 1 or source.name not in names):
                given.setOutputString(source.name)
        elif source.kind is _Kind.GRAPH:
            graph = self._graph(source.prim.GetPath())
            given.setNodeGraphString(graph.getName())
            given.setOutputString(self._output(graph, source, kind))
        elif source.kind is _Kind.INTERFACE:
            graph = self._graph(source.prim.GetPath())
            given.setInterfaceName(self._interface(graph, source.attribute, source.name, kind))

    def _interface(self, graph: Any, attribute: Usd.Attribute, name: str, kind: str) -> str:
        """Name of a graph's input. In USD, a shader of the graph may have the same name as the input."""
        path = attribute.GetPath()
        if path not in self._names:
            self._names[path] = self._into.free(name, graph)
            self._input(graph, attribute, self._names[path], kind, None)
            if graph.getInput(self._names[path]) is None:  # it has no value; inputs that name it need it all the same
                self._note(graph.addInput(self._names[path], kind), path)
        return self._names[path]

    def _output(self, graph: Any, asked: _Source, kind: str) -> str:
        """Name of a graph's output, which is of the type that is asked of it."""
        path = asked.attribute.GetPath()
        if path in self._names:
            return self._names[path]
        name = self._names[path] = self._into.free(asked.name, graph)
        output = graph.addOutput(name, kind)
        self._note(output, path)
        source = self._source(asked.attribute, asked.prim.GetPath())
        if source.kind is _Kind.VALUE:
            value = self._value(source.attribute, kind)
            if value is not None:
                output.setValueString(value)
        elif source.kind is _Kind.NOTHING:
            self._dangling(source)
        else:
            self._connect(output, source, kind)
        return name

    def _source(self, attribute: Usd.Attribute, home: Sdf.Path | None) -> _Source:
        """The source of a value, followed through the graphs and materials that the document lacks."""
        seen = set()
        while True:
            seen.add(attribute.GetPath())
            paths = attribute.GetConnections()
            if not paths:
                return _Source(_Kind.VALUE, attribute.GetPrim(), "", attribute)
            if len(paths) > 1:
                message = f"it is connected {len(paths)} times; the first connection is taken"
                self._report(rules.INTERCHANGE_LOST, attribute.GetPath(), message)
            prim = self._stage.GetPrimAtPath(paths[0].GetPrimPath())
            name, kind = UsdShade.Utils.GetBaseNameAndType(paths[0].name)
            if prim and prim.IsA(UsdShade.Shader) and kind == UsdShade.AttributeType.Output:
                return _Source(_Kind.NODE, prim, name, attribute)
            following = self._stage.GetAttributeAtPath(paths[0])
            is_graph = bool(prim) and prim.IsA(UsdShade.NodeGraph)
            if not is_graph or not following or following.GetPath() in seen:
                return _Source(_Kind.NOTHING, attribute.GetPrim(), str(paths[0]), attribute)
            if prim.GetPath() in self._graphs:
                if kind == UsdShade.AttributeType.Output and home != prim.GetPath():
                    return _Source(_Kind.GRAPH, prim, name, following)
                if kind == UsdShade.AttributeType.Input and home == prim.GetPath():
                    return _Source(_Kind.INTERFACE, prim, name, following)
            attribute = following


def _valid(name: str) -> str:
    return "".join(c if c.isalnum() and c.isascii() else "_" for c in name)
