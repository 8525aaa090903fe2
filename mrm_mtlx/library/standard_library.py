"""The standard library of another MaterialX: a folder of data, which the installed MaterialX reads; nothing is run."""

from __future__ import annotations

import importlib.util
import os
import re
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.library.surface_models import SURFACE_MODELS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from mrm_mtlx.library.hosts import Host

# A definition that a version has got, newest first: the files themselves say "1.39" in all of them.
FIRST_DEFINED = {
    "1.39.6": "ND_maxcomponent_color3",
    "1.39.5": "ND_extract_matrix33",
    "1.39.4": "ND_fractal2d_color3",
    "1.39.3": "ND_fract_float",
    "1.39.2": "ND_chiang_hair_bsdf",
    "1.39.1": "ND_open_pbr_surface_to_standard_surface",
    "1.39.0": "ND_normalmap_float",
}

# Its folders; every host has them, however its folder of data is called.
PARTS = ("stdlib", "pbrlib", "bxdf")
_MARK = Path("pbrlib", "pbrlib_defs.mtlx")

# Bytes of a file of definitions; the largest of MaterialX has 300,000.
_LARGEST_FILE = 16 << 20
# Folders that are looked through for one; an installation of Blender has 2,000.
_MOST_FOLDERS = 20_000


class StandardLibraryError(ValueError):
    """A folder is not the standard library that is needed; the message says what was found, and what to do."""


@dataclass(frozen=True)
class StandardLibrary:
    """A folder of MaterialX's data.

    Attributes
    ----------
    folder
        Holds `stdlib`, `pbrlib` and `bxdf`.
    version
        Of its MaterialX, told from its definitions.
    origin
        Where it is from, in words.
    """

    folder: Path
    version: str
    origin: str

    def surface_models(self) -> mx.Document:
        """Definitions and graphs of the surface models that the node library extends.

        Raises
        ------
        StandardLibraryError
            If a file cannot be read.
        """
        document = mx.createDocument()
        for model in SURFACE_MODELS:
            path = self.folder / "bxdf" / f"{model.node}.mtlx"
            if path.is_file():
                document.importLibrary(_read(path))
        return document

    def nodes(self) -> mx.Document:
        """Definitions of the physically based library; errors as for `surface_models`."""
        return _read(self.folder / _MARK)


def given(path: Path, version: str) -> StandardLibrary:
    """The standard library in or below a folder that the user names.

    Raises
    ------
    StandardLibraryError
        If there is none, or one of another version.
    """
    if not path.is_dir():
        msg = f"'{path}' is no folder"
        raise StandardLibraryError(msg)
    folder = find(path)
    if folder is None:
        msg = (
            f"no standard library of MaterialX in '{path}': expected a folder that holds {', '.join(PARTS)} "
            f"(most hosts call it 'libraries')"
        )
        raise StandardLibraryError(msg)
    found = version_of_folder(folder)
    if found != version:
        is_of = f"is of MaterialX {found}" if found else "is of a MaterialX before 1.39, or of none that is known"
        msg = f"'{folder}' {is_of}, and {version} is needed: name the folder of the host itself, or the version"
        raise StandardLibraryError(msg)
    return StandardLibrary(folder, found, f"'{folder}'")


def of_hosts(hosts: Iterable[Host], version: str) -> StandardLibrary | None:
    """The standard library of the first host that has the version, where it is commonly installed; None if none has."""
    for place in chain.from_iterable(map(_places, hosts)):
        folder = find(place)
        if folder is not None and version_of_folder(folder) == version:
            return StandardLibrary(folder, version, f"'{folder}'")
    return None


def installed(version: str) -> StandardLibrary | None:
    """The standard library of the installed MaterialX if it has this version, else None."""
    for root in mx.getDefaultDataSearchPath().asString().split(mx.PATH_LIST_SEPARATOR):
        folder = find(Path(root)) if root else None
        if folder is not None and version_of_folder(folder) == version:
            return StandardLibrary(folder, version, "the MaterialX that is installed here")
    return None


def find(path: Path) -> Path | None:
    """The folder, of this one and those below it, that holds the parts of a standard library: the topmost; or None.

    Links are not followed.
    """
    todo, number = [path], 0
    while todo and number < _MOST_FOLDERS:
        folder, *todo = todo
        number += 1
        if (folder / _MARK).is_file() and all((folder / part).is_dir() for part in PARTS):
            return folder
        todo += _folders_in(folder)
    return None


def version_of_folder(folder: Path) -> str:
    """Version of the MaterialX whose data a folder holds; "" if it is older than 1.39.

    Raises
    ------
    StandardLibraryError
        If a file cannot be read.
    """
    defined: set[str] = set()
    for path in _definition_files(folder):
        defined.update(re.findall(r'\bname="(ND_\w+)"', _text(path)))
    return next((version for version, name in FIRST_DEFINED.items() if name in defined), "")


def _places(host: Host) -> Iterator[Path]:
    spec = importlib.util.find_spec(host.module) if host.module else None
    for location in (spec.submodule_search_locations or ()) if spec else ():
        yield Path(location)
    for pattern in (Path(place).expanduser() for place in host.places):
        if pattern.is_absolute():  # else it is of another system
            root = Path(pattern.anchor)
            yield from sorted(path for path in root.glob(str(pattern.relative_to(root))) if path.is_dir())


def _folders_in(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            return sorted(Path(e.path) for e in entries if e.is_dir(follow_symlinks=False))
    except OSError:  # not for us to read
        return []


def _definition_files(folder: Path) -> list[Path]:
    of_parts = [path for part in PARTS for path in (folder / part).glob("*.mtlx")]
    found = [*of_parts, *(folder / "bxdf" / "translation").glob("*.mtlx")]
    return sorted(path for path in found if path.is_file())  # a pipe would be waited for


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST_FILE:
            msg = f"'{path}' has more than {_LARGEST_FILE >> 20} MB, which no file of definitions has"
            raise StandardLibraryError(msg)
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        msg = f"'{path}' cannot be read: {error.strerror or error}"
        raise StandardLibraryError(msg) from error


def _read(path: Path) -> mx.Document:
    """A file as a document; what it would include is not read."""
    document, options = mx.createDocument(), mx.XmlReadOptions()
    options.readXIncludeFunction = None
    try:
        mx.readFromXmlString(document, _text(path), mx.FileSearchPath(), options)
    except Exception as error:  # MaterialX's exceptions have no base of their own
        msg = f"'{path}' is no MaterialX document: {error}"
        raise StandardLibraryError(msg) from error
    return document
