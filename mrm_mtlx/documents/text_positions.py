"""Lines and columns of places in a text that is known by its bytes."""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

# Bytes between places whose position is kept: what has to be counted for another one, however long the lines are.
_STEP = 1 << 16
# Bytes of UTF-8 that begin no character.
_FOLLOWING = bytes(range(0x80, 0xC0))


class Position(NamedTuple):
    """A line and a column, both counted from 1; columns count characters, not bytes."""

    line: int
    column: int


class TextPositions:
    """Positions in a text of UTF-8 without a byte order mark.

    A line ends with CR, LF, or both in this order (XML 1.0, section 2.11).
    """

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._steps: list[Position] = []

    def at(self, offset: int) -> Position:
        """The position of the character that begins at a byte."""
        if not self._steps:
            parts = (self._part(start, start + _STEP) for start in range(0, len(self._content), _STEP))
            self._steps = list(accumulate(parts, _behind, initial=Position(1, 1)))
        step = offset // _STEP
        return _behind(self._steps[step], self._part(step * _STEP, offset))

    def _part(self, start: int, stop: int) -> bytes:
        """Bytes of the text, without the second half of a line's end that begins before."""
        cut = start > 0 and self._content[start - 1 : start + 1] == b"\r\n"
        return self._content[start + cut : stop]


def _behind(start: Position, text: bytes) -> Position:
    """The position behind a text that begins at another."""
    ends = text.count(b"\n") + text.count(b"\r") - text.count(b"\r\n")
    last = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
    characters = len(text[last:].translate(None, _FOLLOWING))
    return Position(start.line + ends, characters + (1 if ends else start.column))
