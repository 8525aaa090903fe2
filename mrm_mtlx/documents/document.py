"""What a file of another format gives: a MaterialX document, and where in the file its elements come from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import MaterialX as mx

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding


class ReadError(Exception):
    """A file cannot be read at all; `finding` says why."""

    def __init__(self, found: Finding) -> None:
        super().__init__(found.message)
        self.finding = found


class NothingToWriteError(ValueError):
    """A document has nothing that the format can say; `findings` say why."""

    def __init__(self, findings: list[Finding]) -> None:
        super().__init__("it has no material that the format can say; nothing was written")
        self.findings = findings


@dataclass
class Imported:
    """A file that was read.

    Attributes
    ----------
    document
        What it says, in MaterialX; its data library is set.
    places
        Path of an element of the document, "material/node/input", to its place in the source file. An element that is
        not there lies where its nearest parent does; empty for a file that is a document itself.
    findings
        What is wrong, or could not be carried over.
    reach
        Where the document's names of files lead.
    packed
        Whether that is a scratch folder, with what was inside of the file.
    """

    document: mx.Document
    places: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    reach: Reach = field(kw_only=True)
    packed: bool = False

    def place(self, location: str) -> str:
        """Where in the source file an element lies that the document has at "/material/node/input"."""
        path, rest = location.removeprefix("/"), ""
        while path and path not in self.places:
            path, _, last = path.rpartition("/")
            rest = f"/{last}{rest}"
        return self.places[path] + rest if path else location
