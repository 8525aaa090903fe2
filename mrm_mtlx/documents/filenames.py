"""Names of files in a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.files import names_nothing

if TYPE_CHECKING:
    from collections.abc import Callable


def filename_of(element: Any) -> str:
    """The file that an element's value names, with prefixes, as generators resolve it; "" for none."""
    if element.getType() != "filename" or not element.hasAttribute("value"):
        return ""
    name = str(element.getResolvedValueString())
    return "" if names_nothing(name) else name


def filenames(document: mx.Document) -> list[tuple[Any, str]]:
    """The document's own elements that name a file, and these names."""
    elements = (element for element in document.traverseTree() if element.isA(mx.ValueElement))
    return [(element, name) for element in elements if (name := filename_of(element))]


def rename_files(document: mx.Document, renamed: Callable[[str], str]) -> None:
    """Give every file in a document the name that a function has for its old one, in full: prefixes are removed."""
    found = filenames(document)
    for element in (document, *document.traverseTree()):
        element.removeAttribute("fileprefix")
    for element, name in found:
        element.setValueString(renamed(name))
