"""Lobes in the plane of incidence, and figures of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from mrm_mtlx.api.errors import NoValueError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import OpenDocument, PathLike, open_document
from mrm_mtlx.system.arguments import ArgumentError, check_angles, check_choice, one_or_more, path_of, refuse
from mrm_mtlx.system.shown import Shown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from mrm_mtlx.plots.curves import Curve

# A number, or three for red, green and blue; or their text with commas between.
Numbers: TypeAlias = float | str | tuple[float, ...]

FIGURES = ("2", "4", "all")
DEFAULT_LIGHT_DEG = 45.0
# Largest angle of a light: what is closer to the horizon meets hardly any surface.
LARGEST_LIGHT_DEG = 89.0
# Parameters that are a number or a colour.
_COLORS = ("ior", "extinction", "color0", "color82", "color90", "color")


@dataclass(frozen=True, repr=False)
class Plot(Shown):
    """A picture of curves.

    Attributes
    ----------
    curves
        What is drawn: BRDF [1/sr] against view angle [rad].
    figure
        matplotlib's.
    """

    curves: tuple[Curve, ...]
    figure: Figure = field(repr=False)

    def report(self) -> str:
        """The curves, a line each, with their peaks."""
        lines = [f"{'curve':<40}{'light':>8}{'peak [1/sr]':>14}{'at':>9}"]
        for curve in self.curves:
            peak = int(curve.value.argmax())
            angles = f"{math.degrees(curve.theta_l):>7.4g}°", f"{math.degrees(curve.theta_v[peak]):>8.4g}°"
            lines.append(f"{curve.name:<40}{angles[0]}{curve.value[peak]:>14.5g}{angles[1]}")
        return "\n".join(lines)

    def save(self, path: PathLike) -> None:
        """Write the picture: .png, .svg or .pdf.

        Raises
        ------
        ArgumentError
            If it cannot be written.
        """
        _save(self.figure, Path(path), "path")

    def _repr_png_(self) -> bytes:
        from mrm_mtlx.plots.drawing import encoded

        return encoded(self.figure, ".png")


def plot(
    path: PathLike | OpenDocument | None = None,
    *,
    light: float | Sequence[float] = (),
    azimuth: float | None = None,
    scale: Literal["linear", "log", "polar"] | None = None,
    element: str | None = None,
    model: Literal["schlick", "conductor", "dielectric", "eon", "lambert"] | None = None,
    roughness: float | None = None,
    alpha: float | None = None,
    distribution: Literal["ggx", "beckmann", "phong"] | None = None,
    masking: Literal["smith", "smith_separable", "v_cavity"] | None = None,
    ior: Numbers | None = None,
    extinction: Numbers | None = None,
    color0: Numbers | None = None,
    color82: Numbers | None = None,
    color90: Numbers | None = None,
    color: Numbers | None = None,
    ordinary: bool = False,
    retroreflective: bool = False,
    root: PathLike | Sequence[PathLike] = (),
    output: PathLike | None = None,
    listener: Listener = SILENT,
) -> Plot:
    """Plot lobes in the plane of incidence: BRDF against view angle, of a document or of given parameters.

    The view angle is positive on the side of the light, where a retroreflective lobe has its peak.

    Parameters
    ----------
    path
        A document; else `model` says what.
    light
        Angles of the light from the normal [degrees]. Default: 45.
    azimuth
        Angle between the planes of view and light [degrees]. Default: 0.
    scale
        Of the values. Default: log.
    element
        Only this renderable element of the document.
    model
        Without a document. Default: schlick.
    roughness
        The artist's value; alpha is its square. Default: 0.3.
    alpha
        Width of a microfacet lobe.
    distribution, masking
        Of the facets. Default: ggx, smith.
    ior, extinction
        Index of refraction; of a conductor, both. Default: gold.
    color0, color82, color90
        Schlick's reflectance at normal incidence, the factor of it at 82 degrees, that at grazing incidence.
    color
        Of a diffuse model. Default: 1.
    ordinary, retroreflective
        Only the ordinary, or only the retroreflective lobe. Default: both.
    root
        Folders from which files may be read besides the document's own.
    output
        A picture to write, if any: .png, .svg or .pdf.
    listener
        Told of findings and of the picture.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    DocumentError
        If the document cannot be used; NoValueError if a surface has no value for a direction.
    """
    lobe = {
        "model": model, "roughness": roughness, "alpha": alpha, "distribution": distribution, "masking": masking,
        "ior": ior, "extinction": extinction, "color0": color0, "color82": color82, "color90": color90, "color": color,
        "ordinary": ordinary, "retroreflective": retroreflective,
    }  # fmt: skip
    target = None if output is None else path_of("output", output)
    if target is not None:
        from mrm_mtlx.plots.style import check_picture

        check_picture(target)
    lights, turned = tuple(dict.fromkeys(one_or_more(light))) or (DEFAULT_LIGHT_DEG,), azimuth or 0.0
    _check_view(lights, turned)
    check_choice("scale", scale, ("linear", "log", "polar"))
    if path is not None:
        refuse(lobe, "not with a document, which has its own lobes")
        opened = open_document(path, element=element, root=root, listener=listener)
        curves = _of_document(opened, lights, turned, listener)
    else:
        refuse({"element": element, "root": root}, "only with a document")
        curves = _of_parameters(lobe, lights, turned)
    from mrm_mtlx.plots import drawing

    found = Plot(tuple(curves), drawing.lobes(curves, str(scale or "log"), math.radians(turned)))
    if target is not None:
        _save(found.figure, target, "")
        listener.wrote(target)
    return found


def plot_figures(
    figure: Literal["2", "4", 2, 4, "all"],
    *,
    output: PathLike,
    measured: PathLike | None = None,
    listener: Listener = SILENT,
) -> list[Path]:
    """Draw figures of the paper, Portsmouth et al. 2026; the files that were written.

    Parameters
    ----------
    figure
        One of them, or "all".
    output
        A .png, .svg or .pdf file; for "all" a folder, which is made.
    measured
        Measured points of Figure 4, in ALTA's format.
    listener
        Told of the files.

    Raises
    ------
    ArgumentError
        If the call is wrong, or a file cannot be read or written.
    """
    wanted = str(figure)
    check_choice("figure", wanted, FIGURES)
    if wanted == "2":
        refuse({"measured": measured}, "only with `figure` 4, which has measured points")
    files = _figure_files(wanted, path_of("output", output))
    from mrm_mtlx.measured import read_alta
    from mrm_mtlx.plots import drawing, paper

    try:
        points = None if measured is None else read_alta(Path(measured))
        four = paper.figure_4(points) if "4" in files else []
    except (ValueError, OSError) as error:
        raise ArgumentError(str(error), "measured") from error
    for name, file in files.items():
        _save(drawing.figure_2(paper.figure_2()) if name == "2" else drawing.by_light(four), file, "output")
        listener.wrote(file)
    return list(files.values())


def _figure_files(figure: str, output: Path) -> dict[str, Path]:
    """The file of each figure: one, or as SVG in a folder."""
    from mrm_mtlx.plots.style import check_picture

    if figure != "all":
        check_picture(output)
        return {str(figure): output}
    if output.suffix:
        msg = f"{output}: expected a folder, for several figures"
        raise ArgumentError(msg, "output")
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        msg = f"{output}: {error.strerror}"
        raise ArgumentError(msg, "output") from error
    return {name: output / f"figure{name}.svg" for name in FIGURES if name != "all"}


def _save(figure: Figure, path: Path, argument: str) -> None:
    from mrm_mtlx.plots import drawing

    try:
        drawing.save(figure, path)
    except ValueError as error:
        raise ArgumentError(str(error), argument) from error


def _check_view(lights: Sequence[float], azimuth: float) -> None:
    from mrm_mtlx.plots.style import MAXIMUM_VARIANTS

    check_angles("light", lights, 0.0, LARGEST_LIGHT_DEG)
    if len(lights) > MAXIMUM_VARIANTS:
        msg = f"{len(lights)} angles; at most {MAXIMUM_VARIANTS} can be told apart in a picture"
        raise ArgumentError(msg, "light")
    check_angles("azimuth", [azimuth], -180.0, 180.0)


def _variant(light: float) -> str:
    return f"light at {light:g}°"


def _of_document(opened: OpenDocument, lights: Sequence[float], azimuth: float, listener: Listener) -> list[Curve]:
    """A curve per surface and light."""
    from mrm_mtlx.plots.documents import surface_curve
    from mrm_mtlx.plots.style import MAXIMUM_NAMES

    surfaces = opened.surfaces()
    if len(surfaces) > MAXIMUM_NAMES:
        found = f"{opened.path} has {len(surfaces)} surfaces, of which {MAXIMUM_NAMES} can be told apart in a picture"
        msg = f"{found}; choose one with `element`"
        raise ArgumentError(msg, "path")
    curves = []
    for surface in surfaces:
        try:
            for angle in lights:
                where = (math.radians(angle), math.radians(azimuth))
                curves.append(surface_curve(surface.name, _variant(angle), surface.surface, *where))
        except ValueError as error:
            raise NoValueError(str(error), opened.findings) from error
        surface.refuse_missing_images(listener)
        surface.images.release()
    return curves


def _of_parameters(given: Mapping[str, Any], lights: Sequence[float], azimuth: float) -> list[Curve]:
    """A curve per lobe and light: ordinary and retroreflective, or what is asked for."""
    from mrm_mtlx.plots import parameters
    from mrm_mtlx.plots.curves import lobe_curve

    model = str(given["model"] or "schlick")
    check_choice("model", model, tuple(parameters.PARAMETERS))
    flags = {name: bool(given[name]) for name in ("ordinary", "retroreflective")}
    values = {name: value for name, value in given.items() if value is not None and name not in ("model", *flags)}
    values = {name: _numbers(name, value) if name in _COLORS else value for name, value in values.items()}
    if model not in parameters.MICROFACET:
        refuse(flags, f"not with {model}, a diffuse model")
        wanted = {parameters.DIFFUSE[model]: False}
    else:
        wanted = {name: name == "retroreflective" for name in flags if flags[name] or not any(flags.values())}
    try:
        lobes = {name: parameters.lobe(model, values, retroreflective=retro) for name, retro in wanted.items()}
        return [
            lobe_curve(name, _variant(angle), lobe, math.radians(angle), math.radians(azimuth))
            for name, lobe in lobes.items()
            for angle in lights
        ]
    except ArgumentError:
        raise
    except ValueError as error:
        raise ArgumentError(str(error)) from error


def _numbers(argument: str, given: Numbers) -> float | tuple[float, ...]:
    """A number, or three."""
    numbers: tuple[float, ...] = ()
    try:
        parts = given.split(",") if isinstance(given, str) else given if isinstance(given, tuple | list) else (given,)
        numbers = tuple(float(part) for part in parts)
    except (TypeError, ValueError):
        pass
    if len(numbers) not in (1, 3):
        msg = f"'{given}': expected a number, or three as R,G,B"
        raise ArgumentError(msg, argument)
    return numbers[0] if len(numbers) == 1 else numbers
