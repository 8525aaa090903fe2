"""The file formats that are read as, or written from, a MaterialX document, by the ending of the file's name."""

from __future__ import annotations

import errno
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary

    # Reads a document of MaterialX that a file of another format refers to, or raises an ReadError.
    DocumentReader = Callable[[Path, Reach], Document]


class Format(NamedTuple):
    """A format, and the module that has its `read` and `write`, which is imported where it is used.

    Files of some formats may `refer` to documents of MaterialX.
    """

    name: str
    suffixes: tuple[str, ...]
    module: str
    refer: bool = False

    def read(
        self, path: Path, reach: Reach, library: DataLibrary, scratch: Path, documents: DocumentReader
    ) -> Document:
        """Read an untrusted file.

        Parameters
        ----------
        path, reach
            The file, and where the names in it lead.
        library
            Its definitions.
        scratch
            An existing empty folder for files that are inside of the file; it has to live as long as they are needed.
        documents
            Reads the documents that the file refers to.

        Raises
        ------
        ReadError
            If it cannot be read, for any reason that lies in the file.
        """
        more = (documents,) if self.refer else ()
        read: Document = import_module(self.module).read(path, reach, library, scratch, *more)
        return read

    def write(self, source: Document, path: Path, library: DataLibrary, *, force: bool = False) -> list[Finding]:
        """Write a document and the files beside it, all or none; return what of it the format cannot say.

        Parameters
        ----------
        source
            The document; files that it names are opened only within its `reach`.
        path
            The file; its ending is one of `suffixes`. Whatever stands there is replaced, and with it what it
            names in its folder.
        library
            The document's definitions.
        force
            Whether files beside it may be replaced that are there already, with other content.

        Raises
        ------
        OSError
            If it cannot be written, or only by `force`.
        ReadError
            If a file that the document names may not be copied.
        NothingToWriteError
            If there is nothing in the document that the format can say, with the reasons.
        """
        if path.exists() and not path.is_file():
            raise OSError(errno.EINVAL, "it is not a regular file")
        module = import_module(self.module)
        with FileSet(path.parent, force, lambda: _named(path, module.names)) as files:
            findings: list[Finding] = module.write(source, path, library, files)
        return findings


def _named(path: Path, names: Callable[[Path], Iterable[str]]) -> set[Path]:
    """The files that one names that stands there already, tiles and frames included; none if it cannot be read."""
    reach = Reach.beside(path)
    try:
        found = [file for name in names(path) for file in reach.members(name)] if path.is_file() else []
    except (ReadError, OSError, ValueError):
        return set()
    return {file.parent.resolve() / file.name for file in found}


DOCUMENT = Format("MaterialX", (".mtlx",), "mrm_mtlx.formats.materialx.writing")
# Formats that are translated.
TRANSLATED = (
    Format("USD", (".usda", ".usdc", ".usd", ".usdz"), "mrm_mtlx.formats.usd", refer=True),
    Format("glTF", (".gltf", ".glb"), "mrm_mtlx.formats.gltf"),
)  # fmt: skip
# Endings of the files that a folder is searched for.
SUFFIXES = tuple(suffix for form in (DOCUMENT, *TRANSLATED) for suffix in form.suffixes)


def format_of(path: Path) -> Format | None:
    """The format that a file's ending means; None for an ending that is not known."""
    suffix = path.suffix.lower()
    return next((form for form in (DOCUMENT, *TRANSLATED) if suffix in form.suffixes), None)
