"""The node library in a folder of its own, for other MaterialX hosts."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.library.assembly import node_library_files, served
from mrm_mtlx.library.host_models import (
    FLAG_FILE,
    MODELS_FILE,
    flagged_definitions,
    surface_models_for,
    with_standard_nodes,
)
from mrm_mtlx.library.hosts import Choice, Form
from mrm_mtlx.library.portable.definitions import portable_library_files
from mrm_mtlx.library.standard_library import FIRST_DEFINED
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from mrm_mtlx.library.standard_library import StandardLibrary
    from mrm_mtlx.library.surface_models import Extension

# Not `pbrlib`: MaterialX stops at the first folder of a name on its search path, and a second `pbrlib` would hide the
# standard one, or be hidden by it.
FOLDER = "mrm"


@dataclass(frozen=True)
class HostLibrary:
    """The node library for a host.

    Attributes
    ----------
    files
        Contents by path below the folder.
    extensions
        Which surface models have the new input, or why not.
    """

    files: dict[str, bytes]
    extensions: tuple[Extension, ...]


def library_for(standard: StandardLibrary, form: Form, choice: Choice) -> HostLibrary:
    """The node library and the surface models for hosts of the MaterialX that a standard library is of.

    Raises
    ------
    StandardLibraryError
        If a file of the standard library cannot be read.
    LookupError
        If the node library does not serve its version.
    """
    files = nodes(standard.version, form)
    if form is Form.PORTABLE:
        files = with_standard_nodes(files, standard)
    elif choice is Choice.NAME and (text := flagged_definitions(files, standard.version)):
        files[FLAG_FILE] = text.encode()
    models = surface_models_for(standard, choice)
    if models.text:
        files[MODELS_FILE] = models.text.encode()
    return HostLibrary(files, models.extensions)


def nodes(version: str, form: Form) -> dict[str, bytes]:
    """The node library of a form alone.

    Raises
    ------
    LookupError
        If the version is not served in this form.
    """
    if form is Form.PORTABLE and served(version).walks_every_path:
        msg = f"the portable form is for MaterialX 1.39.2 and later: with {version}, its graphs are walked for hours"
        raise LookupError(msg)
    return portable_library_files(version) if form is Form.PORTABLE else node_library_files(version)


def write_library(destination: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write a node library to `destination/mrm`; the files, sorted: all, or none if one cannot be written.

    Files of the same name are overwritten. What else this project has written there for another host is removed, since
    a host reads every file of the folder; other files stay.

    Raises
    ------
    OSError
        If the destination cannot be written.
    """
    destination.mkdir(parents=True, exist_ok=True)
    folder = destination / FOLDER
    written = {folder / name: content for name, content in files.items()}
    with FileSet(destination) as unfinished:
        for path, content in written.items():
            unfinished.named(path).write_bytes(content)
    for path in (folder / name for name in sorted(_every_name())):
        if path not in written and path.is_file():
            path.unlink()
            with contextlib.suppress(OSError):  # something else is in it
                path.parent.rmdir()
    return sorted(written)


def _every_name() -> set[str]:
    """The files that the library has in any of its forms."""
    names = {name for version in FIRST_DEFINED for name in node_library_files(version)}
    return names | {*portable_library_files(next(iter(FIRST_DEFINED))), MODELS_FILE, FLAG_FILE}
