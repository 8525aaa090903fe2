"""`mrm generate`: shader source for a target."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Implementation, OslModeName
from mrm_mtlx.cli.options import Library, Roots, Timeout
from mrm_mtlx.system.process_limits import TIME_LIMIT_S


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, generate)


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
        OslModeName | None,
        typer.Option(
            "--osl-mode",
            help="How OSL makes a retroreflective lobe, with --target osl; see docs/osl.md. Default: aligned.",
        ),
    ] = None,
    self_contained: Annotated[
        bool, typer.Option("--self-contained", help="Put MaterialX's headers into the source, with --target osl.")
    ] = False,
    script_node: Annotated[
        bool,
        typer.Option(
            "--script-node",
            help="For Blender's Script node, with --target osl: self-contained, its sockets what the document sets.",
        ),
    ] = False,
    stated_precision: Annotated[
        bool,
        typer.Option(
            "--stated-precision",
            help="Leave floats mediump where MaterialX (before 1.39.5) states it, with --target essl. Default: highp.",
        ),
    ] = False,
    library: Library = Implementation.MRM,
    root: Roots = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Print the generated source of a document's surfaces, or write it to files."""
    del timeout  # its option has handed it on
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import Terminal

    found = mrm.generate(
        path,
        target=target,
        element=element,
        output=output,
        osl_mode=osl_mode.value if osl_mode else None,
        self_contained=self_contained,
        script_node=script_node,
        stated_precision=stated_precision,
        library=library.value,
        root=root or (),
        listener=Terminal(),
    )
    if output is None:
        typer.echo(found)
