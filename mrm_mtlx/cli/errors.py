"""The exceptions of the public functions, as usage messages and exit statuses."""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING, Any, NoReturn, get_type_hints

import typer

from mrm_mtlx.api import errors
from mrm_mtlx.cli import usage
from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Callable

# By kind, how its message begins, and the exit status. The findings of a document are on the terminal already.
_ENDS: dict[type[errors.MrmError], tuple[str | None, int]] = {
    errors.NothingToRenderError: ("", 3),
    errors.NoReferenceError: ("mrm: ", 3),
    errors.NoValueError: ("mrm: ", 3),
    errors.NothingToConvertError: ("mrm: ", 1),
    errors.ShaderError: ("", 1),
    errors.DocumentError: (None, 1),
    errors.DataError: ("mrm: ", 1),
    errors.UnavailableError: ("mrm: ", 2),
}


def register(app: typer.Typer, function: Callable[..., None]) -> None:
    """Make a function a command, whose errors end it as they should."""
    app.command()(reporting(function))


def reporting(function: Callable[..., None]) -> Callable[..., None]:
    """The function with typer's exceptions in the place of ours."""

    @functools.wraps(function)
    def wrapped(*arguments: Any, **keywords: Any) -> None:
        try:
            function(*arguments, **keywords)
        except ArgumentError as error:
            _refuse(error, function)
        except errors.MrmError as error:
            raise typer.Exit(tell(error)) from error

    return wrapped


def tell(error: errors.MrmError) -> int:
    """Print the message of an exception, if nothing has said it yet; the exit status that it means."""
    begin, status = next(end for kind, end in _ENDS.items() if isinstance(error, kind))
    if begin is not None:
        typer.echo(printable(f"{begin}{error}"), err=True)
    return status


def _refuse(error: ArgumentError, function: Callable[..., None]) -> NoReturn:
    """A usage message, with arguments as the command line calls them."""
    names = {name: usage.called(hint) for name, hint in get_type_hints(function, include_extras=True).items()}
    message = re.sub(r"`(\w+)`", lambda found: names.get(found[1]) or found[0], error.message)
    raise typer.BadParameter(message, param_hint=names.get(error.argument) or error.argument or None) from error
