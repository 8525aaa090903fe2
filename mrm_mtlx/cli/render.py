"""`mrm render`: a picture of a material."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Implementation, OslModeName, Shape
from mrm_mtlx.cli.options import Library, Roots, Seed, Timeout
from mrm_mtlx.system.process_limits import TIME_LIMIT_S


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, render)


def _engines() -> list[str]:
    """Names to complete."""
    from mrm_mtlx.api.render import engine_names

    return engine_names()


def render(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="IMAGE", help="A .png or .exr file.")],
    shape: Annotated[Shape, typer.Option("--shape", help="What carries the material.")] = Shape.SPHERE,
    light: Annotated[
        str, typer.Option("--light", metavar="headlight|DEGREES", help="At the eye, or at this angle from it.")
    ] = "headlight",
    environment: Annotated[
        Path | None, typer.Option("--environment", metavar="IMAGE", help="Latitude-longitude image that surrounds it.")
    ] = None,
    compare: Annotated[
        bool,
        typer.Option(
            "--compare", help="Four panels: ordinary and retroreflective, each lit from the eye and from aside."
        ),
    ] = False,
    size: Annotated[int, typer.Option("--size", min=16, max=4096, help="Width and height of a panel in pixels.")] = 384,
    exposure: Annotated[
        float | None, typer.Option("--exposure", help="Stops over a white diffuser; default: fitted to the picture.")
    ] = None,
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Renderable element; default: the first.")
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            "--engine",
            metavar="NAME",
            autocompletion=_engines,
            help="gl, the generated GLSL in OpenGL; cycles, the OSL, path-traced; or another that renders, see "
            "`mrm doctor`. Default: gl.",
        ),
    ] = None,
    paths: Annotated[
        int | None,
        typer.Option("--paths", min=1, max=1 << 16, help="Paths per pixel, with --engine cycles. Default: 64."),
    ] = None,
    seed: Seed = 0,
    osl_mode: Annotated[
        OslModeName | None,
        typer.Option(
            "--osl-mode", help="How OSL makes a retroreflective lobe, with --engine cycles. Default: aligned."
        ),
    ] = None,
    library: Library = Implementation.MRM,
    root: Roots = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Render a material on a sphere, plane or cone under a headlight, a light at an angle, and an environment."""
    del timeout  # its option has handed it on
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import terminal

    with terminal("rendering") as listener:
        mrm.render(
            path,
            shape=shape.value,
            light=light,
            environment=environment,
            compare=compare,
            size=size,
            exposure=exposure,
            element=element,
            engine=engine,
            paths=paths,
            seed=seed,
            osl_mode=osl_mode.value if osl_mode else None,
            library=library.value,
            root=root or (),
            output=output,
            listener=listener,
        )
