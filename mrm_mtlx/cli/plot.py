"""`mrm plot`: lobes in the plane of incidence, and figures of the paper."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mrm_mtlx.cli.options import Roots, Timeout, refuse_missing_folder
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.plots.curves import Curve


class Scale(StrEnum):
    """How values are drawn; the values of plots.drawing.SCALES, without importing matplotlib."""

    LINEAR = "linear"
    LOG = "log"
    POLAR = "polar"


class ModelName(StrEnum):
    """Models that need no document; the values of plots.parameters.PARAMETERS, without importing NumPy."""

    SCHLICK = "schlick"
    CONDUCTOR = "conductor"
    DIELECTRIC = "dielectric"
    EON = "eon"
    LAMBERT = "lambert"


class DistributionName(StrEnum):
    """Distributions of facets; the names of bsdf.masking.DISTRIBUTIONS."""

    GGX = "ggx"
    BECKMANN = "beckmann"
    PHONG = "phong"


class MaskingName(StrEnum):
    """How facets hide each other; the names of bsdf.masking.MASKINGS."""

    SMITH = "smith"
    SMITH_SEPARABLE = "smith_separable"
    V_CAVITY = "v_cavity"


class FigureName(StrEnum):
    """Figures of the paper."""

    TWO = "2"
    FOUR = "4"
    ALL = "all"


# Options that are a number or a colour.
_COLORS = ("ior", "extinction", "color0", "color82", "color90", "color")
DEFAULT_LIGHT_DEG = 45.0
# Largest angle of a light: what is closer to the horizon meets hardly any surface.
LARGEST_LIGHT_DEG = 89.0


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(plot)


def plot(
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="IMAGE", help="A .png, .svg or .pdf file; a folder for --figure all."),
    ],
    path: Annotated[Path | None, typer.Argument(metavar="PATH", help="A document; else --model says what.")] = None,
    light: Annotated[
        list[float] | None,
        typer.Option("--light", metavar="DEG", help="Angle of the light from the normal; repeatable. Default: 45."),
    ] = None,
    azimuth: Annotated[
        float | None,
        typer.Option("--azimuth", metavar="DEG", help="Angle between the planes of view and light. Default: 0."),
    ] = None,
    scale: Annotated[Scale | None, typer.Option("--scale", help="Of the values. Default: log.")] = None,
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Only this renderable element of the document.")
    ] = None,
    model: Annotated[ModelName | None, typer.Option("--model", help="Without a document. Default: schlick.")] = None,
    roughness: Annotated[
        float | None, typer.Option("--roughness", help="The artist's value; alpha is its square. Default: 0.3.")
    ] = None,
    alpha: Annotated[float | None, typer.Option("--alpha", help="Width of a microfacet lobe.")] = None,
    distribution: Annotated[
        DistributionName | None, typer.Option("--distribution", help="Of the facets. Default: ggx.")
    ] = None,
    masking: Annotated[MaskingName | None, typer.Option("--masking", help="Of the facets. Default: smith.")] = None,
    ior: Annotated[str | None, typer.Option("--ior", metavar="X|R,G,B", help="Index of refraction.")] = None,
    extinction: Annotated[
        str | None, typer.Option("--extinction", metavar="X|R,G,B", help="Of a conductor. Default: gold.")
    ] = None,
    color0: Annotated[
        str | None, typer.Option("--color0", metavar="X|R,G,B", help="Schlick's reflectance at normal incidence.")
    ] = None,
    color82: Annotated[
        str | None, typer.Option("--color82", metavar="X|R,G,B", help="Factor of it at 82 degrees.")
    ] = None,
    color90: Annotated[
        str | None, typer.Option("--color90", metavar="X|R,G,B", help="Reflectance at grazing incidence.")
    ] = None,
    color: Annotated[
        str | None, typer.Option("--color", metavar="X|R,G,B", help="Of a diffuse model. Default: 1.")
    ] = None,
    ordinary: Annotated[bool, typer.Option("--ordinary", help="Only the ordinary lobe. Default: both.")] = False,
    retroreflective: Annotated[
        bool, typer.Option("--retroreflective", help="Only the retroreflective lobe. Default: both.")
    ] = False,
    figure: Annotated[
        FigureName | None, typer.Option("--figure", help="A figure of the paper (Portsmouth et al. 2026) instead.")
    ] = None,
    measured: Annotated[
        Path | None, typer.Option("--measured", metavar="FILE", help="Measured points of Figure 4, in ALTA's format.")
    ] = None,
    root: Roots = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Plot lobes in the plane of incidence: BRDF against view angle, of a document or of given parameters.

    The view angle is positive on the side of the light, where a retroreflective lobe has its peak.
    """
    del timeout  # its option has handed it on
    lobe = {
        "model": model, "roughness": roughness, "alpha": alpha, "distribution": distribution, "masking": masking,
        "ior": ior, "extinction": extinction,
        "color0": color0, "color82": color82, "color90": color90, "color": color,
        "ordinary": ordinary or None, "retroreflective": retroreflective or None,
    }  # fmt: skip
    view = {"light": light or None, "azimuth": azimuth, "scale": scale}
    if figure is not None:
        _refuse(
            {"PATH": path, "element": element, "root": root or None, **view, **lobe},
            "not with --figure, which has its own",
        )
        if figure is FigureName.TWO:
            _refuse({"measured": measured}, "only with --figure 4, which has measured points")
        _write_figures(figure, output, measured)
        return
    _refuse({"measured": measured}, "only with --figure 4, which has measured points")
    check_output(output)
    lights, turned = light or [DEFAULT_LIGHT_DEG], azimuth or 0.0
    _check_view(lights, turned)
    if path is not None:
        _refuse(lobe, "not with a document, which has its own lobes")
        curves = _of_document(path, element, root, lights, turned)
    else:
        _refuse({"element": element, "root": root or None}, "only with a document")
        curves = _of_parameters(lobe, lights, turned)
    from mrm_mtlx.plots import drawing

    try:
        drawing.save(drawing.lobes(curves, (scale or Scale.LOG).value, math.radians(turned)), output)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    typer.echo(f"wrote {output}", err=True)


