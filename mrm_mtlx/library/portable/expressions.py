"""Formulas that write themselves as nodes of MaterialX's standard library.

    nodes = Expressions(graph, "lobe")
    cosine = nodes.dot(normal, view).absolute()
    sine = (1.0 - cosine * cosine).root()

Each operation is a node, made once for the same operands, and not before something takes its value, so that formulas
may repeat what they need and name what they do not. Operations of constants are none. Colours are computed as vectors:
generators convert a colour that is written in a document by its colour space, and would convert the constants of a
formula with it.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

Number = float | tuple[float, ...]

# By which an input says where its value comes from, and how it is to be read.
_SOURCES = ("value", "nodename", "nodegraph", "output", "interfacename", "colorspace", "unit", "unittype")
_COMPONENTS = {"float": 1, "vector2": 2, "vector3": 3, "vector4": 4}
# Operations of two constants, which need no node.
_OPERATIONS: dict[str, Callable[[float, float], float]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "max": max,
    "min": min,
    "power": operator.pow,
}


@dataclass(frozen=True, eq=False)
class Value:
    """A value that inputs of nodes can take.

    Attributes
    ----------
    nodes
        Whose it is.
    kind
        Its type in MaterialX.
    source
        Attributes of an input that takes it; empty for that of a node.
    number
        Of a constant.
    operation
        Of a node: its category, inputs and constants.
    """

    nodes: Expressions
    kind: str
    source: Mapping[str, str] = field(default_factory=dict)
    number: tuple[float, ...] | None = None
    operation: tuple[str, Mapping[str, Value], Mapping[str, Any]] | None = None

    def given_to(self, taker: Any, name: str) -> None:
        """Add an input to a node that takes this value."""
        given = taker.addInput(name, self.kind)
        for attribute, text in (self.source or {"nodename": self.nodes.written(self)}).items():
            given.setAttribute(attribute, text)

    def is_constant(self, number: float) -> bool:
        """True if all components are a constant, and this one."""
        return self.number is not None and all(x == number for x in self.number)

    def __add__(self, other: Value | float) -> Value:
        """The sum."""
        return self.nodes.combined("add", self, other)

    def __sub__(self, other: Value | float) -> Value:
        """The difference."""
        return self.nodes.combined("subtract", self, other)

    def __mul__(self, other: Value | float) -> Value:
        """The product, component by component."""
        return self.nodes.combined("multiply", self, other)

    def __truediv__(self, other: Value | float) -> Value:
        """The quotient, component by component."""
        return self.nodes.combined("divide", self, other)

    def __radd__(self, other: float) -> Value:
        """The sum with a constant."""
        return self + other

    def __rmul__(self, other: float) -> Value:
        """The product with a constant."""
        return self * other

    def __rsub__(self, other: float) -> Value:
        """A constant without this."""
        return self.nodes.constant(other, self.kind) - self

    def __rtruediv__(self, other: float) -> Value:
        """A constant by this."""
        return self.nodes.constant(other, self.kind) / self

    def __neg__(self) -> Value:
        """The opposite."""
        return self * -1.0

    def root(self) -> Value:
        """The square root, component by component."""
        if self.number is not None:
            return self.nodes.constant(tuple(x**0.5 for x in self.number), self.kind)
        return self.nodes.node("sqrt", self.kind, {"in": self})

    def absolute(self) -> Value:
        """The absolute value, component by component."""
        return self.nodes.node("absval", self.kind, {"in": self})

    def at_least(self, low: Value | float) -> Value:
        """The larger of this and another, component by component."""
        return self.nodes.combined("max", self, low)

    def at_most(self, high: Value | float) -> Value:
        """The smaller of this and another, component by component."""
        return self.nodes.combined("min", self, high)

    def to_the(self, exponent: Value | float) -> Value:
        """The power, component by component."""
        return self.nodes.combined("power", self, exponent)

    def component(self, index: int) -> Value:
        """One of its components."""
        if self.number is not None:
            return self.nodes.constant(self.number[index])
        return self.nodes.node("extract", "float", {"in": self}, index=index)

    def normalized(self) -> Value:
        """The unit vector of its direction."""
        return self.nodes.node("normalize", self.kind, {"in": self})

    def length(self) -> Value:
        """The length of a vector."""
        return self.nodes.node("magnitude", "float", {"in": self})

    def converted(self, kind: str) -> Value:
        """The same numbers as another type: a vector of three for a colour, and the reverse."""
        return self.nodes.node("convert", kind, {"in": self})


class Expressions:
    """Nodes of formulas in a graph or document.

    Parameters
    ----------
    graph
        Where the nodes are.
    prefix
        What their names begin with. Nodes of one shader need names of their own, whatever graph they are in.
    """

    def __init__(self, graph: Any, prefix: str) -> None:
        self._graph = graph
        self._prefix = prefix
        self._known: dict[tuple[Any, ...], Value] = {}
        self._written: dict[int, str] = {}

    def constant(self, number: Number, kind: str = "float") -> Value:
        """A constant; one number for all components, or a number for each."""
        numbers = number if isinstance(number, tuple) else (number,) * _COMPONENTS[kind]
        return self._value(kind, {"value": ", ".join(f"{x:.9g}" for x in numbers)}, numbers)

    def given(self, given: Any) -> Value:
        """The value that an input of the document has, whatever gives it."""
        source = {name: text for name in _SOURCES if (text := str(given.getAttribute(name)))}
        kind = str(given.getType())
        if source.keys() == {"value"} and kind in _COMPONENTS:
            number = given.getValue()
            return self.constant(number if kind == "float" else tuple(number.asTuple()), kind)
        return self._value(kind, source)

    def node(self, category: str, kind: str, inputs: Mapping[str, Value], **constants: str | int) -> Value:
        """The output of a node; `constants` are inputs that are no numbers of a formula: spaces, indices."""
        key = (category, kind, *((name, id(value)) for name, value in inputs.items()), *constants.items())
        if key not in self._known:
            self._known[key] = Value(self, kind, operation=(category, inputs, constants))
        return self._known[key]

    def added(self, category: str, kind: str) -> Any:
        """A new node without inputs."""
        return self._graph.addNode(category, self._graph.createValidChildName(f"{self._prefix}_{category}"), kind)

    def written(self, value: Value) -> str:
        """Name of the node that gives a value."""
        if id(value) not in self._written and value.operation is not None:
            category, inputs, constants = value.operation
            for inner in inputs.values():
                if not inner.source:
                    self.written(inner)  # nodes stand before those that use them
            made = self.added(category, value.kind)
            for name, inner in inputs.items():
                inner.given_to(made, name)
            for name, constant in constants.items():
                made.setInputValue(name, constant)
            self._written[id(value)] = str(made.getName())
        return self._written[id(value)]

    def combined(self, category: str, first: Value, second: Value | float) -> Value:
        """An operation of two values; of a vector and a number, it is done to each component."""
        if not isinstance(second, Value):
            second = self.constant(second)
        if first.number is not None and second.number is not None:
            return self._folded(_OPERATIONS[category], first, second)
        if category == "multiply" and (first.is_constant(0.0) or second.is_constant(0.0)):
            return self.constant(0.0, max(first.kind, second.kind))
        if (category == "multiply" and second.is_constant(1.0)) or (category == "add" and second.is_constant(0.0)):
            return first
        if first.kind == "float" and second.kind != "float":
            if category in ("add", "multiply"):
                first, second = second, first
            elif category == "subtract":
                category, first, second = "add", -second, first
            else:
                category, first, second = "multiply", 1.0 / second, first
        return self.node(category, first.kind, {"in1": first, "in2": second})

    def dot(self, first: Value, second: Value) -> Value:
        """The scalar product."""
        return self.node("dotproduct", "float", {"in1": first, "in2": second})

    def sum(self, value: Value) -> Value:
        """The sum of the components of a vector."""
        return self.dot(value, self.constant(1.0, value.kind))

    def cross(self, first: Value, second: Value) -> Value:
        """The vector product."""
        return self.node("crossproduct", first.kind, {"in1": first, "in2": second})

    def vector(self, components: Iterable[Value]) -> Value:
        """A vector of components."""
        inputs = {f"in{number}": value for number, value in enumerate(components, start=1)}
        return self.node(f"combine{len(inputs)}", f"vector{len(inputs)}", inputs)

    def where(self, value: Value, reaches: float, then: Value, otherwise: Value) -> Value:
        """One of two values, by whether a number is at least another."""
        inputs = {"value1": value, "value2": self.constant(reaches), "in1": then, "in2": otherwise}
        return self.node("ifgreatereq", then.kind, inputs)

    def if_true(self, flag: Value, then: Value, otherwise: Value) -> Value:
        """One of two values, by a boolean."""
        inputs = {"value1": flag, "value2": self._value("boolean", {"value": "true"}), "in1": then, "in2": otherwise}
        return self.node("ifequal", then.kind, inputs)

    def _value(self, kind: str, source: Mapping[str, str], number: tuple[float, ...] | None = None) -> Value:
        """The one value of a source."""
        key = (kind, *source.items())
        if key not in self._known:
            self._known[key] = Value(self, kind, source, number)
        return self._known[key]

    def _folded(self, operation: Callable[[float, float], float], first: Value, second: Value) -> Value:
        """An operation of two constants."""
        kind = max(first.kind, second.kind)  # a float and a vector
        one, other = (x.number * (_COMPONENTS[kind] // len(x.number)) for x in (first, second) if x.number is not None)
        return self.constant(tuple(map(operation, one, other)), kind)
