"""Reports of photometry as text and as JSON (docs/photometry.schema.json)."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.photometry.coefficients import WITHIN
from mrm_mtlx.photometry.report import RETURNED_ENTRANCE_DEG
from mrm_mtlx.standards.tables import MISSING, boxes, classes, limits, notes, standards
from mrm_mtlx.system.text import plural
from mrm_mtlx.system.versions import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.photometry.report import Cell, Chromaticity, PhotometryOptions, SurfaceReport
    from mrm_mtlx.standards.tables import Limit

SCHEMA = "mrm.photometry/1"
LIST_SCHEMA = "mrm.photometry.standards/1"
# Columns of a terminal.
TERMINAL = 80


@dataclass(frozen=True)
class DocumentReport:
    """The report on a document.

    Attributes
    ----------
    path
        As it is shown.
    surfaces
        By name; empty if it is left out.
    reason
        Why it is left out, "" if it is not.
    broken
        Whether that is because it is wrong, not because the reference does not know what it uses.
    """

    path: str
    surfaces: dict[str, SurfaceReport] = field(default_factory=dict)
    reason: str = ""
    broken: bool = False

    @property
    def left_out(self) -> bool:
        """True if it could not be measured."""
        return bool(self.reason)


def to_json(
    documents: Sequence[DocumentReport], limits: Sequence[Limit], options: PhotometryOptions, *, passed: bool
) -> str:
    """The report by docs/photometry.schema.json."""
    reports = [report for document in documents for report in document.surfaces.values()]
    limited = [cell for report in reports for cell in report.cells if cell.minimum is not None]
    content = {
        "schema": SCHEMA,
        "versions": {"mrm": __version__, **{k: metadata.version(v) for k, v in _VERSIONS.items()}},
        "settings": asdict(options),
        "class": _class_json(limits),
        "returned_within": {
            "observation_deg": round(float(np.rad2deg(WITHIN)), 6),
            "entrance_deg": RETURNED_ENTRANCE_DEG,
        },
        "documents": [
            {
                "path": document.path,
                "measured": not document.left_out,
                "surfaces": [_surface_json(name, report, limits) for name, report in document.surfaces.items()],
            }
            for document in documents
        ],
        "summary": {
            "surfaces": len(reports),
            "limits": len(limited),
            "met": sum(cell.met for cell in limited),
            "not_measured": sum(document.left_out for document in documents),
            "passed": passed,
        },
    }
    return json.dumps(content, indent=2, allow_nan=False)


_VERSIONS = {"materialx": "MaterialX", "numpy": "numpy"}


def _class_json(limits: Sequence[Limit]) -> dict[str, str] | None:
    if not limits:
        return None
    return {"standard": limits[0].standard, "class": limits[0].class_name, "colour": limits[0].colour}


def heading(limits: Sequence[Limit], options: PhotometryOptions) -> list[str]:
    """Lines on the class and the way of measuring."""
    lines = []
    if limits:
        first = limits[0]
        lines.append(f"{first.standard}, {first.class_name}, {first.colour}{_why(first)}: value / minimum")
        lines += [f"  {source}" for source in dict.fromkeys(f"{c.source} ({c.confidence})" for c in limits)]
    turned = ", ".join(f"{angle:g}°" for angle in options.rotations_deg)
    how = f"illuminant A, photopic, colours by {_METHODS[options.method]}; "
    how += f"mean of rotations {turned}" if len(options.rotations_deg) > 1 else f"rotation {turned}"
    discs = (options.source_aperture_deg, options.receiver_aperture_deg)
    how += f"; source {discs[0]:g}° and receiver {discs[1]:g}° across" if any(discs) else "; point source and receiver"
    return [*lines, how]


_METHODS = {"spectral": "spectra", "rgb": "product of RGB"}


def _why(limit: Limit) -> str:
    return f" ({limit.derived})" if limit.derived else ""


def surface_lines(report: SurfaceReport) -> list[str]:
    """A surface: tables, colours, and the share of light that comes back."""
    lines = []
    for kind in dict.fromkeys((cell.quantity, cell.unit) for cell in report.cells):
        lines += _table([cell for cell in report.cells if (cell.quantity, cell.unit) == kind])
    lines += [_color_line(color) for color in report.colors]
    return [*lines, f"    returned within 2° at entrance 5°: {100.0 * report.returned:.2g} % of the light"]


def _table(cells: list[Cell]) -> list[str]:
    """Rows of observation angles, columns of entrance angles."""
    columns = sorted({(c.entrance_deg, c.beta1_deg, c.beta2_deg) for c in cells})
    rows = sorted({c.observation_deg for c in cells})
    where = {(c.observation_deg, c.entrance_deg, c.beta1_deg, c.beta2_deg): c for c in cells}
    values = [
        [f"observation {row:g}°", *("" if cell is None else _value(cell) for cell in found)]
        for row in rows
        for found in [[where.get((row, *column)) for column in columns]]
    ]
    title, names = f"{cells[0].quantity} [{cells[0].unit}]", [_entrance(*column) for column in columns]
    lines = _aligned([[title, *names], *values])
    # Many columns have their common word once, if they fit a terminal then.
    short = _aligned([[f"{title}, entrance", *(name.removeprefix("entrance ") for name in names)], *values])
    return short if max(map(len, lines)) > TERMINAL >= max(map(len, short)) else lines


def _aligned(table: list[list[str]]) -> list[str]:
    """Lines of a table: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        ("    " + "   ".join(t.ljust(w) if not i else t.rjust(w) for i, (t, w) in enumerate(line))).rstrip()
        for line in (list(zip(line, widths, strict=True)) for line in table)
    ]


