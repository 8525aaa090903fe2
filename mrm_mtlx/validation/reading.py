"""Reading documents that nobody vouches for: bounded, inside one folder, with a finding for whatever is wrong.

MaterialX's reader is fast and trusting: it recurses over nested elements and opens whatever an include names. What it
is given here has been parsed once before by expat, which is neither. Other formats are translated by `interchange`,
whose remarks become findings.
"""

from __future__ import annotations

import codecs
import os
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any
from xml.parsers import expat

import MaterialX as mx

from mrm_mtlx.interchange.formats import DOCUMENT, format_of
from mrm_mtlx.interchange.imported import Imported, UnreadableError
from mrm_mtlx.library.files import MAXIMUM_BYTES, MAXIMUM_INCLUDES
from mrm_mtlx.limits import MAXIMUM_XML_DEPTH
from mrm_mtlx.validation.findings import Finding, finding

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.library.files import Reach


class ReadError(Exception):
    """The document cannot be read; `finding` says why."""

    def __init__(self, found: Finding) -> None:
        super().__init__(found.message)
        self.finding = found


@dataclass
class _Reading:
    """What is known while a document and its includes are scanned."""

    reach: Reach
    bytes: int = 0
    includes: int = 0
    duplicates: list[Finding] = field(default_factory=list)


def read_document(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> tuple[Imported, list[Finding]]:
    """Read a document, or a file of another format as one, with what it includes and the data library set.

    Parameters
    ----------
    path
        The file. One whose ending is not known is taken for a document.
    reach
        Where the names of files in it lead.
    library
        Its definitions.
    scratch
        An empty folder for files that are inside of the file, see `interchange.formats`.

    Returns
    -------
    tuple
        The document, and findings that do not prevent reading it.

    Raises
    ------
    ReadError
        If it cannot be read, for any reason that lies in the file.
    """
    form = format_of(path) or DOCUMENT
    if form is DOCUMENT:
        return _read_materialx(path, reach, library)
    try:
        imported = form.read(path, reach, library, scratch)
    except UnreadableError as error:
        raise ReadError(finding(*error.remark)) from error
    return imported, [finding(*remark) for remark in imported.remarks]


def in_file(found: Finding, imported: Imported) -> Finding:
    """A finding about the document, with the place in the file that the document was read from."""
    return replace(found, location=imported.place(found.location)) if imported.places else found


def _read_materialx(path: Path, reach: Reach, library: DataLibrary) -> tuple[Imported, list[Finding]]:
    reading = _Reading(reach)
    _scan(path, reading, ())
    document = mx.createDocument()
    try:
        mx.readFromXmlFile(document, str(path), mx.FileSearchPath(str(path.parent)))
        document.setDataLibrary(library.document)
    except Exception as error:  # MaterialX throws several unrelated types
        raise ReadError(finding("DOC_INVALID", "", f"MaterialX cannot read it: {error}")) from error
    return Imported(document, reach=reach), reading.duplicates


def _scan(path: Path, reading: _Reading, parents: tuple[Path, ...]) -> None:
    text = _read_bytes(path, reading)
    hrefs = _parse(text, path, reading, top=not parents)
    chain = (*parents, path.resolve())
    for line, href in hrefs:
        place = f"{path.name} line {line}" if parents else f"line {line}"
        target = reading.reach.at(path.parent).resolve(href)
        if target is None:
            raise ReadError(
                finding("READ_OUTSIDE", place, f"the include '{href}' lies outside the folder being checked")
            )
        if target in chain:
            names = " -> ".join(p.name for p in (*chain[chain.index(target) :], target))
            raise ReadError(finding("READ_INCLUDE", place, f"the document includes itself: {names}"))
        if not target.is_file():
            raise ReadError(finding("READ_INCLUDE", place, f"the included document '{href}' does not exist"))
        reading.includes += 1
        if reading.includes > MAXIMUM_INCLUDES:
            raise ReadError(finding("READ_INCLUDE", place, f"more than {MAXIMUM_INCLUDES} inclusions"))
        _scan(target, reading, chain)


def _read_bytes(path: Path, reading: _Reading) -> bytes:
    try:
        # Only regular files: a pipe or a device would never end.
        size = path.stat().st_size if path.is_file() else -1
        if size < 0:
            raise ReadError(finding("READ_FAILED", "", "it is not a regular file"))
        reading.bytes += size
        if reading.bytes > MAXIMUM_BYTES:
            found = f"{reading.bytes / 2**20:.0f} MiB, more than the {MAXIMUM_BYTES // 2**20} MiB that are read"
            raise ReadError(finding("READ_TOO_LARGE", "", f"document and includes have {found}"))
        with path.open("rb") as stream:
            return stream.read(MAXIMUM_BYTES + 1)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else "no reason given"
        raise ReadError(finding("READ_FAILED", "", f"the file cannot be opened: {reason}")) from error


def _parse(text: bytes, path: Path, reading: _Reading, *, top: bool) -> list[tuple[int, str]]:
    """Check well-formedness, depth and names; return the includes as (line, href)."""
    if not text.strip():
        raise ReadError(finding("READ_XML", "line 1", "the file is empty"))
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in text[:4096]:
        raise ReadError(finding("READ_ENCODING", "", "the file is UTF-16 or binary, not UTF-8"))
    try:
        text.decode("utf-8")
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        byte = text[error.start]
        raise ReadError(finding("READ_ENCODING", f"line {line}", f"byte 0x{byte:02x} is not UTF-8")) from error
    scanner = _Scanner(path, reading)
    try:
        scanner.parser.Parse(text, True)
    except expat.ExpatError as error:
        what = expat.errors.messages[error.code]
        raise ReadError(finding("READ_XML", f"line {error.lineno}", f"{what} at column {error.offset + 1}")) from error
    if top and scanner.root != "materialx":
        raise ReadError(finding("DOC_INVALID", "", f"the root element is <{scanner.root}>, expected <materialx>"))
    return scanner.includes


class _Scanner:
    """Handlers of one expat parse."""

    def __init__(self, path: Path, reading: _Reading) -> None:
        self.root = ""
        self.includes: list[tuple[int, str]] = []
        self._reading = reading
        self._file = path.name
        self._names: list[set[str]] = [set()]
        self._path: list[str] = []
        self.parser = expat.ParserCreate(encoding="utf-8")
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._doctype

    def _doctype(self, *_: Any) -> None:
        place = f"line {self.parser.CurrentLineNumber}"
        raise ReadError(finding("READ_XML", place, "document type declarations are not read"))

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        self.root = self.root or tag
        if tag == "xi:include":
            self.includes.append((line, attributes.get("href", "")))
        name = attributes.get("name", "")
        if name and name in self._names[-1]:
            place = "/" + "/".join((*self._path[1:], name))
            message = f"line {line} of {self._file} has a second element named '{name}', which is dropped"
            self._reading.duplicates.append(finding("DOC_DUPLICATE_NAME", place, message))
        self._names[-1].add(name)
        self._names.append(set())
        self._path.append(name or tag)
        if len(self._path) > MAXIMUM_XML_DEPTH:
            message = f"elements are nested more than {MAXIMUM_XML_DEPTH} levels deep"
            raise ReadError(finding("READ_TOO_DEEP", f"line {line}", message))

    def _end(self, tag: str) -> None:
        del tag
        self._names.pop()
        self._path.pop()
