"""Untrusted packages (.usdz): unpacked within bounds, and refused where programs would find other files.

A package is a ZIP archive of files stored as they are, one behind the other (USDZ specification). USD finds them by
their own headers, other programs by the directory at the end; here both have to say the same, so that what is checked
is what a host opens.
"""

from __future__ import annotations

import lzma
import struct
import zipfile
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple, NoReturn

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.system.text import shown

if TYPE_CHECKING:
    from collections.abc import Iterator

# Of all files in a package together, unpacked; and their number.
MAXIMUM_PACKAGE_BYTES = 256 * 2**20
MAXIMUM_FILES = 4096

# Files in a package begin at multiples of this, so that they can be mapped into memory (USDZ specification).
ALIGNMENT = 64
# What a package may hold (layers, images, sounds), for USD's validator of files' endings.
_ENDINGS = (
    *("usda", "usdc", "usd", "usdz", "mtlx"),
    *("png", "jpg", "jpeg", "exr", "avif"),
    *("m4a", "mp3", "wav"),
)
# A file's header (ZIP, APPNOTE 4.3.7) up to its name: signature, flags, method, sizes, length of name and extra field.
_HEADER = struct.Struct("<4s2xHH4x4xIIHH")
_SIGNATURE = b"PK\x03\x04"
_ENCRYPTED, _SIZES_BEHIND = 0x1, 0x8
# A file whose sizes stand behind it has at most this much there (APPNOTE 4.3.9).
_DESCRIPTOR = 24
# What Python's zipfile raises of an archive that is damaged.
_ERRORS = (
    *(zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError),
    *(ValueError, struct.error, zlib.error, lzma.LZMAError, OverflowError),
)


class Package(NamedTuple):
    """A package that was unpacked.

    Attributes
    ----------
    folder
        The folder that has its files.
    first
        Its first file, which is the layer that the package means.
    problems
        What two of USD's validators would say of it, which would open it anew: the kind, and the message.
    """

    folder: Path
    first: Path
    problems: list[tuple[str, str]]


def unpack(path: Path, folder: Path, place: str) -> Package:
    """Take the files out of a package; those whose names lead out of it are left there.

    Parameters
    ----------
    path, folder
        The package, and an empty folder.
    place
        What is named as the place of what is wrong.

    Raises
    ------
    ReadError
        If it is damaged, larger than the bounds, or no package of USD.
    """
    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream, metadata_encoding="utf-8") as package:
            entries = sorted(package.infolist(), key=lambda entry: entry.header_offset)
            _refuse_large(entries, place)
            problems = list(_checked(stream, entries, path.name, place))
            files = [_extract(package, entry, folder) for entry in entries if not entry.is_dir()]
    except _ERRORS as error:
        # An error of the system names a folder of this machine.
        reason = error.strerror or "no reason given" if isinstance(error, OSError) else str(error) or "it is damaged"
        _refuse(f"the package {path.name} cannot be unpacked: {' '.join(reason.split())}", place)
    if not files or files[0] is None:
        _refuse(f"the package {path.name} does not begin with a layer", place)
    return Package(folder, files[0], problems)


def _refuse_large(entries: list[zipfile.ZipInfo], place: str) -> None:
    size = sum(entry.file_size for entry in entries)
    if size > MAXIMUM_PACKAGE_BYTES or len(entries) > MAXIMUM_FILES:
        found = f"{len(entries)} files of {size / 2**20:.0f} MiB"
        bounds = f"{MAXIMUM_FILES} files and {MAXIMUM_PACKAGE_BYTES // 2**20} MiB are read"
        raise ReadError(rules.READ_TOO_LARGE.at(place, f"the package holds {found}; {bounds}"))


def _checked(stream: BinaryIO, entries: list[zipfile.ZipInfo], name: str, place: str) -> Iterator[tuple[str, str]]:
    """Refuse files that are not stored one behind the other as the directory says; yield `Package.problems`."""
    end = described = 0
    for entry in entries:
        file = shown(entry.filename, quote="")
        stream.seek(entry.header_offset)
        header = stream.read(_HEADER.size)
        if len(header) < _HEADER.size:
            _refuse(f"the package {name} cannot be unpacked: the header of {file} is cut short", place)
        signature, flags, method, packed, size, *lengths = _HEADER.unpack(header)
        if signature != _SIGNATURE:
            _refuse(f"the package {name} cannot be unpacked: there is no header where {file} is to begin", place)
        if (flags | entry.flag_bits) & _ENCRYPTED:
            _refuse(f"the package {name} cannot be unpacked: {file} is encrypted", place)
        if method != zipfile.ZIP_STORED or entry.compress_type != zipfile.ZIP_STORED:
            _refuse(f"{file} is compressed; a package of USD holds its files as they are", place)
        sizes = {entry.file_size, entry.compress_size} | (set() if flags & _SIZES_BEHIND else {packed, size})
        if len(sizes) > 1:
            _refuse(f"the package {name} cannot be unpacked: it states several sizes of {file}", place)
        behind = entry.header_offset - end
        if behind < 0:
            _refuse(f"the package {name} cannot be unpacked: {file} overlaps the file before it", place)
        if behind > described:
            _refuse(
                f"the package {name} cannot be unpacked: before {file} there is what its directory does not name",
                place,
            )
        start = entry.header_offset + _HEADER.size + sum(lengths)
        end = start + entry.file_size
        described = _DESCRIPTOR if flags & _SIZES_BEHIND else 0
        if not entry.is_dir():
            yield from _problems(entry.filename, start, name)


def _problems(filename: str, start: int, package: str) -> Iterator[tuple[str, str]]:
    file = shown(filename, quote="")
    suffix = filename.rpartition("/")[2].rpartition(".")[2]
    if suffix.lower() not in _ENDINGS:
        kind = "usdUtilsValidators:FileExtensionValidator.UnsupportedFileExtensionInPackage"
        yield kind, f"File '{file}' in package '{package}' has an unknown unsupported extension {shown(suffix)}."
    if start % ALIGNMENT:
        kind = "usdUtilsValidators:RootPackageValidator.ByteMisalignment"
        yield kind, f"File '{file}' in package '{package}' has an invalid offset {start}."


def _extract(package: zipfile.ZipFile, entry: zipfile.ZipInfo, folder: Path) -> Path | None:
    """The file that an entry becomes; None if its name leads out of the folder."""
    target = Reach.only(folder).inside(Path(entry.filename))
    if target is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        with package.open(entry) as stream:
            target.write_bytes(stream.read(entry.file_size))
    return target


def _refuse(message: str, place: str) -> NoReturn:
    raise ReadError(rules.READ_FORMAT.at(place, message))
