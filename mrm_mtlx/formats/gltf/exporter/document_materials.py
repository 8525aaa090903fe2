"""Writes the materials of a document as a glTF asset, reads them back, and says what they are apart."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from mrm_mtlx.documents.document_images import ImagesTooLargeError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.gltf.container import LOST, is_data, open_container
from mrm_mtlx.formats.gltf.exporter.asset import Asset
from mrm_mtlx.formats.gltf.exporter.material import Material
from mrm_mtlx.formats.gltf.exporter.texture_slots import Images
from mrm_mtlx.formats.gltf.importer.asset_materials import read
from mrm_mtlx.formats.pbr import comparison
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.value_sources import resolved
from mrm_mtlx.reference import UnsupportedError
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary

LEFT_OUT = rules.INTERCHANGE_LEFT_OUT


def names(path: Path) -> list[str]:
    """Names of files in an asset, as `write` has them.

    Raises
    ------
    ReadError
        If it is none.
    """
    data = open_container(path, Reach.beside(path)).data
    uris = [element.get("uri") for array in ("buffers", "images") for element in data.get(array, [])]
    return [unquote(uri) for uri in uris if isinstance(uri, str) and not is_data(uri)]


def write(source: Document, path: Path, library: DataLibrary, files: FileSet) -> list[Finding]:
    """Write a document as .gltf or .glb, into a set of files; see `formats.format`.

    A material that glTF cannot say is left out. What was written is read back, and how far it is from the document is
    a found where it is more than rounding.

    Raises
    ------
    OSError
        If it cannot be written.
    NothingToWriteError
        If glTF can say none of the document's materials.
    """
    document = resolved(source.materialx)
    images, asset = Images(source, path), Asset()
    findings: list[Finding] = []
    written = []
    for element in renderable_elements(document):
        place = f"/{element.getNamePath()}"
        images.start_surface()
        try:
            material = Material(element, asset, images)
        except InexpressibleError as error:
            findings.append(LEFT_OUT.at(place, f"glTF has no form for it: {error}"))
            continue
        findings += [LOST.at(f"{place}{where}", message) for where, message in material.losses]
        asset.materials.append(material.data)
        written.append(element)
    if not written:
        raise NothingToWriteError(findings)
    findings += _differences(written, asset, images, path, library)
    asset.save(path, files)
    return findings


def _differences(elements: list[Any], asset: Asset, images: Images, path: Path, library: DataLibrary) -> list[Finding]:
    """Findings about how far the asset's materials are from those that they were made of."""
    findings = []
    with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
        copy, scratch = Path(folder) / path.name, Path(folder) / "scratch"
        scratch.mkdir()
        with FileSet(Path(folder)) as files:
            asset.save(copy, files, beside=False)
        back = read(copy, Reach.beside(copy), library, scratch)
        found = Images(back, copy)
        for element, again, data in zip(elements, renderable_elements(back.materialx), asset.materials, strict=True):
            place = f"/{element.getNamePath()}"
            images.start_surface()
            found.start_surface()
            transmits = "KHR_materials_transmission" in data.get("extensions", {})
            pair = (element, images), (again, found)
            try:
                largest, mean = comparison.difference(*pair, transmits=transmits)
            except ImagesTooLargeError as error:
                findings.append(LOST.at(place, f"it was written and not compared: it has {error}"))
                continue
            except (UnsupportedError, RecursionError) as error:
                findings.append(LOST.at(place, f"it was written and not compared: {error}"))
                continue
            if largest > comparison.ROUNDING:
                message = f"as glTF, its values differ by up to {_share(largest)}, {_share(mean)} in the mean"
                findings.append(LOST.at(place, message, "Look at both, by mrm render, before relying on it."))
    return findings


def _share(value: float) -> str:
    return f"{100.0 * value:.3g} %"
