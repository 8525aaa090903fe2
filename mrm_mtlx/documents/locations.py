"""Source locations of the elements of a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from mrm_mtlx.findings.source_location import SourceLocation

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import MaterialX as mx

    from mrm_mtlx.documents.xml_elements import XmlElements

# Elements that have a value or a connection, and what says it. In the file, a "parameter" is what is an input now.
_PORTS = ("input", "output", "parameter", "token")
_CONTENT = ("value", "nodename", "nodegraph", "interfacename")


class Locations(Protocol):
    """Source locations of the elements of a file, by their place there: a path, a JSON pointer, a prim path."""

    def of(self, place: str) -> SourceLocation:
        """The location of an element, or else of its nearest parent that is known, or else of the file."""


class WholeFile:
    """The location of which no more than the file is known."""

    def __init__(self, file: str) -> None:
        self._file = file

    def of(self, place: str) -> SourceLocation:
        """The file."""
        del place
        return SourceLocation(self._file)


class XmlLocations:
    """Source locations of the elements of a document, and of the documents that it includes.

    MaterialX changes documents of earlier versions while it reads them: elements get other names, and sometimes each
    other's. Whatever is not as it stands in the file has the location of its parent.

    Parameters
    ----------
    document
        The document, of whose elements each knows its file.
    file
        The path of the document as findings show it.
    elements
        By the path of each file: that path as findings show it, and the elements in it.
    """

    def __init__(self, document: mx.Document, file: str, elements: Mapping[str, tuple[str, XmlElements]]) -> None:
        self._document, self._file, self._elements = document, file, elements

    def of(self, place: str) -> SourceLocation:
        """The location of the element with a path, "/graph/node"."""
        names = place.removeprefix("/").split("/")
        element = self._document.getChild(names[0]) if names[0] else None
        uri = "" if element is None else element.getActiveSourceUri()
        if uri not in self._elements:
            return SourceLocation(self._file)
        file, elements = self._elements[uri]
        number = _nearest(elements, element, _top_level(elements, element), names[1:])
        return SourceLocation(file, *(() if number is None else elements.position(number)))


def _nearest(elements: XmlElements, element: Any, number: int | None, names: Sequence[str]) -> int | None:
    """The location of the element that names lead to from one of its parents, or else of the nearest parent.

    `element` and `number` are the parent in the document and in the file; None if the file has not even that.
    """
    if element is None or number is None or not _is_as_in_file(element, *elements.tag(number)):
        return None
    if names:
        below = _nearest(elements, element.getChild(names[0]), elements.child(number, names[0]), names[1:])
        if below is not None:
            return below
    return number


def _top_level(elements: XmlElements, element: Any) -> int | None:
    """An element of a document in the file that it comes from, where its namespace is not part of its name."""
    name, namespace = element.getName(), f"{element.getNamespace()}:"
    names = {name, name.removeprefix(namespace)}
    found = [number for name in names if (number := elements.child(elements.ROOT, name)) is not None]
    return found[0] if len(found) == 1 else None


def _is_as_in_file(element: Any, tag: str, attributes: Mapping[str, str]) -> bool:
    """True if an element of a document is the one that a file has under its path."""
    if element.getCategory() not in _PORTS:
        return tag not in _PORTS
    return tag in _PORTS and all(element.getAttribute(name) == attributes.get(name, "") for name in _CONTENT)
