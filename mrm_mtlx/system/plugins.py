"""Objects that other packages register, as entry points of a group."""

from __future__ import annotations

from importlib import metadata
from typing import TypeVar

T = TypeVar("T")


class PluginError(Exception):
    """Something that another package registers is of no use; the message names it, and says what to do."""


def registered(group: str, kind: type[T]) -> list[T]:
    """The objects of a group, in the order of their names.

    Raises
    ------
    PluginError
        If one does not load, or is of another kind.
    """
    found = []
    for entry in sorted(metadata.entry_points(group=group), key=lambda entry: (entry.name, entry.value)):
        package = f" of {entry.dist.name} {entry.dist.version}" if entry.dist is not None else ""
        what = f"the entry point '{entry.name} = {entry.value}'{package} in {group}"
        try:
            value = entry.load()
        except Exception as error:  # whatever the modules of other packages raise
            msg = f"{what} does not load ({type(error).__name__}: {error}); upgrade or remove the package"
            raise PluginError(msg) from error
        if not isinstance(value, kind):
            msg = f"{what} is a {type(value).__name__}, expected a {kind.__name__}; upgrade or remove the package"
            raise PluginError(msg)
        found.append(value)
    return found
