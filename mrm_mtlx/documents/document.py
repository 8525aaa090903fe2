"""A document that was read: its MaterialX, the file that it comes from, and where its names of files lead."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from mrm_mtlx.findings.source_location import SourceLocation

if TYPE_CHECKING:
    from pathlib import Path

    import MaterialX as mx

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.documents.locations import Locations
    from mrm_mtlx.findings.finding import Finding


class ReadError(Exception):
    """A file cannot be read at all; `finding` says why."""

    def __init__(self, found: Finding) -> None:
        super().__init__(found.message)
        self.finding = found


@dataclass(kw_only=True)
class Document:
    """A document, however it is stored.

    Attributes
    ----------
    materialx
        What it says, in MaterialX; its data library is set.
    path
        The file that it was read from.
    reach
        Where its names of files lead.
    packed
        Whether `reach` leads to a scratch folder, with what was inside of the file.
    source_locations
        Path of an element, "material/node/input", to where the source file has it, in that format's words: a prim's
        path, a JSON pointer. An element that is not there lies where its nearest parent does; empty for a file whose
        own elements these are.
    locations
        Where in its files that is: line and column, as far as the format has them.
    findings
        What reading it found: what is wrong, or could not be carried over.
    original
        The document that `materialx` is another form of, with elements of the same names; None for none.
    """

    materialx: mx.Document
    path: Path
    reach: Reach
    packed: bool = False
    source_locations: dict[str, str] = field(default_factory=dict)
    locations: Locations | None = None
    findings: list[Finding] = field(default_factory=list)
    original: mx.Document | None = None

    def source_location(self, location: str) -> str:
        """The place in the source file of the element at "/material/node/input", or of its nearest parent."""
        path, rest = location.removeprefix("/"), ""
        while path and path not in self.source_locations:
            path, _, last = path.rpartition("/")
            rest = f"/{last}{rest}"
        return self.source_locations[path] + rest if path else location

    def in_source(self, found: Finding) -> Finding:
        """A finding about an element, with the element's location in the source file; others as they are."""
        return found if found.source else self.located(replace(found, location=self.source_location(found.location)))

    def located(self, found: Finding) -> Finding:
        """A finding whose location is one in the source file, with the file, and the line if that is known."""
        if found.source:
            return found
        known = self.locations
        return replace(found, source=known.of(found.location) if known else SourceLocation(self.reach.shown(self.path)))
