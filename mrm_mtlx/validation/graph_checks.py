"""Checks of a document's structure against the node definitions."""

from __future__ import annotations

import difflib
import math
import re
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.library.color_spaces import LINEAR, equivalent, in_opencolorio, is_handled
from mrm_mtlx.library.surface_models import FLAG, amounts_of
from mrm_mtlx.text import text_lines
from mrm_mtlx.validation.findings import Finding, Severity, finding

if TYPE_CHECKING:
    from collections.abc import Iterator

# Generators recurse along connections; chains that real graphs never reach are refused before they do.
MAXIMUM_CHAIN = 200

# Messages of MaterialX's own validation that a more precise rule here covers.
_COVERED = (
    "Node interface error",
    "Node interface doesn't support",
    "Invalid value",
    "Invalid port connection",
    "No output found for port connection",
    "Mismatched types in port connection",
)

_COMPONENTS = {"float": 1, "vector2": 2, "vector3": 3, "vector4": 4, "color3": 3, "color4": 4}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def check_graph(document: mx.Document) -> list[Finding]:
    """Findings about nodes, inputs, values and connections, in document order."""
    try:
        valid, messages = document.validate()
    except Exception as error:  # definitions that inherit from themselves, types that contain themselves
        return [finding("DOC_INVALID", "", f"MaterialX cannot validate it: {error}")]
    findings = list(check_cycles(document))
    if findings:
        return findings  # whatever follows connections must not run on these
    for node in nodes_of(document):
        findings += check_node(node)
    findings += check_outputs(document)
    findings += check_color_spaces(document)
    if not valid:
        explained = any(f.severity is Severity.ERROR for f in findings)
        for line in text_lines(messages.strip()):
            if not (explained and line.startswith(_COVERED)):
                findings.append(finding("DOC_INVALID", "", line.strip()))
    return findings


def nodes_of(document: mx.Document) -> list[Any]:
    """All nodes of the document, those inside its graphs included, in file order; not those of the library."""
    return [element for element in document.traverseTree() if element.isA(mx.Node)]


def location(element: Any) -> str:
    """Path of an element, "/graph/node/input"."""
    return f"/{element.getNamePath()}"


def check_node(node: Any) -> Iterator[Finding]:
    """Whether the node is defined, and its inputs with it."""
    definition = node.getNodeDef()
    if definition is None:
        yield from _undefined(node)
        return
    for given in node.getInputs():
        declared = definition.getActiveInput(given.getName())
        if declared is None:  # of the definition that the node names
            yield _unknown_input(given, node, [definition])
        else:
            yield from _check_value(given, declared)
            yield from _check_connection(given, declared)


def _undefined(node: Any) -> Iterator[Finding]:
    """Why a node has no definition: no such category, an unknown input, a wrong type."""
    category = node.getCategory()
    definitions = node.getDocument().getMatchingNodeDefs(category)
    if not definitions:
        known = {d.getNodeString() for d in node.getDocument().getNodeDefs()}
        known |= {d.getNodeString() for d in _library(node).getNodeDefs()}
        if category.startswith("ND_"):  # the name of a definition, as USD's shaders have
            known = {d.getName() for d in _library(node).getNodeDefs()}
        near = difflib.get_close_matches(category, sorted(known), 1)
        message = f"there is no node '{category}'" + (f"; did you mean '{near[0]}'?" if near else "")
        yield finding("DOC_UNKNOWN_NODE", location(node), message)
        return
    fitting = [d for d in definitions if d.getType() == node.getType()]
    if not fitting:
        types = ", ".join(sorted({d.getType() for d in definitions}))
        message = f"'{category}' of type {node.getType()} is not defined; it exists for {types}"
        yield finding("DOC_UNKNOWN_NODE", location(node), message)
        return
    version = node.getVersionString()
    if version and not any(d.isVersionCompatible(version) for d in fitting):
        versions = ", ".join(dict.fromkeys(d.getVersionString() or "none" for d in fitting))
        message = f"version {version} of '{category}' is not defined; it exists in {versions}"
        hint = "Remove the node's version, or name one that exists."
        yield finding("DOC_UNKNOWN_NODE", location(node), message, hint)
        return
    explained = False
    for given in node.getInputs():
        name = given.getName()
        declared = [d.getActiveInput(name) for d in fitting if d.getActiveInput(name) is not None]
        if not declared:
            explained = True
            yield _unknown_input(given, node, fitting)
        elif given.getType() not in {d.getType() for d in declared}:
            explained = True
            types = " or ".join(sorted({d.getType() for d in declared}))
            message = f"input '{name}' has type {given.getType()}, expected {types}"
            yield finding("DOC_INPUT_TYPE", location(given), message)
    if not explained:
        message = f"no definition of '{category}' takes this combination of input types"
        yield finding("DOC_UNKNOWN_NODE", location(node), message)


