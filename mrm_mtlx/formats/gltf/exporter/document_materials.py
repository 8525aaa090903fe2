"""Writes the materials of a document as a glTF asset, reads them back, and says what they are apart."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
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
from mrm_mtlx.formats.gltf.options import GltfOptions
from mrm_mtlx.formats.pbr import comparison
from mrm_mtlx.formats.pbr.inputs import inputs_of
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.value_sources import resolved
from mrm_mtlx.reference import UnsupportedError
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.library import DataLibrary

DEFAULT = GltfOptions()


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


def write(
    source: Document, path: Path, library: DataLibrary, files: FileSet, options: GltfOptions = DEFAULT
) -> list[Finding]:
    """Write a document as .gltf or .glb, into a set of files; see `formats.format`.

    A material that glTF cannot say is left out. What was written is read back, and how far it is from the document is
    a finding where it is more than rounding.

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
    written: list[_Written] = []
    for element in renderable_elements(document):
        place = f"/{element.getNamePath()}"
        images.start_surface()
        try:
            inputs = inputs_of(element, images, exact=bool(options.exact))
            material = Material(element, inputs, asset, images)
        except InexpressibleError as error:
            findings.append(rules.INTERCHANGE_LEFT_OUT.at(place, f"glTF has no form for it: {error}"))
            continue
        findings += [LOST.at(f"{place}{where}", message) for where, message in material.losses]
        asset.materials.append(material.data)
        written.append(_Written(element, inputs.approximated, images))
    if not written:
        raise NothingToWriteError(findings)
    findings += _differences(written, asset, path, library)
    asset.save(path, files)
    return findings


class _Written(NamedTuple):
    """An element that was written, why it is an approximation, "" if it is none, and the pixels of its files."""

    element: Any
    approximated: str
    images: Images

    def compared(self, again: Any, found: Images, data: dict[str, Any]) -> Iterator[Finding]:
        """Findings about how far it is from the element that was read back."""
        self.images.start_surface()
        found.start_surface()
        pair = (self.element, self.images), (again, found)
        transmits = "KHR_materials_transmission" in data.get("extensions", {})
        try:
            apart = comparison.difference(*pair, transmits=transmits)
            if apart[0] > comparison.ROUNDING:
                yield self._told(comparison.told(apart, *(comparison.photometry(*each) for each in pair)))
        except ImagesTooLargeError as error:
            yield self._at(LOST, f"it was written and not compared: it has {error}")
        except (UnsupportedError, RecursionError) as error:
            yield self._at(LOST, f"it was written and not compared: {error}")

    def _told(self, difference: str) -> Finding:
        hint = "Look at both, by mrm render, before relying on it."
        if not self.approximated:
            return self._at(LOST, f"as glTF, {difference}", hint)
        message = f"glTF has no form for it: {self.approximated}; the nearest that it has is written, in which "
        return self._at(rules.INTERCHANGE_APPROXIMATED, message + difference, hint)

    def _at(self, rule: Rule, message: str, hint: str = "") -> Finding:
        return rule.at(f"/{self.element.getNamePath()}", message, hint)


def _differences(elements: list[_Written], asset: Asset, path: Path, library: DataLibrary) -> list[Finding]:
    """Findings about how far the asset's materials are from those that they were made of."""
    with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
        copy, scratch = Path(folder) / path.name, Path(folder) / "scratch"
        scratch.mkdir()
        with FileSet(Path(folder)) as files:
            asset.save(copy, files, beside=False)
        back = read(copy, Reach.beside(copy), library, scratch)
        found = Images(back, copy)
        all_of = zip(elements, renderable_elements(back.materialx), asset.materials, strict=True)
        return [each for one, again, data in all_of for each in one.compared(again, found, data)]
