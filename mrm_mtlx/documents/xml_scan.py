"""Looks at the XML of a document before MaterialX does, which recurses over it and takes some of what is broken."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple
from xml.parsers import expat

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.text_positions import Position, TextPositions
from mrm_mtlx.documents.xml_elements import XmlElements
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.system.limits import MAXIMUM_XML_DEPTH

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Finding, Rule

# Encodings that a declaration may name: UTF-8, and its subset.
_ENCODINGS = ("utf-8", "utf8", "us-ascii", "ascii")
_XINCLUDE = "http://www.w3.org/2001/XInclude"
# What XML consists of, each part after the other. A "<" within the quotes of a tag is what XML forbids and MaterialX
# takes.
_PARTS = re.compile(
    r"[^<]++|<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|(?P<tag><(?![!?])(?:[^<>\"']++|\"[^\"]*+\"|'[^']*+')*+>)",
    re.DOTALL,
)


class Include(NamedTuple):
    """An element that includes another file."""

    source: SourceLocation
    href: str


@dataclass
class Scan:
    """Findings, inclusions and elements of the XML of one file, before it is read.

    Attributes
    ----------
    file, elements
        Its path as findings show it, and where its elements begin.
    root, version
        Tag of the root element, and the version that it states.
    includes, findings
        What it includes, and what is odd about it.
    """

    file: str
    elements: XmlElements
    root: str = ""
    version: str = ""
    includes: list[Include] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)


def scan(content: bytes, file: str, *, is_document: bool) -> Scan:
    """Look at the content of a file.

    Parameters
    ----------
    content, file
        Its bytes, and its path as findings show it.
    is_document
        Whether it is the document itself, which need not be named.

    Raises
    ------
    ReadError
        If MaterialX must not be given it: it is not well-formed, not UTF-8, too deep, or includes what is not read.
    """
    name = _Name(file, is_document)
    if not content.strip():
        raise ReadError(name.finding(rules.READ_XML, "the file is empty", Position(1, 1)))
    content = content.removeprefix(codecs.BOM_UTF8)
    text = _decoded(content, name)
    try:
        return _Parse(name, XmlElements(content)).run(text)
    except expat.ExpatError as error:
        refused = _refused(error, name)
    mark = _unused_sign(text)
    marked, count = _marked(text, mark) if mark else (text, 0)
    if not count:
        raise refused
    try:
        return _Parse(name, XmlElements(marked.encode(), mark), mark, count).run(marked)
    except expat.ExpatError as error:
        raise _refused(error, name) from error


class _Name(NamedTuple):
    """A file's name in findings."""

    file: str
    is_document: bool

    @property
    def last(self) -> str:
        """The last part of the path."""
        return self.file.rpartition("/")[2]

    def finding(self, rule: Rule, message: str, at: Position | None = None) -> Finding:
        """A case of a rule in the file."""
        place = ("" if self.is_document else self.last, f"line {at.line}" if at else "")
        return replace(rule.at(" ".join(filter(None, place)), message), source=self.source(at))

    def source(self, at: Position | None) -> SourceLocation:
        """A place in the file."""
        return SourceLocation(self.file, *(at or ()))


def _refused(error: expat.ExpatError, name: _Name) -> ReadError:
    at = Position(error.lineno, error.offset + 1)
    return ReadError(name.finding(rules.READ_XML, f"{expat.errors.messages[error.code]} at column {at.column}", at))


def _decoded(content: bytes, name: _Name) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in content[:4096]:
        raise ReadError(name.finding(rules.READ_ENCODING, "the file is UTF-16 or binary, not UTF-8"))
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        at, byte = TextPositions(content).at(error.start), content[error.start]
        raise ReadError(name.finding(rules.READ_ENCODING, f"byte 0x{byte:02x} is not UTF-8", at)) from error


def _unused_sign(text: str) -> str:
    """A character of the private use area that a text lacks, or "" if it has all."""
    used = set(text)
    return next((sign for sign in map(chr, range(0xE000, 0xF900)) if sign not in used), "")


def _marked(text: str, mark: str) -> tuple[str, int]:
    """A text with a mark in place of every "<" within the quotes of a tag, up to what is no XML; and their number."""
    parts, end = [], 0
    while part := _PARTS.match(text, end):
        parts.append(part[0] if part["tag"] is None else f"<{part[0][1:].replace('<', mark)}")
        end = part.end()
    marked = "".join(parts)
    return marked + text[end:], marked.count(mark)


