"""`mrm convert`: a document in another format, and a file of another format as a document."""

from __future__ import annotations

import functools
import inspect
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_type_hints

import typer
from typer.core import TyperCommand

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.options import Roots, Timeout
from mrm_mtlx.system.arguments import ArgumentError, refuse
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Callable


class _Command(TyperCommand):
    """The command, which asks for the formats and their options when it is run, and not when `mrm` starts."""

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """That of the command with all options."""
        app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        errors.register(app, _with_options_of_formats(convert))
        return typer.main.get_command(app).make_context(info_name, args, parent, **extra)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("convert", cls=_Command, help=convert.__doc__)(lambda: None)


def convert(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document, or a file of another format.")],
    output: Annotated[
        Path | None, typer.Argument(metavar="OUTPUT", help="What to write; its ending names the format.")
    ] = None,
    option: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="The same as OUTPUT.")] = None,
    to: Annotated[str | None, typer.Option("--to", help="The format, whatever the ending.")] = None,
    portable: Annotated[
        bool, typer.Option("--portable", help="Nodes of MaterialX's standard library alone, for hosts without ours.")
    ] = False,
    file: Annotated[
        Path | None,
        typer.Option("--compare", metavar="FILE", help="Write nothing; compare with this OpenMATERIAL file."),
    ] = None,
    root: Roots = None,
    force: Annotated[
        bool, typer.Option("--force", help="Also replace files beside OUTPUT that are there with other content.")
    ] = False,
    timeout: Timeout = TIME_LIMIT_S,
    **options: Any,
) -> None:
    """Write a document as USD or glTF, read one from these, or write its R_A as OpenMATERIAL 3D has it."""
    del timeout  # its option has handed it on
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import Terminal

    if output is not None and option is not None:
        raise ArgumentError(f"{output} is to be written already", "option")
    output = output or option
    shared: dict[str, Any] = {"root": root or (), "listener": Terminal(), **options}
    if file is not None:
        refuse(
            {"option": output, "to": to, "portable": portable, "force": force}, "not with `file`, which writes nothing"
        )
        found = mrm.compare(path, file, **shared)
        typer.echo(found)
        raise typer.Exit(0 if found.equal else 1)
    if output is None:
        raise ArgumentError("expected a file to write, or `file`", "output")
    written = mrm.convert(path, output, to=to, portable=portable, force=force, **shared)
    raise typer.Exit(0 if written.complete else 1)


def _with_options_of_formats(function: Callable[..., None]) -> Callable[..., None]:
    """The function with an option for each that a format declares, and the names of formats for `--to`."""
    from mrm_mtlx.formats.format import Capability
    from mrm_mtlx.formats.registry import declared_options, formats_that

    @functools.wraps(function)
    def wrapped(**given: Any) -> None:
        function(**given)

    hints = get_type_hints(function, include_extras=True)
    del hints["options"], hints["return"]
    names = [known.name for known in formats_that(Capability.WRITE) if known.ambiguous]
    enumeration: Any = StrEnum
    hints["to"] = Annotated[
        enumeration("FormatName", [(name.upper(), name) for name in names]) | None, *hints["to"].__metadata__
    ]
    for name, (of_type, (metavar, description)) in declared_options().items():
        hints[name] = Annotated[of_type, typer.Option(_flag(name, of_type), metavar=metavar or None, help=description)]
    own, kind = inspect.signature(function).parameters, inspect.Parameter.KEYWORD_ONLY
    parameters = [
        inspect.Parameter(name, kind, annotation=hint, default=own[name].default if name in own else None)
        for name, hint in hints.items()
    ]
    wrapped.__annotations__ = hints
    vars(wrapped)["__signature__"] = inspect.Signature(parameters)
    return wrapped


def _flag(name: str, of_type: Any) -> str:
    """The option's name on the command line, with its opposite if it is a switch."""
    flag = name.replace("_", "-")
    return f"--{flag}/--no-{flag}" if bool in get_args(of_type) else f"--{flag}"
