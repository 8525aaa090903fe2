"""Reading of data files that others wrote: bounded, and with the place of what is wrong."""

from __future__ import annotations

import math
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from mrm_mtlx.system import text

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from typing import BinaryIO

# Longest line that is read: measured data have some 150 characters.
MAXIMUM_LINE = 4096

# Bounds of any such file: that of the measurement which the paper fits has 7,397 samples in 1 MiB.
MAXIMUM_BYTES = 64 * 2**20
MAXIMUM_SAMPLES = 1_000_000

# A word of the file in a message.
shown = partial(text.shown, most=40)


class LineError(Exception):
    """An error in the file, and its line, counted from 1; 0 is the whole file."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


@contextmanager
def opened(path: Path, maximum_bytes: int) -> Iterator[BinaryIO]:
    """A regular file that is not larger than this, open for reading.

    Raises
    ------
    ValueError
        With the name of the file, if it is something else, absent or larger.
    OSError
        If it cannot be opened.
    """
    if not path.is_file():  # a pipe or a device would never end
        msg = f"{path.name}: it does not exist, or is not a regular file"
        raise ValueError(msg)
    if path.stat().st_size > maximum_bytes:
        msg = f"{path.name}: larger than the {maximum_bytes // 2**20} MiB that are read"
        raise ValueError(msg)
    with path.open("rb") as stream:
        yield stream


@contextmanager
def located(path: Path) -> Iterator[None]:
    """Turns a `LineError` into a ValueError with the name of the file and the line."""
    try:
        yield
    except LineError as error:
        place = f" line {error.line}" if error.line else ""
        msg = f"{path.name}{place}: {error}"
        raise ValueError(msg) from None


def lines(stream: BinaryIO) -> Iterator[tuple[int, str]]:
    """Lines that are not empty, numbered from 1, without what surrounds them."""
    number = 0
    while line := stream.readline(MAXIMUM_LINE + 1):
        number += 1
        if len(line) > MAXIMUM_LINE:
            raise LineError(number, f"longer than the {MAXIMUM_LINE} characters that are read")
        try:
            # A file may begin with a mark of its encoding, which is no part of its first word.
            text = line.decode("utf-8-sig" if number == 1 else "utf-8").strip()
        except UnicodeDecodeError:
            raise LineError(number, "not UTF-8; expected a text file") from None
        if text:
            yield number, text


def finite(word: str, line: int) -> float:
    """The number that a word of the file is.

    Raises
    ------
    LineError
        If it is none, or not finite.
    """
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or "_" in word:  # Python's own numbers may have underscores
        raise LineError(line, f"{shown(word)} is no finite number")
    return number