def _refuse(options: Mapping[str, Any], why: str) -> None:
    """Options that do not go with the others are a usage error: nothing is accepted and ignored."""
    for name, value in options.items():
        if value is not None:
            raise typer.BadParameter(why, param_hint=name if name.isupper() else f"--{name}")


def check_output(output: Path, option: str = "--output") -> None:
    """Refuse a picture whose name or folder will not do, before anything is evaluated."""
    from mrm_mtlx.plots.style import SUFFIXES

    if output.suffix.lower() not in SUFFIXES:
        expected = f"expected a name that ends in {', '.join(SUFFIXES)}"
        raise typer.BadParameter(f"{output}: {expected}", param_hint=option)
    refuse_missing_folder(output, option)


def _check_view(lights: list[float], azimuth: float) -> None:
    from mrm_mtlx.plots.style import MAXIMUM_VARIANTS

    for angle in lights:
        if not 0.0 <= angle <= LARGEST_LIGHT_DEG:
            message = f"{angle:g}: expected an angle from 0 to {LARGEST_LIGHT_DEG:g} degrees"
            raise typer.BadParameter(message, param_hint="--light")
    if len(set(lights)) > MAXIMUM_VARIANTS:
        message = f"{len(set(lights))} angles; at most {MAXIMUM_VARIANTS} can be told apart in a picture"
        raise typer.BadParameter(message, param_hint="--light")
    if not -180.0 <= azimuth <= 180.0:
        raise typer.BadParameter(f"{azimuth:g}: expected an angle from -180 to 180 degrees", param_hint="--azimuth")