def _entrance(entrance: float, beta1: float, beta2: float) -> str:
    if beta2 == 0.0:
        return f"entrance {entrance:g}°" if beta1 == entrance else f"entrance {beta1:g}°"
    return f"across {beta2:g}°" if beta1 == 0.0 else f"{beta1:g}°, across {beta2:g}°"


def _value(cell: Cell) -> str:
    if cell.minimum is None:
        return _digits(cell.value)
    return f"{_digits(cell.value)} / {_digits(cell.minimum)} {'ok  ' if cell.met else 'FAIL'}"


def _digits(value: float) -> str:
    """Four digits, none of them made up behind the point of a large number."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"


def _color_line(color: Chromaticity) -> str:
    if (color.illuminant, color.observation_deg, color.beta1_deg) == ("D65", 45.0, 45.0):
        light = "day, D65, 45°/0°"
        factor = f", luminance factor {100.0 * color.factor:.3g} %"
    else:
        light, factor = f"night, A, {color.observation_deg:g}°/{color.beta1_deg:g}°", ""
    if color.margin is None or color.box is None:
        found = "black" if np.isnan(color.x) else f"x {color.x:.3f}, y {color.y:.3f}{factor}"
        return f"    {light}: {found}; no box for this colour was read"
    box = f"{color.box.colour} box, {color.box.standard}, {color.box.table}"
    place = "inside by" if color.margin >= 0.0 else "outside by"
    required = "" if color.counts else " (a yardstick)"
    at = f"x {color.x:.3f}, y {color.y:.3f}{factor}"
    return f"    {light}: {at}; {place} {abs(color.margin):.3f}: {box}{required}{'' if color.met else ' FAIL'}"


def _surface_json(name: str, report: SurfaceReport, limits: Sequence[Limit]) -> dict[str, Any]:
    sources = [{"source": c.source, "confidence": c.confidence, "derived": c.derived or None} for c in limits]
    return {
        "name": name,
        "met": report.met,
        "returned": report.returned,
        "cells": [
            {**asdict(cell), "met": None if cell.minimum is None else cell.met, **(sources[i] if sources else {})}
            for i, cell in enumerate(report.cells)
        ],
        "colors": [_color_json(color) for color in report.colors],
    }


def _color_json(color: Chromaticity) -> dict[str, Any]:
    box = color.box
    black = np.isnan(color.x)
    return {
        "illuminant": color.illuminant,
        "observation_deg": color.observation_deg,
        "entrance_deg": color.beta1_deg,
        "x": None if black else color.x,
        "y": None if black else color.y,
        "luminance_factor": color.factor,
        "box": None
        if box is None
        else {"standard": box.standard, "table": box.table, "colour": box.colour, "source": box.source},
        "margin": color.margin,
        "counts": color.counts,
    }


def list_text() -> str:
    """The standards and their classes, a line each, with sources; and what is missing."""
    lines: list[str] = []
    previous = ""
    for chosen in classes():
        if chosen.standard != previous:
            lines += ["", chosen.standard, *(f"  note: {note}" for note in notes(chosen.standard))]
            previous = chosen.standard
        rows = limits(chosen.class_name, chosen.colour, standard=chosen.standard)
        sources = "; ".join(dict.fromkeys(f"{row.source} ({row.confidence})" for row in rows))
        quantities = ", ".join(dict.fromkeys(f"{row.quantity} [{row.unit}]" for row in rows))
        found = f"  {chosen.class_name} | {chosen.colour}{_why(rows[0])} | {plural(len(rows), 'limit')} of {quantities}"
        lines.append(f"{found} | {sources}")
    return "\n".join([*lines[1:], "", "Not here, for their tables were not read:", *(f"  {name}" for name in MISSING)])


def list_json() -> str:
    """All minima and boxes, with sources."""
    names = dict.fromkeys(limit.standard for limit in standards())
    content = {
        "schema": LIST_SCHEMA,
        "limits": [asdict(limit) for limit in standards()],
        "boxes": [asdict(box) for box in boxes()],
        "notes": {name: notes(name) for name in names},
        "missing": list(MISSING),
    }
    return json.dumps(content, indent=2, allow_nan=False)
