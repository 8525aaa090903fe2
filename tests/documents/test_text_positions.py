"""Lines and columns of bytes in a text, against counting its characters one by one."""

from __future__ import annotations

import pytest

from mrm_mtlx.documents import text_positions
from mrm_mtlx.documents.text_positions import TextPositions


def counted(content: bytes, offset: int) -> tuple[int, int]:
    """The position of a byte by the characters before it."""
    line, column, text = 1, 1, content[:offset].decode()
    for at, character in enumerate(text):
        is_first_half = character == "\r" and content[offset : offset + 1] == b"\n" and at == len(text) - 1
        if character == "\n" or (character == "\r" and text[at + 1 : at + 2] != "\n" and not is_first_half):
            line, column = line + 1, 1
        else:
            column += 1
    return line, column


TEXTS = {
    "Unix": "one\ntwo\n\nfour",
    "Windows": "one\r\ntwo\r\n\r\nfour",
    "old Mac": "one\rtwo\r\rfour",
    "mixed": "\r\n\n\r\r\n.\n\r",
    "tabs": "\tone\n\t\ttwo",
    "characters of many bytes": "ä€\U0001f6a7x\n\U0001f6a7€äx",
    "one line": "x" * 100,
    "empty lines": "\n" * 100,
}


@pytest.mark.parametrize("step", [1, 2, 3, 7, 1 << 16])
@pytest.mark.parametrize("name", TEXTS)
def test_every_character_is_where_counting_puts_it(monkeypatch, name, step):
    monkeypatch.setattr(text_positions, "_STEP", step)
    content = TEXTS[name].encode()
    positions = TextPositions(content)
    starts = [at for at in range(len(content)) if content[at] & 0xC0 != 0x80]
    starts = [at for at in starts if content[at - 1 : at + 1] != b"\r\n"]  # within the end of a line
    assert [positions.at(at) for at in starts] == [counted(content, at) for at in starts]


def test_a_long_line_takes_no_longer_than_short_ones(monkeypatch):
    content = b"x" * (4 << 20)
    positions = TextPositions(content)
    positions.at(0)
    taken = []
    behind = text_positions._behind
    monkeypatch.setattr(text_positions, "_behind", lambda start, text: taken.append(len(text)) or behind(start, text))
    assert positions.at(len(content) - 1) == (1, len(content))
    assert sum(taken) <= text_positions._STEP
