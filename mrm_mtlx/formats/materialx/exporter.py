"""A document as MaterialX's own XML, with the files that it names."""

from __future__ import annotations

import re
from html import unescape
from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.documents.filenames import rename_files
from mrm_mtlx.documents.files import read_regular
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.files import name_beside
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.system.writing import FileSet

# How MaterialX writes a file's name.
_FILES = re.compile('type="filename" value="([^"]*)"')
# What texts of other formats may hold, and XML 1.0 may not (section 2.2), not even as a reference.
_CONTROLS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f]")


def write(source: Document, path: Path, library: DataLibrary, files: FileSet) -> list[Finding]:
    """Write a document without its data library, into a set of files; see `formats.format`.

    Names of files are those of `name_beside`.
    """
    del library
    document = source.materialx.copy()
    rename_files(document, lambda name: name_beside(name, source, path, files))
    lost = [found for element in document.traverseTree() for found in _without_controls(element)]
    files.named(path).write_text(mx.writeToXmlString(document), encoding="utf-8")
    return lost


def names(path: Path) -> list[str]:
    """Names of files in a document, as `write` has them."""
    content = read_regular(path, MAXIMUM_DOCUMENT_BYTES) or b""
    return [unescape(name) for name in set(_FILES.findall(content.decode("utf-8", "replace")))]


def _without_controls(element: mx.Element) -> Iterator[Finding]:
    """Leave out what XML cannot hold of an element's attributes, and say so of each."""
    for name in element.getAttributeNames():
        text = element.getAttribute(name)
        if _CONTROLS.search(text):
            element.setAttribute(name, _CONTROLS.sub("", text))
            message = f"its {name} has control characters, which XML cannot hold; they are left out"
            yield rules.INTERCHANGE_LOST.at(f"/{element.getNamePath()}", message)
