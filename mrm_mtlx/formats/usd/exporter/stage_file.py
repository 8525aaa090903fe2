"""A document's materials as a file of USD: text, crate, or a package with its images."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from pxr import Sdf, Tf, UsdUtils

from mrm_mtlx.formats.files import name_beside
from mrm_mtlx.formats.usd.exporter.material_prims import write_materials
from mrm_mtlx.formats.usd.exporter.preview import Previews
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.formats.usd.opening.layers import open_layer
from mrm_mtlx.formats.usd.options import UsdOptions
from mrm_mtlx.system.console import silenced
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary

DEFAULT = UsdOptions()
# Files in a package begin at multiples of this, so that they can be mapped into memory (USDZ specification).
ALIGNMENT = 64
# Length of a file's header in a package without its name, and of that of a header's extra field (ZIP, APPNOTE 4.3.7).
_HEADER, _EXTRA_HEADER = 30, 4
# Of the extra field that fills up a header; USD's own packages use the same number.
_EXTRA_ID = 0x1986


def write(
    source: Document, path: Path, library: DataLibrary, files: FileSet, options: UsdOptions = DEFAULT
) -> list[Finding]:
    """Write the materials of a document as `path`, into a set of files; see `formats.format`."""
    del library  # the document's own is set
    if path.suffix.lower() == ".usdz":
        return _package(source, path.stem, files.named(path), options)
    return _layer(source, path, files, options)


def names(path: Path) -> list[str]:
    """Names of files in a layer, as `write` has them.

    Raises
    ------
    ReadError
        If it is none.
    """
    if path.suffix.lower() == ".usdz":
        return []
    with silenced():
        layer = open_layer(path, "").layer
        found: list[str] = []

        def look(at: Sdf.Path) -> None:
            spec = layer.GetAttributeAtPath(at) if at.IsPropertyPath() else None
            if spec is not None and isinstance(spec.default, Sdf.AssetPath):
                found.append(str(spec.default.path))

        layer.Traverse(Sdf.Path.absoluteRootPath, look)
    return found


def _layer(source: Document, path: Path, files: FileSet, options: UsdOptions) -> list[Finding]:
    """Write a layer that is to stand at `path`."""
    unfinished = files.named(path)

    def anchored(name: str) -> str:
        beside = name_beside(name, source, path, files)
        return beside if beside.startswith("../") else f"./{beside}"

    layer = Sdf.Layer.CreateAnonymous(unfinished.suffix)
    previews = Previews(source.original or source.materialx, source.reach, anchored)
    add_look = {"add_look": previews.add} if options.has_preview else {}
    try:
        findings = write_materials(source.materialx, layer, anchored, **add_look) + previews.findings
    except Tf.ErrorException as error:
        msg = f"USD cannot hold it: {said(error)}"
        raise ValueError(msg) from error
    try:
        layer.Export(str(unfinished))
    except Tf.ErrorException as error:
        raise OSError(0, said(error)) from error
    return findings


def _package(source: Document, name: str, unfinished: Path, options: UsdOptions) -> list[Finding]:
    """Write a package: USD gathers the images, and what it wrote is stored again without the time of writing."""
    with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
        layer, gathered = Path(folder, f"{name}.usdc"), Path(folder, "gathered.usdz")
        with FileSet(Path(folder)) as files:
            findings = _layer(source, layer, files, options)
        with silenced():
            made = UsdUtils.CreateNewUsdzPackage(str(layer), str(gathered))
        if not made:
            raise OSError(0, "USD cannot make the package; is an image missing?")
        # USD's names are UTF-8 and do not say so.
        with (
            zipfile.ZipFile(gathered, metadata_encoding="utf-8") as found,
            zipfile.ZipFile(unfinished, "w") as package,
        ):
            position = 0
            for entry in found.infolist():
                position = _store(package, entry.filename, found.read(entry), position)
    return findings


def _store(package: zipfile.ZipFile, name: str, content: bytes, position: int) -> int:
    """Add a file at the next multiple of `ALIGNMENT`, uncompressed, of no date; return the position behind it."""
    entry = zipfile.ZipInfo(name)
    start = position + _HEADER + len(name.encode()) + _EXTRA_HEADER
    padding = -start % ALIGNMENT
    entry.extra = _EXTRA_ID.to_bytes(2, "little") + padding.to_bytes(2, "little") + bytes(padding)
    package.writestr(entry, content)
    return start + padding + len(content)