class _Parse:
    """One parse by expat.

    `marks` of the sign `mark` stand for "<" in values of attributes. Were one elsewhere, MaterialX would see other
    elements than were seen here.
    """

    def __init__(self, name: _Name, elements: XmlElements, mark: str = "", marks: int = 0) -> None:
        self._name, self._mark, self._marks = name, mark, marks
        self._elements = elements
        self._add = elements.add
        self._scan = Scan(name.file, elements)
        # Of each element around: its number, and the names of its children so far.
        self._around: list[int] = []
        self._names: list[set[str] | None] = []
        self._prefixes = {"xi"}
        self._ascii = True
        self._parser = expat.ParserCreate()
        self._parser.XmlDeclHandler = self._declaration
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def run(self, text: str) -> Scan:
        """Parse a text.

        Raises
        ------
        expat.ExpatError
            If it is not well-formed.
        ReadError
            If it is, and is not to be read.
        """
        self._ascii = text.isascii()
        try:
            self._parser.Parse(text, True)
            if self._marks:
                raise self._error(rules.READ_XML, 'there is a "<" where none may stand')
        finally:
            del self._parser  # it holds this object, and would be freed with it some time
        return self._scan

    def _position(self) -> Position:
        return Position(self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1)

    def _finding(self, rule: Rule, message: str) -> Finding:
        return self._name.finding(rule, message, self._position())

    def _error(self, rule: Rule, message: str) -> ReadError:
        return ReadError(self._finding(rule, message))

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        del version, standalone
        if encoding and encoding.lower() not in _ENCODINGS and not self._ascii:
            raise self._error(rules.READ_ENCODING, f"the file says that it is {encoding}, and is UTF-8")

    def _doctype(self, *_: object) -> None:
        raise self._error(rules.READ_XML, "document type declarations are not read")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        # Called for every element that is read: its time is most of what reading takes.
        if self._mark:
            self._restore(attributes)
        name = attributes.get("name", "")
        around = self._around
        if not around:
            self._note_root(tag, attributes)
        elif (names := self._names[-1]) is None:
            self._names[-1] = {name}
        elif name not in names:
            names.add(name)
        elif name:
            self._scan.findings.append(self._duplicate(name))
        if tag.endswith("include") or _XINCLUDE in attributes.values():
            self._note_include(tag, attributes)
        around.append(self._add(around[-1] if around else 0, name or (tag,), self._parser.CurrentByteIndex))
        self._names.append(None)
        if len(around) > MAXIMUM_XML_DEPTH:
            raise self._error(rules.READ_TOO_DEEP, f"elements are nested more than {MAXIMUM_XML_DEPTH} levels deep")

    def _note_root(self, tag: str, attributes: dict[str, str]) -> None:
        self._scan.root, self._scan.version = tag, attributes.get("version", "")
        if tag == "materialx" and "version" not in attributes:
            self._scan.findings.append(self._finding(rules.DOC_VERSION, "the document states no version"))

    def _duplicate(self, name: str) -> Finding:
        at = self._position()
        message = f"line {at.line} of {self._name.last} has a second element named '{name}', which is dropped"
        parents = self._elements.path(self._around[-1])
        place = f"/{parents}/{name}" if parents else f"/{name}"
        return replace(rules.DOC_DUPLICATE_NAME.at(place, message), source=self._name.source(at))

    def _restore(self, attributes: dict[str, str]) -> None:
        """Give values of attributes the signs back that were marked, and say so."""
        for name, value in attributes.items():
            if self._mark in value:
                self._marks -= value.count(self._mark)
                attributes[name] = value.replace(self._mark, "<")
                message = f'the value of {name} has a "<" in it: {attributes[name]}'
                self._scan.findings.append(self._finding(rules.READ_XML_LENIENT, message))

    def _note_include(self, tag: str, attributes: dict[str, str]) -> None:
        """Note an element that MaterialX takes for an inclusion; refuse those that it would drop without a word."""
        self._prefixes |= {name.partition(":")[2] for name, value in attributes.items() if value == _XINCLUDE}
        prefix, _, local = tag.rpartition(":")
        if local != "include" or prefix not in self._prefixes:
            return
        if prefix != "xi":
            raise self._error(rules.READ_INCLUDE, f"MaterialX knows inclusions as xi:include alone, not as {tag}")
        if len(self._around) != 1:
            raise self._error(
                rules.READ_INCLUDE, "MaterialX reads inclusions as children of the materialx element alone"
            )
        self._scan.includes.append(Include(self._name.source(self._position()), attributes.get("href", "")))

    def _end(self, tag: str) -> None:
        del tag
        self._names.pop()
        self._around.pop()
