"""Untrusted XML of MaterialX as a document, with what it includes.

MaterialX's reader is fast and trusting: it recurses over nested elements and opens whatever an include names. So it
opens nothing here: each file is read once, looked at (`xml_scan`), and MaterialX is given those very bytes.
"""

from __future__ import annotations

import os
import posixpath
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import MaterialX as mx

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.documents.elements import location, nodes_of
from mrm_mtlx.documents.files import read_regular
from mrm_mtlx.documents.locations import XmlLocations
from mrm_mtlx.documents.xml_scan import Include, Scan, scan
from mrm_mtlx.findings import rules
from mrm_mtlx.library.dialects import lacks_retroreflective
from mrm_mtlx.library.surface_models import FLAG, MICROFACET_NODES
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.documents.xml_elements import XmlElements
    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.library import DataLibrary


class _File(NamedTuple):
    """A file that was read: where it lies, its bytes, and what they include, in order."""

    path: Path
    content: bytes
    includes: list[_File]


@dataclass
class _Reading:
    """The state of reading a document and its includes."""

    reach: Reach
    size: int = 0
    includes: int = 0
    findings: list[Finding] = field(default_factory=list)
    known: dict[Path, tuple[bytes, Scan]] = field(default_factory=dict)

    def elements(self) -> dict[str, tuple[str, XmlElements]]:
        """The elements of the files, as `XmlLocations` has them."""
        return {str(path): (found.file, found.elements) for path, (_, found) in self.known.items()}


