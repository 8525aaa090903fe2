"""The looks of pictures of lobes: sizes for a paper's column, colours and lines that all eyes tell apart.

The colours are those of Okabe and Ito, for the models as in Figure 2 of the paper: GGX blue, MRM green, EON orange,
Lambert red. Lines that share a picture also differ in their dashes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.writing import check_folder

if TYPE_CHECKING:
    from pathlib import Path

# Width of a column [inch], 8.5 cm, and the smallest letters in it [pt].
COLUMN = 8.5 / 2.54
SMALLEST_LETTERS = 7.0

BLUE, GREEN, ORANGE, RED = "#0072B2", "#009E73", "#E69F00", "#D55E00"
SKY, PURPLE, BLACK = "#56B4E9", "#CC79A7", "#000000"
MODEL_COLORS = {
    "GGX": BLUE,
    "MRM": GREEN,
    "EON": ORANGE,
    "Lambert": RED,
    "ordinary": BLUE,
    "retroreflective": GREEN,
}
# Of everything else, in this order. Red is Lambert's line.
COLORS = (GREEN, BLUE, ORANGE, PURPLE, SKY, BLACK)
# Solid, dashed, dotted, dash-dotted, long dashes, dash-dot-dotted: lengths in line widths.
DASHES: tuple[Any, ...] = (
    "solid",
    (0, (4, 1.5)),
    (0, (1, 1.2)),
    (0, (5, 1.5, 1, 1.5)),
    (0, (9, 2)),
    (0, (5, 1.5, 1, 1.5, 1, 1.5)),
)

# What matplotlib is told. Letters are drawn as outlines in SVG, so that they look the same everywhere; the salt and the
# absent dates make two runs write the same bytes.
SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "figure.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "grid.linewidth": 0.4,
    "grid.color": "#dddddd",
    "axes.grid": True,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "legend.columnspacing": 1.2,
    "legend.borderaxespad": 0.2,
    "savefig.dpi": 300,
    "svg.fonttype": "path",
    "svg.hashsalt": "mrm plot",
    "pdf.fonttype": 42,
}
# By suffix, what else is written into a file; None leaves out what would differ between runs.
METADATA: dict[str, Any] = {
    ".png": {},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
SUFFIXES = tuple(METADATA)
# As many names and variants as there are colours and dashes to tell them apart.
MAXIMUM_NAMES = len(COLORS)
MAXIMUM_VARIANTS = len(DASHES)


def check_picture(path: Path, argument: str = "output") -> None:
    """Raise an ArgumentError for a picture whose name or folder will not do, before anything is evaluated."""
    if path.suffix.lower() not in SUFFIXES:
        msg = f"{path}: expected a name that ends in {', '.join(SUFFIXES)}"
        raise ArgumentError(msg, argument)
    check_folder(path, argument)
