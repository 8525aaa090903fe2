"""`mrm plot`: lobes in the plane of incidence, and figures of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Distribution, Figure, LobeModel, Masking, Scale
from mrm_mtlx.cli.options import Roots, Timeout
from mrm_mtlx.system.arguments import refuse
from mrm_mtlx.system.process_limits import TIME_LIMIT_S


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, plot)


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
    model: Annotated[LobeModel | None, typer.Option("--model", help="Without a document. Default: schlick.")] = None,
    roughness: Annotated[
        float | None, typer.Option("--roughness", help="The artist's value; alpha is its square. Default: 0.3.")
    ] = None,
    alpha: Annotated[float | None, typer.Option("--alpha", help="Width of a microfacet lobe.")] = None,
    distribution: Annotated[
        Distribution | None, typer.Option("--distribution", help="Of the facets. Default: ggx.")
    ] = None,
    masking: Annotated[Masking | None, typer.Option("--masking", help="Of the facets. Default: smith.")] = None,
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
        Figure | None, typer.Option("--figure", help="A figure of the paper (Portsmouth et al. 2026) instead.")
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
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import Terminal

    given: dict[str, Any] = {
        "element": element, "root": root or (), "light": light or (), "azimuth": azimuth, "scale": scale,
        "model": model, "roughness": roughness, "alpha": alpha, "distribution": distribution, "masking": masking,
        "ior": ior, "extinction": extinction, "color0": color0, "color82": color82, "color90": color90, "color": color,
        "ordinary": ordinary, "retroreflective": retroreflective,
    }  # fmt: skip
    if figure is not None:
        refuse({"path": path, **given}, "not with --figure, which has its own")
        mrm.plot_figures(figure.value, output=output, measured=measured, listener=Terminal())
    else:
        refuse({"measured": measured}, "only with --figure 4, which has measured points")
        mrm.plot(path, **given, output=output, listener=Terminal())
