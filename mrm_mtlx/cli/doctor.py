"""`mrm doctor`: what this machine can run, and what adds what it lacks."""

from __future__ import annotations

from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import TableFormat


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, doctor)


def doctor(
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Say instead which of MaterialX's nodes the reference evaluates.")
    ] = False,
) -> None:
    """Say which targets can be generated, compiled and run here, and what to install for the others.

    The exit status is 0 if generated GLSL can be run and compared, else 1.
    """
    import mrm_mtlx as mrm

    found = mrm.coverage() if coverage else mrm.doctor()
    typer.echo(found.to_json() if report_format is TableFormat.JSON else found)
    raise typer.Exit(0 if isinstance(found, mrm.CoverageReport) or found.ok else 1)
