"""Reading a file of measured data in whichever of the formats it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.measured.alta import read_alta
from mrm_mtlx.measured.merl import is_merl, read_merl
from mrm_mtlx.measured.table import is_table, read_table
from mrm_mtlx.measured.text import MAXIMUM_BYTES, opened
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.measured.measurement import CoefficientSamples, Measurement

# Bytes by which a format is told.
_HEAD = 4096
_ENDINGS: dict[str, Callable[[Path], Measurement | CoefficientSamples]] = {
    ".binary": read_merl,
    ".csv": read_table,
    ".alta": read_alta,
    ".dat": read_alta,
}


def read(path: Path) -> Measurement | CoefficientSamples:
    """Read measured data: MERL binary, ALTA text or a CSV table.

    What is in the file decides; where that says nothing, the ending of its name.

    Raises
    ------
    ValueError
        With the name of the file, if it is of none of the formats, or as its reader says.
    OSError
        If the file cannot be opened.
    """
    with opened(path, MAXIMUM_BYTES) as stream:
        head = stream.read(_HEAD)
    if is_merl(head):
        return read_merl(path)
    ending = _ENDINGS.get(path.suffix.lower())
    if b"\0" not in head:
        text = head.decode("utf-8", errors="replace")
        if any(line.startswith(("#DIM", "#PARAM_IN", "#PARAM_OUT")) for line in text_lines(text)):
            return read_alta(path)
        if is_table(text):
            return read_table(path)
    if ending is None:
        expected = "MERL binary (.binary), ALTA text (.alta, .dat) or a CSV table (.csv)"
        msg = f"{path.name}: its format is not known; expected {expected}"
        raise ValueError(msg)
    return ending(path)
