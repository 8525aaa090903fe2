"""A node as its function sees it, in one evaluation."""
# ruff: noqa: D102 -- the contract of each method is that of `nodes.Inputs`

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from mrm_mtlx.documents.graph import Scope, connected_node, source
from mrm_mtlx.reference.closures import Closure, Facets, Light, nothing
from mrm_mtlx.reference.nodes import ShaderValue

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.reference.nodes import Value
    from mrm_mtlx.reference.state import State


class InputValue(Protocol):
    """The walk over the graph, from an input of a node on."""

    def __call__(
        self, node: Any, definition: Any, name: str, scope: Scope, light: Light, *, stored: bool = False
    ) -> Value | None:
        """See `evaluation.Evaluation.input_value`."""
        ...


@dataclass
class NodeInputs:
    """`nodes.Inputs` of one node in one evaluation."""

    state: State
    node: Any
    definition: Any
    scope: Scope
    light: Light
    input_value: InputValue
    _settled: int = 0

    @property
    def frame(self) -> Mapping[str, Array]:
        return self.state.frame

    def geometric_property(self, name: str, default: Array) -> Array:
        self.state.asked[name] = str(self.definition.getType())
        return self.state.properties.get(name, default)

    @property
    def lights(self) -> list[Light]:
        return self.state.lights

    def under(self, light: Light) -> NodeInputs:
        return replace(self, light=light)

    def array(self, name: str) -> Array:
        return cast("Array", self._value(name))

    def stored(self, name: str) -> Array:
        return cast("Array", self._value(name, stored=True))

    def text(self, name: str) -> str:
        return cast("str", self._value(name))

    def image(self, name: str) -> NDArray[np.floating] | None:
        file = self.text(name)
        return self.state.images(file) if file else None

    def closure(self, name: str) -> Closure:
        value = self._value(name)
        return nothing() if value is None else cast("Closure", value)

    def emission(self, name: str) -> Array:
        value = self._value(name)
        return np.zeros((3, 1)) if value is None else cast("Array", value)

    def shader(self, name: str) -> ShaderValue:
        value = self._value(name)
        return ShaderValue(np.zeros((3, 1)), np.zeros((3, 1))) if value is None else cast("ShaderValue", value)

    def discrete(self, value: Array) -> Array:
        self._settled += 1
        return self.state.settle((self.scope.path, str(self.node.getNamePath()), self._settled), np.asarray(value))

    def skipped(self, value: Array) -> Array:
        key = (self.scope.path, str(self.node.getNamePath()), self._settled)
        exact = None if self.state.exact is None else self.state.exact.discrete.varying.get(key)
        return np.asarray(np.zeros(value.shape, bool) if exact is None else np.abs(value - exact) > 1.0)

    @property
    def level(self) -> float:
        return self.state.perturbation.level

    def is_defined(self, name: str) -> bool:
        return self.definition.getActiveInput(name) is not None

    def is_connected(self, name: str) -> bool:
        given = self.node.getInput(name)
        if given is None:
            return False
        found = source(given, self.scope)
        return bool(given.getInterfaceName()) if found is None else found[0].getCategory() != "constant"

    def is_weighted(self, name: str) -> bool:
        given = self.node.getInput(name)
        node = None if given is None else connected_node(given)
        definition = None if node is None else node.getNodeDef()
        return definition is not None and definition.getActiveInput("weight") is not None

    def deviates(self, deviation: Deviation) -> bool:
        return self.state.deviates(deviation)

    def note(self, facets: Facets) -> None:
        self.state.lobes.append(facets)

    def _value(self, name: str, *, stored: bool = False) -> Value | None:
        at = self.node, self.definition, name, self.scope, self.light
        return self.state.values.input((name, stored, self.light.mode), lambda: self.input_value(*at, stored=stored))
