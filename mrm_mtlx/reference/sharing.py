"""Values that evaluations of the same samples share: an exact one's, where a perturbation does not touch them.

Each value is noted with what it is made of: the directions and quantities that were asked for while it was evaluated
(`rounding.Perturbation.touches`). Numbers of the document are in everything.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar, cast

from mrm_mtlx.reference.closures import Light
from mrm_mtlx.reference.float32.rounding import EXACT, Direction, Perturbation

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from mrm_mtlx.reference.float32.rounding import Ingredient, Quantity

_Result = TypeVar("_Result")
Key: TypeAlias = "tuple[object, ...]"

_DIRECTIONS = {direction.value: direction for direction in Direction}


@dataclass(frozen=True)
class Known(Generic[_Result]):
    """A value, and what it is made of."""

    value: _Result
    needs: frozenset[Ingredient]


@dataclass
class Values:
    """Values that an evaluation knows, by key, as they are asked for.

    `exact`: of the exact evaluation of the same samples, from which is taken what the perturbation does not touch.
    """

    perturbation: Perturbation = EXACT
    exact: Values | None = None
    _known: dict[Key, Known[Any]] = field(default_factory=dict)
    # Keys of the values that are being evaluated, innermost last, and what they are made of as far as that is known.
    _open: list[tuple[Key, set[Ingredient]]] = field(default_factory=lambda: [((), set())])

    @property
    def needs(self) -> frozenset[Ingredient]:
        """Ingredients so far of the value that is being evaluated."""
        return frozenset(self._open[-1][1])

    def note(self, needs: Iterable[Ingredient]) -> None:
        """Note what the value that is being evaluated is made of."""
        self._open[-1][1].update(needs)

    def find(self, key: Key) -> Known[Any] | None:
        """The value that is known by a key, of this evaluation or of the exact one."""
        return self._known.get(key) or self._unperturbed(key)

    def make(self, key: Key, function: Callable[[], _Result]) -> Known[_Result]:
        """The function's result, known by this key from now on."""
        known = self._known[key] = self._evaluated(key, set(), function)
        return known

    def take(self, known: Known[_Result]) -> _Result:
        """A value for the one that is being evaluated, which is then made of the same."""
        self.note(known.needs)
        return known.value

    def input(self, name: object, function: Callable[[], _Result]) -> _Result:
        """An input of the value that is being evaluated, by a name of its own there."""
        return self._shared(name, set(), function)

    def kept(self, name: object, function: Callable[[], _Result]) -> _Result:
        """As `input`, of an intermediate result: it is made of all that has been asked for before, too."""
        return self._shared(name, set(self._open[-1][1]), function)

    def _shared(self, name: object, needs: set[Ingredient], function: Callable[[], _Result]) -> _Result:
        key = (*self._open[-1][0], name)
        known = self._unperturbed(key) or self._evaluated(key, needs, function)
        if self.exact is None:
            self._known[key] = known
        return cast("_Result", self.take(known))

    def _unperturbed(self, key: Key) -> Known[Any] | None:
        known = None if self.exact is None else self.exact._known.get(key)
        return None if known is None or self.perturbation.touches(known.needs) else known

    def _evaluated(self, key: Key, needs: set[Ingredient], function: Callable[[], _Result]) -> Known[_Result]:
        self._open.append((key, needs))
        value = function()
        self._open.pop()
        return Known(value, frozenset(needs))


@dataclass(frozen=True)
class NotingLight(Light):
    """A light that notes which of its directions and quantities were asked for, and keeps intermediate results."""

    values: Values = field(kw_only=True)

    def __getattribute__(self, name: str) -> Any:
        """The attribute; that it is a direction is noted."""
        if name in _DIRECTIONS:
            self.values.note((_DIRECTIONS[name],))
        return super().__getattribute__(name)

    def perturbs(self, quantity: Quantity) -> bool:
        """See `Light`; the quantity is noted."""
        self.values.note((quantity,))
        return super().perturbs(quantity)

    def kept(self, name: str, function: Callable[[], _Result]) -> _Result:
        """See `Light`."""
        return self.values.kept(name, function)
