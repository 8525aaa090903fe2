"""Pictures of curves, in files: the only module here that imports matplotlib."""

from __future__ import annotations

import io
from itertools import chain
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path
from matplotlib.ticker import LogLocator, MaxNLocator, MultipleLocator, NullFormatter

from mrm_mtlx.plots import style
from mrm_mtlx.system.writing import replacing

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.plots.curves import Curve
    from mrm_mtlx.plots.paper import Panel

SCALES = ("linear", "log", "polar")

_LAMBERT = 1.0 / np.pi
# Decades below its highest value that a logarithmic axis shows at most.
_DECADES = 9
# View angles up to here [rad] must fit on a logarithmic axis.
_STEADY = np.deg2rad(80.0)
_LAMBERT_LINE: dict[str, Any] = {"color": style.RED, "linewidth": 0.7, "zorder": 1.5}
_LIGHT_MARK: dict[str, Any] = {"color": "black", "marker": "v", "markersize": 4, "linestyle": "none", "clip_on": False}
# Letters of a name that fit beside a line in the width of a column.
_LONGEST_NAME = 44
_VALUE = "BRDF [1/sr]"
_VIEW = r"view angle $\theta_v$ [°]"


def lobes(curves: Sequence[Curve], scale: str, azimuth: float = 0.0) -> Figure:
    """A picture of curves, the Lambertian 1/pi for comparison, and where the lights stand.

    Parameters
    ----------
    curves
        At most `style.MAXIMUM_NAMES` names and `style.MAXIMUM_VARIANTS` variants.
    scale
        A name of `SCALES`; polar has the value as the radius.
    azimuth
        Angle between the planes of v and l [rad]; told where it is not 0.
    """
    with mpl.rc_context(style.SETTINGS):
        polar = scale == "polar"
        view = _VIEW if azimuth == 0.0 else rf"{_VIEW}, $\varphi$ = {np.rad2deg(azimuth):g}°"
        lines = _lines(curves)
        keys = [*chain(*_keys(curves, lines)), _lambert_key(), Line2D([], [], label="light", **_LIGHT_MARK)]
        figure, axes = _one_plot(-(-len(keys) // _columns(keys)), polar=polar)
        for curve in curves:
            axes.plot(
                curve.theta_v if polar else np.rad2deg(curve.theta_v), curve.value, **lines[curve.name, curve.variant]
            )
        _lambert(axes, polar=polar)
        lights = sorted({curve.theta_l for curve in curves})
        if polar:
            _polar_axes(axes, curves, lights)
            figure.supxlabel(f"radius: {_VALUE}; around: {view}")
        else:
            _view_axis(axes)
            axes.set_xlabel(view)
            axes.set_ylabel(_VALUE)
            _value_axis(axes, scale, [(curve.theta_v, curve.value) for curve in curves])
            # Where the lights stand: marks on the upper edge.
            axes.plot(np.rad2deg(lights), np.ones(len(lights)), transform=axes.get_xaxis_transform(), **_LIGHT_MARK)
        _legend(figure, keys)
        return figure


def figure_2(panels: Sequence[Panel]) -> Figure:
    """Figure 2 of the paper, from `paper.figure_2`: a row per light angle, a column per azimuth."""
    with mpl.rc_context(style.SETTINGS):
        figure = Figure(figsize=(style.COLUMN, style.COLUMN), layout=ConstrainedLayoutEngine(wspace=0.08))
        grid = figure.subplots(2, 2, sharex=True, sharey=True)
        lines = _lines(panels[0].curves)
        for axes, panel in zip(grid.flat, panels, strict=True):
            for curve in panel.curves:
                axes.plot(np.rad2deg(curve.theta_v), curve.value, **lines[curve.name, curve.variant])
            _lambert(axes)
            axes.set_title(
                rf"$\theta_l$ = {np.rad2deg(panel.theta_l):g}°, $\varphi$ = {np.rad2deg(panel.azimuth):g}°", pad=3
            )
            _view_axis(axes, 45.0)
        _value_axis(grid.flat[0], "log", [(c.theta_v, c.value) for panel in panels for c in panel.curves])
        figure.supxlabel(_VIEW)
        figure.supylabel(_VALUE)
        colored, dashed = _keys(panels[0].curves, lines)
        _legend(figure, [*colored, _lambert_key(), *dashed])
        return figure


def by_light(panels: Sequence[Panel], label: str = "MRM, fitted") -> Figure:
    """A model beside what was measured, a row per light angle; Figure 4 of the paper, from `paper.figure_4`."""
    with mpl.rc_context(style.SETTINGS):
        height = style.COLUMN * (0.25 + 0.3 * len(panels))
        figure = Figure(figsize=(style.COLUMN, height), layout="constrained")
        rows = figure.subplots(len(panels), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        fit: dict[str, Any] = {"color": style.GREEN, "linestyle": style.DASHES[1]}
        dots: dict[str, Any] = {"color": "black", "marker": "o", "markersize": 1.6, "linestyle": "none"}
        for axes, panel in zip(rows, panels, strict=True):
            if panel.points is not None:
                axes.plot(np.rad2deg(panel.points[0]), panel.points[1], **dots)
            for curve in panel.curves:
                axes.plot(np.rad2deg(curve.theta_v), curve.value, **fit)
            axes.set_title(rf"$\theta_l$ = {np.rad2deg(panel.theta_l):g}°", pad=3)
            _view_axis(axes)
        series = [(c.theta_v, c.value) for panel in panels for c in panel.curves]
        _value_axis(rows[0], "log", series + [panel.points for panel in panels if panel.points is not None])
        rows[-1].set_xlabel(_VIEW)
        figure.supylabel(_VALUE)
        keys = [Line2D([], [], label=label, **fit)]
        keys += [Line2D([], [], label="measured", **dots)] if panels[0].points is not None else []
        _legend(figure, keys)
        return figure


def save(figure: Figure, path: Path) -> None:
    """Write a picture whole or not at all; the same data give the same bytes.

    Raises
    ------
    ValueError
        If the name does not end in one of `style.SUFFIXES`, or the file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix not in style.SUFFIXES:
        msg = f"{path}: expected a name that ends in {', '.join(style.SUFFIXES)}"
        raise ValueError(msg)
    try:
        content = encoded(figure, suffix)  # matplotlib leaves files open that it cannot write to
        with replacing(path) as unfinished:
            unfinished.write_bytes(content)
    except OSError as error:
        msg = f"{path} cannot be written: {error.strerror or error}"
        raise ValueError(msg) from error


def encoded(figure: Figure, suffix: str) -> bytes:
    """A picture as the content of a file with one of `style.SUFFIXES`."""
    content = io.BytesIO()
    with mpl.rc_context(style.SETTINGS):
        figure.savefig(content, format=suffix[1:], metadata=style.METADATA[suffix])
    return content.getvalue()


def _lines(curves: Sequence[Curve]) -> dict[tuple[str, str], dict[str, Any]]:
    """Colour by name, dashes by variant; where there is one variant, dashes by name too."""
    names, variants = _names(curves), _variants(curves)
    if len(names) > style.MAXIMUM_NAMES or len(variants) > style.MAXIMUM_VARIANTS:
        most = f"{style.MAXIMUM_NAMES} and {style.MAXIMUM_VARIANTS}"
        msg = f"{len(names)} names and {len(variants)} variants; at most {most} can be told apart"
        raise ValueError(msg)
    single = len(variants) == 1
    return {
        (name, variant): {
            "color": style.MODEL_COLORS.get(name, style.COLORS[i]),
            "linestyle": style.DASHES[i if single else k],
        }
        for i, name in enumerate(names)
        for k, variant in enumerate(variants)
    }


def _names(curves: Sequence[Curve]) -> list[str]:
    return list(dict.fromkeys(curve.name for curve in curves))


def _variants(curves: Sequence[Curve]) -> list[str]:
    return list(dict.fromkeys(curve.variant for curve in curves))


def _keys(curves: Sequence[Curve], lines: dict[tuple[str, str], dict[str, Any]]) -> tuple[list[Line2D], list[Line2D]]:
    """Entries of a legend: a coloured line per name; a dashed black one per variant, if there are several."""
    names, variants = _names(curves), _variants(curves)
    colored = []
    for name in names:
        line = lines[name, variants[0]] if len(variants) == 1 else {"color": lines[name, variants[0]]["color"]}
        colored.append(Line2D([], [], label=_plain(name), **line))
    dashed = [Line2D([], [], label=v, color="black", linestyle=lines[names[0], v]["linestyle"]) for v in variants]
    return colored, dashed if len(variants) > 1 else []


def _plain(name: str) -> str:
    """A name as it is written, at a length that fits a column: not a formula, nor hidden for an underscore."""
    half = _LONGEST_NAME // 2
    shown = name if len(name) <= _LONGEST_NAME else f"{name[: half - 1]}…{name[-half:]}"
    return shown.replace("$", r"\$")


def _lambert(axes: Axes, *, polar: bool = False) -> None:
    if polar:
        angles = np.linspace(-np.pi / 2, np.pi / 2, 181)
        axes.plot(angles, np.full_like(angles, _LAMBERT), **_LAMBERT_LINE)
    else:
        axes.axhline(_LAMBERT, **_LAMBERT_LINE)


def _lambert_key() -> Line2D:
    return Line2D([], [], label="Lambert, 1/π", **_LAMBERT_LINE)


def _legend(figure: Figure, keys: list[Line2D]) -> None:
    """A legend above everything else, in as many columns as fit."""
    where: Any = "outside upper center" if figure.get_layout_engine() else "upper center"
    figure.legend(handles=keys, loc=where, ncols=_columns(keys))


def _columns(keys: list[Line2D]) -> int:
    return next((n for n in (3, 2) if n <= len(keys) and _width(keys, n) <= style.COLUMN), 1)


def _width(keys: list[Line2D], columns: int) -> float:
    """Width of a legend [inch]: entries fill the columns one after the other."""
    size = style.SETTINGS["legend.fontsize"]
    # What stands beside a name: the line, the space behind it, and the space between columns, in sizes of the letters.
    beside = style.SETTINGS["legend.handlelength"] + 0.8 + style.SETTINGS["legend.columnspacing"]
    font = FontProperties(family=style.SETTINGS["font.family"], size=size)
    names = [text_to_path.get_text_width_height_descent(str(key.get_label()), font, ismath=False)[0] for key in keys]
    widest = [float(np.max(part)) + beside * size for part in np.array_split(names, columns) if len(part)]
    return float(np.sum(widest)) / 72.0


def _view_axis(axes: Axes, step: float = 30.0) -> None:
    axes.set_xlim(-90.0, 90.0)
    axes.xaxis.set_major_locator(MultipleLocator(step))


def _value_axis(axes: Axes, scale: str, series: Sequence[tuple[Array, Array]]) -> None:
    """The range of values that (view angle, value) pairs ask for; Lambert's 1/pi is always in it."""
    highest = max(_LAMBERT, *(float(np.max(value)) for _, value in series))
    if scale == "linear":
        axes.set_ylim(1.06 * min(0.0, *(float(np.min(value)) for _, value in series)), 1.06 * highest)
        return
    axes.set_yscale("log")
    # What falls off towards the horizon, or to zero, may leave the picture.
    steady = [value[(np.abs(theta_v) < _STEADY) & (value > 0.0)] for theta_v, value in series]
    lowest = min([_LAMBERT, *(float(np.min(value)) for value in steady if len(value))])
    top = np.ceil(np.log10(1.05 * highest))
    bottom = max(np.floor(np.log10(lowest)), top - _DECADES)
    axes.set_ylim(10.0**bottom, 10.0**top)
    axes.yaxis.set_major_locator(LogLocator(10.0, numticks=6))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _one_plot(rows: int, *, polar: bool) -> tuple[Figure, Any]:
    """A figure with one pair of axes, under a legend of so many rows."""
    # A row beyond the second makes the picture higher, not the plot smaller.
    letters = style.SETTINGS["legend.fontsize"] / 72.0
    more = 1.5 * letters * max(rows - 2, 0)
    if not polar:
        figure = Figure(figsize=(style.COLUMN, 0.75 * style.COLUMN + more), layout="constrained")
        return figure, figure.add_subplot()
    # Half a disc is placed by hand: it stands in the middle of the square that the whole disc would fill, of which
    # layouts leave the other half empty. All lengths in inches; room for the legend above, labels below.
    height, radius, below = 0.68 * style.COLUMN + more, 0.4 * style.COLUMN, 0.12 * style.COLUMN
    figure = Figure(figsize=(style.COLUMN, height))
    square = (0.5 - radius / style.COLUMN, (below - radius / 2) / height)
    return figure, figure.add_axes((*square, 2 * radius / style.COLUMN, 2 * radius / height), projection="polar")


def _polar_axes(axes: Any, curves: Sequence[Curve], lights: Sequence[float]) -> None:
    """Normal up, the light's side to the right; an arrow from each light towards the surface."""
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetamin(-90.0)
    axes.set_thetamax(90.0)
    grid = np.arange(-90, 91, 30)
    axes.set_thetagrids(grid, [f"{angle}°".replace("-", "−") for angle in grid])
    axes.tick_params(axis="x", pad=-1)
    highest = max(_LAMBERT, *(float(np.max(curve.value)) for curve in curves))
    axes.set_rlim(0.0, 1.3 * highest)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    for theta_l in lights:
        axes.annotate("", xy=(theta_l, 1.06 * highest), xytext=(theta_l, 1.3 * highest), arrowprops=arrow)
