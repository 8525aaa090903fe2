"""What a file of another format gives: a MaterialX document, and where in the file its elements come from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import MaterialX as mx

    from mrm_mtlx.documents.files import Reach


class Remark(NamedTuple):
    """Something that is wrong with a file, or that another format cannot say.

    Attributes
    ----------
    code
        Of a rule of the validation's catalogue.
    place
        In the source file: a prim path, a JSON pointer, an element's path.
    message
        What was found, on one line.
    hint
        What to do; "" for the rule's own remedy.
    """

    code: str
    place: str
    message: str
    hint: str = ""


class UnreadableError(Exception):
    """The file cannot be read at all; `remark` says why."""

    def __init__(self, remark: Remark) -> None:
        super().__init__(remark.message)
        self.remark = remark


class NothingToWriteError(ValueError):
    """A document has nothing that the format can say; `remarks` say why."""

    def __init__(self, remarks: list[Remark]) -> None:
        super().__init__("it has no material that the format can say; nothing was written")
        self.remarks = remarks


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
    remarks
        What is wrong, or could not be carried over.
    reach
        Where the document's names of files lead.
    packed
        Whether that is a scratch folder, with what was inside of the file.
    """

    document: mx.Document
    places: dict[str, str] = field(default_factory=dict)
    remarks: list[Remark] = field(default_factory=list)
    reach: Reach = field(kw_only=True)
    packed: bool = False

    def place(self, location: str) -> str:
        """Where in the source file an element lies that the document has at "/material/node/input"."""
        path, rest = location.removeprefix("/"), ""
        while path and path not in self.places:
            path, _, last = path.rpartition("/")
            rest = f"/{last}{rest}"
        return self.places[path] + rest if path else location
