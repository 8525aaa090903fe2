"""`mrm convert`: a document in another format, and a file of another format as a document."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import FormatName
from mrm_mtlx.cli.options import Roots, Timeout
from mrm_mtlx.system.arguments import ArgumentError, refuse
from mrm_mtlx.system.process_limits import TIME_LIMIT_S


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, convert)


def convert(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document, or a file of another format.")],
    output: Annotated[
        Path | None, typer.Argument(metavar="OUTPUT", help="What to write; its ending names the format.")
    ] = None,
    option: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="The same as OUTPUT.")] = None,
    to: Annotated[FormatName | None, typer.Option("--to", help="The format, whatever the ending.")] = None,
    into: Annotated[
        Path | None, typer.Option("--into", metavar="FILE", help="An OpenMATERIAL file whose other data are kept.")
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="POINTER", help="Object of --into for a new block, as /parent. Default: the top."),
    ] = None,
    compare: Annotated[
        Path | None,
        typer.Option("--compare", metavar="FILE", help="Write nothing; compare with this OpenMATERIAL file."),
    ] = None,
    observation: Annotated[
        float | None, typer.Option("--observation", metavar="DEG", help="Observation angle of R_A. Default: 0.2.")
    ] = None,
    entrance: Annotated[
        float | None, typer.Option("--entrance", metavar="DEG", help="Entrance angle of R_A. Default: -4.")
    ] = None,
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Element whose R_A it is; default: the first.")
    ] = None,
    root: Roots = None,
    force: Annotated[
        bool, typer.Option("--force", help="Also replace files beside OUTPUT that are there with other content.")
    ] = False,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Write a document as USD or glTF, read one from these, or write its R_A as OpenMATERIAL 3D has it."""
    del timeout  # its option has handed it on
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import Terminal

    if output is not None and option is not None:
        raise ArgumentError(f"{output} is to be written already", "option")
    output = output or option
    shared: dict[str, Any] = {
        "observation": observation, "entrance": entrance, "element": element, "root": root or (),
        "listener": Terminal(),
    }  # fmt: skip
    if compare is not None:
        of_writing = {"option": output, "to": to, "into": into, "at": at, "force": force}
        refuse(of_writing, "not with --compare, which writes nothing")
        found = mrm.compare_openmaterial(path, compare, **shared)
        typer.echo(found)
        raise typer.Exit(0 if found.equal else 1)
    if output is None:
        raise ArgumentError("expected a file to write, or --compare", "output")
    written = mrm.convert(path, output, to=to.value if to else None, into=into, at=at, force=force, **shared)
    raise typer.Exit(0 if written.complete else 1)
