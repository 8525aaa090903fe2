"""Writing a document as MaterialX's own XML. Reading one is `validation.reading`, which checks it on the way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.interchange.files import name_beside
from mrm_mtlx.library.files import replacing

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.interchange.imported import Imported, Remark
    from mrm_mtlx.library import DataLibrary


def write(source: Imported, path: Path, library: DataLibrary) -> list[Remark]:
    """Write a document without its data library; see `interchange.formats`.

    Names of files are those of `name_beside`.
    """
    del library
    document = source.document.copy()
    files = [e for e in document.traverseTree() if e.isA(mx.ValueElement) and e.getType() == "filename"]
    names = [(element, element.getResolvedValueString()) for element in files if element.getValueString()]
    for element in (document, *document.traverseTree()):
        element.removeAttribute("fileprefix")
    for element, name in names:
        element.setValueString(name_beside(name, source, path))
    with replacing(path) as unfinished:
        unfinished.write_text(mx.writeToXmlString(document), encoding="utf-8")
    return []
