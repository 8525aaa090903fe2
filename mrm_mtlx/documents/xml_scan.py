"""Looks at the XML of a document before MaterialX does, which recurses over it and takes some of what is broken."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple
from xml.parsers import expat

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
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

    line: int
    href: str


@dataclass
class Scan:
    """What the XML of one file says before it is read: its root element, what it includes, and what is odd about it."""

    root: str = ""
    includes: list[Include] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)


def scan(content: bytes, name: str, *, is_document: bool) -> Scan:
    """Look at the content of a file.

    Parameters
    ----------
    content, name
        Its bytes, and its name in findings.
    is_document
        Whether it is the document itself, which need not be named.

    Raises
    ------
    ReadError
        If MaterialX must not be given it: it is not well-formed, not UTF-8, too deep, or includes what is not read.
    """
    file = "" if is_document else f"{name} "
    text = _decoded(content, file)
    try:
        return _Parse(name, file).run(text)
    except expat.ExpatError as error:
        refused = _refused(error, file)
    mark = _unused_sign(text)
    marked, count = _marked(text, mark) if mark else (text, 0)
    if not count:
        raise refused
    try:
        return _Parse(name, file, mark, count).run(marked)
    except expat.ExpatError as error:
        raise _refused(error, file) from error


def _refused(error: expat.ExpatError, file: str) -> ReadError:
    what = expat.errors.messages[error.code]
    return ReadError(rules.READ_XML.at(f"{file}line {error.lineno}", f"{what} at column {error.offset + 1}"))


def _decoded(content: bytes, file: str) -> str:
    if not content.strip():
        raise ReadError(rules.READ_XML.at(f"{file}line 1", "the file is empty"))
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in content[:4096]:
        raise ReadError(rules.READ_ENCODING.at(file.strip(), "the file is UTF-16 or binary, not UTF-8"))
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start]
        raise ReadError(rules.READ_ENCODING.at(f"{file}line {line}", f"byte 0x{byte:02x} is not UTF-8")) from error


def _unused_sign(text: str) -> str:
    """A character of the private use area that a text has not, or "" if it has all."""
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

    def __init__(self, name: str, file: str, mark: str = "", marks: int = 0) -> None:
        self._name, self._file, self._mark, self._marks = name, file, mark, marks
        self._scan = Scan()
        self._names: list[set[str]] = [set()]
        self._path: list[str] = []
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
        self._parser.Parse(text, True)
        if self._marks:
            raise self._error(rules.READ_XML, 'there is a "<" where none may stand')
        return self._scan

    def _place(self) -> str:
        return f"{self._file}line {self._parser.CurrentLineNumber}"

    def _error(self, rule: Rule, message: str) -> ReadError:
        return ReadError(rule.at(self._place(), message))

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        del version, standalone
        if encoding and encoding.lower() not in _ENCODINGS and not self._ascii:
            raise self._error(rules.READ_ENCODING, f"the file says that it is {encoding}, and is UTF-8")

    def _doctype(self, *_: object) -> None:
        raise self._error(rules.READ_XML, "document type declarations are not read")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if self._mark:
            self._restore(attributes)
        self._scan.root = self._scan.root or tag
        if not self._path and tag == "materialx" and "version" not in attributes:
            self._scan.findings.append(rules.DOC_VERSION.at(self._place(), "the document states no version"))
        self._note_include(tag, attributes)
        name = attributes.get("name", "")
        if name and name in self._names[-1]:
            place = "/" + "/".join((*self._path[1:], name))
            line = f"line {self._parser.CurrentLineNumber} of {self._name}"
            message = f"{line} has a second element named '{name}', which is dropped"
            self._scan.findings.append(rules.DOC_DUPLICATE_NAME.at(place, message))
        self._names[-1].add(name)
        self._names.append(set())
        self._path.append(name or tag)
        if len(self._path) > MAXIMUM_XML_DEPTH:
            raise self._error(rules.READ_TOO_DEEP, f"elements are nested more than {MAXIMUM_XML_DEPTH} levels deep")

    def _restore(self, attributes: dict[str, str]) -> None:
        """Give values of attributes the signs back that were marked, and say so."""
        for name, value in attributes.items():
            if self._mark in value:
                self._marks -= value.count(self._mark)
                attributes[name] = value.replace(self._mark, "<")
                message = f'the value of {name} has a "<" in it: {attributes[name]}'
                self._scan.findings.append(rules.READ_XML_LENIENT.at(self._place(), message))

    def _note_include(self, tag: str, attributes: dict[str, str]) -> None:
        """Note an element that MaterialX takes for an inclusion; refuse those that it would drop without a word."""
        self._prefixes |= {name.partition(":")[2] for name, value in attributes.items() if value == _XINCLUDE}
        prefix, _, local = tag.rpartition(":")
        if local != "include" or prefix not in self._prefixes:
            return
        if prefix != "xi":
            raise self._error(rules.READ_INCLUDE, f"MaterialX knows inclusions as xi:include alone, not as {tag}")
        if len(self._path) != 1:
            raise self._error(
                rules.READ_INCLUDE, "MaterialX reads inclusions as children of the materialx element alone"
            )
        self._scan.includes.append(Include(self._parser.CurrentLineNumber, attributes.get("href", "")))

    def _end(self, tag: str) -> None:
        del tag
        self._names.pop()
        self._path.pop()
