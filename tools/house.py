"""The picture of docs/development.md: `python -m tools.house docs/figures/house.svg` draws the rooms of the package.

Their order is the one that tests/test_architecture.py holds the imports to; what a room is, is the first line of its
docstring.
"""

from __future__ import annotations

import ast
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch

from mrm_mtlx.plots import style
from mrm_mtlx.plots.drawing import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

REPOSITORY = Path(__file__).parents[1]
PACKAGE = REPOSITORY / "mrm_mtlx"
# What is added in a room, and where.
DOORS = {
    "formats": ("a format", "registry.py"),
    "engines": ("an engine", "registry.py"),
    "findings": ("a rule", "catalogue.py"),
    "library": ("a MaterialX version, a surface model", "dialects.py"),
    "reference": ("a node, a deviation", "nodes/registry.py"),
    "standards": ("a class", "data/standards.csv"),
    "bsdf": ("a distribution, a lobe", "masking.py"),
    "cli": ("a command", "main.py"),
}
WIDTH, ROW, GAP, MARGIN = 7.6, 0.58, 0.07, 0.42  # inches; the margin has the arrow
TEXT = "#222222"
PLAIN, WITH_DOOR = "#f1f1ee", "#dbe9f6"


def main(arguments: list[str]) -> None:
    """Draw the picture into a file."""
    save(house(), Path(arguments[0]))


def layers() -> list[list[str]]:
    """Names of the rooms, a list per layer, top first."""
    tree = ast.parse((REPOSITORY / "tests" / "test_architecture.py").read_text(encoding="utf-8"))
    (found,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "LAYERS"
    )
    return [sorted(layer) for layer in ast.literal_eval(found)]


def about(room: str) -> str:
    """What a room is: the first line of its docstring."""
    docstring = ast.get_docstring(ast.parse((PACKAGE / room / "__init__.py").read_text(encoding="utf-8"))) or ""
    return docstring.partition("\n")[0].replace("`", "")


def house() -> Figure:
    """The rooms, in rows from the top to the bottom."""
    rows = layers()
    height = len(rows) * ROW
    with mpl.rc_context(style.SETTINGS):
        figure, axes = plt.subplots(figsize=(WIDTH + MARGIN, height))
        figure.subplots_adjust(left=0.0, right=1.0, top=1.0, bottom=0.0)
        axes.set(xlim=(0.0, WIDTH + MARGIN), ylim=(height, 0.0))
        axes.set_axis_off()
        for number, rooms in enumerate(rows):
            width = WIDTH / len(rooms)
            for column, room in enumerate(rooms):
                _draw(axes, room, column * width, number * ROW, width)
        _arrow(axes, height)
        return figure


def _draw(axes: Axes, room: str, x: float, y: float, width: float) -> None:
    """A room, with its name, what it is, and its door if it has one."""
    door = DOORS.get(room)
    box = FancyBboxPatch(
        (x + GAP, y + GAP / 2), width - 2 * GAP, ROW - GAP,
        boxstyle="round,pad=0,rounding_size=0.06", facecolor=WITH_DOOR if door else PLAIN, edgecolor="#999999", lw=0.6,
    )  # fmt: skip
    axes.add_patch(box)
    axes.text(x + 0.16, y + 0.19, room, fontsize=9.0, fontweight="bold", color=TEXT, va="center")
    if door:
        label = f"+ {door[0]}"
        axes.text(x + width - 0.16, y + 0.19, label, fontsize=7.0, color="#1f5c99", va="center", ha="right")
    letters = int((width - 0.32) * 17.5)
    lines = textwrap.wrap(about(room), letters)[:2]
    axes.text(x + 0.16, y + 0.41, "\n".join(lines), fontsize=6.5, color=TEXT, va="center", linespacing=1.1)


def _arrow(axes: Axes, height: float) -> None:
    x = WIDTH + MARGIN / 2
    axes.annotate("", (x, height - 0.1), (x, 0.1), arrowprops={"arrowstyle": "->", "lw": 1.0, "color": "#777777"})
    axes.text(
        x + 0.02, height / 2, "imports run downward", rotation=90, ha="center", va="center", fontsize=7.5,
        color="#555555", bbox={"facecolor": "white", "edgecolor": "none", "pad": 3.0},
    )  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:])
