"""`mrm generate`: shader source for a target."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli.options import Implementation, Library, OslModeName, Roots
from mrm_mtlx.text import printable


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(generate)


def generate(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document.")],
    target: Annotated[str, typer.Option("--target", metavar="NAME", help="Shading language.")] = "glsl",
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Only this renderable element.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FOLDER", help="Write one file per stage into this folder.")
    ] = None,
    osl_mode: Annotated[
        OslModeName, typer.Option("--osl-mode", help="How OSL makes a retroreflective lobe; see docs/osl.md.")
    ] = OslModeName.ALIGNED,
    library: Library = Implementation.MRM,
    root: Roots = None,
) -> None:
    """Print the generated source of a document's surfaces, or write it to files."""
    from mrm_mtlx.cli.documents import open_document
    from mrm_mtlx.cli.options import chosen_targets, write_file
    from mrm_mtlx.library import Origin, load_library
    from mrm_mtlx.shadergen import TARGETS, GenerationError, OslMode, available_targets
    from mrm_mtlx.shadergen import generate as generate_shader

    chosen_targets([target], available_targets())
    data = load_library(Origin(library.value))
    opened = open_document(path, data, element, root)
    for renderable in opened.elements:
        try:
            shader = generate_shader(renderable, target, data, OslMode(osl_mode.value))
        except GenerationError as error:
            typer.echo(printable(f"error SHADER_GENERATE /{renderable.getNamePath()}: {error}"), err=True)
            raise typer.Exit(1) from error
        for stage, suffix in TARGETS[target].suffixes.items():
            if output is None:
                typer.echo(shader.sources[stage])
                continue
            file = output / f"{renderable.getNamePath().replace('/', '_')}{suffix}"
            try:
                output.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise typer.BadParameter(f"{output}: {error.strerror}", param_hint="--output") from error
            write_file(file, shader.sources[stage])
            typer.echo(f"wrote {file}", err=True)
