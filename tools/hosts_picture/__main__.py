"""`python -m tools.hosts_picture hosts.png PYTHON...`: spheres in each Blender's Storm, with and without the library.

Each PYTHON is an interpreter that has Blender as a module; without any, those that the variable MRM_BLENDER_PYTHONS
lists, with the separator of search paths between, or this one.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import mrm_mtlx as mrm
from tools.hosts_picture.drawing import CENTRES, SURFACES, blender, draw, write_stage

VARIABLE = "MRM_BLENDER_PYTHONS"


def main(arguments: list[str]) -> int:
    """Write the picture."""
    picture, *pythons = arguments
    pythons = pythons or [each for each in os.environ.get(VARIABLE, sys.executable).split(os.pathsep) if each]
    rows: dict[str, Path] = {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for python in pythons:
            host = blender(python)
            library = mrm.install_library(folder / host.host, host=host.host, stdlib=host.folder)
            title = f"Blender {host.release}: MaterialX {library.version}, OpenUSD's Storm"
            rows[title] = folder / f"{host.release}.png"
            draw(host, library, write_stage(folder, "spheres.mtlx"), rows[title])
        title = f"Blender {host.release}, without the library"
        rows[title] = folder / "without.png"
        draw(host, None, write_stage(folder, "spheres.usda"), rows[title])
        compose(rows, Path(picture))
    return 0


def compose(rows: dict[str, Path], picture: Path) -> None:
    """One picture of several, each under its title, with the names of the surfaces above."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(len(rows), 1, figsize=(6.4, 2.1 * len(rows)), layout="compressed", facecolor="white")
    for axis, (title, path) in zip(axes, rows.items(), strict=True):
        image = plt.imread(path)
        axis.imshow(image[..., :3] * image[..., 3:])
        axis.set_xlabel(title, fontsize=8)
        axis.set_xticks([])
        axis.set_yticks([])
    for x, name in zip(CENTRES, SURFACES, strict=True):
        name = name.replace(" with", "\nwith")
        axes[0].text(x, 1.03, name, fontsize=8, ha="center", va="bottom", transform=axes[0].transAxes)
    figure.savefig(picture, dpi=100)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
