"""Stages from text, documents through USD and back, and the values of their surfaces."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.registry import MATERIALX, format_for
from mrm_mtlx.formats.usd import read
from mrm_mtlx.formats.usd.options import UsdOptions
from mrm_mtlx.reference import ShadingPoints, Surface, UnsupportedError
from mrm_mtlx.shadergen import renderable_elements

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.library import DataLibrary

# The look for hosts without MaterialX has tests of its own, and costs an evaluation of each material.
NETWORK_ALONE = UsdOptions(preview=False)
HEAD = '#usda 1.0\n(\n    defaultPrim = "M"\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'


@pytest.fixture
def usda(tmp_path: Path) -> Callable[..., Path]:
    """Function from the prims of a stage, as text, to its file in the test's folder."""

    def make(prims: str, name: str = "stage.usda", head: str = HEAD) -> Path:
        path = tmp_path / name
        path.write_text(head + prims, encoding="utf-8")
        return path

    return make


@pytest.fixture
def imported(library: DataLibrary, tmp_path: Path) -> Callable[[Path], Document]:
    """Function from a file of any format to what is read from it, its folder being the test's."""

    def run(path: Path) -> Document:
        return read_document(path, Reach.beside(path), library, _scratch(tmp_path))

    return run


@pytest.fixture
def stage_of(library: DataLibrary, tmp_path: Path, usda: Callable[..., Path]) -> Callable[..., Document]:
    """Function from the prims of a stage, or a file, to what `usd.read` makes of it."""

    def run(prims: str | Path) -> Document:
        path = usda(prims) if isinstance(prims, str) else prims
        return read(path, Reach.beside(path), library, _scratch(tmp_path))

    return run


@pytest.fixture
def written(library: DataLibrary, tmp_path: Path) -> Callable[..., Path]:
    """Function from a document to the file of USD that is written of it; `lost` collects what was lost."""

    def run(document: Any, name: str = "out.usda", lost: list[Any] | None = None) -> Path:
        source = document
        if not isinstance(document, Document):
            source = Document(materialx=document, path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path))
        findings = format_for(tmp_path / name).write(source, tmp_path / name, library, NETWORK_ALONE)
        if lost is None:
            assert findings == []
        else:
            lost += findings
        return tmp_path / name

    return run


@pytest.fixture
def round_trip(
    library: DataLibrary, tmp_path: Path, stage_of: Callable[..., Document], imported: Callable[..., Document]
) -> Callable[..., Document]:
    """Function from a document to that which comes back: .mtlx to .usda to .mtlx, each a file.

    The stage has the look for hosts without MaterialX, too, if it is not to have the `network_alone`.
    """

    def run(source: Document, network_alone: bool = True) -> Document:
        there, back = tmp_path / "there.usda", tmp_path / "back.mtlx"
        format_for(there).write(source, there, library, NETWORK_ALONE if network_alone else None)
        MATERIALX.write(stage_of(there), back, library)
        return imported(tmp_path / "back.mtlx")

    return run


@pytest.fixture
def shades() -> Callable[[Document, np.random.Generator], list[Array | str]]:
    """Function from a document to the colours of its surfaces, emission included, at points that a seed fixes.

    A quarter of the directions see the mirrored light, a quarter look back at it, so that narrow lobes show. A surface
    that the reference does not know gives what it says of it.
    """

    def run(source: Document, rng: np.random.Generator) -> list[Array | str]:
        points = _points(np.random.default_rng(rng.bit_generator.seed_seq))
        found: list[Array | str] = []
        for element in renderable_elements(source.materialx):
            images = CheckedImages(source.reach, "")
            try:
                found.append(Surface(element, images=images).shade(points))
            except UnsupportedError as error:
                found.append(str(error))
        return found

    return run


def _scratch(folder: Path) -> Path:
    """An empty folder in a folder, another one each time."""
    return Path(tempfile.mkdtemp(prefix="scratch_", dir=folder))


def _points(rng: np.random.Generator, count: int = 64) -> ShadingPoints:
    def hemisphere() -> Array:
        v = rng.normal(size=(count, 3))
        v[:, 2] = np.abs(v[:, 2]) + 1e-2
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    view, light = hemisphere(), hemisphere()
    quarter = count // 4
    light[:quarter] = view[:quarter] * [-1.0, -1.0, 1.0]
    light[quarter : 2 * quarter] = view[quarter : 2 * quarter]
    return ShadingPoints(
        view=view,
        light=light,
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (count, 1)),
        position=rng.normal(size=(count, 3)),
        texcoord=rng.uniform(size=(count, 2)),
    )