def read(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
    """Read a document with what it includes; see `formats.format`."""
    del scratch  # nothing is inside of it
    return read_xml(path, reach, library)


def read_xml(path: Path, reach: Reach, library: DataLibrary) -> Document:
    """The same, also of a document that a file of another format refers to.

    Raises
    ------
    ReadError
        If it cannot be read.
    """
    reading = _Reading(reach)
    file = _read(path.absolute(), reading, ())
    try:
        document = _document(file)
        _find_sources(document, reach, library)
        document.setDataLibrary(library.document)
    except Exception as error:  # MaterialX throws several unrelated types
        raise ReadError(rules.DOC_INVALID.at("", f"MaterialX cannot read it: {error}")) from error
    reading.findings += _flags_of_later_versions(document, reading)
    locations = XmlLocations(document, reach.shown(path), reading.elements())
    return Document(materialx=document, path=path, reach=reach, locations=locations, findings=reading.findings)


def _document(file: _File) -> mx.Document:
    """The document of a file, as MaterialX's reader makes it: first what is included, then the file's own elements.

    Sources of implementations are relative to the file that has them; that is what the URI is for.
    """
    options = mx.XmlReadOptions()
    options.readXIncludeFunction = None
    document = mx.createDocument()
    document.setSourceUri(str(file.path))
    for included in file.includes:
        document.importLibrary(_document(included))
    mx.readFromXmlString(document, file.content, mx.FileSearchPath(), options)
    return document


def _flags_of_later_versions(document: mx.Document, reading: _Reading) -> Iterator[Finding]:
    """Findings on the flag in a file that states a version without it, and that MaterialX has upgraded."""
    earlier = {str(path): found.version for path, (_, found) in reading.known.items()}
    earlier = {uri: version for uri, version in earlier.items() if lacks_retroreflective(version)}
    if not earlier:
        return
    for node in nodes_of(document):
        version = earlier.get(node.getActiveSourceUri())
        flag = node.getInput(FLAG) if version and node.getCategory() in MICROFACET_NODES else None
        if flag is not None:
            message = f"the file states version {version}, in which {node.getCategory()} has no such input"
            yield rules.RETRO_VERSION.at(location(flag), message)


def _find_sources(document: mx.Document, reach: Reach, library: DataLibrary) -> None:
    """Name sources that only the folders to be searched have by absolute paths: generators do not look there."""
    for child in document.getChildren():
        if child.isA(mx.Implementation) and child.getFile():
            beside = replace(reach, folder=Path(child.getActiveSourceUri()).parent, search=library.source_folders)
            found = replace(beside, search=reach.search).find(child.getFile())
            if found is not None and beside.find(child.getFile()) is None:
                child.setFile(str(found.absolute()))


def _read(path: Path, reading: _Reading, parents: tuple[Path, ...]) -> _File:
    """Read a file and all that it includes; `parents` are the files that include it, the document first."""
    content, found = _scanned(path, reading, is_document=not parents)
    chain = (*parents, path)
    return _File(path, content, [_included(include, chain, reading) for include in found.includes])


def _included(include: Include, chain: tuple[Path, ...], reading: _Reading) -> _File:
    """Read what the last file of a chain includes.

    Names are relative to its own folder, as XInclude has it. MaterialX looks in those of the including files as well.
    """
    folders = [path.parent for path in reversed(chain)]
    reach = replace(reading.reach, folder=folders[0], search=(*folders[1:], *reading.reach.search))
    path = reach.locate(include.href)
    target = reach.inside(path)
    line = include.source.line
    place = f"line {line}" if len(chain) == 1 else f"{chain[-1].name} line {line}"

    def refuse(rule: Rule, message: str) -> NoReturn:
        raise ReadError(replace(rule.at(place, message), source=include.source))

    if target is None:
        refuse(rules.READ_OUTSIDE, f"the include '{include.href}' lies outside the folder being checked")
    targets = [reach.inside(file) for file in chain]
    if target in targets:
        names = " -> ".join(file.name for file in (*chain[targets.index(target) :], target))
        refuse(rules.READ_INCLUDE, f"the document includes itself: {names}")
    if not target.is_file():
        problem = "is not a regular file" if target.exists() else "does not exist"
        refuse(rules.READ_INCLUDE, f"the included document '{include.href}' {problem}")
    reading.includes += 1
    if reading.includes > MAXIMUM_INCLUDES:
        refuse(rules.READ_INCLUDE, f"more than {MAXIMUM_INCLUDES} inclusions")
    return _read(path, reading, chain)


def _scanned(path: Path, reading: _Reading, *, is_document: bool) -> tuple[bytes, Scan]:
    """Content of a file and what the scan of it says; a file that is included twice is read once, and counts twice."""
    if path not in reading.known:
        content = _content(path, "" if is_document else path.name)
        _count(path, content, reading)
        # Names of includes may lead up and down again.
        file = reading.reach.shown(path) if is_document else posixpath.normpath(reading.reach.shown(path))
        reading.known[path] = content, scan(content, file, is_document=is_document)
        reading.findings += reading.known[path][1].findings
    else:
        _count(path, reading.known[path][0], reading)
    content, found = reading.known[path]
    if is_document and found.root != "materialx":
        raise ReadError(rules.DOC_INVALID.at("", f"the root element is <{found.root}>, expected <materialx>"))
    return content, found


def _count(path: Path, content: bytes, reading: _Reading) -> None:
    """Add a file to the size of all that is read."""
    reading.size += len(content) if len(content) <= MAXIMUM_DOCUMENT_BYTES else path.stat().st_size
    if reading.size > MAXIMUM_DOCUMENT_BYTES:
        found = f"{reading.size / 2**20:.0f} MiB, more than the {MAXIMUM_DOCUMENT_BYTES // 2**20} MiB that are read"
        raise ReadError(rules.READ_TOO_LARGE.at("", f"document and includes have {found}"))


def _content(path: Path, place: str) -> bytes:
    """Bytes of a file, as many as are read and one more."""
    try:
        content = read_regular(path, MAXIMUM_DOCUMENT_BYTES + 1)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else "no reason given"
        raise ReadError(rules.READ_FAILED.at(place, f"the file cannot be opened: {reason}")) from error
    if content is None:
        raise ReadError(rules.READ_FAILED.at(place, "it is not a regular file"))
    return content
