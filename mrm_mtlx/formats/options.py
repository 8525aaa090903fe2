"""Options that a format declares: typed, and with the words that the command line shows.

    @dataclass(frozen=True)
    class MyOptions(Options):
        digits: Annotated[int | None, Option("N", "Digits of numbers. Default: 9.")] = None

They are checked when they are made. `registry` has those of all formats.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple, get_type_hints


class Option(NamedTuple):
    """An option as the command line shows it: what stands for its value, and what it does."""

    metavar: str
    description: str


@dataclass(frozen=True)
class Options:
    """The options of a format; this one has none. What is not given is None."""

    @classmethod
    def names(cls) -> list[str]:
        """Names of the options, in order."""
        return [field.name for field in fields(cls)]

    @classmethod
    def declared(cls) -> dict[str, tuple[Any, Option]]:
        """The type of each option, without its words, and its words."""
        hints = get_type_hints(cls, include_extras=True)
        return {name: (hints[name].__origin__, *hints[name].__metadata__) for name in cls.names()}
