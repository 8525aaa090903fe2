"""Pictures of coefficients of retroreflection, from `coefficients`; with `drawing` all that imports matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MultipleLocator, NullFormatter, NullLocator

from mrm_mtlx.plots import style

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from mrm_mtlx.plots.coefficients import CoefficientPanel

# Decades below the highest value that are shown at most, unless a minimum lies deeper.
_DECADES = 4
_TICKS_DEG = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
_MARK: dict[str, Any] = {"marker": "^", "markersize": 4, "linestyle": "none", "markeredgewidth": 0.5}


def picture(panels: Sequence[CoefficientPanel], mark: str = "minimum") -> Figure:
    """A plot per panel, one under the other; triangles are minima, which the curve of their colour has to be above.

    `mark` is what the triangles are called.
    """
    with mpl.rc_context(style.SETTINGS):
        figure = Figure(figsize=(style.COLUMN, 0.72 * style.COLUMN * len(panels)), layout="constrained")
        for axes, panel in zip(np.ravel(figure.subplots(len(panels), 1)), panels, strict=True):
            _draw(axes, panel, mark)
        return figure


def _draw(axes: Axes, panel: CoefficientPanel, mark: str) -> None:
    for i, series in enumerate(panel.series):
        # Of more angles than there are colours, they are used again.
        color, dashes = style.COLORS[i % len(style.COLORS)], style.DASHES[i % len(style.DASHES)]
        axes.plot(series.angle_deg, series.value, color=color, linestyle=dashes, label=series.name)
        axes.plot(series.limit_deg, series.limit, color=color, markeredgecolor="black", zorder=3, **_MARK)
    axes.set_ylabel(rf"${panel.quantity}$ [{panel.unit.replace('m2', 'm²')}]")
    _value_axis(axes, panel)
    handles = axes.get_legend_handles_labels()[0]
    if any(len(series.limit) for series in panel.series):
        handles = [*handles, Line2D([], [], color="white", markeredgecolor="black", label=mark, **_MARK)]
    if panel.angle == "observation":
        axes.set_xscale("log")
        axes.set_xlim(panel.series[0].angle_deg[0], panel.series[0].angle_deg[-1])
        axes.xaxis.set_major_locator(FixedLocator(_TICKS_DEG))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.set_xlabel("observation angle [°]")
        axes.legend(handles=handles, title="entrance", title_fontsize=7, loc="lower left", ncols=1 + len(handles) // 4)
    else:
        axes.set_xlim(panel.series[0].angle_deg[0], panel.series[0].angle_deg[-1])
        axes.xaxis.set_major_locator(MultipleLocator(10.0))
        axes.set_xlabel(f"entrance angle {'to the side, β₂' if panel.across else 'β₁'} [°]")
        axes.legend(handles=handles, title="observation", title_fontsize=7, loc="best", ncols=1 + len(handles) // 4)


def _value_axis(axes: Axes, panel: CoefficientPanel) -> None:
    """A logarithmic axis from below the lowest minimum to above the highest value."""
    every = np.concatenate([part for s in panel.series for part in (s.value, s.limit)])
    limits = np.concatenate([series.limit for series in panel.series])
    highest = float(np.max(every, initial=0.0))
    if highest <= 0.0:  # a black surface
        axes.set_ylim(0.0, 1.0)
        return
    floor = min(highest * 10.0**-_DECADES, float(np.min(limits, initial=np.inf)))
    lowest = max(float(np.min(every[every > 0.0])), floor)
    axes.set_yscale("log")
    axes.set_ylim(lowest / 2.0, highest * 2.0)
    axes.yaxis.set_major_locator(LogLocator(10.0, numticks=8))
    axes.yaxis.set_minor_formatter(NullFormatter())
