"""Reader of tables: CSV with named columns, whose names end in their units.

    # name: yellow tape
    theta_l_deg, theta_v_deg, dphi_deg, f_per_sr
    15, 14, 0, 9.8

or

    observation_deg, entrance_deg, ra_cd_per_lx_m2
    0.2, -4, 250

Lines that begin with `#` are comments; `# name: ...` names what was measured. The first other line has the names, in
any order, with commas or semicolons between; every further line is a sample, separated in the same way. Between
semicolons numbers may have a decimal comma, as spreadsheets write them in much of Europe; then all of them have it that
have decimals. `COLUMNS` has the names and their units. A table has
either BRDF samples (theta_l, theta_v, dphi, values) or coefficients of retroreflection (observation, entrance, value).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mrm_mtlx.measured.measurement import GRAZING, CoefficientSamples, Measurement
from mrm_mtlx.measured.text import MAXIMUM_BYTES, MAXIMUM_SAMPLES, LineError, finite, lines, located, opened, shown
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO

    from mrm_mtlx.bsdf.arrays import Array

_ANGLE = {"deg": math.pi / 180.0, "rad": 1.0}
_BRDF = {"per_sr": 1.0}
# By quantity, its units and the factor of each that leads to the unit inside: rad, 1/sr, cd/(lx m^2), cd/(lx m^2).
# `f_cos_l` has the cosine of theta_l in it; `f_r` and so on are channels.
COLUMNS: dict[str, dict[str, float]] = {
    "theta_l": _ANGLE,
    "theta_v": _ANGLE,
    "dphi": _ANGLE,
    **dict.fromkeys(("f", "f_r", "f_g", "f_b", "f_cos_l", "f_cos_l_r", "f_cos_l_g", "f_cos_l_b"), _BRDF),
    "observation": _ANGLE,
    "entrance": _ANGLE,
    "entrance2": _ANGLE,
    "ra": {"cd_per_lx_m2": 1.0, "mcd_per_lx_m2": 1e-3},
    "rl": {"cd_per_lx_m2": 1.0, "mcd_per_lx_m2": 1e-3},
}
_DIRECTIONS = ("theta_l", "theta_v", "dphi")
_GEOMETRY = ("observation", "entrance")
# The columns of values that belong together.
_VALUES = (("f",), ("f_r", "f_g", "f_b"), ("f_cos_l",), ("f_cos_l_r", "f_cos_l_g", "f_cos_l_b"))

SEPARATORS = (",", ";")
# Of coefficients, all are fitted and all are drawn; a goniometer's whole table has some thousands.
MAXIMUM_COEFFICIENTS = 20_000


class _Form:
    """The marks of a table's cells, as far as they are known from the lines that were read.

    Attributes
    ----------
    separator
        A comma or a semicolon, as the line of names has it.
    marks
        By decimal mark, the first line that has it.
    """

    def __init__(self, separator: str) -> None:
        self.separator = separator
        self.marks: dict[str, int] = {}

    @classmethod
    def of(cls, names: str, line: int) -> _Form:
        """The form of the table whose columns have these names.

        Raises
        ------
        LineError
            If nothing separates the names, or both characters do.
        """
        found = [separator for separator in SEPARATORS if separator in names]
        if len(found) == 1:
            return cls(found[0])
        problem = "has both commas and semicolons" if found else "has no comma or semicolon"
        raise LineError(line, f"{shown(names)} {problem}; expected names of columns, separated by one of them")

    def cells(self, text: str) -> list[str]:
        """The cells of a line."""
        return [word.strip() for word in text.split(self.separator)]

    def number(self, word: str, line: int) -> float:
        """The number of a cell.

        Raises
        ------
        LineError
            If it is none, or not finite, or if other cells have another decimal mark.
        """
        if self.separator == ";":
            for mark in ".,":
                if mark in word:
                    self.marks.setdefault(mark, line)
            if len(self.marks) > 1:
                where = f"a decimal point in line {self.marks['.']} and a decimal comma in line {self.marks[',']}"
                raise LineError(line, f"{shown(word)}: {where}; expected one of them, and no mark between thousands")
            if word.count(",") == 1:
                word = word.replace(",", ".")
        return finite(word, line)


class _Column(NamedTuple):
    quantity: str
    factor: float
    title: str


def read_table(path: Path) -> Measurement | CoefficientSamples:
    """Read a CSV table of BRDF samples or of coefficients of retroreflection.

    Parameters
    ----------
    path
        A regular file.

    Returns
    -------
    Measurement or CoefficientSamples
        Its samples in the order of the file. R_L is converted: R_A = R_L cos(nu), nu between n and v.

    Raises
    ------
    ValueError
        With the name of the file and the line, if a column or unit is unknown, missing or there twice, or if a value is
        no finite number, negative or out of range.
    OSError
        If the file cannot be opened.
    """
    with opened(path, MAXIMUM_BYTES) as stream, located(path):
        return _table(stream, path.stem)


def is_table(head: str) -> bool:
    """True if the first line of a file that is no comment looks like names of columns."""
    for line in text_lines(head):
        if line.strip() and not line.lstrip("\ufeff").startswith("#"):
            return any(letter.isalpha() for letter in line) and any(each in line for each in SEPARATORS)
    return False


def _table(stream: BinaryIO, name: str) -> Measurement | CoefficientSamples:
    columns: list[_Column] = []
    form = _Form(",")
    header = 0
    rows: list[list[float]] = []
    places: list[int] = []
    for number, text in lines(stream):
        if text.startswith("#"):
            key, colon, value = text[1:].partition(":")
            name = value.strip() if colon and key.strip() == "name" else name
        elif not columns:
            form = _Form.of(text, number)
            columns, header = _header(form.cells(text), number), number
        elif len(rows) == (most := _most(columns)):
            raise LineError(number, f"more than the {most} samples that are read")
        else:
            rows.append(_row(text, number, columns, form))
            places.append(number)
    if not columns:
        raise LineError(
            0, "it has no line with names of columns, such as 'theta_l_deg, theta_v_deg, dphi_deg, f_per_sr'"
        )
    if not rows:
        raise LineError(header, "no samples follow the names of the columns")
    values = {column.quantity: np.array(row) for column, row in zip(columns, zip(*rows, strict=True), strict=True)}
    titles = {column.quantity: column.title for column in columns}
    table = _Table(values, titles, places)
    return _brdf(table, name) if "theta_l" in values else _coefficients(table, name)


def _most(columns: list[_Column]) -> int:
    """Rows that are read."""
    of_geometry = any(column.quantity in _GEOMETRY for column in columns)
    return MAXIMUM_COEFFICIENTS if of_geometry else MAXIMUM_SAMPLES


class _Table(NamedTuple):
    """Columns by quantity in the units inside, what they are called in the file, and the line of each row."""

    values: dict[str, Array]
    titles: dict[str, str]
    places: list[int]

    def check(self, quantity: str, lowest: float, highest: float, expected: str) -> None:
        """True if a column is within bounds."""
        column = self.values[quantity]
        wrong = np.flatnonzero((column < lowest) | (column > highest))
        if len(wrong):
            found = column[wrong[0]] / _factor(self.titles[quantity], quantity)
            raise LineError(self.places[wrong[0]], f"{self.titles[quantity]} is {found:g}; expected {expected}")


def _factor(title: str, quantity: str) -> float:
    return COLUMNS[quantity][title[len(quantity) + 1 :]]


def _header(titles: list[str], line: int) -> list[_Column]:
    columns = [_column(title, i, line) for i, title in enumerate(titles, start=1)]
    quantities = [column.quantity for column in columns]
    for quantity in quantities:
        if quantities.count(quantity) > 1:
            raise LineError(line, f"{shown(quantity)} stands in two columns")
    brdf, coefficients = (any(q in quantities for q in group) for group in (_DIRECTIONS, (*_GEOMETRY, "entrance2")))
    if brdf and coefficients:
        raise LineError(
            line, "columns of a BRDF (theta_l ...) and of coefficients (observation ...); expected one kind"
        )
    needed = _GEOMETRY if coefficients else _DIRECTIONS
    missing = [q for q in needed if q not in quantities]
    if missing:
        names = ", ".join(_spelling(q) for q in missing)
        raise LineError(line, f"no column {names}; found {shown(', '.join(c.title for c in columns))}")
    groups: tuple[tuple[str, ...], ...] = (("ra",), ("rl",)) if coefficients else _VALUES
    values = tuple(q for q in quantities if q not in (*_DIRECTIONS, *_GEOMETRY, "entrance2"))
    if not any(sorted(values) == sorted(group) for group in groups):
        expected = " or ".join(" and ".join(f"{q}_{next(iter(COLUMNS[q]))}" for q in group) for group in groups)
        raise LineError(line, f"columns of values {shown(', '.join(values) or 'none')}; expected {expected}")
    return columns


def _column(title: str, number: int, line: int) -> _Column:
    # The longest name first: f_cos_l_r_per_sr is no unit of f.
    for quantity in sorted(COLUMNS, key=len, reverse=True):
        if title == quantity or title.startswith(f"{quantity}_"):
            unit = title[len(quantity) + 1 :]
            if unit in COLUMNS[quantity]:
                return _Column(quantity, COLUMNS[quantity][unit], title)
            found = f"the unit {shown(unit)}" if unit else "no unit"
            raise LineError(line, f"column {number}, {shown(title)}, has {found}; expected {_spelling(quantity)}")
    known = ", ".join(COLUMNS)
    raise LineError(line, f"column {number} is {shown(title)}; expected one of {known}, each with its unit")


def _spelling(quantity: str) -> str:
    return " or ".join(f"{quantity}_{unit}" for unit in COLUMNS[quantity])


def _row(text: str, line: int, columns: list[_Column], form: _Form) -> list[float]:
    words = form.cells(text)
    if len(words) != len(columns):
        is_split = form.separator == "," and len(words) > len(columns)
        hint = "; with decimal commas, separate columns by semicolons" if is_split else ""
        raise LineError(line, f"{len(words)} columns, where the line of names has {len(columns)}{hint}")
    return [form.number(word, line) * column.factor for word, column in zip(words, columns, strict=True)]


def _brdf(table: _Table, name: str) -> Measurement:
    quarter = np.pi / 2
    table.check("theta_l", 0.0, quarter - GRAZING, "0 to less than 90 degrees")
    table.check("theta_v", 0.0, quarter, "0 to 90 degrees; the side goes into dphi (0 is that of the light)")
    table.check("dphi", -2.0 * np.pi, 2.0 * np.pi, "-360 to 360 degrees")
    channels = next(group for group in _VALUES if group[0] in table.values)
    for channel in channels:
        table.check(channel, 0.0, np.inf, "0 or more; a BRDF is not negative")
    theta_l, theta_v, dphi = (table.values[q] for q in _DIRECTIONS)
    f = np.stack([table.values[channel] for channel in channels], axis=1)
    had_cosine = channels[0].startswith("f_cos_l")
    if had_cosine:
        f = f / np.cos(theta_l)[:, None]
    return Measurement(name, theta_l, theta_v, np.arctan2(np.sin(dphi), np.cos(dphi)), f, had_cosine)


def _coefficients(table: _Table, name: str) -> CoefficientSamples:
    values = table.values
    beta2 = values.setdefault("entrance2", np.zeros(len(table.places)))
    below = np.pi / 2 - GRAZING
    table.check("observation", 0.0, below, "0 to less than 90 degrees")
    table.check("entrance", -below, below, "an angle between -90 and 90 degrees")
    if "entrance2" in table.titles:
        table.check("entrance2", -below, below, "an angle between -90 and 90 degrees")
    quantity = "ra" if "ra" in values else "rl"
    table.check(quantity, np.finfo(float).tiny, np.inf, "more than 0")
    observation, beta1 = values["observation"], values["entrance"]
    # n.v = cos(beta2) cos(beta1 - observation): photometry.goniometer.
    cos_nu = np.cos(beta2) * np.cos(beta1 - observation)
    if np.min(cos_nu) < np.sin(GRAZING):
        line = table.places[int(np.argmin(cos_nu))]
        raise LineError(line, "the viewer is below the surface's horizon, by entrance minus observation")
    ra = values[quantity] * (cos_nu if quantity == "rl" else 1.0)
    return CoefficientSamples(name, observation, beta1, beta2, ra)
