"""The report on one or more documents: plain data that shows itself."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from mrm_mtlx.photometry import formatting
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import plural, printable

if TYPE_CHECKING:
    from mrm_mtlx.photometry.formatting import DocumentReport
    from mrm_mtlx.photometry.report import PhotometryOptions, SurfaceReport
    from mrm_mtlx.standards.tables import Box, Limit


class Outcome(StrEnum):
    """Ends of a measurement: all limits met; one not, or a document wrong; or something could not be measured."""

    MET = "met"
    FAILED = "failed"
    INCOMPLETE = "incomplete"


@dataclass(frozen=True, repr=False)
class PhotometryReport(Shown):
    """The values of the surfaces of documents.

    Attributes
    ----------
    documents
        By document, what each of its surfaces measures.
    limits
        The minima of the class that was asked for; empty for none.
    options
        How it was measured.
    """

    documents: tuple[DocumentReport, ...]
    limits: tuple[Limit, ...]
    options: PhotometryOptions

    @property
    def surfaces(self) -> list[SurfaceReport]:
        """The surfaces of all documents."""
        return [surface for document in self.documents for surface in document.surfaces.values()]

    @property
    def outcome(self) -> Outcome:
        """The end of the measurement."""
        if any(document.broken for document in self.documents) or not all(surface.met for surface in self.surfaces):
            return Outcome.FAILED
        left_out = any(document.left_out for document in self.documents)
        return Outcome.INCOMPLETE if left_out or not self.surfaces else Outcome.MET

    def verdict(self) -> str:
        """The last line of the report."""
        surfaces, left_out = self.surfaces, sum(document.left_out for document in self.documents)
        measured = plural(len(surfaces), "surface")
        measured += f", {plural(left_out, 'document')} not measured" if left_out else ""
        words = {Outcome.MET: "PASSED", Outcome.FAILED: "FAILED", Outcome.INCOMPLETE: "NOT ALL MEASURED"}
        if not self.limits:
            word = {**words, Outcome.MET: "MEASURED"}[self.outcome]
            return f"{word}  {measured}; no limits asked for (--list)"
        cells = [cell for surface in surfaces for cell in surface.cells]
        met = sum(cell.met for cell in cells)
        outside = sum(not color.met for surface in surfaces for color in surface.colors)
        colors = f", {plural(outside, 'colour')} outside of the standard's box" if outside else ""
        return f"{words[self.outcome]}  {met} of {plural(len(cells), 'limit')} met{colors}, {measured}"

    def report(self) -> str:
        """Tables of each surface, and the verdict."""
        lines = [*formatting.heading(self.limits, self.options), ""]
        for document in self.documents:
            lines.append(printable(document.path) + (": not measured" if document.left_out else ""))
            for name, surface in document.surfaces.items():
                lines += [f"  /{printable(name)}", *formatting.surface_lines(surface)]
            lines.append("")
        return "\n".join([*lines, self.verdict()])

    def to_json(self) -> str:
        """The report by docs/photometry.schema.json."""
        passed = self.outcome is Outcome.MET
        return formatting.to_json(self.documents, self.limits, self.options, passed=passed)


@dataclass(frozen=True, repr=False)
class StandardsReport(Shown):
    """The minima and colour boxes of the standards that are known, with their sources."""

    limits: tuple[Limit, ...]
    boxes: tuple[Box, ...]

    def report(self) -> str:
        """The standards and their classes, a line each; and what is missing."""
        return formatting.list_text()

    def to_json(self) -> str:
        """All of it as JSON."""
        return formatting.list_json()
