"""The page of the materials of classes, from their documents: `python -m tools.classes_page > docs/classes.md`.

With `--picture FILE` it draws them instead, in OpenGL.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.fitting.classes import MATERIALS, entrance
from mrm_mtlx.fitting.performance import CEILINGS
from mrm_mtlx.library import class_materials_folder, load_library
from mrm_mtlx.photometry import document_brdf
from mrm_mtlx.photometry.report import PhotometryOptions, SurfaceReport, measure
from mrm_mtlx.render import picture
from mrm_mtlx.shadergen import renderable_elements

if TYPE_CHECKING:
    from mrm_mtlx.fitting.classes import ClassMaterial
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.standards.tables import Limit

COLUMNS = 3
PANEL = 112
# What carries a material in the picture, where a sphere would not.
SHAPES = {"iso_20471_silver": "cone", "lifesaving_silver": "cone"}

HEAD = """<!-- Made by: python -m tools.classes_page > docs/classes.md -->
# Materials of known performance

A material for each class of a standard, in `materials_classes/` of a checkout; `mrm library --classes` prints where
an installed package has them. Each stands at least 3 % above every minimum of its class, in every geometry of the
class, as [`mrm photometry`](photometry.md) measures it, and returns within 2° no more light than its
construction can. They are
made by

    mrm fit --classes -o materials_classes

from the minima that `mrm photometry --list` prints. To check one:

    mrm photometry materials_classes/dot_c2_red.mtlx --class DOT-C2 --color red

The tables below are made from the documents:

    python -m tools.make_docs classes.md images/classes.png

![Each material twice: under a light from 30 degrees aside, and from half a degree](images/classes.png)

Each twice: left by a light from 30° aside, right from 0.5° aside, 200 times darker exposed. Road markings shine at
grazing angles alone.

## How they are made

A clear face (but for markings and the tape of clothing), one retroreflective lobe or two, a diffuse base. Width,
height and fall-off of the lobes are fitted: the sum of ln²(value / minimum) is the least there is with every value 3
% above its minimum. A second lobe comes in only where one would return too much: EN ISO 20471. What comes back falls
with the entrance angle, color0 (1 - (1 - cos)^e) with e from 0.35, below which single precision loses the peak.

* The minima of a class are no measurement: a material that is sold stands further above some of them than above
  others. Beyond the angles of the class, the values are those of the lobes.
* `share` is what the lobes return within 2°, the largest observation angle of any class, at normal incidence, of the
  brightest channel. Ceilings by a supplier (Traffic Signs Minnesota, of sign sheeting): beads 0.14, truncated cube
  corners 0.32, full ones 0.58. GGX lobes have wide tails: those of EN ISO 20471 return 0.21 in all directions. No sum
  of such lobes meets the bare minima of that class with less than 0.157 in all directions, or 0.132 within 2°.
* Chosen by judgement: construction, colours, gloss, and the area of reflectors, 30 cm² and for pedals 12 cm². Colours
  by day and at night, by spectra, are inside the boxes of their colour that were read, those of DPR 495/1992 its own;
  no box for amber was read.
* A lobe does not change as the sheet is rotated; that of prisms does.
* Missing, as no verified minima were at hand: red of FRA-224 (the table that was read has white and yellow), yellow
  of FMVSS 131 (here that of ASTM D4956 Type III, whose white and red have the same minima), and what `mrm photometry
  --list` names at its end.
"""


def main(arguments: list[str]) -> None:
    """Print the page, or draw the picture."""
    parser = argparse.ArgumentParser(prog="python -m tools.classes_page", description=__doc__.partition("\n")[0])
    parser.add_argument("--picture", type=Path, help="draw the materials into this file, and print nothing")
    chosen = parser.parse_args(arguments)
    if chosen.picture:
        draw(chosen.picture)
    else:
        sys.stdout.write(page())


def page() -> str:
    """The page of the documents as they are."""
    library = load_library()
    reports = {material: report(material, library) for material in MATERIALS}
    return "\n".join([HEAD, *_summary(reports), *(line for m, r in reports.items() for line in _section(m, r))]) + "\n"


def report(material: ClassMaterial, library: DataLibrary) -> SurfaceReport:
    """What a material's document measures against its class."""
    _, element = opened(material, library)
    options = PhotometryOptions(rotations_deg=(0.0,), area_cm2=material.make.area_cm2)
    return measure(document_brdf(element), material.limits(), options)