def _unknown_input(given: Any, node: Any, definitions: list[Any]) -> Finding:
    name, category = given.getName(), node.getCategory()
    if name in (FLAG, *amounts_of(category)):
        message = f"'{category}' has no input '{name}'"
        return finding("RETRO_UNDEFINED", location(given), message)
    inputs = list(dict.fromkeys(i.getName() for d in definitions for i in d.getActiveInputs()))
    near = difflib.get_close_matches(name, inputs, 1)
    message = f"'{category}' has no input '{name}'" + (f"; did you mean '{near[0]}'?" if near else "")
    return finding("DOC_UNKNOWN_INPUT", location(given), message, f"Its inputs are {', '.join(inputs)}.")


def _check_value(given: Any, declared: Any) -> Iterator[Finding]:
    text = given.getValueString()
    if not text or is_connected(given):
        return
    if declared.getDefaultGeomPropString():
        message = f"'{given.getName()}' is given as {text}, but taken from the geometry"
        yield finding("DOC_VALUE_IGNORED", location(given), message)
        return
    value = _parsed(given)
    if value is None:
        message = f"'{text}' is not a {given.getType()}{_form(given.getType())}"
        yield finding("DOC_INPUT_VALUE", location(given), message)
        return
    allowed = [item.strip() for item in declared.getAttribute("enum").split(",") if item.strip()]
    if given.getType() == "string" and allowed and text not in allowed and not declared.getAttribute("enumvalues"):
        message = f"'{text}' is not one of {', '.join(allowed)}"
        yield finding("DOC_INPUT_VALUE", location(given), message)
    yield from _check_range(given, declared, value)
    yield from _check_unit(given, declared)


def _check_unit(given: Any, declared: Any) -> Iterator[Finding]:
    """A unit of another type than the definition's; one that does not exist is MaterialX's own finding."""
    wanted, kind = declared.getUnitType(), given.getUnitType()
    if wanted and kind not in ("", wanted):
        message = f"'{given.getUnit()}' is a unit of {kind}, expected one of {wanted}"
        yield finding("DOC_INPUT_VALUE", location(given), message)


def _check_range(given: Any, declared: Any, value: Any) -> Iterator[Finding]:
    numbers = _numbers(value)
    for attribute, beyond, word in (("uimin", min, "below"), ("uimax", max, "above")):
        bound = _bound(declared, attribute)
        if bound is None or len(bound) != len(numbers):
            continue
        if any(beyond(number, limit) != limit for number, limit in zip(numbers, bound, strict=True)):
            limit = declared.getAttribute(attribute)
            message = f"{given.getName()} = {given.getValueString()} is {word} the definition's {attribute} of {limit}"
            yield finding("DOC_VALUE_RANGE", location(given), message)


def _check_connection(given: Any, declared: Any) -> Iterator[Finding]:
    if not is_connected(given):
        return
    output = given.getConnectedOutput()
    node = given.getConnectedNode()
    named = given.getNodeName() or given.getNodeGraphString() or given.getOutputString()
    if node is None and output is None:
        yield finding("DOC_CONNECTION", location(given), f"nothing is named '{named}' there")
    elif given.getNodeName() and given.getOutputString() and not _has_output(node, given.getOutputString()):
        message = f"'{given.getNodeName()}' has no output '{given.getOutputString()}'"
        yield finding("DOC_CONNECTION", location(given), message)
    else:
        source = given.getOutputString() and _output_type(node, given.getOutputString())
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


def check_color_spaces(document: mx.Document) -> Iterator[Finding]:
    """Colour spaces that MaterialX has no transform for, each once, where it is declared first."""
    declared: dict[str, list[Any]] = {}
    for element in document.traverseTree():
        if element.getAttribute("colorspace"):
            declared.setdefault(element.getAttribute("colorspace"), []).append(element)
    for space, elements in declared.items():
        if not is_handled(document, space):
            yield _unknown_space(space, equivalent(document, space), elements)


def _unknown_space(space: str, known: str, elements: list[Any]) -> Finding:
    more = f" (it is declared {len(elements)} times)" if len(elements) > 1 else ""
    if known:
        message = f"'{space}' is OpenColorIO's name of {known}, and unknown to MaterialX's generators{more}"
        return finding("DOC_COLOR_SPACE", location(elements[0]), message, f"Write {known}.")
    whose = "of OpenColorIO's configurations " if in_opencolorio(space) else ""
    message = f"'{space}' {whose}cannot be converted to {LINEAR}{more}"
    return finding("DOC_COLOR_SPACE", location(elements[0]), message)


