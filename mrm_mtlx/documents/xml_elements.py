"""Beginnings of the elements of an XML file, by the names that MaterialX gives them."""

from __future__ import annotations

import contextlib
import re
from array import array
from xml.parsers import expat

from mrm_mtlx.documents.text_positions import Position, TextPositions

# What includes another file, of which MaterialX makes no element.
_INCLUSION = ("xi:include",)
# What MaterialX makes "_" of in a name that it finds itself.
_INVALID = re.compile(r"[^A-Za-z0-9_:]")
# Bytes that are looked at at once in search of the end of a tag.
_STEP = 4096


class XmlElements:
    """The elements of one file in its order, as `xml_scan` meets them; an element is known by its number.

    A file may have a million of them, of which as many are asked for as there are findings. So little is kept of each,
    and names are put in order when the first is asked for.

    Parameters
    ----------
    content
        The file, without a byte order mark.
    mark
        A sign that stands in it for "<" in values of attributes, see `xml_scan`.
    """

    ROOT = 0

    def __init__(self, content: bytes, mark: str = "") -> None:
        self._content, self._mark = content, mark
        self._positions = TextPositions(content)
        self._parents = array("l")
        self._offsets = array("l")
        # The name; of an element without one, its tag in a tuple.
        self._names: list[str | tuple[str]] = []
        self._children: dict[tuple[int, str], int | None] = {}

    def add(self, parent: int, name: str | tuple[str], offset: int) -> int:
        """Note an element whose tag begins at a byte, and return its number; the first is the root.

        Of an element without a name, it is the tag, in a tuple.
        """
        self._parents.append(parent)
        self._offsets.append(offset)
        self._names.append(name)
        return len(self._names) - 1

    def path(self, number: int) -> str:
        """Path of an element, "graph/node", with tags in place of names that are not there."""
        names: list[str] = []
        while number != self.ROOT:
            name = self._names[number]
            names.append(name if isinstance(name, str) else name[0])
            number = self._parents[number]
        return "/".join(reversed(names))

    def child(self, parent: int, name: str) -> int | None:
        """The child that has a name in a document; None if there is none, or if the name is not clear in a path."""
        if not self._children:
            self._put_in_order()
        return self._children.get((parent, name))

    def position(self, number: int) -> Position:
        """The beginning of an element's tag."""
        return self._positions.at(self._offsets[number])

    def tag(self, number: int) -> tuple[str, dict[str, str]]:
        """The tag of an element, and its attributes."""
        found: list[tuple[str, dict[str, str]]] = []
        parser = expat.ParserCreate("utf-8")
        parser.StartElementHandler = lambda *tag: found.append(tag)
        start = self._offsets[number]
        with contextlib.suppress(expat.ExpatError):  # of what follows an element without children
            for at in range(start, len(self._content), _STEP):
                parser.Parse(self._content[at : at + _STEP])
                if found:
                    break
        tag, attributes = found[0]
        if self._mark:
            attributes = {name: value.replace(self._mark, "<") for name, value in attributes.items()}
        return tag, attributes

    def _put_in_order(self) -> None:
        """Find the names as MaterialX does: the first of several has it, and an element without gets one by its tag."""
        children = self._children
        last: dict[tuple[int, str], str] = {}
        for number in range(1, len(self._names)):
            parent, name = self._parents[number], self._names[number]
            if name == _INCLUSION or (parent, name) in children:
                continue  # and nothing leads to what is inside
            if isinstance(name, tuple):
                name = last[parent, name[0]] = self._free_name(parent, name[0], last.get((parent, name[0]), ""))
            children[parent, name] = number
        for parent, name in [key for key in children if "/" in key[1]]:  # another element may have the same path
            children[parent, name.partition("/")[0]] = None

    def _free_name(self, parent: int, tag: str, last: str) -> str:
        """The name that an element gets for its tag; `last` is that of the one before it."""
        name = last or _INVALID.sub("_", f"{tag}1")
        while (parent, name) in self._children:
            stem = name.rstrip("0123456789")
            name = f"{stem}{int(name[len(stem) :]) + 1}"
        return name
