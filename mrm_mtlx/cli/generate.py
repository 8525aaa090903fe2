"""`mrm generate`: shader source for a target."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli.options import Implementation, Library, OslModeName, Roots, Timeout
from mrm_mtlx.system.process_limits import TIME_LIMIT_S
from mrm_mtlx.system.text import printable


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
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Print the generated source of a document's surfaces, or write it to files."""
    del timeout  # its option has handed it on
    from mrm_mtlx.cli.documents import open_document
    from mrm_mtlx.cli.options import chosen_targets
    from mrm_mtlx.library import Origin, load_library
    from mrm_mtlx.shadergen import TARGETS, GenerationError, OslMode, available_targets
    from mrm_mtlx.shadergen import generate as generate_shader

    chosen_targets([target], available_targets())
    data = load_library(Origin(library.value))
    opened = open_document(path, data, element, root)
    sources: dict[str, str] = {}
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
            sources[f"{renderable.getNamePath().replace('/', '_')}{suffix}"] = shader.sources[stage]
    if output is not None:
        _write(sources, output)


def _write(sources: dict[str, str], folder: Path) -> None:
    """Write files into a folder, which is made, all or none."""
    from mrm_mtlx.system.writing import FileSet

    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileSet(folder) as files:
            for name, source in sources.items():
                files.named(folder / name).write_text(source, encoding="utf-8")
    except OSError as error:
        raise typer.BadParameter(f"{folder} cannot be written: {error.strerror}", param_hint="--output") from error
    for name in sources:
        typer.echo(f"wrote {folder / name}", err=True)
