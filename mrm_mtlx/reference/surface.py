"""Evaluates the graph of a renderable element."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import MaterialX as mx
import numpy as np

from mrm_mtlx.reference.closures import Closure, Facets, Light, Model, transparent
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.rounding import (
    EXACT,
    OUTPUT_ROUNDINGS,
    ROUNDING_FACTOR,
    SMALLEST,
    UNIT,
    Move,
    Tolerance,
    moves,
    value_sign,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes import Value

# Graphs deeper than this are refused with a message instead of running into the interpreter's own limit of 1000 frames,
# of which a node takes five.
MAXIMUM_DEPTH = 120

_GEOMETRY = ("Nworld", "Tworld", "Pworld", "UV0")


class UnsupportedError(Exception):
    """The reference does not know something that the surface is made of.

    `names` are the node definitions, colour spaces and geometric properties it lacks, sorted.
    """

    def __init__(self, names: list[str]) -> None:
        super().__init__(f"the reference does not know {', '.join(names)}")
        self.names = names


@dataclass(frozen=True)
class Scope:
    """Where an element stands: inside which graph, and what is bound to the graph's interface.

    `path` tells apart two uses of one graph; `interface` maps the graph's inputs to the node that uses it.
    """

    path: str = ""
    node: Any = None
    outer: Scope | None = None


class Surface:
    """A renderable element, ready to be evaluated.

    Parameters
    ----------
    element
        A material, or an output or node of type surfaceshader, in a document whose data library is set.
    model
        Whose microfacet lobes: those of the hardware targets, or of OSL's closures.

    Raises
    ------
    UnsupportedError
        If the graph uses what the reference does not know; all of it is named at once.
    RecursionError
        If the graph is deeper than `MAXIMUM_DEPTH` nodes, or cyclic.
    """

    def __init__(self, element: Any, model: Model = Model.HARDWARE) -> None:
        self._element = element
        self._model = model
        self._document = element.getDocument()  # elements do not keep their document alive
        survey = _Survey()
        survey.visit(_shader_node(element))
        if survey.unknown:
            raise UnsupportedError(sorted(survey.unknown))

    def response(self, points: ShadingPoints, move: Move = EXACT) -> Array:
        """Radiance per unit irradiance of one light, the cosine of l included, shape (samples, 3), float64.

        `move` displaces the evaluation by a rounding error; see `rounding`.
        """
        color, _ = self._evaluate(points.moved(move.view, move.light), move)
        return np.ascontiguousarray(np.broadcast_to(color, (3, len(points))).T)

    def lobes(self, points: ShadingPoints) -> list[Facets]:
        """The microfacet lobes met while evaluating these points, with their parameters; in the graph's order."""
        return self._evaluate(points, EXACT)[1]

    def _evaluate(self, points: ShadingPoints, move: Move) -> tuple[Array, list[Facets]]:
        """Colour, component first, and the microfacet lobes met; a material without a shader is black."""
        root = _shader_node(self._element)
        if root is None:
            return np.zeros((3, 1)), []
        evaluation = _Evaluation(points, move, self._model)
        with np.errstate(all="ignore"):  # 0/0 of degenerate input is what the shader has, too
            return cast("Array", evaluation.node_value(root, "", Scope())), evaluation.lobes

    def tolerance(self, points: ShadingPoints) -> Tolerance:
        """The expected response, and by how much a float32 evaluation may miss it.

        allowed = ROUNDING_FACTOR * sum over the moves of |response(moved) - response| + OUTPUT_ROUNDINGS units of the
        response itself.
        """
        expected = self.response(points)
        moved = np.zeros_like(expected)
        for move in moves():
            moved += np.abs(self.response(points, move) - expected)
        allowed = ROUNDING_FACTOR * moved + OUTPUT_ROUNDINGS * UNIT * np.abs(expected) + SMALLEST
        return Tolerance(expected, allowed)


