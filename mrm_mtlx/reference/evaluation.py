"""Evaluates a graph for samples: walks it from its end, each node by its function or through the graph that defines it.

A shader is generated from the graph and so evaluates the same operations; which of them float32 rounds, and where a
rounding decides, is noted on the way (`float32.rounding`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import MaterialX as mx
import numpy as np

from mrm_mtlx.documents.constants import nothing_given, numbers, unit_scale
from mrm_mtlx.documents.graph import Scope, binding, defining_graph, interface_input, source
from mrm_mtlx.documents.interfaces import file_space, is_passed_over, value_space
from mrm_mtlx.library.color_spaces import color_transform
from mrm_mtlx.reference.closures import Closure, Light, Model
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.models import OTHER_NUMBERS, SAME_MODEL, Contents
from mrm_mtlx.reference.node_inputs import NodeInputs
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.reference.state import State

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes import Value

# Types whose values are not numbers that float32 rounds.
_UNROUNDED = ("integer", "boolean", "string", "filename")


class Evaluation(State):
    """One pass over the graph for some samples."""

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
        found = self.definitions.get(path)
        if found is None:
            found = self.definitions[path] = node.getNodeDef()
        return found

    def _evaluate(self, node: Any, definition: Any, scope: Scope, light: Light) -> Value | dict[str, Value]:
        kinds = {str(out.getName()): str(out.getType()) for out in definition.getActiveOutputs()}
        if definition.getName() not in NODES:
            inner = Scope(f"{scope.path}/{node.getNamePath()}", node, scope)
            made = self._graph_values(defining_graph(definition), inner, light)
            if len(kinds) == 1:  # that of the graph, whatever its name
                made = dict(zip(kinds, made.values(), strict=True))
            return {name: self._in_linear_color(made[name], node, name, kinds[name], scope, light) for name in made}
        value = NODES[definition.getName()](NodeInputs(self, node, definition, scope, light, self.input_value))
        if self.model is Model.CLOSURES and isinstance(value, Closure) and definition.getName() not in SAME_MODEL:
            nodes = {str(node.getCategory())} if np.any(value.response != 0.0) else ()
            value = replace(value, contents=value.contents | Contents(nodes=frozenset(nodes)))
        if self.model is Model.CLOSURES and definition.getName() in OTHER_NUMBERS:
            self.other_numbers.add(str(node.getCategory()))
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
        return self.rounded(value)

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
        """The value that an input of a graph of the document holds, for an input of a node in it that reads it."""
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
        return self.rounded(number)

    def _written(self, number: NDArray[np.float32], scope: Scope) -> Array:
        """The number as the shader holds it: in float32; one inside of a graph is written into the source."""
        if scope.node is not None or scope.values:
            six = np.array([float(f"{x:.6f}") for x in number.flat]).reshape(number.shape).astype(np.float32)
            if np.any(six != number) and self.deviates(Deviation.SIX_DECIMALS):
                number = six
        return number.astype(float)

    def _is_taken_as_it_is(self, element: Any) -> bool:
        """True for a colour that is a definition's default, which generators do not transform; see `Deviation`."""
        if not element.getParent().isA(mx.NodeDef):
            return False
        if color_transform(element.getDocument(), element.getActiveColorSpace()) is None:
            return False
        return self.deviates(Deviation.DEFAULT_COLORS)


def _has_closures(definition: Any) -> bool:
    """True if a node's value depends on the mode: it is a closure itself. Shaders add up the modes."""
    return any(out.getType() in ("BSDF", "VDF") for out in definition.getActiveOutputs())