def opened(material: ClassMaterial, library: DataLibrary) -> tuple[Any, Any]:
    """Its document, which has to be held, and the material in it."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(class_materials_folder() / f"{material.name}.mtlx"))
    document.setDataLibrary(library.document)
    KEPT.append(document)
    return document, renderable_elements(document)[0]


KEPT: list[Any] = []


def lobes(material: ClassMaterial) -> list[tuple[float, float, float]]:
    """Width, exponent and color0 of the brightest channel, of each lobe of a material's document."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(class_materials_folder() / f"{material.name}.mtlx"))
    (graph,) = document.getNodeGraphs()
    found = []
    for node in graph.getNodes("generalized_schlick_bsdf"):
        width, exponent, color0 = (node.getInputValue(name) for name in ("roughness", "exponent", "color0"))
        found.append((float(width[0]), float(exponent), max(color0[i] for i in range(3))))
    return found


def share(material: ClassMaterial) -> float:
    """What the lobes of its document return within 2 degrees at normal incidence, without a face."""
    from math import radians, tan

    t2 = tan(radians(1.0)) ** 2
    return sum(color0 * t2 / (alpha**2 + t2) for alpha, _, color0 in lobes(material))


def _summary(reports: dict[ClassMaterial, SurfaceReport]) -> list[str]:
    head = [
        "material",
        "class",
        "construction",
        "share",
        "alpha",
        "e",
        "least value / minimum",
        "Y by day, %",
        "night x, y",
    ]
    lines = ["## All of them", "", f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    for material, found in reports.items():
        least = min(cell.value / cell.minimum for cell in found.cells if cell.minimum)
        day, night = found.colors
        construction = f"{material.make.construction}, at most {CEILINGS[material.make.construction]:g}"
        cells = [
            f"`{material.name}`",
            f"{material.standard}, {material.class_name}, {material.colour}",
            construction,
            f"{share(material):.3f}",
            ", ".join(f"{alpha:.4f}" for alpha, _, _ in lobes(material)),
            f"{lobes(material)[0][1]:.2f}",
            f"{least:.2f}",
            f"{100.0 * day.factor:.0f}",
            f"{night.x:.3f}, {night.y:.3f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _section(material: ClassMaterial, found: SurfaceReport) -> list[str]:
    """Value and minimum in every geometry of one class."""
    rows = material.limits()
    values = {
        (limit.observation_deg, entrance(limit)): f"{_number(cell.value)} / {limit.minimum:g}"
        for limit, cell in zip(rows, found.cells, strict=True)
    }
    observations = list(dict.fromkeys(limit.observation_deg for limit in rows))
    entrances = list(dict.fromkeys(entrance(limit) for limit in rows))
    area = f", of {material.make.area_cm2:g} cm²" if material.make.area_cm2 else ""
    lines = [
        "",
        f"## {material.name}",
        "",
        f"{material.what}. {material.standard}, {material.class_name}, {material.colour}; {_source(rows)}.",
        f"{rows[0].quantity} in {rows[0].unit}{area}, value / minimum, by observation angle (down) and entrance angle:",
        "",
        f"| | {' | '.join(f'{name}°' if name[-1].isdigit() else _with_degree(name) for name in entrances)} |",
        f"|{'---|' * (len(entrances) + 1)}",
    ]
    for observation in observations:
        cells = [values.get((observation, name), "") for name in entrances]
        lines.append(f"| {observation:g}° | {' | '.join(cells)} |")
    return lines


def _with_degree(name: str) -> str:
    number, _, side = name.partition(" ")
    return f"{number}° {side}"


def _source(rows: list[Limit]) -> str:
    return "; ".join(dict.fromkeys(f"{row.source} ({row.confidence})" for row in rows))


def _number(value: float) -> str:
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.3g}"


def draw(path: Path) -> None:
    """All materials under a light aside and one near the eye, in a picture."""
    import matplotlib as mpl
    import numpy as np

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    library, rows = load_library(), -(-len(MATERIALS) // COLUMNS)
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(9.6, 1.72 * rows), facecolor="#181818")
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, material in zip(axes.flat, MATERIALS, strict=False):
        _, element = opened(material, library)
        panels = []
        for light_degrees, exposure in ((30.0, 1.0), (0.5, 1.0 / 200.0)):
            options = picture.PictureOptions(
                SHAPES.get(material.name, "sphere"), light_degrees, PANEL, None, compare=False
            )
            fine = picture.render(element, library, Reach.only(class_materials_folder()), options, ENGINE)
            square = (PANEL, picture.OVERSAMPLING, PANEL, picture.OVERSAMPLING, 3)
            panels.append(exposure * np.asarray(fine).reshape(square).mean(axis=(1, 3)))
        axis.imshow(np.clip(np.concatenate(panels, axis=1), 0.0, 1.0) ** (1.0 / 2.2), interpolation="lanczos")
        axis.set_title(material.name, color="white", fontsize=8, pad=3)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.965, bottom=0.005, hspace=0.18, wspace=0.04)
    figure.savefig(path, dpi=64, metadata={"Software": None})


if __name__ == "__main__":
    main(sys.argv[1:])
