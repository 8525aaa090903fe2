"""The untrusted file of one layer: checked, and opened as a layer that has no file."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from pxr import Ar, Sdf, Tf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.formats.usd.opening.composition_size import MAXIMUM_DEPTH, too_deep
from mrm_mtlx.formats.usd.opening.crates import refuse_damaged

if TYPE_CHECKING:
    from pathlib import Path

# Of all files of a stage together. Geometry may lie beside the materials, so that they are larger than documents.
MAXIMUM_STAGE_BYTES = 256 * 2**20

# How files of USD begin, what such a file is called, and what is expected of an ending.
_TEXT, _CRATE, _PACKAGE = b"#usda", b"PXR-USDC", b"PK\x03\x04"
_NAMES = {_TEXT: "USD text", _CRATE: "USD crate", _PACKAGE: "a package"}
_CONTENT = {".usda": (_TEXT,), ".usdc": (_CRATE,), ".usd": (_TEXT, _CRATE), ".usdz": (_PACKAGE,)}
# The endings of layers, and of packages of them.
SUFFIXES = tuple(_CONTENT)
PACKAGE_SUFFIX = ".usdz"
# What opens and closes a prim, and what may contain such signs: strings, asset paths, paths, and comments of the three
# kinds that USD knows. What is not closed, which USD refuses, goes on to the end: nothing is scanned twice.
_TOKENS = re.compile(
    rb'"""(?:[^"\\]++|\\.|"(?!""))*+(?:"""|\\?\Z)'
    rb"|'''(?:[^'\\]++|\\.|'(?!''))*+(?:'''|\\?\Z)"
    rb'|"(?:[^"\\\r\n]++|\\.)*+"?'
    rb"|'(?:[^'\\\r\n]++|\\.)*+'?"
    rb"|@@@(?:[^@\\]++|\\@@@|\\|@(?!@@))*+(?:@{3,5}|\Z)|@[^@\r\n]*@|<[^<>\r\n]*>"
    rb"|#[^\r\n]*|//[^\r\n]*|/\*(?:.*?\*/|.*)|[{}]",
    re.DOTALL,
)


class Opened(NamedTuple):
    """A layer that was opened, and whether it is a crate, whose values need not be of the types that are stated."""

    layer: Sdf.Layer
    is_crate: bool


def check_file(file: Path, place: str) -> bytes:
    """The kind of a file, by how it begins; it is regular, and what its name says.

    Raises
    ------
    ReadError
        If it is none of USD's files, or nested too deeply.
    """
    if not file.is_file():  # a pipe or a device would never end
        raise ReadError(rules.READ_FAILED.at(place, f"{file.name} is not a regular file"))
    try:
        with file.open("rb") as stream:
            head = stream.read(8)
            kind = next((kind for kind in _NAMES if head.startswith(kind)), None)
            if kind == _TEXT:
                _refuse_depth(head + stream.read(MAXIMUM_STAGE_BYTES), place)
            elif kind == _CRATE:
                refuse_damaged(stream, file.name, place)
    except OSError as error:
        raise ReadError(rules.READ_FAILED.at(place, f"{file.name}: {error.strerror}")) from error
    expected = _CONTENT.get(file.suffix.lower(), tuple(_NAMES))
    if kind is None or kind not in expected:
        found = "is empty" if not head else f"holds {_NAMES[kind]}" if kind else "is no file of USD"
        message = f"{file.name} {found}; expected {' or '.join(_NAMES[k] for k in expected)}"
        raise ReadError(rules.READ_FORMAT.at(place, message))
    return kind


def open_layer(file: Path, place: str) -> Opened:
    """Open a layer without a file of its own: what names it by its path, in this stage or another, does not find it.

    Raises
    ------
    ReadError
        If it cannot be read.
    """
    kind = check_file(file, place)
    name = str(file)
    if Sdf.Layer.SplitIdentifier(name)[1] or Ar.IsPackageRelativePath(name) or kind == _PACKAGE:
        raise ReadError(rules.READ_FAILED.at(place, f"{file.name} lies where USD takes its path for another"))
    try:
        layer = Sdf.Layer.OpenAsAnonymous(name, False, file.name)
    except Tf.ErrorException as error:
        raise ReadError(rules.READ_FORMAT.at(place, f"{file.name}: {said(error)}")) from error
    if layer is None:
        raise ReadError(rules.READ_FORMAT.at(place, f"USD cannot read {file.name}"))
    return Opened(layer, kind == _CRATE)


def _refuse_depth(text: bytes, place: str) -> None:
    """Refuse text that is nested too deeply for USD's parser; dictionaries and variants are nested, too."""
    depth = 0
    for match in _TOKENS.finditer(text):
        depth += {b"{": 1, b"}": -1}.get(match[0], 0)
        if depth > 2 * MAXIMUM_DEPTH:
            line = text.count(b"\n", 0, match.start()) + 1
            raise ReadError(too_deep(place or f"line {line}"))
