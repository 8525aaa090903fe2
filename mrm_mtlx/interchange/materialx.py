"""Writing a document as MaterialX's own XML. Reading one is `validation.reading`, which checks it on the way."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.library.files import replacing, resolve_inside

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.interchange.imported import Imported, Remark
    from mrm_mtlx.library import DataLibrary


def write(source: Imported, path: Path, library: DataLibrary) -> list[Remark]:
    """Write a document without its data library; see `interchange.formats`.

    Names of files are written relative to `path`. Files that were inside of the source, as in a package, are copied
    into a folder beside `path` that has its stem as name.
    """
    del library
    document = source.document.copy()
    files = [e for e in document.traverseTree() if e.isA(mx.ValueElement) and e.getType() == "filename"]
    names = [(element, element.getResolvedValueString()) for element in files if element.getValueString()]
    for element in (document, *document.traverseTree()):
        element.removeAttribute("fileprefix")
    for element, name in names:
        element.setValueString(_anchored(name, source, path))
    with replacing(path) as unfinished:
        unfinished.write_text(mx.writeToXmlString(document), encoding="utf-8")
    return []


def _anchored(name: str, source: Imported, path: Path) -> str:
    """A file's name as seen from the folder of `path`."""
    target = resolve_inside(name, source.folder, source.root)
    if target is None:  # a checked document has none
        return name
    if source.packed and target.is_file():
        folder = path.parent / path.stem
        folder.mkdir(exist_ok=True)
        target = shutil.copyfile(target, folder / target.name).resolve()
    return os.path.relpath(target, path.parent.resolve()).replace(os.sep, "/")
