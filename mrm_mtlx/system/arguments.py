"""Checks of what a caller gives: one error type, which names the argument that is wrong."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from mrm_mtlx.system.text import shown

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

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


def one_or_more(given: T | Iterable[T] | None) -> tuple[T, ...]:
    """The values of an argument that takes several, or one without a list around it; of None none.

    Examples
    --------
    >>> one_or_more("glsl"), one_or_more(["glsl", "osl"]), one_or_more(0.2)
    (('glsl',), ('glsl', 'osl'), (0.2,))
    """
    if given is None:
        return ()
    one = isinstance(given, str | bytes | os.PathLike) or not isinstance(given, Iterable)
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
    if value is not None and not (isinstance(value, str) and value in choices):
        msg = f"{_shown(value)}: expected one of {', '.join(choices)}"
        raise ArgumentError(msg, argument)


def check_range(argument: str, value: float, lower: float, upper: float = math.inf) -> None:
    """Raise an ArgumentError unless a number is within bounds, which belong to it."""
    if not (isinstance(value, Real) and lower <= value <= upper):
        raise ArgumentError(_expected(value, Real, lower, upper), argument)


def check_whole(argument: str, value: int, lower: int, upper: float = math.inf) -> None:
    """Raise an ArgumentError unless a number is whole, and within bounds, which belong to them."""
    if not (isinstance(value, Integral) and lower <= value <= upper):
        raise ArgumentError(_expected(value, Integral, lower, upper), argument)


def check_positive(argument: str, value: float | None) -> None:
    """Raise an ArgumentError unless a number is finite and above 0, or None."""
    if value is not None and not (isinstance(value, Real) and 0.0 < value < math.inf):
        msg = f"{_shown(value)}: expected a number above 0"
        raise ArgumentError(msg, argument)


def check_flag(argument: str, value: bool | None) -> None:
    """Raise an ArgumentError unless a value is True, False or None."""
    if value is not None and not isinstance(value, bool):
        msg = f"{_shown(value)}: expected True or False"
        raise ArgumentError(msg, argument)


def check_angles(argument: str, angles: Sequence[float], lower: float, upper: float) -> None:
    """Raise an ArgumentError unless all angles [degrees] are within bounds, which belong to them."""
    for angle in angles:
        if not (isinstance(angle, Real) and lower <= angle <= upper):
            msg = f"{_shown(angle)}: expected an angle from {lower:g} to {upper:g} degrees"
            raise ArgumentError(msg, argument)


def path_of(argument: str, value: str | os.PathLike[str]) -> Path:
    """A path; an ArgumentError for what is none."""
    try:
        return Path(value)
    except TypeError:
        msg = f"{_shown(value)}: expected a path"
        raise ArgumentError(msg, argument) from None


def _expected(value: Any, kind: type, lower: float, upper: float) -> str:
    """A number that is wrong, and those that are right; their kind as well if it is of another."""
    bounds = f"{lower:.10g} or more" if upper == math.inf else f"{lower:.10g} to {upper:.10g}"
    name = "" if isinstance(value, kind) else "a whole number, " if kind is Integral else "a number, "
    return f"{_shown(value) if isinstance(value, kind) else shown(repr(value), '')}: expected {name}{bounds}"


def _shown(value: Any) -> str:
    """A value that is wrong, as a message has it."""
    if isinstance(value, str):
        return shown(str(value))
    return f"{value:g}" if isinstance(value, Real) else shown(repr(value), "")
