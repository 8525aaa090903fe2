"""Checks of what a caller gives: one error type, which names the argument that is wrong."""

from __future__ import annotations

import math
import os
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

T = TypeVar("T", bound="str | float | os.PathLike[str]")


class ArgumentError(ValueError):
    """An argument of a call is wrong.

    Attributes
    ----------
    message
        What was given and what was expected, on one line. A word in backticks is the name of an argument, which the
        command line writes as it calls it.
    argument
        The name of the argument, "" where no single one is wrong.
    """

    def __init__(self, message: str, argument: str = "") -> None:
        super().__init__(f"{argument}: {message}" if argument else message)
        self.message, self.argument = message, argument

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.message, self.argument)


def one_or_more(given: T | Iterable[T]) -> tuple[T, ...]:
    """The values of an argument that takes several, or one without a list around it.

    Examples
    --------
    >>> one_or_more("glsl"), one_or_more(["glsl", "osl"]), one_or_more(0.2)
    (('glsl',), ('glsl', 'osl'), (0.2,))
    """
    one = isinstance(given, str | Real | os.PathLike)
    return (cast("T", given),) if one else tuple(cast("Iterable[T]", given))


def refuse(given: Mapping[str, Any], why: str) -> None:
    """Raise an ArgumentError for the first argument that is given: nothing is accepted and ignored.

    None, False and what is empty is not given.
    """
    for argument, value in given.items():
        if value is not None and value is not False and value != () and value != []:
            raise ArgumentError(why, argument)


def check_choice(argument: str, value: str | None, choices: Collection[str]) -> None:
    """Raise an ArgumentError unless a value is one of the choices, or None."""
    if value is not None and value not in choices:
        msg = f"'{value}': expected one of {', '.join(choices)}"
        raise ArgumentError(msg, argument)


def check_range(argument: str, value: float, lower: float, upper: float = math.inf) -> None:
    """Raise an ArgumentError unless a number is within bounds, which belong to it."""
    if not lower <= value <= upper:
        expected = f"{lower:.10g} or more" if upper == math.inf else f"{lower:.10g} to {upper:.10g}"
        msg = f"{value:g}: expected {expected}"
        raise ArgumentError(msg, argument)


def check_positive(argument: str, value: float | None) -> None:
    """Raise an ArgumentError unless a number is finite and above 0, or None."""
    if value is not None and not 0.0 < value < math.inf:
        msg = f"{value:g}: expected a number above 0"
        raise ArgumentError(msg, argument)


def check_angles(argument: str, angles: Sequence[float], lower: float, upper: float) -> None:
    """Raise an ArgumentError unless all angles [degrees] are within bounds, which belong to them."""
    for angle in angles:
        if not lower <= angle <= upper:
            msg = f"{angle:g}: expected an angle from {lower:g} to {upper:g} degrees"
            raise ArgumentError(msg, argument)
