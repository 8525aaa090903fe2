"""The contract of file formats: names, endings, what can be done with files of one, and the module that does it."""

from __future__ import annotations

import errno
from dataclasses import dataclass
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.options import Options
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.measured import Coefficient


class NothingToWriteError(ValueError):
    """A document has nothing that the format can say; `findings` say why."""

    def __init__(self, findings: list[Finding]) -> None:
        super().__init__("it has no material that the format can say; nothing was written")
        self.findings = findings


class UnevaluatedSurfaceError(Exception):
    """A surface has values that the format needs, and that the reference cannot evaluate."""


class UnreadableImagesError(Exception):
    """A surface has images that the format needs, and that cannot be read; `findings` say which."""

    def __init__(self, findings: list[Finding]) -> None:
        super().__init__("; ".join(found.message for found in findings))
        self.findings = findings


class Comparison(Protocol):
    """The result of comparing a document with a file; its text is the report, with the verdict last."""

    @property
    def equal(self) -> bool:
        """True if both say the same."""


class Capability(StrEnum):
    """Something that can be done with files of a format, by a function of that name in its module."""

    READ = "read"
    WRITE = "write"
    COMPARE = "compare"
    COEFFICIENTS = "coefficients"


@dataclass(frozen=True)
class Format:
    """A file format.

    Its module is imported where it is used, and has a function for each of the capabilities, with the parameters of the
    method of that name here, options only if the format has some. That of `write` is given the set of files to write
    into: `write(document, path, library, files)`; a format that writes files beside its own also has `names(path)`, the
    names of files that a file of it has.

    Attributes
    ----------
    name
        What options and Python call it.
    title
        What messages call it.
    suffixes
        Endings of its files, in lower case.
    module
        Where its functions are.
    capabilities
        What can be done.
    ambiguous
        Whether other files have these endings, too. Then folders are not searched for them, the module's
        `recognises(start)` tells a file of the format by its first bytes, and what is written may have any ending if
        `--to` names the format.
    holds_networks
        Whether a file of it holds nodes of MaterialX as they are.
    options
        The class of its options, "module:Class"; "" for none.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    module: str
    capabilities: frozenset[Capability] = frozenset((Capability.READ, Capability.WRITE))
    ambiguous: bool = False
    holds_networks: bool = False
    options: str = ""

    def can(self, capability: Capability) -> bool:
        """True if the format has a capability."""
        return capability in self.capabilities

    @property
    def options_class(self) -> type[Options]:
        """The class of its options."""
        module, _, name = self.options.partition(":")
        found: type[Options] = getattr(import_module(module), name) if module else Options
        return found

    @property
    def writes_beside(self) -> bool:
        """True if there may be files beside a file that is written."""
        return self.can(Capability.WRITE) and hasattr(self._module, "names")

    def recognises(self, start: bytes) -> bool:
        """True if a file with these first bytes may be one of the format."""
        return not self.ambiguous or bool(self._module.recognises(start))

    def read(self, path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
        """Read an untrusted file.

        Parameters
        ----------
        path, reach
            The file, and where the names in it lead.
        library
            Its definitions.
        scratch
            An existing empty folder for files that are inside of the file; it has to live as long as they are needed.

        Raises
        ------
        ReadError
            If it cannot be read, for any reason that lies in the file.
        """
        read: Document = self._module.read(path, reach, library, scratch)
        return read

    def write(
        self,
        document: Document,
        path: Path,
        library: DataLibrary,
        options: Options | None = None,
        *,
        force: bool = False,
    ) -> list[Finding]:
        """Write a document and the files beside it, all or none; return what of it the format cannot say.

        Parameters
        ----------
        document
            Files that it names are opened only within its `reach`.
        path
            The file; its ending is one of `suffixes`. Whatever stands there is replaced, and with it what it
            names in its folder.
        library
            The document's definitions.
        options
            Those of the format; by default as they are by default.
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
        UnevaluatedSurfaceError, UnreadableImagesError
            If values of a surface cannot be evaluated.
        ArgumentError
            If an option is wrong.
        """
        if path.exists() and not path.is_file():
            raise OSError(errno.EINVAL, "it is not a regular file")
        with FileSet(path.parent, force, lambda: self._named(path)) as files:
            findings: list[Finding] = self._module.write(document, path, library, files, *self._given(options))
        return findings

    def compare(self, document: Document, path: Path, options: Options | None = None) -> Comparison:
        """Compare a document with what an untrusted file says of one.

        Raises
        ------
        UnevaluatedSurfaceError, UnreadableImagesError, ArgumentError
            As `write`; ArgumentError also if the file, which is the argument `compare`, is wrong.
        """
        compared: Comparison = self._module.compare(document, path, *self._given(options))
        return compared

    def coefficients(self, path: Path, options: Options | None = None) -> list[Coefficient]:
        """Coefficients of retroreflection in an untrusted file that holds no more of a material.

        Raises
        ------
        ReadError
            If it cannot be read.
        ArgumentError
            If an option is wrong.
        """
        found: list[Coefficient] = self._module.coefficients(path, *self._given(options))
        return found

    @property
    def _module(self) -> Any:
        return import_module(self.module)

    def _given(self, options: Options | None) -> tuple[Options, ...]:
        return (options or self.options_class(),) if self.options else ()

    def _named(self, path: Path) -> set[Path]:
        """The files that one names that stands there already, tiles and frames included; none if it cannot be read."""
        reach = Reach.beside(path)
        try:
            names: Iterable[str] = self._module.names(path) if self.writes_beside and path.is_file() else ()
            found = [file for name in names for file in reach.members(name)]
        except (ReadError, OSError, ValueError):
            return set()
        return {file.parent.resolve() / file.name for file in found}