@dataclass
class _Evaluation:
    """One pass over the graph; values are kept per node and scope."""

    points: ShadingPoints
    move: Move
    model: Model = Model.HARDWARE
    values: dict[tuple[str, str], Value | dict[str, Value]] = field(default_factory=dict)
    numbers: int = 0  # of the document's, met so far
    lobes: list[Facets] = field(default_factory=list)

    def __post_init__(self) -> None:
        # The generated shader normalises what it interpolates, and takes the light's direction as it is.
        self.light = Light(_unit(self.points.view.T), np.atleast_2d(self.points.light).T, self.move.part, self.model)
        self.frame = {
            "Nworld": _unit(self.points.normal.T),
            "Tworld": _unit(self.points.tangent.T),
            "Pworld": self.points.position.T,
            "UV0": self.points.texcoord.T,
        }
        properties = self.points.properties
        self.properties = {name: self._rounded(np.asarray(v, dtype=float).T) for name, v in properties.items()}

    def _rounded(self, value: Array) -> Array:
        if not self.move.values:
            return value
        self.numbers += 1
        return value * (1.0 + UNIT * value_sign(self.move.values, self.numbers))

    def node_value(self, node: Any, output: str, scope: Scope) -> Value:
        """Value of a node's output; the first one if `output` is empty."""
        key = (scope.path, node.getNamePath())
        if key not in self.values:
            definition = node.getNodeDef()
            graph = _graph(definition)
            if definition.getName() in NODES:
                self.values[key] = NODES[definition.getName()](_NodeInputs(self, node, definition, scope))
            else:
                inner = Scope("/".join((scope.path, *key[1:])), node, scope)
                self.values[key] = {
                    out.getName(): self.node_value(out.getConnectedNode(), out.getOutputString(), inner)
                    for out in graph.getOutputs()
                }
        value = self.values[key]
        if isinstance(value, dict):
            return value[output] if output else next(iter(value.values()))
        return value

    def input_value(self, node: Any, definition: Any, name: str, scope: Scope) -> Value | None:
        """Value of a node's input: connected, bound to an interface, given, or the definition's default."""
        declared = definition.getActiveInput(name)
        given = node.getInput(name)
        if given is not None:
            source = _source(given, scope)
            if source is not None:
                return self.node_value(*source)
            bound = _binding(given, scope)
            if bound is not None:
                return self._interface_value(bound, given, scope)
            # MaterialX's generators pass over a number given to an input that has a geometric default (a normal).
            if declared.getDefaultGeomPropString():
                return self._default(declared)
            if given.getValueString() or given.getType() in ("string", "filename"):
                return self._constant(given, declared)
        return self._default(declared)

    def _interface_value(self, name: str, given: Any, scope: Scope) -> Value | None:
        outer_node = scope.node
        if outer_node is None:  # a graph of the document itself: the interface input carries the value
            interface = given.getInterfaceInput()
            source = _source(interface, scope)
            if source is not None:
                return self.node_value(*source)
            return self._constant(interface, interface)
        return self.input_value(outer_node, outer_node.getNodeDef(), name, scope.outer or Scope())

    def _default(self, declared: Any) -> Value | None:
        geometry = declared.getDefaultGeomPropString()
        if geometry:
            return self.frame[geometry]
        if declared.getType() in ("BSDF", "EDF", "VDF", "surfaceshader") or not declared.getValueString():
            return None if declared.getType() != "string" else ""
        return self._constant(declared, declared)

    def _constant(self, element: Any, declared: Any) -> Value:
        kind = element.getType()
        if kind in ("string", "filename"):
            return str(element.getResolvedValueString())
        value = element.getValue()
        if kind == "boolean":
            return np.asarray(bool(value))
        if kind == "integer":
            return np.asarray(float(value))
        # What the shader holds is the number rounded to float32.
        if kind == "float":
            number = np.asarray(np.float32(_in_unit(float(value), element, declared)), dtype=float)
        else:
            number = np.array([[np.float32(x)] for x in value.asTuple()], dtype=float)
        if kind.startswith("color"):
            number = _COLOR_SPACES[element.getActiveColorSpace()](number)
        return self._rounded(number)


@dataclass(frozen=True)
class _NodeInputs:
    """`nodes.Inputs` of one node in one evaluation."""

    evaluation: _Evaluation
    node: Any
    definition: Any
    scope: Scope

    @property
    def light(self) -> Light:
        return self.evaluation.light

    @property
    def properties(self) -> Mapping[str, Array]:
        return self.evaluation.properties

    def array(self, name: str) -> Array:
        return cast("Array", self._value(name))

    def text(self, name: str) -> str:
        return cast("str", self._value(name))

    def closure(self, name: str) -> Closure:
        value = self._value(name)
        return transparent() if value is None else cast("Closure", value)

    def note(self, facets: Facets) -> None:
        self.evaluation.lobes.append(facets)

    def _value(self, name: str) -> Value | None:
        return self.evaluation.input_value(self.node, self.definition, name, self.scope)


def constant_input(node: Any, name: str) -> Array | str | None:
    """Value of a node's input where it is the same at every point; None where it varies or cannot be evaluated here.

    `node` stands in a document whose data library is set, and has a definition with that input. Scalars have shape (),
    colours and vectors (components,).
    """
    definition = node.getNodeDef()
    given, survey = node.getInput(name), _Survey()
    if given is not None:
        survey.visit(_connected(given))
    if survey.unknown:
        return None
    evaluation = _Evaluation(_TWO_POINTS, EXACT)
    try:
        value = evaluation.input_value(node, definition, name, Scope())
    except (KeyError, AttributeError, TypeError):  # an interface that is bound only where the graph is used
        return None
    if isinstance(value, str):
        return value
    if not isinstance(value, np.ndarray) or value.shape[-1:] == (2,):
        return None
    return value if value.ndim == 0 else value[:, 0]


# Two points that differ in everything: what is the same at both is constant.
_TWO_POINTS = ShadingPoints(
    view=np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]),
    light=np.array([[0.0, 0.6, 0.8], [0.0, 0.0, 1.0]]),
    normal=np.array([[0.0, 0.0, 1.0], [0.0, 0.28, 0.96]]),
    tangent=np.array([[1.0, 0.0, 0.0], [0.0, 0.96, -0.28]]),
    position=np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]),
    texcoord=np.array([[0.0, 0.0], [0.25, 0.75]]),
)


