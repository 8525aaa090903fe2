"""The report of a conformance run: plain data that shows itself."""

from __future__ import annotations

import json
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mrm_mtlx.conformance.results import SCHEMA
from mrm_mtlx.system.json_data import finite
from mrm_mtlx.system.shown import COLUMNS, Shown
from mrm_mtlx.validation.results import Status

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mrm_mtlx.conformance.results import CaseResult

_HEADER = ("target", "status", "samples", "largest", "median", "of allowed")
_NOTE = "Relative errors; 'of allowed' is the largest ratio of an error to its own tolerance."
_LOBES = ("aligned lobe", "material", "alpha", "view", "L1", "bound", "albedo", "±", "")
_LOBES_NOTE = (
    "L1: integral of |found - exact| over that of exact; albedo: ratio of the integrals, 1 within ±; view in degrees."
)


@dataclass(frozen=True, repr=False)
class ConformanceReport(Shown):
    """The node library, or MaterialX's, against the oracle.

    Attributes
    ----------
    versions, engines
        What it was run with.
    library
        Whose implementation of the flag.
    cases
        A result per case and target.
    """

    versions: Mapping[str, str]
    engines: Mapping[str, Mapping[str, Any]]
    library: str
    cases: tuple[CaseResult, ...]

    @property
    def status(self) -> Status:
        """Failed if a case did; skipped if none was checked."""
        statuses = {case.status for case in self.cases}
        return next((status for status in (Status.FAIL, Status.PASS) if status in statuses), Status.SKIP)

    def verdict(self) -> str:
        """The last line of the report."""
        statuses = [case.status for case in self.cases]
        words = {Status.FAIL: "FAILED", Status.PASS: "PASSED", Status.SKIP: "NOTHING CHECKED"}
        counts = [f"{statuses.count(status)} {status}ed" for status in (Status.PASS, Status.FAIL)]
        return f"{words[self.status]}  {', '.join(counts)}, {statuses.count(Status.SKIP)} skipped"

    def report(self) -> str:
        """The targets of each case, the approximate lobes if there are any, and the verdict."""
        by_name: dict[str, list[CaseResult]] = {}
        for case in self.cases:
            by_name.setdefault(case.name, []).append(case)
        rows = {name: [_figures(case) for case in cases] for name, cases in by_name.items()}
        compared = [_HEADER, *(row for found in rows.values() for row in found if len(row) == len(_HEADER))]
        widths = [max(len(row[column]) for row in compared) for column in range(len(_HEADER))]
        lines = ["case", f"  {_row(_HEADER, widths)}"]
        for name, found in rows.items():
            lines.append(name)
            for row in found:
                lines += textwrap.wrap(
                    _row(row, widths), COLUMNS, initial_indent="  ", subsequent_indent=" " * 6, break_long_words=False
                )
        return "\n".join([*lines, *textwrap.wrap(_NOTE, COLUMNS), *_approximations(self.cases), self.verdict()])

    def to_json(self) -> str:
        """The report as JSON."""
        report = {
            "schema": SCHEMA,
            "versions": self.versions,
            "engines": self.engines,
            "library": self.library,
            "cases": [case.to_json() for case in self.cases],
        }
        return json.dumps(finite(report), indent=2, allow_nan=False)


def _figures(case: CaseResult) -> tuple[str, ...]:
    """A row of the table; of what was skipped, with the reason in the place of figures."""
    found = case.comparison
    if found:
        figures = (f"{found.samples}", f"{found.max_error:.2e}", f"{found.median_error:.2e}", f"{found.excess:.2f}")
        return case.target, case.status, *figures
    if case.approximations:
        return case.target, case.status, "-", "-", "-", f"{max(a.excess for a in case.approximations):.2f}"
    return case.target, case.status, case.reason or "-"


def _approximations(cases: Sequence[CaseResult]) -> list[str]:
    """L1 error and albedo ratio of each approximate lobe, where there are any."""
    rows = [_LOBES]
    for case in cases:
        for a in case.approximations:
            found = f"{a.l1:.3f}", f"{a.l1_bound:g}", f"{a.albedo:.4f}", f"{a.albedo_bound:g}"
            verdict = "" if a.passed else "FAIL"
            rows.append((case.case.node, a.material, f"{a.alpha:g}", f"{a.view_deg:g}", *found, verdict))
    if len(rows) == 1:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(len(_LOBES))]
    return ["", *(_row(row, widths) for row in rows), *textwrap.wrap(_LOBES_NOTE, COLUMNS)]


def _row(cells: Sequence[str], widths: Sequence[int]) -> str:
    return "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=False)).rstrip()
