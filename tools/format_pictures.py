"""Pictures of what other formats make of materials: `python -m tools.format_pictures` draws them into docs/images."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np

import mrm_mtlx as mrm
from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines import osl
from mrm_mtlx.engines.osl.process import RUNTIME
from mrm_mtlx.library import load_library, materials_folder
from mrm_mtlx.render import picture
from tools.pictures import IMAGES, in_opengl, shown

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.library import DataLibrary

PROGRAM = Path(__file__).with_name("look_in_blender.py")
SIDE = 160
ASIDE_DEG = 30.0
# What has no form in glTF.
WITHOUT_FORM = (
    "cats_eye", "shoe_trim", "road_marking_paint", "hi_vis_tape_silver", "prismatic_tape_orange", "embossed_foil",
)  # fmt: skip
BY_DAY = ("traffic_cone_collar", "hi_vis_tape_silver", "prismatic_tape_orange", "embossed_foil")


def nearest_in_gltf(target: Path) -> None:
    """Six materials as they are and from glTF, gltf-nearest.png."""
    library = load_library()
    figure, axes = plt.subplots(len(WITHOUT_FORM), 2, figsize=(7.2, 1.76 * len(WITHOUT_FORM)), facecolor="#181818")
    for row, name in zip(axes, WITHOUT_FORM, strict=True):
        for axis, angle in zip(row, (None, ASIDE_DEG), strict=True):
            options = picture.PictureOptions("sphere", angle, SIDE, None, compare=False)
            # Side by side, so that both are as bright as they are beside each other.
            axis.imshow(shown(picture.side_by_side(there_and_back(name, options, library))), interpolation="lanczos")
            axis.set_axis_off()
        row[0].text(-8, SIDE / 2, name.replace("_", "\n"), color="white", ha="right", va="center", fontsize=8)
    for axis, light in zip(axes[0], ("light at the eye", f"light {ASIDE_DEG:g}° aside"), strict=True):
        axis.set_title(f"{light}: as it is, and from glTF", color="white", fontsize=8)
    figure.subplots_adjust(left=0.12, right=0.995, top=0.97, bottom=0.005, hspace=0.03, wspace=0.03)
    figure.savefig(target, dpi=96, metadata={"Software": None})


def there_and_back(name: str, options: picture.PictureOptions, library: DataLibrary) -> list[NDArray[np.floating]]:
    """Linear radiance of a material as it is, and after it went through glTF."""
    path = materials_folder() / f"{name}.mtlx"
    with tempfile.TemporaryDirectory() as folder:
        asset, back = Path(folder, "asset.glb"), Path(folder, "back.mtlx")
        mrm.convert(path, asset)
        mrm.convert(asset, back)
        return [in_opengl(each, library, options) for each in (path, back)]


def look_by_day(target: Path) -> None:
    """Four materials as they are, and as Blender imports them from USD, usd-preview.png; prints their brightness."""
    library = load_library()
    figure, axes = plt.subplots(2, len(BY_DAY), figsize=(2.0 * len(BY_DAY), 4.2), facecolor="#181818")
    with tempfile.TemporaryDirectory() as folder:
        for column, name in zip(axes.T, BY_DAY, strict=True):
            path, stage = materials_folder() / f"{name}.mtlx", Path(folder, f"{name}.usda")
            mrm.convert(path, stage)
            options = picture.PictureOptions("sphere", ASIDE_DEG, SIDE, None, compare=False)
            panels = [in_opengl(path, library, options), in_blender(stage)]
            middle = slice(SIDE // 3, 2 * SIDE // 3)
            print(f"{name:24} {[round(float(np.median(panel[middle, middle])), 3) for panel in panels]}")
            for axis, panel in zip(column, panels, strict=True):
                axis.imshow(shown(panel), interpolation="lanczos")
                axis.set_axis_off()
            column[0].set_title(name, color="white", fontsize=8)
    for axis, label in zip(axes[:, 0], ("MaterialX, mrm render", "look, Blender 5.0.1"), strict=True):
        axis.text(-8, SIDE / 2, label, color="white", ha="right", va="center", fontsize=8, rotation=90)
    figure.subplots_adjust(left=0.04, right=0.995, top=0.94, bottom=0.005, hspace=0.03, wspace=0.03)
    figure.savefig(target, dpi=96, metadata={"Software": None})


def in_blender(stage: Path) -> NDArray[np.floating]:
    """Linear radiance of a sphere in a stage's first material, as Blender imports it."""
    image = stage.with_suffix(".exr")
    command = [RUNTIME.interpreter() or sys.executable, str(PROGRAM), str(stage), str(image), str(SIDE), str(ASIDE_DEG)]
    subprocess.run(command, check=True, capture_output=True)
    pixels = read_image(image)
    assert pixels is not None
    radiance = np.asarray(pixels[..., :3])
    return np.where(radiance.max(axis=2, keepdims=True) == 0.0, np.float32(picture.BACKDROP), radiance)


def main(arguments: list[str]) -> None:
    """Draw every picture."""
    parser = argparse.ArgumentParser(prog="python -m tools.format_pictures", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=IMAGES, help="their folder; default: docs/images")
    folder = parser.parse_args(arguments).output
    folder.mkdir(parents=True, exist_ok=True)
    nearest_in_gltf(folder / "gltf-nearest.png")
    if osl.availability().available:
        look_by_day(folder / "usd-preview.png")
    else:
        print(f"no usd-preview.png: {osl.availability().detail}", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
