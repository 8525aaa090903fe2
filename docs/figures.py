"""Makes the pictures of the documentation: `python docs/figures.py`. Needs matplotlib, which the extra `dev` brings."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import MaterialX as mx
import matplotlib as mpl

from mrm_mtlx.engines.gl.textures import read_image
from mrm_mtlx.library import load_library, materials_folder
from mrm_mtlx.render import picture
from mrm_mtlx.shadergen import renderable_elements

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

IMAGES = Path(__file__).parent / "images"
SHAPES = {"traffic_cone_collar": "cone", "shoe_trim": "cone", "hi_vis_tape_silver": "sphere", "cats_eye": "sphere"}
PANELS = (
    "ordinary,\nlight at the eye",
    "ordinary,\nlight 30° aside",
    "as written,\nlight at the eye",
    "as written,\nlight 30° aside",
)
PANEL = 160


def comparison(path: Path, shape: str, size: int) -> NDArray[np.float32]:
    """Pixels of `mrm render --compare` for a document, (size, width, 3), sRGB in [0, 1]."""
    library = load_library()
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library.document)
    settings = picture.Settings(shape, None, size, None, compare=True)
    radiance = picture.render(renderable_elements(document)[0], library, path.parent, settings)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "picture.png"
        picture.write(radiance, target, None)
        return read_image(target)


def overview(paths: list[Path]) -> None:
    """All materials under each other, docs/images/materials.png."""
    figure, axes = plt.subplots(len(paths), 1, figsize=(9.0, 1.72 * len(paths)), facecolor="#181818")
    for axis, path in zip(axes, paths, strict=True):
        pixels = comparison(path, SHAPES.get(path.stem, "plane"), PANEL)
        axis.imshow(pixels, interpolation="lanczos")
        axis.set_axis_off()
        axis.text(-12, PANEL / 2, path.stem.replace("_", "\n"), color="white", ha="right", va="center", fontsize=9)
    width = pixels.shape[1] / 4
    for index, label in enumerate(PANELS):
        axes[0].text((index + 0.5) * width, -8, label, color="white", ha="center", va="bottom", fontsize=9)
    figure.subplots_adjust(left=0.16, right=0.99, top=0.965, bottom=0.005, hspace=0.04)
    figure.savefig(IMAGES / "materials.png", dpi=80, metadata={"Software": None})


def teaser(path: Path) -> None:
    """One material, docs/images/compare.png: the README's picture."""
    figure, axis = plt.subplots(figsize=(10.0, 3.0), facecolor="#181818")
    pixels = comparison(path, "cone", 320)
    axis.imshow(pixels, interpolation="lanczos")
    axis.set_axis_off()
    width = pixels.shape[1] / 4
    for index, label in enumerate(PANELS):
        axis.text((index + 0.5) * width, -10, label.replace("\n", " "), color="white", ha="center", fontsize=9)
    figure.subplots_adjust(left=0.0, right=1.0, top=0.93, bottom=0.0)
    figure.savefig(IMAGES / "compare.png", dpi=96, metadata={"Software": None})


def main() -> None:
    """Make every picture."""
    IMAGES.mkdir(exist_ok=True)
    paths = sorted(materials_folder().glob("*.mtlx"))
    teaser(materials_folder() / "traffic_cone_collar.mtlx")
    overview(paths)
    print(f"{len(paths)} materials in {IMAGES.name}/materials.png", file=sys.stderr)


if __name__ == "__main__":
    main()
