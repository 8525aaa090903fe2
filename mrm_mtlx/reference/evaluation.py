"""Evaluates a graph for samples: walks it from its end, each node by its function or through the graph that defines it.

A shader is generated from the graph and so evaluates the same operations; which of them float32 rounds, and where a
rounding decides, is noted on the way (`rounding`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import MaterialX as mx
import numpy as np

from mrm_mtlx.documents.constants import nothing_given, numbers, unit_scale
from mrm_mtlx.documents.graph import Scope, binding, defining_graph, interface_input, source
from mrm_mtlx.documents.interfaces import file_space, is_passed_over, value_space
from mrm_mtlx.library.color_spaces import color_transform
from mrm_mtlx.reference.closures import Closure, Environment, Facets, Light, Mode, Model
from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.rounding import EXACT, VIEW, Move, value_sign
from mrm_mtlx.reference.models import OTHER_NUMBERS, SAME_MODEL
from mrm_mtlx.reference.node_inputs import NodeInputs
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.reference.sharing import NotingLight, Values

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes import Value
    from mrm_mtlx.reference.points import ShadingPoints

# Types whose values are not numbers that float32 rounds.
_UNROUNDED = ("integer", "boolean", "string", "filename")


@dataclass(frozen=True)
class Illumination:
    """What lights a surface: one light of unit irradiance at each sample's l, or none, and its surroundings."""

    light: bool = True
    environment: Environment | None = None


LIGHT = Illumination()


@dataclass
class Discrete:
    """Discrete intermediate results (a comparison, a floor) of an exact evaluation.

    A result that is the same at all samples is a property of the document and no matter of rounding: moved evaluations
    take it from here. `varying` are those that are not.
    """

    settled: dict[tuple[str, str, int], Array] = field(default_factory=dict)
    varying: dict[tuple[str, str, int], Array] = field(default_factory=dict)


