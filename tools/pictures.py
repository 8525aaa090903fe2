"""The pictures of the documentation: `python -m tools.pictures` draws them into docs/images."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx
import matplotlib as mpl
import numpy as np
import OpenImageIO as oiio

import mrm_mtlx as mrm
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines import gl, osl, storm
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.library import Origin, load_library, materials_folder
from mrm_mtlx.render import picture, scenes
from mrm_mtlx.shadergen import OslMode, renderable_elements

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.library import DataLibrary

IMAGES = Path(__file__).parents[1] / "docs" / "images"
SHAPES = {"traffic_cone_collar": "cone", "shoe_trim": "cone", "hi_vis_tape_silver": "sphere", "cats_eye": "sphere"}
PANELS = (
    "ordinary,\nlight at the eye",
    "ordinary,\nlight 30° aside",
    "as written,\nlight at the eye",
    "as written,\nlight 30° aside",
)
PANEL = 160
# Angles of the light from the eye; None is at the eye.
ANGLES = (None, 1.0, 30.0)
FIVE = {
    "hi_vis_tape_silver": "sphere",
    "traffic_cone_collar": "cone",
    "road_sign_sheeting_prismatic_blue": "plane",
    "licence_plate": "plane",
    "bicycle_reflector_red": "sphere",
}
FIVE_PANEL = 96
KEPT: list[Any] = []


def comparison(path: Path, shape: str, size: int) -> NDArray[np.float32]:
    """Pixels of `mrm render --compare` for a document, (size, width, 3), sRGB in [0, 1]."""
    library = load_library()
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library.document)
    options = picture.PictureOptions(shape, None, size, None, compare=True)
    radiance = picture.render(renderable_elements(document)[0], library, Reach.beside(path), options, gl.ENGINE)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "picture.png"
        picture.write(radiance, target, None)
        return read_image(target)


def overview(paths: list[Path], target: Path) -> None:
    """All materials under each other: materials.png."""
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
    figure.savefig(target, dpi=80, metadata={"Software": None})


def teaser(path: Path, target: Path) -> None:
    """One material: compare.png, the README's picture."""
    figure, axis = plt.subplots(figsize=(10.0, 3.0), facecolor="#181818")
    pixels = comparison(path, "cone", 320)
    axis.imshow(pixels, interpolation="lanczos")
    axis.set_axis_off()
    width = pixels.shape[1] / 4
    for index, label in enumerate(PANELS):
        axis.text((index + 0.5) * width, -10, label.replace("\n", " "), color="white", ha="center", fontsize=9)
    figure.subplots_adjust(left=0.0, right=1.0, top=0.93, bottom=0.0)
    figure.savefig(target, dpi=96, metadata={"Software": None})


def five_in_osl(target: Path) -> None:
    """Five materials in OpenGL and in Cycles, osl.png; prints how far the pictures are apart."""
    figure, axes = plt.subplots(len(FIVE), 1, figsize=(9.0, 1.36 * len(FIVE)), facecolor="#181818")
    library = load_library()
    for axis, (name, shape) in zip(axes, FIVE.items(), strict=True):
        path = materials_folder() / f"{name}.mtlx"
        rows = []
        for angle in ANGLES:
            options = picture.PictureOptions(shape, angle, FIVE_PANEL, None, compare=False)
            panels = [in_opengl(path, library, options)]
            panels += [
                scenes.render(
                    *renderable(path, library),
                    Reach.beside(path),
                    options,
                    osl.CYCLES.scene_renderer,
                    paths=32,
                    mode=mode,
                )
                for mode in (OslMode.ALIGNED, OslMode.CYCLES)
            ]
            for mode, panel in zip(("aligned", "cycles"), panels[1:], strict=True):
                off = np.abs(panel - panels[0]) / np.quantile(panels[0], 0.99)
                print(f"{name:30} {angle or 0:4g} deg  {mode:8} mean {off.mean():.1e}  largest {off.max():.1e}")
            rows.append(panels)
        # By light, then by renderer.
        axis.imshow(shown(picture.side_by_side([panel for panels in rows for panel in panels])))
        axis.set_axis_off()
        axis.text(-12, FIVE_PANEL / 2, name.replace("_", "\n"), color="white", ha="right", va="center", fontsize=8)
    width = (FIVE_PANEL + 4) * 3
    for index, label in enumerate(("light at the eye", "1° aside", "30° aside")):
        axes[0].text((index + 0.5) * width, -8, label, color="white", ha="center", va="bottom", fontsize=9)
    figure.subplots_adjust(left=0.12, right=0.995, top=0.95, bottom=0.005, hspace=0.04)
    figure.savefig(target, dpi=110, metadata={"Software": None})


