"""Minima of the standards, and colour boxes, from the tables that were read: data/*.csv.

What is not here was not read, see `MISSING`. `confidence` is verified-primary (read in the text of the law) or
verified-secondary (read in a third party's print). All are minima, mostly of new material; those of one class need not
belong to one physical sheet.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.standards.quantities import Quantity
from mrm_mtlx.system.arguments import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mrm_mtlx.bsdf.arrays import Array

# Standards, or parts of those here, whose tables were not read.
MISSING = (
    "ASTM D4956 Types IV, V, VIII, IX and XI, and any edition after 2001",
    "EN 12899-1 (RA1, RA2)",
    "UN R104",
    "ISO 7591",
    "ISO 6742-2",
    "EN 1436:2018",
)
# 16 CFR 1512 prints the minima of clear reflectors, and these shares of them for the other colours.
_SHARES_OF_CLEAR = {"amber": (0.625, "5/8 of clear"), "red": (0.25, "1/4 of clear")}


@dataclass(frozen=True)
class Limit:
    """A minimum that a class of a standard asks for.

    Attributes
    ----------
    standard, table, class_name, colour
        As printed; colour is "unspecified" where none is.
    observation_deg
        Observation angle, as printed.
    entrance_deg
        Entrance angle, as printed.
    beta1_deg, beta2_deg
        Its components: in one plane, or for reflectors up/down and left/right.
    quantity
    unit
        Of the minimum: cd/lx/m2, mcd/lx/m2, mcd/lx or cd/fc, m.
    minimum
    confidence
        "verified-primary" or "verified-secondary".
    source
        Where it was read.
    derived
        How it follows from a printed row, "" for a printed one.
    """

    standard: str
    table: str
    class_name: str
    colour: str
    observation_deg: float
    entrance_deg: float
    beta1_deg: float
    beta2_deg: float
    quantity: Quantity
    unit: str
    minimum: float
    confidence: str
    source: str
    derived: str = ""


@dataclass(frozen=True)
class Box:
    """A region of chromaticities, a convex polygon.

    Attributes
    ----------
    standard, table
        As printed.
    illuminant
        "D65" by day, "A" at night.
    observation_deg, beta1_deg
        The geometry; 45/0 is light at 45 degrees and a viewer along the normal.
    subject
        What the box is for.
    colour
    corners : tuple of (x, y)
        In printed order.
    confidence, source
        As `Limit`.
    """

    standard: str
    table: str
    illuminant: str
    observation_deg: float
    beta1_deg: float
    subject: str
    colour: str
    corners: tuple[tuple[float, float], ...]
    confidence: str
    source: str

    def margin(self, x: float, y: float) -> float:
        """Distance to the nearest edge, negative outside.

        Green and blue end on the spectrum locus, where straight edges stand for the curve: no colour of Rec.709 gets
        near it.
        """
        corners = np.array(self.corners)
        edges = np.roll(corners, -1, axis=0) - corners
        to = np.array([x, y]) - corners
        along = np.clip(np.sum(to * edges, axis=1) / np.sum(edges * edges, axis=1), 0.0, 1.0)
        nearest = float(np.min(np.linalg.norm(to - along[:, None] * edges, axis=1)))
        side = _cross(edges, to)
        return nearest if np.all(side >= 0.0) or np.all(side <= 0.0) else -nearest


class Class(NamedTuple):
    """A class of a standard in one colour, by the names that choose it."""

    standard: str
    class_name: str
    colour: str


@cache
def standards() -> tuple[Limit, ...]:
    """All minima, those of 16 CFR 1512's other colours after their clear ones."""
    printed = [
        Limit(
            class_name=row.pop("class"),
            quantity=Quantity(row.pop("quantity")),
            **row | {name: float(row[name]) for name in _NUMBERS},
        )
        for row in _rows("standards.csv")
    ]
    derived = [
        replace(limit, colour=colour, minimum=share * limit.minimum, derived=how)
        for colour, (share, how) in _SHARES_OF_CLEAR.items()
        for limit in printed
        if limit.colour == "clear"
    ]
    return tuple(printed + derived)


