"""The container of an untrusted glTF asset, .gltf or .glb.

Its JSON is parsed, its header and chunks are checked, and a range of a buffer is read when it is asked for; geometry is
not read. pygltflib, which has classes for all of glTF, opens whatever path an asset names and checks neither types nor
ranges, and materialxgltf builds on it: what would be left of them here is four arrays and two headers.
"""

from __future__ import annotations

import base64
import binascii
import re
import struct
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import unquote

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats import json_text
from mrm_mtlx.formats.gltf.importer.locations import AssetLocations
from mrm_mtlx.formats.gltf.schema import problems
from mrm_mtlx.formats.json_text import kind
from mrm_mtlx.system.text import printable, shown

if TYPE_CHECKING:
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Rule

# Rules: what breaks glTF's rules, what MaterialX cannot say, and what the validation's catalogue has.
INVALID, LOST = rules.INTERCHANGE_INVALID, rules.INTERCHANGE_LOST
OUTSIDE, NO_FILE, TOO_LARGE = rules.READ_OUTSIDE, rules.DOC_FILE, rules.READ_TOO_LARGE

# Largest JSON that is read. A data URI has a third more than its bytes; geometry and large images belong beside it.
MAXIMUM_JSON_BYTES = 32 * 2**20
# Largest file of one image.
MAXIMUM_IMAGE_BYTES = 64 * 2**20
# Most elements of one array that is read; what is there takes a millisecond each.
MAXIMUM_COUNT = 10_000

# Arrays of the asset that materials need.
ARRAYS = ("materials", "textures", "images", "samplers", "bufferViews", "buffers")
_MAGIC, _VERSION = b"glTF", 2
_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_JSON, _BINARY = b"JSON", b"BIN\0"
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]*:")
_DATA = re.compile(r"data:(?P<type>[^;,]*)(?:;[^;,]*)*?(?P<base64>;base64)?,", re.IGNORECASE)