def portable_beside_exact(paths: list[Path], target: Path) -> None:
    """All materials and their portable forms, portable.png; prints how far the pictures are apart.

    Each pair of pictures is on one scale.
    """
    rows = -(-len(paths) // 2)
    figure, axes = plt.subplots(rows, 2, figsize=(15.0, 1.16 * rows), facecolor="#181818")
    library, standard = load_library(), load_library(Origin.UPSTREAM)
    with tempfile.TemporaryDirectory() as folder:
        for axis, path in zip(axes.T.flat, paths, strict=False):
            converted = Path(folder, path.name)
            mrm.convert(path, converted, portable=True)
            pairs = []
            for angle in ANGLES:
                options = picture.PictureOptions("sphere", angle, FIVE_PANEL, None, compare=False)
                panels = [in_opengl(path, library, options), in_opengl(converted, standard, options)]
                off = np.abs(panels[1] - panels[0]) / np.quantile(panels[0], 0.99)
                print(f"{path.stem:36} {angle or 0:4g} deg  mean {off.mean():.1e}  largest {off.max():.1e}")
                pairs.append(shown(picture.side_by_side(panels)))
            axis.imshow(np.concatenate(pairs, axis=1))
            name = path.stem.replace("_", "\n")
            axis.text(-12, FIVE_PANEL / 2, name, color="white", ha="right", va="center", fontsize=8)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis in axes[0]:
        for index, label in enumerate(("light at the eye", "1° aside", "30° aside")):
            middle = (index + 0.5) * 2 * (FIVE_PANEL + 4)
            axis.text(middle, -8, label, color="white", ha="center", va="bottom", fontsize=9)
    figure.subplots_adjust(left=0.07, right=0.995, top=0.965, bottom=0.005, hspace=0.04, wspace=0.18)
    figure.savefig(target, dpi=90, metadata={"Software": None})


def in_storm(target: Path) -> None:
    """The five materials in OpenGL and in OpenUSD's Storm, storm.png; prints how far the pictures are apart."""
    renderer = storm.ENGINE.scene_renderer
    figure, axes = plt.subplots(len(FIVE), 1, figsize=(9.0, 1.36 * len(FIVE)), facecolor="#181818")
    library = load_library()
    for axis, (name, shape) in zip(axes, FIVE.items(), strict=True):
        path = materials_folder() / f"{name}.mtlx"
        rows = []
        for angle in ANGLES:
            options = picture.PictureOptions(shape, angle, FIVE_PANEL, None, compare=False)
            drawn = in_opengl(path, library, options)
            rasterised = scenes.render(*renderable(path, library), Reach.beside(path), options, renderer)
            off = np.abs(rasterised - drawn) / np.quantile(drawn, 0.99)
            print(f"{name:30} {angle or 0:4g} deg  storm    mean {off.mean():.1e}  largest {off.max():.1e}")
            rows += [drawn, rasterised]
        axis.imshow(shown(picture.side_by_side(rows)))
        axis.set_axis_off()
        axis.text(-12, FIVE_PANEL / 2, name.replace("_", "\n"), color="white", ha="right", va="center", fontsize=8)
    width = (FIVE_PANEL + 4) * 2
    for index, label in enumerate(("light at the eye", "1° aside", "30° aside")):
        axes[0].text((index + 0.5) * width, -8, label, color="white", ha="center", va="bottom", fontsize=9)
    figure.subplots_adjust(left=0.12, right=0.995, top=0.95, bottom=0.005, hspace=0.04)
    figure.savefig(target, dpi=80, metadata={"Software": None})


def three_formats(target: Path) -> None:
    """A material from a glTF asset and from what it is converted to, gltf.png; prints how they differ."""
    library = load_library()
    figure, axes = plt.subplots(2, 3, figsize=(7.2, 5.0), facecolor="#181818")
    firsts: dict[float | None, NDArray[np.floating]] = {}
    with tempfile.TemporaryDirectory() as folder:
        paths = [cone_asset(Path(folder)), Path(folder) / "cone.mtlx", Path(folder) / "cone.usda"]
        for path in paths[1:]:
            scratch = Path(folder) / f"from_{path.suffix[1:]}"
            scratch.mkdir()
            form = format_for(path)
            assert form is not None
            form.write(read_document(paths[0], Reach(paths[0].parent, Path(folder)), library, scratch), path, library)
        for column, path in enumerate(paths):
            scratch = Path(folder) / f"of_{path.suffix[1:]}"
            scratch.mkdir()
            read = read_document(path, Reach.beside(path), library, scratch)
            for row, angle in enumerate((None, 30.0)):
                options = picture.PictureOptions("cone", angle, 256, None, compare=False)
                image = picture.render(renderable_elements(read.materialx)[0], library, read.reach, options, gl.ENGINE)
                image = image.reshape(256, picture.OVERSAMPLING, 256, picture.OVERSAMPLING, 3).mean(axis=(1, 3))
                first = firsts.setdefault(angle, image)
                print(f"{path.name:10} {angle or 0:4g} deg  largest {np.abs(image - first).max():.1e}")
                axes[row, column].imshow(shown(image), interpolation="lanczos")
                axes[row, column].set_axis_off()
            axes[0, column].set_title(path.suffix, color="white", fontsize=10)
    for row, label in enumerate(("light at the eye", "light 30° aside")):
        axes[row, 0].text(-12, 128, label, color="white", ha="right", va="center", fontsize=9, rotation=90)
    figure.subplots_adjust(left=0.05, right=0.995, top=0.93, bottom=0.005, hspace=0.03, wspace=0.03)
    figure.savefig(target, dpi=96, metadata={"Software": None})


def cone_asset(folder: Path) -> Path:
    """A glTF asset with a cone's material: two white bands are retroreflective where a mask of slanted stripes is."""
    height, width = 128, 512
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    band = (np.abs(v - 0.35) < 0.09) | (np.abs(v - 0.65) < 0.09)
    color = np.where(band[..., None], [235, 235, 230], [226, 74, 18])
    mask = 255 * (band & ((32.0 * u + 6.0 * v) % 1.0 < 0.6))
    for name, pixels in (("color", color), ("mask", np.repeat(mask[..., None], 3, axis=2))):
        target = oiio.ImageOutput.create(str(folder / f"{name}.png"))
        target.open(str(folder / f"{name}.png"), oiio.ImageSpec(width, height, 3, "uint8"))
        target.write_image(np.ascontiguousarray(pixels, dtype=np.uint8))
        target.close()
    material = {
        "name": "cone",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0, "roughnessFactor": 0.2},
        "extensions": {
            # The F0 of 0.04 that a dielectric has by default would hardly be seen.
            "KHR_materials_specular": {"specularColorFactor": [4.0, 4.0, 4.0]},
            "KHR_materials_retroreflection": {
                "retroreflectionFactor": 1.0,
                "retroreflectionTexture": {"index": 1},
            },
        },
    }
    asset = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_retroreflection", "KHR_materials_specular"],
        "materials": [material],
        "textures": [{"source": 0}, {"source": 1}],
        "images": [{"uri": "color.png"}, {"uri": "mask.png"}],
    }
    path = folder / "cone.gltf"
    path.write_text(json.dumps(asset))
    return path


