"""Reader of the text format of ALTA, the library for analysing BRDFs.

    #SAMPLE "yellow tape"
    #DIM 3 1
    #VS 0
    #PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI
    #PARAM_OUT INV_STERADIAN_COSINE_FACTOR
    0.2618 -1.5184 0.0 0.0036

Lines that begin with `#` are the header; every other line is a sample: coordinates, then channels. `DIM` has the number
of each, `VS` whether uncertainties follow, `PARAM_IN` what the coordinates mean, `PARAM_OUT` what the channels mean.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.measured.measurement import GRAZING, Measurement
from mrm_mtlx.measured.text import MAXIMUM_BYTES, MAXIMUM_SAMPLES, LineError, finite, lines, located, opened, shown

if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO

    from mrm_mtlx.bsdf.arrays import Array

# (theta_l, theta_v cos(dphi), theta_v sin(dphi)) [rad].
PARAM_IN = "ISOTROPIC_TL_TV_PROJ_DPHI"
COORDINATES = 3
# What the values are: whether they have the cosine of theta_l in them.
PARAM_OUT = {"INV_STERADIAN": False, "INV_STERADIAN_COSINE_FACTOR": True}

MAXIMUM_CHANNELS = 64

# How far beyond the horizon a rounded theta_v may be [rad].
_ROUNDED = 1e-4


def read_alta(path: Path) -> Measurement:
    """Read an isotropic BRDF in ALTA's text format.

    Parameters
    ----------
    path
        A regular file.

    Returns
    -------
    Measurement
        Its samples in the order of the file; f in 1/sr, the cosine of theta_l divided out where the file has it in.

    Raises
    ------
    ValueError
        With the name of the file and the line, if the file is none of this format, is in a parametrisation or unit that
        is not read, has a value that is no finite number, negative or out of range, or is larger than the bounds above.
    OSError
        If the file cannot be opened.
    """
    with opened(path, MAXIMUM_BYTES) as stream, located(path):
        return _measurement(stream)


def _measurement(stream: BinaryIO) -> Measurement:
    header: dict[str, str] = {}
    rows: list[list[float]] = []
    columns = 0
    for number, text in lines(stream):
        if text.startswith("#"):
            key, _, value = text[1:].strip().partition(" ")
            if rows and key in ("DIM", "VS", "PARAM_IN", "PARAM_OUT"):
                raise LineError(number, f"'#{key}' after the first sample; the header comes first")
            header[key] = value.strip()
            continue
        if not rows:
            columns = _columns(header, number)
        if len(rows) == MAXIMUM_SAMPLES:
            raise LineError(number, f"more than the {MAXIMUM_SAMPLES} samples that are read")
        row = _numbers(text, number, columns)
        _check(row, number)
        rows.append(row)
    if not rows:
        raise LineError(0, "it has no samples; expected the header and lines of numbers of ALTA's text format")
    return _converted(np.array(rows), header)


def _columns(header: dict[str, str], line: int) -> int:
    """Numbers per sample, from a header that is complete and of the kind that is read; `line` is where it ended."""
    for key in ("DIM", "PARAM_IN", "PARAM_OUT"):
        if key not in header:
            raise LineError(line, f"the first sample comes before a header line '#{key}'")
    if header["PARAM_IN"] != PARAM_IN:
        raise LineError(line, f"PARAM_IN is {shown(header['PARAM_IN'])}; what is read is {PARAM_IN}")
    if header["PARAM_OUT"] not in PARAM_OUT:
        raise LineError(line, f"PARAM_OUT is {shown(header['PARAM_OUT'])}; what is read is {', '.join(PARAM_OUT)}")
    if header.get("VS", "0").split() not in (["0"], []):
        raise LineError(line, f"VS is {shown(header['VS'])}: uncertainties of the values are not read, only VS 0")
    found = header["DIM"].split()
    if len(found) != 2 or not all(part.isascii() and part.isdigit() and len(part) < 5 for part in found):
        raise LineError(line, f"DIM is {shown(header['DIM'])}; expected the numbers of coordinates and of channels")
    coordinates, channels = map(int, found)
    if coordinates != COORDINATES or not 1 <= channels <= MAXIMUM_CHANNELS:
        expected = f"{COORDINATES} coordinates for {PARAM_IN}, and 1 to {MAXIMUM_CHANNELS} channels"
        raise LineError(line, f"DIM is {shown(header['DIM'])}; expected {expected}")
    return coordinates + channels


def _numbers(text: str, line: int, columns: int) -> list[float]:
    words = text.split()
    if len(words) != columns:
        raise LineError(line, f"{len(words)} columns, where DIM in the header says {columns}")
    return [finite(word, line) for word in words]


def _check(row: list[float], line: int) -> None:
    """True where a sample is above the horizon and not negative."""
    theta_l, theta_v = row[0], math.hypot(row[1], row[2])
    if not 0.0 <= theta_l <= math.pi / 2 - GRAZING:
        raise LineError(line, f"theta_l is {theta_l:g} rad; expected 0 to less than pi/2 (90 degrees)")
    if theta_v > math.pi / 2 + _ROUNDED:
        raise LineError(line, f"theta_v is {theta_v:g} rad; expected at most pi/2 (90 degrees)")
    if min(row[COORDINATES:]) < 0.0:
        raise LineError(line, f"the value {min(row[COORDINATES:]):g} is negative; a BRDF is not")


def _converted(rows: Array, header: dict[str, str]) -> Measurement:
    theta_l, x, y = rows[:, :COORDINATES].T
    f = rows[:, COORDINATES:]
    had_cosine = PARAM_OUT[header["PARAM_OUT"]]
    if had_cosine:
        f = f / np.cos(theta_l)[:, None]
    name = header.get("SAMPLE", "").strip('"')
    return Measurement(name, theta_l, np.minimum(np.hypot(x, y), np.pi / 2), np.arctan2(y, x), f, had_cosine)