_NUMBERS = ("observation_deg", "entrance_deg", "beta1_deg", "beta2_deg", "minimum")


@cache
def boxes() -> tuple[Box, ...]:
    """All colour boxes."""
    corners: dict[tuple[str, ...], list[tuple[float, float]]] = {}
    for row in _rows("chromaticity.csv"):
        corner = (float(row.pop("x")), float(row.pop("y")))
        del row["corner"]
        corners.setdefault(tuple(row.values()), []).append(corner)
    return tuple(
        Box(standard, table, illuminant, float(observation), float(entrance), subject, colour, tuple(found), *source)
        for (standard, table, illuminant, observation, entrance, subject, colour, *source), found in corners.items()
    )


def notes(standard: str) -> list[str]:
    """Notes for who reads the rows of a standard."""
    return [row["note"] for row in _rows("notes.csv") if row["standard"] == standard]


def classes(limits: Iterable[Limit] | None = None) -> list[Class]:
    """The classes in these minima, or in all, in their order."""
    rows = standards() if limits is None else limits
    return list(dict.fromkeys(Class(limit.standard, limit.class_name, limit.colour) for limit in rows))


def limits(class_name: str | None = None, color: str | None = None, *, standard: str | None = None) -> list[Limit]:
    """The minima of one class in one colour.

    Names need not be complete: case, spaces and punctuation do not count, and the beginning is enough, of the name or
    of a word in it, where only one name has it. What is left out may be left out where there is only one.

    Raises
    ------
    ArgumentError
        If nothing fits, or more than one class or colour does: it names the argument that does not tell them apart, and
        lists what there is.

    Examples
    --------
    >>> [limit.minimum for limit in limits("DOT-C2", "red")]
    [60.0, 60.0, 15.0, 15.0, 15.0, 4.0]
    """
    rows = _chosen(list(standards()), "standard", standard)
    rows = _chosen(rows, "class_name", class_name)
    rows = _chosen(rows, "colour", color)
    if len({limit.standard for limit in rows}) > 1:  # the same class in two standards
        raise _ambiguous(rows, "standard", standard)
    return rows


def _chosen(rows: list[Limit], column: str, wanted: str | None) -> list[Limit]:
    """Rows whose name is wanted, or all if none is asked for and there is but one."""
    names = _names(rows, column)
    if wanted is None:
        if column == "standard":  # the class may decide
            return rows
        fitting = names
    else:
        fitting = [n for n in names if _plain(n) == _plain(wanted)] or [n for n in names if _begins(n, wanted)]
    if len(fitting) != 1:
        raise _ambiguous(rows, column, wanted)
    return [row for row in rows if getattr(row, column) == fitting[0]]


def _names(rows: list[Limit], column: str) -> list[str]:
    return list(dict.fromkeys(getattr(row, column) for row in rows))


def _ambiguous(rows: list[Limit], column: str, wanted: str | None) -> ArgumentError:
    what = column.removesuffix("_name")
    given = f"no single {what} is called '{wanted}'" if wanted is not None else f"which {what} is not said"
    msg = f"{given}; expected one of: {', '.join(_names(rows, column))}"
    return ArgumentError(msg, _ARGUMENTS.get(column, column))


# The arguments that are not called as the columns of the tables.
_ARGUMENTS = {"colour": "color"}


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _begins(name: str, wanted: str) -> bool:
    """True if the name, or what follows one of its words, begins so: no part of a word is found in the middle."""
    words = re.findall(r"[a-z0-9]+", name.lower())
    return bool(_plain(wanted)) and any("".join(words[i:]).startswith(_plain(wanted)) for i in range(len(words)))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _rows(name: str) -> list[dict[str, Any]]:
    text = (files(__package__) / "data" / name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))
