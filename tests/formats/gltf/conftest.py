"""Small assets made as they are needed, and what the documents that they become are worth."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import read_image
from mrm_mtlx.formats import gltf
from mrm_mtlx.reference import Illumination, ShadingPoints, Surface
from mrm_mtlx.shadergen import renderable_elements

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.documents.document import Document


@pytest.fixture(scope="session")
def png() -> Callable[..., bytes]:
    """Function that writes pixels, whole numbers of shape (height, width, channels), as a PNG and returns its bytes."""

    def write(path: Path, pixels: Any, kind: str = "uint8") -> bytes:
        values = np.ascontiguousarray(pixels, dtype=kind)
        spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
        spec.attribute("oiio:UnassociatedAlpha", 1)
        output = oiio.ImageOutput.create(str(path))
        assert output.open(str(path), spec)
        assert output.write_image(values)
        assert output.close()
        return path.read_bytes()

    return write


@pytest.fixture
def write_asset(tmp_path: Path) -> Callable[..., Path]:
    """Function from the arrays of an asset to its .gltf file in the test's folder."""

    def write(name: str = "model.gltf", **arrays: Any) -> Path:
        path = tmp_path / name
        path.write_text(json.dumps({"asset": {"version": "2.0"}, **arrays}), encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def glb() -> Callable[..., bytes]:
    """Function from an asset's JSON and binary chunk to the bytes of a .glb."""

    def make(data: Any, binary: bytes = b"") -> bytes:
        text = json.dumps(data).encode()
        text += b" " * (-len(text) % 4)
        binary += bytes(-len(binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if binary:
            chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    return make


@pytest.fixture
def read(library, tmp_path) -> Callable[[Path], Document]:
    """Function that reads an asset; files inside of it go to a folder of their own."""

    def run(path: Path) -> Document:
        scratch = tmp_path / f"scratch_{len(list(tmp_path.glob('scratch_*')))}"
        scratch.mkdir()
        return gltf.read(path, Reach.beside(path), library, scratch)

    return run


@pytest.fixture(scope="session")
def surface_of() -> Callable[..., Surface]:
    """Function from what was read to a surface with its images, by default the first."""

    def make(imported: Document, index: int = 0) -> Surface:
        element = renderable_elements(imported.materialx)[index]
        return Surface(element, images=lambda name: read_image(imported.reach.folder / name))

    return make


@pytest.fixture
def points(rng, hemisphere) -> Callable[..., ShadingPoints]:
    """Function from texture coordinates, v upward, to points there with random directions; frame n = z, t = x."""

    def make(texcoord: Any, normal: Any = (0.0, 0.0, 1.0), tangent: Any = (1.0, 0.0, 0.0)) -> ShadingPoints:
        texcoord = np.atleast_2d(texcoord)
        count = len(texcoord)
        return ShadingPoints(
            view=hemisphere(rng, count),
            light=hemisphere(rng, count),
            normal=np.tile(normal, (count, 1)),
            tangent=np.tile(tangent, (count, 1)),
            position=np.zeros((count, 3)),
            texcoord=texcoord,
        )

    return make


@pytest.fixture(scope="session")
def emitted() -> Callable[[Surface, ShadingPoints], Any]:
    """Function from a surface to what it emits, shape (points, 3)."""
    dark = Illumination(light=False)
    return lambda surface, points: surface.shade(points, dark)
