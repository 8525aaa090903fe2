"""Names of files in a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx

if TYPE_CHECKING:
    from collections.abc import Callable


def filenames(document: mx.Document) -> list[tuple[Any, str]]:
    """The document's own elements that name a file, and the names as generators resolve them: with prefixes."""
    elements = (e for e in document.traverseTree() if e.isA(mx.ValueElement) and e.getType() == "filename")
    return [(element, str(element.getResolvedValueString())) for element in elements if element.getValueString()]


def rename_files(document: mx.Document, renamed: Callable[[str], str]) -> None:
    """Give every file in a document the name that a function has for its old one, in full: prefixes are removed."""
    found = filenames(document)
    for element in (document, *document.traverseTree()):
        element.removeAttribute("fileprefix")
    for element, name in found:
        element.setValueString(renamed(name))