def _variant(light: float) -> str:
    return f"light at {light:g}°"


def _of_document(
    path: Path, element: str | None, roots: list[Path] | None, lights: list[float], azimuth: float
) -> list[Curve]:
    """A curve per surface and light."""
    from mrm_mtlx.cli.documents import open_surfaces
    from mrm_mtlx.plots.documents import surface_curve
    from mrm_mtlx.plots.style import MAXIMUM_NAMES

    surfaces = open_surfaces(path, element, roots)
    if len(surfaces) > MAXIMUM_NAMES:
        found = f"{path} has {len(surfaces)} surfaces, of which {MAXIMUM_NAMES} can be told apart in a picture"
        raise typer.BadParameter(f"{found}; choose one with --element", param_hint="PATH")
    curves = []
    for opened in surfaces:
        try:
            for angle in dict.fromkeys(lights):
                where = (math.radians(angle), math.radians(azimuth))
                curves.append(surface_curve(opened.name, _variant(angle), opened.surface, *where))
        except ValueError as error:
            typer.echo(f"mrm: {error}", err=True)
            raise typer.Exit(3) from error
        opened.refuse_missing_images()
        opened.images.release()
    return curves


def _of_parameters(options: Mapping[str, Any], lights: list[float], azimuth: float) -> list[Curve]:
    """A curve per lobe and light: ordinary and retroreflective, or what is asked for."""
    from mrm_mtlx.plots import parameters
    from mrm_mtlx.plots.curves import lobe_curve

    model = (options["model"] or ModelName.SCHLICK).value
    flags = {"ordinary": options["ordinary"], "retroreflective": options["retroreflective"]}
    given = {name: value for name, value in options.items() if value is not None and name not in ("model", *flags)}
    given = {name: _numbers(name, value) if name in _COLORS else value for name, value in given.items()}
    if model not in parameters.MICROFACET:
        _refuse(flags, f"not with {model}, a diffuse model")
        wanted = {parameters.DIFFUSE[model]: False}
    else:
        wanted = {name: name == "retroreflective" for name in flags if flags[name] or not any(flags.values())}
    try:
        lobes = {name: parameters.lobe(model, given, retroreflective=retro) for name, retro in wanted.items()}
        return [
            lobe_curve(name, _variant(angle), lobe, math.radians(angle), math.radians(azimuth))
            for name, lobe in lobes.items()
            for angle in dict.fromkeys(lights)
        ]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def _numbers(name: str, text: str) -> float | tuple[float, ...]:
    """A number, or three with commas between."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) not in (1, 3):
        raise typer.BadParameter(f"'{text}': expected a number, or three as R,G,B", param_hint=f"--{name}")
    return numbers[0] if len(numbers) == 1 else numbers


def _write_figures(figure: FigureName, output: Path, measured: Path | None) -> None:
    """One figure to a file, or all as SVG to a folder, which is made."""
    if figure is not FigureName.ALL:
        check_output(output)
        files = {figure: output}
    else:
        if output.suffix:
            raise typer.BadParameter(f"{output}: expected a folder, for several figures", param_hint="--output")
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise typer.BadParameter(f"{output}: {error.strerror}", param_hint="--output") from error
        files = {name: output / f"figure{name.value}.svg" for name in FigureName if name is not FigureName.ALL}
    from mrm_mtlx.measured import read_alta
    from mrm_mtlx.plots import drawing, paper

    try:
        points = None if measured is None else read_alta(measured)
        four = paper.figure_4(points) if FigureName.FOUR in files else []
    except (ValueError, OSError) as error:
        raise typer.BadParameter(str(error), param_hint="--measured") from error
    for name, file in files.items():
        picture = drawing.figure_2(paper.figure_2()) if name is FigureName.TWO else drawing.by_light(four)
        try:
            drawing.save(picture, file)
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--output") from error
        typer.echo(f"wrote {file}", err=True)
