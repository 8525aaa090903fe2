"""`mrm render`: a picture of a material."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli.choices import Implementation, OslModeName
from mrm_mtlx.cli.options import Library, Roots, Seed, Timeout, refuse_missing_folder
from mrm_mtlx.system.process_limits import TIME_LIMIT_S
from mrm_mtlx.system.text import printable


class ShapeName(StrEnum):
    """Shapes that can be rendered."""

    SPHERE = "sphere"
    PLANE = "plane"
    CONE = "cone"


def _engines() -> list[str]:
    """Names of the engines that render, in the order of the registry."""
    from mrm_mtlx.engines import registry

    return [name for name, engine in registry.engines().items() if registry.renders(engine)]


def _known(name: str | None) -> str | None:
    """Refuse an engine that does not render, or is not there."""
    if name is not None and name not in _engines():
        raise typer.BadParameter(f"'{name}' is not one of {', '.join(map(repr, _engines()))}.")
    return name


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(render)


def render(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="IMAGE", help="A .png or .exr file.")],
    shape: Annotated[ShapeName, typer.Option("--shape", help="What carries the material.")] = ShapeName.SPHERE,
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
    engine_name: Annotated[
        str | None,
        typer.Option(
            "--engine",
            metavar="NAME",
            callback=_known,
            autocompletion=_engines,
            help="gl, the generated GLSL in OpenGL; cycles, the OSL, path-traced; or another that renders, see "
            "`mrm doctor`. Default: gl.",
        ),
    ] = None,
    paths: Annotated[
        int, typer.Option("--paths", min=1, max=1 << 16, help="Paths per pixel, with --engine cycles.")
    ] = 64,
    seed: Seed = 0,
    osl_mode: Annotated[
        OslModeName, typer.Option("--osl-mode", help="How OSL makes a retroreflective lobe, with --engine cycles.")
    ] = OslModeName.ALIGNED,
    library: Library = Implementation.MRM,
    root: Roots = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Render a material on a sphere, plane or cone under a headlight, a light at an angle, and surroundings."""
    del timeout  # its option has handed it on
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.cli.documents import open_document
    from mrm_mtlx.documents.document_images import ImagesTooLargeError
    from mrm_mtlx.documents.images import read_image
    from mrm_mtlx.engines import registry
    from mrm_mtlx.engines.base import CompileError, EngineFailure
    from mrm_mtlx.library import Origin, load_library
    from mrm_mtlx.render import path_traced, picture
    from mrm_mtlx.shadergen import GenerationError, OslMode
    from mrm_mtlx.system import child

    if output.suffix.lower() not in (".png", ".exr"):
        raise typer.BadParameter(f"{output}: expected a name that ends in .png or .exr", param_hint="--output")
    refuse_missing_folder(output, "--output")
    if exposure is not None and not -100.0 <= exposure <= 100.0:
        raise typer.BadParameter(f"{exposure}: expected -100 to 100 stops", param_hint="--exposure")
    engine = registry.engines()[engine_name or _engines()[0]]
    available = engine.availability()
    if not available.available:
        typer.echo(f"mrm: {available.detail}; to add it: {available.remedy}", err=True)
        raise typer.Exit(2)
    data = load_library(Origin(library.value))
    opened = open_document(path, data, element, root)
    try:
        surroundings = None if environment is None else read_image(environment)
        settings = picture.PictureOptions(shape.value, _light_angle(light), size, surroundings, compare)
        child.allow(picture.memory(settings))
        surface = (opened.elements[0], data, opened.imported.reach, settings)
        if engine.path_tracer is None:
            picture.write(picture.render(*surface, engine), output, exposure)
        else:
            with progress("rendering") as report:
                mode, tracer = OslMode(osl_mode.value), engine.path_tracer
                panels = path_traced.render(*surface, tracer, paths=paths, seed=seed, mode=mode, progress=report)
            picture.write(panels, output, exposure, oversampling=1)
    except ImagesTooLargeError as error:
        raise typer.BadParameter(f"{path} has {error}", param_hint="PATH") from error
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    except GenerationError as error:
        typer.echo(printable(f"error SHADER_GENERATE /{opened.elements[0].getNamePath()}: {error}"), err=True)
        raise typer.Exit(1) from error
    except CompileError as error:
        typer.echo(printable(f"error SHADER_COMPILE: {error}"), err=True)
        raise typer.Exit(1) from error
    except EngineFailure as error:
        typer.echo(f"mrm: {error}", err=True)
        raise typer.Exit(2) from error
    typer.echo(f"wrote {output}", err=True)


def _light_angle(text: str) -> float | None:
    """Angle of the light from the eye in degrees, None for the headlight."""
    if text == "headlight":
        return None
    try:
        angle = float(text)
    except ValueError:
        raise typer.BadParameter(f"'{text}': expected headlight or an angle in degrees", param_hint="--light") from None
    if not -180.0 <= angle <= 180.0:
        raise typer.BadParameter(f"{text}: expected an angle from -180 to 180 degrees", param_hint="--light")
    return angle