def _shader_node(element: Any) -> Any:
    """The surface shader node behind a renderable element, or None."""
    if element.isA(mx.Output):
        return element.getConnectedNode()
    if element.getType() == "material":
        shader = element.getInput("surfaceshader")
        return None if shader is None else _connected(shader)
    return element


def _connected(element: Any) -> Any:
    output = element.getConnectedOutput()
    return output.getConnectedNode() if output is not None else element.getConnectedNode()


def _source(element: Any, scope: Scope) -> tuple[Any, str, Scope] | None:
    """Node, output name and scope that an input is connected to."""
    node = element.getConnectedNode() if element.getNodeName() else None
    if node is not None:
        return node, str(element.getOutputString()), scope
    if element.getNodeGraphString() or (element.getOutputString() and not element.getNodeName()):
        output = element.getConnectedOutput()
        if output is not None and output.getConnectedNode() is not None:
            return output.getConnectedNode(), str(output.getOutputString()), scope
    return None


def _binding(element: Any, scope: Scope) -> str | None:
    name = str(element.getInterfaceName())
    if not name or (scope.node is None and element.getInterfaceInput() is None):
        return None
    return name


def _graph(definition: Any) -> Any:
    """The graph that defines a node, or None."""
    implementation = definition.getImplementation("genglsl")
    return implementation if implementation is not None and implementation.isA(mx.NodeGraph) else None


@dataclass
class _Survey:
    """What the reference does not know in everything that a node depends on.

    `heights` are the lengths of the longest chains that end at the nodes already seen, `trail` the nodes on the way.
    """

    unknown: set[str] = field(default_factory=set)
    heights: dict[str, int] = field(default_factory=dict)
    trail: list[str] = field(default_factory=list)

    def visit(self, node: Any) -> int:
        """Survey a node; the length of the longest chain of nodes that ends at it.

        Raises
        ------
        RecursionError
            If the graph is cyclic, or deeper than `MAXIMUM_DEPTH`.
        """
        if node is None:
            return 0
        path = node.getNamePath()
        if path in self.trail:
            msg = f"the graph is cyclic at {path}"
            raise RecursionError(msg)
        if len(self.trail) + self.heights.get(path, 1) > MAXIMUM_DEPTH:
            msg = f"the graph is deeper than {MAXIMUM_DEPTH} nodes at {path}"
            raise RecursionError(msg)
        if path not in self.heights:
            self.trail.append(path)
            self.heights[path] = 1 + max((self.visit(n) for n in self._sources(node)), default=0)
            self.trail.pop()
        return self.heights[path]

    def _sources(self, node: Any) -> list[Any]:
        """Nodes that a node takes values from; what it needs and the reference lacks is noted."""
        definition = node.getNodeDef()
        if definition is None:
            self.unknown.add(str(node.getCategory()))
            return []
        sources = []
        for given in node.getInputs():
            if given.getType().startswith("color") and given.getValueString():
                space = given.getActiveColorSpace()
                if space not in _COLOR_SPACES:
                    self.unknown.add(f"colour space {space}")
            sources += [_connected(element) for element in (given, given.getInterfaceInput()) if element is not None]
        if definition.getName() in NODES:
            for declared in definition.getActiveInputs():
                geometry = declared.getDefaultGeomPropString()
                if geometry not in ("", *_GEOMETRY) and node.getInput(declared.getName()) is None:
                    self.unknown.add(f"geometric property {geometry}")
            return sources
        graph = _graph(definition)
        if graph is None:
            self.unknown.add(str(definition.getName()))
            return sources
        made = [output.getConnectedNode() for output in graph.getOutputs()]
        if None in made:
            self.unknown.add(f"{definition.getName()} (its graph has an output that nothing is connected to)")
        return sources + made


def _unit(a: Array) -> Array:
    return np.asarray(a / np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]))


def _in_unit(value: float, element: Any, declared: Any) -> float:
    """A number in the unit of its definition; MaterialX's generators convert it so."""
    given, wanted = element.getUnit(), declared.getUnit()
    if not given or not wanted or given == wanted:
        return value
    units = _unit_scales(element.getDocument(), declared.getUnitType())
    return value * units[given] / units[wanted]


def _unit_scales(document: Any, kind: str) -> dict[str, float]:
    converter = mx.LinearUnitConverter.create(document.getUnitTypeDef(kind))
    return dict(converter.getUnitScale())


def _srgb(value: Array) -> Array:
    """IEC 61966-2-1 decoding."""
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0.0) + 0.055) / 1.055) ** 2.4)


# From a colour space to linear Rec.709; "" and "none" are taken as they are.
_COLOR_SPACES: dict[str, Any] = {
    "": lambda value: value,
    "none": lambda value: value,
    "lin_rec709": lambda value: value,
    "srgb_texture": _srgb,
}