def check_cycles(document: mx.Document) -> Iterator[Finding]:
    """A circle of connections, or a chain beyond `MAXIMUM_CHAIN`; the first one found."""
    graphs = _defining_graphs(document)
    depth: dict[str, int] = {}
    for start in nodes_of(document):
        if start.getNamePath() in depth:
            continue
        open_nodes: list[tuple[Any, Iterator[Any]]] = [(start, iter(_upstream(start, graphs)))]
        on_path = {start.getNamePath()}
        while open_nodes:
            node, upstream = open_nodes[-1]
            path = node.getNamePath()
            following = next(upstream, None)
            if following is None:
                open_nodes.pop()
                on_path.discard(path)
                depth[path] = 1 + max((depth.get(n.getNamePath(), 0) for n in _upstream(node, graphs)), default=0)
                if depth[path] > MAXIMUM_CHAIN:
                    message = f"the node ends a chain of more than {MAXIMUM_CHAIN} nodes"
                    yield finding("DOC_CYCLE", location(node), message)
                    return
                continue
            name = following.getNamePath()
            if name in on_path:
                circle = [n.getName() for n, _ in open_nodes]
                circle = circle[[n.getNamePath() for n, _ in open_nodes].index(name) :]
                message = f"the nodes feed each other: {' <- '.join((*circle, following.getName()))}"
                yield finding("DOC_CYCLE", location(node), message)
                return
            if name not in depth:
                open_nodes.append((following, iter(_upstream(following, graphs))))
                on_path.add(name)


def _defining_graphs(document: mx.Document) -> dict[str, list[Any]]:
    """The document's graphs that define nodes, by the name of the definition."""
    graphs: dict[str, list[Any]] = {}
    for graph in document.getChildren():  # getNodeGraphs() would add those of the library
        if graph.isA(mx.NodeGraph) and graph.getNodeDefString():
            graphs.setdefault(graph.getNodeDefString(), []).append(graph)
        elif graph.isA(mx.Implementation) and document.getNodeGraph(graph.getNodeGraph()) is not None:
            graphs.setdefault(graph.getNodeDefString(), []).append(document.getNodeGraph(graph.getNodeGraph()))
    return graphs


def _upstream(node: Any, graphs: dict[str, list[Any]]) -> list[Any]:
    """Nodes that a node depends on: through its connections, its graph's interface, and the graph that defines it."""
    found = []
    for given in node.getInputs():
        for element in (given, given.getInterfaceInput()):
            if element is None:
                continue
            output = element.getConnectedOutput() if is_connected(element) else None
            source = output.getConnectedNode() if output is not None else element.getConnectedNode()
            if source is not None:
                found.append(source)
    definition = node.getNodeDef() if graphs else None
    if definition is not None:
        for graph in graphs.get(definition.getName(), ()):
            found += [o.getConnectedNode() for o in graph.getOutputs() if o.getConnectedNode() is not None]
    return [n for n in found if n.isA(mx.Node)]


def is_connected(element: Any) -> bool:
    """Whether an input takes its value from elsewhere than a literal or an interface."""
    return bool(element.getNodeName() or element.getNodeGraphString() or element.getOutputString())


def _library(element: Any) -> Any:
    document = element.getDocument()
    return document.getDataLibrary() if document.hasDataLibrary() else document


def _has_output(node: Any, name: str) -> bool:
    return bool(_output_type(node, name))


def _output_type(node: Any, name: str) -> str:
    definition = node.getNodeDef() if node is not None and node.isA(mx.Node) else None
    output = definition.getActiveOutput(name) if definition is not None else None
    if output is None and node is not None:
        output = node.getOutput(name)
    return str(output.getType()) if output is not None else ""


def _parsed(given: Any) -> Any:
    """Parsed value, or None if it is not of its type; numbers that are not finite are none."""
    kind = given.getType()
    if kind in ("string", "filename", "geomname"):
        return given.getValueString()
    if kind in _COMPONENTS:
        # MaterialX takes what it understands of a number and passes over the rest: "0,5" would be 0.
        parts = given.getValueString().split(",")
        if len(parts) != _COMPONENTS[kind] or not all(_NUMBER.fullmatch(part.strip()) for part in parts):
            return None
    try:
        value = given.getValue()
    except Exception:  # MaterialX throws several unrelated types
        return None
    return value if value is None or all(math.isfinite(x) for x in _numbers(value)) else None


def _numbers(value: Any) -> list[float]:
    if isinstance(value, bool | str):
        return []
    if isinstance(value, int | float):
        return [float(value)]
    return [float(x) for x in value.asTuple()] if hasattr(value, "asTuple") else []


def _bound(declared: Any, attribute: str) -> list[float] | None:
    text = declared.getAttribute(attribute)
    try:
        bound = [float(part) for part in text.split(",")] if text else []
    except ValueError:
        return None
    return bound if bound and all(math.isfinite(x) for x in bound) else None


def _form(kind: str) -> str:
    if _COMPONENTS.get(kind, 1) > 1:
        return f" ({_COMPONENTS[kind]} numbers, separated by commas)"
    return {"boolean": " (exactly true or false)", "integer": " (a whole number)", "float": " (a finite number)"}.get(
        kind, ""
    )
