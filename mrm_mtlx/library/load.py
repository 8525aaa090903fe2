"""Loading the data libraries in the order that makes ours win."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from pathlib import Path, PurePosixPath
from posixpath import normpath
from typing import Any

import MaterialX as mx

from mrm_mtlx.library.assembly import node_library_files, served, source_files
from mrm_mtlx.library.dialects import materialx_version, module
from mrm_mtlx.library.paths import node_library_folder
from mrm_mtlx.library.surface_models import Extension, extend


class Origin(StrEnum):
    """Whose implementation of the retroreflective BSDFs is used."""

    MRM = "mrm"
    UPSTREAM = "upstream"


@dataclass(frozen=True)
class DataLibrary:
    """A loaded data library.

    Attributes
    ----------
    origin
        `mrm`: the node library of this project over the standard library. `upstream`: the standard library alone.
    document
        All definitions and implementations; shared, to be read only.
    search_path
        Where source files and their includes are found.
    surface_models
        Which surface models got an input for retroreflectivity, or why not; empty for the standard library alone.
    """

    origin: Origin
    document: mx.Document
    search_path: mx.FileSearchPath
    surface_models: tuple[Extension, ...] = ()

    @property
    def source_folders(self) -> tuple[Path, ...]:
        """The folders of `search_path`."""
        return tuple(Path(folder) for folder in self.search_path.asString().split(mx.PATH_LIST_SEPARATOR))


def definitions_for(element: Any) -> Any:
    """The document with the libraries' definitions for an element: its own document if that has no data library."""
    document = element.getDocument()
    return document.getDataLibrary() if _has_data_libraries() and document.hasDataLibrary() else document


def set_data_library(document: mx.Document, definitions: mx.Document) -> None:
    """Give a document the definitions of a library: a reference, or a copy where MaterialX has no data libraries.

    A copy lacks what has the name of an element of the document.
    """
    if _has_data_libraries():
        document.setDataLibrary(definitions)
    else:
        document.importLibrary(definitions)


def _has_data_libraries() -> bool:
    return module().has_data_libraries


def load_library(origin: Origin = Origin.MRM) -> DataLibrary:
    """Load the standard library and, for `Origin.MRM`, ours before it; one copy per process.

    MaterialX keeps the first element of a name and the first implementation of a definition, so ours is loaded first.
    Each of the two is loaded in a call and with a search path of its own: a folder name resolves to its first match on
    the path alone, so that one common path would hide one of the two libraries. The surface models that both are needed
    for come last.
    """
    return _load(origin)


def add_node_library(document: mx.Document) -> None:
    """Add the node library to a document, as the installed MaterialX wants it; its sources stay where they lie."""
    version = materialx_version()
    sources = source_files(served(version))
    for name, content in node_library_files(version).items():
        if PurePosixPath(name).suffix == ".mtlx":
            part = mx.createDocument()
            mx.readFromXmlString(part, content.decode())
            part.setSourceUri(str(node_library_folder() / "pbrlib" / name))
            for implementation in part.getImplementations():
                # The folders of a dialect and of what is common to all lie apart: a path from here would not be found.
                implementation.setFile(str(sources[normpath(PurePosixPath(name).parent / implementation.getFile())]))
            document.importLibrary(part)


@cache
def _load(origin: Origin) -> DataLibrary:
    document = mx.createDocument()
    search_path = mx.getDefaultDataSearchPath()
    if origin is Origin.MRM:
        add_node_library(document)
        search_path.append(mx.FileSearchPath(str(node_library_folder())))
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    return DataLibrary(origin, document, search_path, extend(document) if origin is Origin.MRM else ())