def renderable(path: Path, library: DataLibrary) -> tuple[Any, DataLibrary]:
    """The first material of a document, and the library."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library.document)
    element = renderable_elements(document)[0]
    KEPT.append(document)  # elements do not keep their document alive
    return element, library


def in_opengl(path: Path, library: DataLibrary, options: picture.PictureOptions) -> NDArray[np.floating]:
    """Linear radiance as the OpenGL engine has it, one value per pixel."""
    image = picture.render(*renderable(path, library), Reach.beside(path), options, gl.ENGINE)
    size = options.size
    return np.asarray(image.reshape(size, picture.OVERSAMPLING, size, picture.OVERSAMPLING, 3).mean(axis=(1, 3)))


def shown(radiance: NDArray[np.floating]) -> NDArray[np.floating]:
    """The picture's colours on one scale."""
    return picture.tone_map(np.asarray(radiance, dtype=np.float64), None)


def main(arguments: list[str]) -> None:
    """Draw every picture."""
    parser = argparse.ArgumentParser(prog="python -m tools.pictures", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=IMAGES, help="their folder; default: docs/images")
    folder = parser.parse_args(arguments).output
    folder.mkdir(parents=True, exist_ok=True)
    teaser(materials_folder() / "traffic_cone_collar.mtlx", folder / "compare.png")
    overview(sorted(materials_folder().glob("*.mtlx")), folder / "materials.png")
    portable_beside_exact(sorted(materials_folder().glob("*.mtlx")), folder / "portable.png")
    three_formats(folder / "gltf.png")
    if osl.availability().available:
        five_in_osl(folder / "osl.png")
    else:
        print(f"no osl.png: {osl.availability().detail}", file=sys.stderr)
    if storm.ENGINE.availability().available:
        in_storm(folder / "storm.png")
    else:
        print(f"no storm.png: {storm.ENGINE.availability().detail}", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
