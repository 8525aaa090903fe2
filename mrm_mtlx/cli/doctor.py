"""`mrm doctor`: what this machine can run, and what adds what it lacks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import TableFormat
from mrm_mtlx.system.arguments import refuse


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, doctor)


def doctor(
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Say instead which of MaterialX's nodes the reference evaluates.")
    ] = False,
    host: Annotated[
        str | None,
        typer.Option(
            "--host", metavar="NAME", help="Say instead whether a host, such as usd-26.08, finds the library."
        ),
    ] = None,
    path: Annotated[
        Path | None, typer.Option("--path", metavar="DIR", help="Folder that the library was installed into.")
    ] = None,
    materialx: Annotated[
        str | None,
        typer.Option("--for", metavar="VERSION", help="Version of the host's MaterialX, if not that of docs/hosts.md."),
    ] = None,
    ask: Annotated[
        Path | None,
        typer.Option("--ask", metavar="PROGRAM", help="The host's Python interpreter, or Blender: it is asked."),
    ] = None,
) -> None:
    """Say which targets can be generated, compiled and run here, and what to install for the others.

    The exit status is 0 if generated GLSL can be run and compared, else 1; of a host, 0 if nothing is wrong.
    """
    import mrm_mtlx as mrm

    found: mrm.CoverageReport | mrm.DoctorReport | mrm.HostReport
    if host is None:
        refuse({"path": path, "materialx": materialx, "ask": ask}, "goes with `host`")
        found = mrm.coverage() if coverage else mrm.doctor()
    else:
        refuse({"coverage": coverage}, "not with `host`")
        found = mrm.check_host(host, path=path, materialx=materialx, ask=ask)
    typer.echo(found.to_json() if report_format is TableFormat.JSON else found)
    raise typer.Exit(0 if isinstance(found, mrm.CoverageReport) or found.ok else 1)