@dataclass
class Evaluation:
    """One pass over the graph for some samples; values are kept per node and scope, closures also per mode.

    `images` gives the pixels of a file by its name in the document; `exact` is the exact evaluation of the same
    samples: what it decided, and its values that the move does not touch, are taken from there. `watch` is told the
    path of each node that is evaluated, those that it depends on first, and its value.
    """

    points: ShadingPoints
    move: Move = EXACT
    model: Model = Model.HARDWARE
    illumination: Illumination = LIGHT
    images: Callable[[str], NDArray[np.floating] | None] = lambda _name: None
    deviations: frozenset[Deviation] = frozenset()
    exact: Evaluation | None = None
    discrete: Discrete = field(default_factory=Discrete)
    lobes: list[Facets] = field(default_factory=list)
    used: set[str] = field(default_factory=set)  # geometry, by the names of `frame`
    asked: dict[str, str] = field(default_factory=dict)  # geometric properties and their types
    foreign: set[str] = field(default_factory=set)  # numbers that OSL has otherwise
    met: set[Deviation] = field(default_factory=set)  # where MaterialX's code may deviate
    watch: Callable[[str, Any], None] = lambda _path, _value: None

    def __post_init__(self) -> None:
        """Prepare the shading frame as the generated vertex stage and `main` do."""
        # The generated shader normalises what it interpolates, and takes the light's direction as it is.
        view, light = unit(self.points.view.T), np.atleast_2d(self.points.light).T
        self.values: Values = Values(self.move, None if self.exact is None else self.exact.values)
        at = NotingLight(view, light, self.move.part, self.model, share=self.move.share, values=self.values)
        self.light: Light = at
        surroundings = self.illumination.environment
        modes = [] if surroundings is None else [Mode.INDIRECT, Mode.TRANSMISSION]
        around = [replace(at, mode=m, environment=surroundings) for m in modes]
        self.lights: list[Light] = [*[at] * self.illumination.light, *around]
        normal, tangent = self.points.normal.T, self.points.tangent.T
        frame = {"N": unit(normal), "T": unit(tangent), "B": unit(np.cross(normal, tangent, axis=0))}
        frame["P"] = self.points.position.T
        named = {f"{name}{space}": value for name, value in frame.items() for space in ("world", "object")}
        self.frame = _Noting(named | {"UV0": self.points.texcoord.T, "Vworld": -view}, self.used, self.values)
        self._definitions: dict[tuple[str, str], Any] = {} if self.exact is None else self.exact._definitions
        self._numbers = 0  # rounded so far
        properties = self.points.properties
        self.properties = {name: self._rounded(np.asarray(v, dtype=float).T) for name, v in properties.items()}

    def _rounded(self, value: Array) -> Array:
        if not self.move.values:
            return value
        self._numbers += 1
        return value * (1.0 + self.move.step * value_sign(self.move.values, self._numbers))

    def settle(self, key: tuple[str, str, int], value: Array) -> Array:
        """A discrete result; see `Discrete`."""
        if value.ndim == 0 or value.shape[-1] == 1:
            if self.exact is not None:
                return self.exact.discrete.settled.get(key, value)
            self.discrete.settled[key] = value
        else:
            self.discrete.varying[key] = value
        return value

    def node_value(self, node: Any, output: str, scope: Scope, light: Light) -> Value:
        """Value of a node's output; the first one if `output` is empty, the only one whatever it is."""
        path = (scope.path, str(node.getNamePath()))
        known = self.values.find((*path, None)) or self.values.find((*path, light.mode))
        if known is None:
            definition = self._definition(path, node)
            key = (*path, light.mode if _has_closures(definition) else None)
            known = self.values.make(key, lambda: self._evaluate(node, definition, scope, light))
            self.watch("/".join(filter(None, path)).lstrip("/"), self.values.take(known))
        value = self.values.take(known)
        if isinstance(value, dict):
            named = value[output] if output and len(value) > 1 else next(iter(value.values()))
            return cast("Value", named)
        return cast("Value", value)

    def _definition(self, path: tuple[str, str], node: Any) -> Any:
        """A node's definition, which MaterialX takes its time to find."""
        found = self._definitions.get(path)
        if found is None:
            found = self._definitions[path] = node.getNodeDef()
        return found

    def _evaluate(self, node: Any, definition: Any, scope: Scope, light: Light) -> Value | dict[str, Value]:
        kinds = {str(out.getName()): str(out.getType()) for out in definition.getActiveOutputs()}
        if definition.getName() not in NODES:
            inner = Scope(f"{scope.path}/{node.getNamePath()}", node, scope)
            made = self._graph_values(defining_graph(definition), inner, light)
            if len(kinds) == 1:  # that of the graph, whatever its name
                made = dict(zip(kinds, made.values(), strict=True))
            return {name: self._in_linear_color(made[name], node, name, kinds[name], scope, light) for name in made}
        value = NODES[definition.getName()](NodeInputs(self, node, definition, scope, light))
        if self.model is Model.CLOSURES and isinstance(value, Closure) and definition.getName() not in SAME_MODEL:
            lit = np.any(value.response != 0.0)
            value = replace(value, foreign=value.foreign | ({str(node.getCategory())} if lit else set()))
        if self.model is Model.CLOSURES and definition.getName() in OTHER_NUMBERS:
            self.foreign.add(str(node.getCategory()))
        if isinstance(value, dict):
            return {name: self._rounded_value(v, kinds[name]) for name, v in value.items()}
        output, kind = next(iter(kinds.items()))
        return self._in_linear_color(self._rounded_value(value, kind), node, output, kind, scope, light)

    def _graph_values(self, graph: Any, scope: Scope, light: Light) -> dict[str, Value]:
        return {
            str(out.getName()): self.node_value(out.getConnectedNode(), out.getOutputString(), scope, light)
            for out in graph.getOutputs()
        }

    def _rounded_value(self, value: Value, kind: str) -> Value:
        if not isinstance(value, np.ndarray) or kind in _UNROUNDED or value.dtype == bool:
            return value
        return self._rounded(value)

    def _in_linear_color(self, value: Value, node: Any, output: str, kind: str, scope: Scope, light: Light) -> Value:
        """The value of a node that is given an image in a colour space: generators transform the colours it gives.

        That is the outermost node of colours that has the file, also where an image inside of its graph reads it.
        """
        files = [given for given in node.getInputs() if given.getType() == "filename"]
        if not files or not kind.startswith("color"):
            return value
        use = f"{scope.path}/{node.getNamePath()}:{output}"
        return self.linear_color(cast("Array", value), file_space(files[0], scope), node.getDocument(), light, use)

    def linear_color(self, value: Array, space: str, document: Any, light: Light, use: str) -> Array:
        """Colours in linear Rec.709, through the graph that MaterialX has for their space; alpha stays.

        `use` tells apart the colours of an evaluation.
        """
        definition = color_transform(document, space)
        if definition is None:
            return value
        scope = Scope(f"{use}:{space}", values={"in": value[:3]}, needs=self.values.needs)
        made = self._graph_values(defining_graph(definition), scope, light)
        color = cast("Array", next(iter(made.values())))
        if len(value) == 3:
            return color
        return np.concatenate([color, np.broadcast_to(value[3:], (len(value) - 3, color.shape[-1]))])

    def input_value(
        self, node: Any, definition: Any, name: str, scope: Scope, light: Light, *, stored: bool = False
    ) -> Value | None:
        """Value of a node's input: connected, bound to an interface, given, or the definition's default.

        `stored`: a colour that is given is taken as it stands, in whatever space.
        """
        declared = definition.getActiveInput(name)
        given = node.getInput(name)
        if given is None:
            return self._default(declared, scope, light, stored)
        found = source(given, scope)
        if found is not None:
            return self.node_value(*found, light)
        bound = binding(given, scope)
        if bound is not None:
            return self._interface_value(bound, given, declared, scope, light, stored)
        # MaterialX's generators pass over a number given to an input that has a geometric default (a normal).
        is_given = given.getValueString() or given.getType() in ("string", "filename")
        if declared.getDefaultGeomPropString() or not is_given:
            return self._default(declared, scope, light, stored)
        return self._constant(given, declared, scope, light, stored)

    def _interface_value(
        self, name: str, given: Any, declared: Any, scope: Scope, light: Light, stored: bool
    ) -> Value | None:
        if name in scope.values:
            self.values.note(scope.needs)
            value: Value = scope.values[name]
            return value
        outer_node = scope.node
        if outer_node is None:  # a graph of the document itself: the interface input carries the value
            interface = interface_input(given)
            found = source(interface, scope)
            return (
                self.node_value(*found, light)
                if found
                else self._held(interface, given, declared, scope, light, stored)
            )
        outer = scope.outer or Scope()
        definition = self._definition((outer.path, str(outer_node.getNamePath())), outer_node)
        return self.input_value(outer_node, definition, name, outer, light, stored=stored)

    def _held(
        self, interface: Any, given: Any, declared: Any, scope: Scope, light: Light, stored: bool
    ) -> Value | None:
        """What an input of a graph of the document holds itself, for an input of a node in it that reads it."""
        if not interface.getDefaultGeomPropString() and is_passed_over(interface, declared, scope):
            return self._default(declared, scope, light, stored)
        if stored or not interface.getType().startswith("color") or interface.getParent().isA(mx.NodeDef):
            return self._default(interface, scope, light, stored)
        number = cast("Array", self._default(interface, scope, light, stored=True))
        use = f"{scope.path}/{given.getNamePath()}"
        return self.linear_color(number, value_space(interface, given), interface.getDocument(), light, use)

    def _default(self, declared: Any, scope: Scope, light: Light, stored: bool) -> Value | None:
        geometry = declared.getDefaultGeomPropString()
        if geometry:
            return self.frame[geometry]
        if declared.getType() in ("string", "filename"):
            return str(declared.getResolvedValueString())
        if declared.getValueString():
            return self._constant(declared, declared, scope, light, stored)
        return nothing_given(declared.getType())

    def _constant(self, element: Any, declared: Any, scope: Scope, light: Light, stored: bool) -> Value:
        kind = element.getType()
        if kind in ("string", "filename"):
            return str(element.getResolvedValueString())
        if kind in ("boolean", "integer"):
            return numbers(element)
        number = self._written(np.asarray(numbers(element) * unit_scale(element, declared), dtype=np.float32), scope)
        if kind.startswith("color") and not stored and not self._is_taken_as_it_is(element):
            use = f"{scope.path}/{element.getNamePath()}"
            number = self.linear_color(number, element.getActiveColorSpace(), element.getDocument(), light, use)
        return self._rounded(number)

    def _written(self, number: NDArray[np.float32], scope: Scope) -> Array:
        """What the shader holds: the number in float32; one inside of a graph is written into the source."""
        if scope.node is not None or scope.values:
            six = np.array([float(f"{x:.6f}") for x in number.flat]).reshape(number.shape).astype(np.float32)
            if np.any(six != number):
                self.met.add(Deviation.SIX_DECIMALS)
                number = six if Deviation.SIX_DECIMALS in self.deviations else number
        return number.astype(float)

    def _is_taken_as_it_is(self, element: Any) -> bool:
        """Whether a colour is a definition's default that generators do not transform; see `Deviation`."""
        if not element.getParent().isA(mx.NodeDef):
            return False
        if color_transform(element.getDocument(), element.getActiveColorSpace()) is None:
            return False
        self.met.add(Deviation.DEFAULT_COLORS)
        return Deviation.DEFAULT_COLORS in self.deviations


class _Noting(dict[str, "Array"]):
    """A dictionary that notes which of its entries were asked for."""

    def __init__(self, entries: Mapping[str, Array], asked: set[str], values: Values) -> None:
        super().__init__(entries)
        self._asked, self._values = asked, values

    def __getitem__(self, name: str) -> Array:
        self._asked.add(name)
        if name == "Vworld":
            self._values.note((VIEW,))
        return super().__getitem__(name)


def _has_closures(definition: Any) -> bool:
    """Whether a node's value depends on the mode: it is a closure itself. Shaders add up the modes."""
    return any(out.getType() in ("BSDF", "VDF") for out in definition.getActiveOutputs())
