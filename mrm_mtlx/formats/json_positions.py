"""Positions of the values of a JSON text, by JSON pointer."""

from __future__ import annotations

import contextlib
import json
import re
from itertools import count
from json import JSONDecoder
from typing import TYPE_CHECKING, NamedTuple

from mrm_mtlx.documents.text_positions import Position, TextPositions
from mrm_mtlx.formats.json_text import pointer

if TYPE_CHECKING:
    from collections.abc import Iterator

_SPACE = re.compile(r"[ \t\n\r]*")
_COLON = re.compile(r"[ \t\n\r]*:[ \t\n\r]*")
_COMMA = re.compile(r"[ \t\n\r]*,?[ \t\n\r]*")


class Place(NamedTuple):
    """A value that is there: its pointer, and where it begins, which for one of an object is where its name does."""

    pointer: str
    position: Position


class JsonPositions:
    """The positions in a text that has been parsed before, see `json_text`.

    Python's parser has none. It is used here to skip what is not asked for: a value is looked into when a pointer leads
    there, once.
    """

    def __init__(self, content: bytes) -> None:
        # One character per byte, whatever the bytes mean: what JSON consists of is ASCII, and offsets are those of the
        # file then.
        self._text = content.decode("latin-1")
        self._positions = TextPositions(content)
        self._members: dict[int, dict[str, tuple[int, int]]] = {}

    def nearest(self, wanted: str) -> Place:
        """The value that a pointer leads to, or else the nearest around it that is there."""
        begin = value = _behind(_SPACE, self._text, 0)
        keys = []
        for part in wanted.split("/")[1:]:
            key = part.replace("~1", "/").replace("~0", "~")
            if key not in self._members_of(value):
                break
            begin, value = self._members_of(value)[key]
            keys.append(key)
        return Place(pointer(*keys), self._positions.at(begin))

    def _members_of(self, value: int) -> dict[str, tuple[int, int]]:
        """The beginnings of each member of an object or array and of its value; of the one that begins at `value`."""
        if value not in self._members:
            self._members[value] = {}
            with contextlib.suppress(RecursionError):  # where the text was parsed, the stack may have had more room
                self._members[value] |= self._scan(value)
        return self._members[value]

    def _scan(self, value: int) -> Iterator[tuple[str, tuple[int, int]]]:
        text, at, decoder = self._text, _behind(_SPACE, self._text, value + 1), JSONDecoder()
        if text[value] not in "{[":
            return
        for index in count():
            if text[at] in "}]":
                return
            begin, name = at, str(index)
            if text[value] == "{":
                _, end = decoder.raw_decode(text, at)
                name = json.loads(text[at:end].encode("latin-1"))
                at = _behind(_COLON, text, end)
            yield name, (begin, at)
            _, end = decoder.raw_decode(text, at)
            at = _behind(_COMMA, text, end)


def _behind(pattern: re.Pattern[str], text: str, at: int) -> int:
    """The end of a match that begins at a place."""
    found = pattern.match(text, at)
    return at if found is None else found.end()
