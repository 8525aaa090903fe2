"""The pictures of docs/hosts/blender.md, by Blender: `python -m tools.blender_extension.figures -o DIR`."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np

from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines.osl import process
from mrm_mtlx.library import materials_folder
from tools.blender_extension.archive import archive
from tools.blender_extension.contents import contents

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

PROGRAM = Path(__file__).with_name("first_steps.py")
SCENES = {"aside": "the lamp of the new file", "camera": "light at the camera", "off": "Retroreflective turned off"}
ENGINES = {"CYCLES": "Cycles", "HYDRA_STORM": "Hydra Storm"}
_WIDTH, _SAMPLES = 320, 64
_COLUMNS = 6


def draw(folder: Path, materials: Sequence[str] = (), *, width: int = _WIDTH, samples: int = _SAMPLES) -> None:
    """Have a Blender that nobody has used before do the steps of the page; its pictures are in the folder then.

    Raises
    ------
    RuntimeError
        If there is no Blender, or it fails; the message is its own.
    """
    interpreter = process.RUNTIME.interpreter()
    if interpreter is None:
        raise RuntimeError(process.RUNTIME.availability().detail)
    with tempfile.TemporaryDirectory() as scratch:
        zipped = Path(scratch, "mrm-blender.zip")
        zipped.write_bytes(archive(contents()))
        request = {"archive": str(zipped), "folder": str(folder), "materials": list(materials)}
        done = subprocess.run(
            [interpreter, "-I", str(PROGRAM), json.dumps({**request, "width": width, "samples": samples})],
            capture_output=True, text=True, check=False, cwd=scratch,
            env={**os.environ, "HOME": scratch, "BLENDER_USER_RESOURCES": str(Path(scratch, "user"))},
        )  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stderr[-4000:])


def first_steps(folder: Path, target: Path) -> None:
    """What a user sees on the way, in both engines: blender-first.png."""
    figure, axes = plt.subplots(len(ENGINES), len(SCENES), figsize=(9.0, 4.9), facecolor="#181818")
    for row, (engine, label) in zip(axes, ENGINES.items(), strict=True):
        for axis, (scene, title) in zip(row, SCENES.items(), strict=True):
            axis.imshow(picture(folder / f"{scene}.{engine}.png"))
            axis.set_axis_off()
            if engine == next(iter(ENGINES)):
                axis.set_title(title, color="white", fontsize=10)
        row[0].text(-12, 120, label, color="white", ha="right", va="center", fontsize=10, rotation=90)
    figure.subplots_adjust(left=0.04, right=0.995, top=0.93, bottom=0.01, hspace=0.03, wspace=0.02)
    figure.savefig(target, dpi=90, metadata={"Software": None})


def spheres(folder: Path, names: Sequence[str], target: Path) -> None:
    """Each material on a sphere under the light at the camera: blender-materials.png."""
    rows = -(-len(names) // _COLUMNS)
    figure, axes = plt.subplots(rows, _COLUMNS, figsize=(9.0, 1.72 * rows), facecolor="#181818")
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, names, strict=False):
        pixels = picture(folder / f"{name}.png")
        edge, middle = pixels.shape[0] // 4, pixels.shape[1] // 2
        axis.imshow(pixels[edge:-edge, middle - edge : middle + edge])
        axis.set_title(textwrap.fill(name.replace("_", " "), 22), color="white", fontsize=7)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.92, bottom=0.01, hspace=0.26, wspace=0.02)
    figure.savefig(target, dpi=90, metadata={"Software": None})


def picture(path: Path) -> NDArray[np.float32]:
    """Colours of a picture that Blender has written, (height, width, 3) in [0, 1]."""
    return np.asarray(read_image(path)[..., :3], dtype=np.float32)


def main(arguments: list[str]) -> int:
    """Draw both pictures; 2 if there is no Blender."""
    parser = argparse.ArgumentParser(prog="python -m tools.blender_extension.figures", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="their folder")
    output = parser.parse_args(arguments).output
    names = sorted(path.stem for path in materials_folder().glob("*.mtlx"))
    with tempfile.TemporaryDirectory() as folder:
        try:
            draw(Path(folder), names)
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return 2
        first_steps(Path(folder), output / "blender-first.png")
        spheres(Path(folder), names, output / "blender-materials.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