class GltfError(Exception):
    """Something that an asset names cannot be had; `finding` says why."""

    def __init__(self, rule: Rule, place: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.finding = rule.at(place, printable(message), hint)


@dataclass(frozen=True)
class Container:
    """An asset that was opened.

    Attributes
    ----------
    path, reach
        Its file, and where the names in it lead.
    locations
        Where what it says stands in the file.
    data
        Its JSON; each of `ARRAYS` that is there is an array of objects.
    binary
        Offset and length of the binary chunk in the file [bytes], or None.
    """

    path: Path
    reach: Reach
    locations: AssetLocations
    data: dict[str, Any]
    binary: tuple[int, int] | None
    _decoded: dict[int, bytes] = field(default_factory=dict, compare=False, repr=False)

    def element(self, array: str, index: int, user: str) -> dict[str, Any]:
        """An element of an array, checked against the schema.

        Raises
        ------
        GltfError
            If there is no such element, with `user`, the pointer to the index; or if it breaks the schema.
        """
        elements = self.data.get(array, [])
        if index >= len(elements):
            msg = f"it names element {index} of {array}, of which there are {len(elements)}"
            raise GltfError(INVALID, user, msg)
        element: dict[str, Any] = elements[index]
        for problem in problems(array.removesuffix("s"), element, json_text.pointer(array, index)):
            if problem.rule is INVALID:
                raise GltfError(problem.rule, problem.location, problem.message, problem.hint)
        return element

    def file(self, uri: str, place: str) -> Path:
        """The file that a URI means.

        Raises
        ------
        GltfError
            If it has a scheme, leads out of the folder, or there is no such file.
        """
        if _SCHEME.match(uri):
            msg = f"the URI {shown(uri)} is not relative; nothing but files beside the asset is opened"
            raise GltfError(OUTSIDE, place, msg, "Put the file beside the asset, and name it by a relative path.")
        name = unquote(uri)
        target = self.reach.inside(Path(name))
        if target is None:
            raise GltfError(OUTSIDE, place, f"the URI {shown(uri)} leads out of the folder being read")
        if not target.is_file():
            raise GltfError(NO_FILE, place, f"there is no file {shown(name)} beside the asset")
        return target

    def view(self, index: int, user: str) -> bytes:
        """The bytes of a buffer view.

        Raises
        ------
        GltfError
            If it does not exist, is larger than an image may be, or reaches beyond its buffer.
        """
        place = json_text.pointer("bufferViews", index)
        view = self.element("bufferViews", index, user)
        offset, length = int(view.get("byteOffset", 0)), int(view["byteLength"])
        buffer_index = int(view["buffer"])
        buffer = self.element("buffers", buffer_index, f"{place}/buffer")
        if length > MAXIMUM_IMAGE_BYTES:
            raise GltfError(TOO_LARGE, place, f"an image of more than {MAXIMUM_IMAGE_BYTES // 2**20} MiB")
        if offset + length > buffer["byteLength"]:
            msg = f"bytes {offset} to {offset + length} lie beyond the {buffer['byteLength']} of buffer {buffer_index}"
            raise GltfError(INVALID, place, msg)
        content = self._range(buffer_index, buffer, offset, length)
        if len(content) < length:
            msg = f"buffer {buffer_index} ends before the {buffer['byteLength']} bytes that it is said to have"
            raise GltfError(INVALID, json_text.pointer("buffers", buffer_index), msg)
        return content

    def _range(self, index: int, buffer: dict[str, Any], offset: int, length: int) -> bytes:
        place = json_text.pointer("buffers", index, "uri")
        if "uri" not in buffer:
            if index != 0 or self.binary is None:
                msg = "it has no uri; only the first buffer of a .glb with a binary chunk may have none"
                raise GltfError(INVALID, json_text.pointer("buffers", index), msg)
            start, size = self.binary
            return read_range(self.path, start + offset, max(0, min(length, size - offset)), place)
        if is_data(buffer["uri"]):
            if index not in self._decoded:
                self._decoded[index] = decoded(buffer["uri"], place)
            return self._decoded[index][offset : offset + length]
        return read_range(self.file(buffer["uri"], place), offset, length, place)


def open_container(path: Path, reach: Reach) -> Container:
    """Open a .gltf or .glb.

    Raises
    ------
    ReadError
        If it is no glTF 2.0, broken, or larger than is read.
    """
    try:
        return _opened(path, reach)
    except GltfError as error:
        raise ReadError(error.finding) from error


def _opened(path: Path, reach: Reach) -> Container:
    try:
        size = path.stat().st_size if path.is_file() else -1
        if size < 0:
            _refuse(rules.READ_FAILED, "it is not a regular file")
        with path.open("rb") as stream:
            is_binary = stream.read(len(_MAGIC)) == _MAGIC
    except OSError as error:
        _refuse(rules.READ_FAILED, f"the file cannot be opened: {error.strerror or 'no reason given'}")
    if path.suffix.lower() == ".glb" and not is_binary:
        _refuse(INVALID, "a .glb begins with the four bytes 'glTF'; this file does not")
    (start, length), binary = _chunks(path, size) if is_binary else ((0, size), None)
    if length > MAXIMUM_JSON_BYTES:
        found = f"its JSON has {length / 2**20:.0f} MiB, more than the {MAXIMUM_JSON_BYTES // 2**20} MiB that are read"
        _refuse(TOO_LARGE, found, "Keep images and geometry in files beside it, or write a .glb.")
    content, file = read_range(path, start, length, ""), reach.shown(path)
    try:
        data = json_text.parse(content)
    except json_text.JsonError as error:
        wrong = INVALID.at("", printable(str(error)), "Correct the place that is named.")
        line, column = (None, None) if is_binary or error.position is None else error.position
        raise ReadError(replace(wrong, source=SourceLocation(file, line, column, pointer=""))) from error
    except RecursionError:
        _refuse(rules.READ_TOO_DEEP, "its JSON is nested more deeply than is read", "glTF has some ten levels.")
    locations = AssetLocations(file, content, is_text=not is_binary)
    try:
        _check(data)
    except ReadError as error:
        raise ReadError(replace(error.finding, source=locations.of(error.finding.location))) from error
    return Container(path, reach, locations, data, binary)


def read_range(path: Path, offset: int, length: int, place: str) -> bytes:
    """Bytes of a file, fewer where it ends before.

    Raises
    ------
    GltfError
        If it cannot be read.
    """
    try:
        with path.open("rb") as stream:
            stream.seek(offset)
            return stream.read(length)
    except OSError as error:
        msg = f"{path.name} cannot be read: {error.strerror or 'no reason given'}"
        raise GltfError(rules.READ_FAILED, place, msg) from error


def is_data(uri: str) -> bool:
    """True if a URI has the bytes themselves."""
    return uri[:5].lower() == "data:"


def decoded(uri: str, place: str) -> bytes:
    """The bytes of a data URI.

    Raises
    ------
    GltfError
        If it is not in base64.
    """
    head = _DATA.match(uri)
    if head is None or head["base64"] is None:
        raise GltfError(INVALID, place, f"expected data:<media type>;base64,<bytes>, got {shown(uri)}")
    try:
        return base64.b64decode(uri[head.end() :], validate=True)
    except (binascii.Error, ValueError) as error:
        raise GltfError(INVALID, place, f"the data URI is no base64: {error}") from None


def media_type(uri: str) -> str:
    """The media type that a data URI states, "" for none."""
    head = _DATA.match(uri)
    return "" if head is None else head["type"].lower()


def _chunks(path: Path, size: int) -> tuple[tuple[int, int], tuple[int, int] | None]:
    """Offset and length of the JSON and the binary chunk."""
    header = read_range(path, 0, _HEADER.size, "")
    if len(header) < _HEADER.size:
        _refuse(INVALID, f"the file ends within the {_HEADER.size} bytes of its header")
    _, version, length = _HEADER.unpack(header)
    if version != _VERSION:
        _refuse(INVALID, f"it is version {version} of the container; expected {_VERSION}")
    if length != size:
        cut = "; it was cut short" if length > size else ""
        _refuse(INVALID, f"its header says {length} bytes, the file has {size}{cut}")
    found: dict[bytes, tuple[int, int]] = {}
    at = _HEADER.size
    while at < size:
        head = read_range(path, at, _CHUNK.size, "")
        if len(head) < _CHUNK.size:
            _refuse(INVALID, f"the file ends within the head of a chunk, at byte {at}")
        length, name = _CHUNK.unpack(head)
        at += _CHUNK.size
        if at + length > size:
            _refuse(INVALID, f"the chunk at byte {at - _CHUNK.size} says {length} bytes; {size - at} are left")
        if not found and name != _JSON:
            _refuse(INVALID, "its first chunk is not JSON")
        found.setdefault(name, (at, length))
        at += length
        if len(found) > 1 or at >= size:  # more chunks are extensions, which is not read
            break
    if _JSON not in found:
        _refuse(INVALID, "it has no JSON chunk")
    return found[_JSON], found.get(_BINARY)


def _check(data: dict[str, Any]) -> None:
    """Refuse what is not glTF 2.0, or has arrays that are none."""
    asset = data.get("asset")
    asset = asset if isinstance(asset, dict) else {}
    version = asset.get("version")
    if not isinstance(version, str) or not re.fullmatch(r"2\.\d{1,3}", version):
        found = shown(version) if isinstance(version, str) else "nothing of the kind"
        _refuse(INVALID, f"expected the version of glTF, '2.0', got {found}", place="/asset/version")
    least = asset.get("minVersion", "2.0")
    if least != "2.0":
        _refuse(INVALID, f"it asks for version {shown(str(least))}; 2.0 is read", place="/asset/minVersion")
    for name in ARRAYS:
        elements = data.get(name, [])
        if not isinstance(elements, list):
            _refuse(INVALID, f"expected an array, got {kind(elements)}", place=f"/{name}")
        if len(elements) > MAXIMUM_COUNT:
            _refuse(TOO_LARGE, f"{len(elements)} elements; up to {MAXIMUM_COUNT} are read", place=f"/{name}")
        for index, element in enumerate(elements):
            if not isinstance(element, dict):
                _refuse(INVALID, f"expected an object, got {kind(element)}", place=f"/{name}/{index}")


def _refuse(rule: Rule, message: str, hint: str = "", place: str = "") -> NoReturn:
    raise ReadError(rule.at(place, printable(message), hint))
