"""The node library as a version of MaterialX wants it: what is common to all, and the closures of its dialect."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from mrm_mtlx.library.dialects import Dialect, dialect
from mrm_mtlx.library.paths import node_library_folder

if TYPE_CHECKING:
    from pathlib import Path

_DIALECTS = "dialects"
_GLSL_LIST, _MSL_LIST = "genglsl/mrm_genglsl_impl.mtlx", "genmsl/mrm_genmsl_impl.mtlx"


def node_library_files(version: str) -> dict[str, bytes]:
    """Contents of the node library for a version of MaterialX, by path relative to its folder, sorted.

    Written to one folder they are all that a host of this version needs, but for the surface models.

    Raises
    ------
    LookupError
        If the library does not serve the version; the message says why.
    ValueError
        If it is no version.

    Examples
    --------
    >>> [name for name in node_library_files("1.39.3") if name.endswith(".glsl")][:2]
    ['genglsl/lib/mrm_retroreflection.glsl', 'genglsl/mrm_conductor_bsdf.glsl']
    """
    spoken = served(version)
    files = {name: path.read_bytes() for name, path in source_files(spoken).items()}
    if not spoken.msl_inherits:
        files[_MSL_LIST] = _for_msl(files[_GLSL_LIST])
    return dict(sorted(files.items()))


def served(version: str) -> Dialect:
    """The dialect of a version of MaterialX that the node library serves; errors as for `node_library_files`."""
    spoken = dialect(version)
    if spoken.unserved:
        msg = f"the node library serves MaterialX 1.39.0 and later, not {version}: {spoken.unserved}"
        raise LookupError(msg)
    return spoken


def source_files(spoken: Dialect) -> dict[str, Path]:
    """The files of a dialect by their paths in the library, as they lie in this package: its own before the common."""
    root = node_library_folder() / "pbrlib"
    dialects = root / _DIALECTS
    files = {name: path for name, path in _below(root).items() if not path.is_relative_to(dialects)}
    return files | _below(dialects / spoken.closures) if spoken.closures else files


def _below(folder: Path) -> dict[str, Path]:
    return {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}


def _for_msl(glsl: bytes) -> bytes:
    """The list of implementations for GLSL as one for MSL: the same functions of the same files."""
    document = ET.fromstring(glsl)
    for implementation in document:
        file = PurePosixPath("..", PurePosixPath(_GLSL_LIST).parent, implementation.attrib["file"])
        implementation.set("name", implementation.attrib["name"].replace("_genglsl", "_genmsl"))
        implementation.set("file", str(file))
        implementation.set("target", "genmsl")
    ET.indent(document)
    text = ET.tostring(document, encoding="unicode")
    return f'<?xml version="1.0"?>\n{text}\n'.encode()
