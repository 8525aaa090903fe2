"""`mrm doctor`: what this machine can run, and what adds what it lacks."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.options import TableFormat

if TYPE_CHECKING:
    from mrm_mtlx.engines.availability import Availability


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(doctor)


def doctor(
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
) -> None:
    """Say which targets can be generated, compiled and run here, and what to install for the others.

    The exit status is 0 if generated GLSL can be run and compared, else 1.
    """
    from mrm_mtlx.library import node_library_folder
    from mrm_mtlx.shadergen import available_targets
    from mrm_mtlx.validation.runner import versions

    engines = survey()
    if report_format is TableFormat.JSON:
        report = {
            "schema": "mrm.doctor/1",
            "versions": versions(),
            "targets": list(available_targets()),
            "engines": {
                name: {"use": use, "available": a.available, "detail": a.detail, "remedy": a.remedy}
                for name, (use, a) in engines.items()
            },
        }
        typer.echo(json.dumps(report, indent=2))
    else:
        typer.echo("versions   " + ", ".join(f"{name} {version}" for name, version in versions().items()))
        typer.echo(f"library    {'found' if node_library_folder().is_dir() else 'missing'}")
        typer.echo(f"targets    {', '.join(available_targets())} (source can be generated)")
        width = max(len(use) for use, _ in engines.values())
        for name, (use, state) in engines.items():
            typer.echo(
                f"{name.ljust(9)}  {'ok     ' if state.available else 'missing'}  {use.ljust(width)}  {state.detail}"
            )
            if state.remedy:
                typer.echo(f"{'':20}to add it: {state.remedy}")
    raise typer.Exit(0 if engines["gl"][1].available else 1)


def survey() -> dict[str, tuple[str, Availability]]:
    """Engines and compilers by name: what each is for, and whether it is there."""
    from mrm_mtlx.engines import compilers, gl, osl

    return {
        "gl": ("compiles and runs glsl and essl", gl.availability()),
        "vulkan": ("compiles Vulkan GLSL", compilers.vulkan_availability()),
        "slang": ("compiles Slang", compilers.slang_availability()),
        "osl": ("compiles OSL", osl.compiler_availability()),
        "cycles": ("runs and renders OSL", osl.availability()),
    }
