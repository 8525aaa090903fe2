"""A document, read and checked, for the functions that use one."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

from mrm_mtlx.api.errors import DocumentError, NoReferenceError, NothingToRenderError, ShaderError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.system import child
from mrm_mtlx.system.arguments import ArgumentError, check_choice, one_or_more, path_of, refuse
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import plural, printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.documents.image_checks import CheckedImages
    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.reference import Surface

# Whose implementation of the flag is used; the names of library.Origin.
LibraryName: TypeAlias = Literal["mrm", "upstream"]
PathLike: TypeAlias = str | os.PathLike[str]


@dataclass(frozen=True, eq=False, repr=False)
class OpenDocument(Shown):
    """A document that was read and checked. Its elements live as long as it is held.

    Attributes
    ----------
    path
    findings
        What is to be said of it, none of which prevents its use.
    elements
        Names of its renderable elements, or the one that was chosen.
    source, library
        What was read, and the definitions that it was read with.
    """

    path: Path
    findings: tuple[Finding, ...]
    elements: tuple[str, ...]
    source: Document
    library: DataLibrary

    def report(self) -> str:
        """Its findings, and the names of its elements."""
        opened = f"OPENED  {plural(len(self.elements), 'surface')}: {', '.join(self.elements)}"
        return "\n".join(map(printable, [str(self.path), *finding_lines(self.findings), opened]))

    @property
    def document(self) -> Any:
        """The MaterialX document itself."""
        return self.source.materialx

    def element(self, name: str) -> Any:
        """A renderable element of MaterialX, by its name."""
        return self.document.getDescendant(name)

    def only(self, element: str | None) -> OpenDocument:
        """The same document with one of its elements chosen.

        Raises
        ------
        ArgumentError
            If it has no such element.
        """
        if element is None:
            return self
        if element not in self.elements:
            msg = f"{element}: expected one of {', '.join(self.elements)}"
            raise ArgumentError(msg, "element")
        return OpenDocument(self.path, self.findings, (element,), self.source, self.library)

    def shader_error(self, rule: Rule, name: str, error: Exception) -> ShaderError:
        """An exception that says why an element has no shader, as a case of a rule."""
        found = self.source.in_source(rule.at(f"/{name}", str(error)))
        return ShaderError(str(found), (*self.findings, found))

    def surfaces(self) -> list[OpenSurface]:
        """The surfaces of its elements, ready to be evaluated.

        Raises
        ------
        NoReferenceError
            If the reference does not know what a surface uses.
        """
        from mrm_mtlx.documents.image_checks import CheckedImages
        from mrm_mtlx.reference import Surface, UnsupportedError

        found = []
        for name in self.elements:
            images = CheckedImages(self.source.reach, f"/{name}")
            try:
                found.append(OpenSurface(name, Surface(self.element(name), images=images), images, self))
            except (UnsupportedError, RecursionError) as error:
                msg = f"/{name} has no reference: {error}"
                raise NoReferenceError(msg, self.findings) from error
        return found


@dataclass(frozen=True)
class OpenSurface:
    """A surface of a document, ready to be evaluated, and the images that it reads then.

    Attributes
    ----------
    name
        Of its element.
    surface
        The reference.
    images
        What is wrong with them is known once they are read.
    owner
        The document.
    """

    name: str
    surface: Surface
    images: CheckedImages = field(repr=False)
    owner: OpenDocument = field(repr=False)

    def refuse_missing_images(self, listener: Listener = SILENT) -> None:
        """Raise a DocumentError if an image could not be read."""
        problems = [self.owner.source.in_source(found) for found in self.images.findings]
        if problems:
            listener.image_findings(problems)
            msg = "; ".join(found.message for found in problems)
            raise DocumentError(msg, (*self.owner.findings, *problems))


def open_document(
    path: PathLike | OpenDocument,
    *,
    element: str | None = None,
    library: LibraryName = "mrm",
    root: PathLike | Sequence[PathLike] = (),
    listener: Listener = SILENT,
) -> OpenDocument:
    """Read and check a document, or a file of another format as one.

    Parameters
    ----------
    path
        The file. A document that is open already is taken as it is.
    element
        The renderable element in question; by default all.
    library
        "mrm": this project's implementation of the flag; "upstream": MaterialX's.
    root
        Folders from which files may be read besides the document's own, and in which they are looked for.
    listener
        Told of the findings.

    Raises
    ------
    ArgumentError
        If the path is a folder, or there is no such element.
    DocumentError
        If the document cannot be read or is broken; NothingToRenderError if it has nothing to render.
    """
    if isinstance(path, OpenDocument):
        refuse({"root": root, "library": None if library == "mrm" else library}, "not with a document that is open")
        return path.only(element)
    from mrm_mtlx.library import Origin, load_library

    check_choice("library", library, ("mrm", "upstream"))
    roots = folders(root)
    path = path_of("path", path)
    child.opening(path)
    if path.is_dir():
        msg = f"{path} is a folder; name one document"
        raise ArgumentError(msg, "path")
    data = load_library(Origin(library))
    source, findings = _read(path, roots, data)
    listener.findings(findings)
    if source is None:
        raise DocumentError(_first(path, findings), findings)
    return _chosen(path, source, findings, data, element)


def documents_of(
    paths: PathLike | OpenDocument | Sequence[PathLike | OpenDocument], exclude: str | Sequence[str] = ()
) -> list[Path | OpenDocument]:
    """Each document once, those of folders in order.

    Raises
    ------
    ArgumentError
        If none is named.
    """
    from mrm_mtlx.validation import collecting

    found: list[Path | OpenDocument] = []
    for path in _several(paths):
        if isinstance(path, Path) and path.is_dir():
            found += collecting.documents_of(path, one_or_more(exclude))
        else:
            found.append(path)
    if not found and not paths:
        msg = "expected a document"
        raise ArgumentError(msg, "paths")
    return list(dict.fromkeys(found))


def _several(paths: PathLike | OpenDocument | Sequence[PathLike | OpenDocument]) -> list[Path | OpenDocument]:
    """Paths as a list, of one or more."""
    listed: tuple[Any, ...] = one_or_more(cast("Any", paths))
    return [one if isinstance(one, OpenDocument) else path_of("paths", one) for one in listed]


def paths_of(paths: PathLike | Sequence[PathLike]) -> list[Path]:
    """Paths, of one or more."""
    listed = one_or_more(paths)
    if not listed:
        msg = "expected a document or a folder"
        raise ArgumentError(msg, "paths")
    return [path_of("paths", path) for path in listed]


def folders(root: PathLike | Sequence[PathLike]) -> tuple[Path, ...]:
    """Folders that exist, of one or more.

    Raises
    ------
    ArgumentError
        If one does not.
    """
    found = tuple(path_of("root", folder) for folder in one_or_more(root))
    for folder in found:
        if not folder.is_dir():
            msg = f"{folder}: expected a folder that exists"
            raise ArgumentError(msg, "root")
    return found


def _read(path: Path, roots: tuple[Path, ...], library: DataLibrary) -> tuple[Document | None, list[Finding]]:
    """A document, None if it cannot be used, and what is to be said of it."""
    from mrm_mtlx.documents.document import ReadError
    from mrm_mtlx.documents.files import Reach, shown_path
    from mrm_mtlx.findings import rules
    from mrm_mtlx.findings.finding import capped
    from mrm_mtlx.formats.reading import read_document
    from mrm_mtlx.validation.checks.files import check_files
    from mrm_mtlx.validation.checks.graph import check_graph

    if not path.exists():
        return None, [rules.READ_MISSING.at("", f"'{path}' does not exist").in_file(shown_path(path))]
    try:
        source = read_document(path, Reach.beside(path, roots), library, _scratch())
        checked = check_graph(source.materialx)
        checked += check_files(source.materialx, source.reach, library)
    except ReadError as error:
        return None, [error.finding]
    findings = source.findings + checked
    usable = not any(found.blocks for found in findings)
    # What else USD thinks of a stage is for `mrm validate`: here its materials are used.
    told = capped(found for found in findings if not found.rule.of_host)
    return source if usable else None, [source.in_source(found) for found in told]


def finding_lines(findings: Sequence[Finding]) -> list[str]:
    """A line for each finding, as reports of an open or a written document have it."""
    return [f"  {found}" for found in findings]


def _first(path: Path, findings: Sequence[Finding]) -> str:
    """The message of an exception: the first of the errors, and how many more there are."""
    errors = [found for found in findings if found.severity == "error"]
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    first = errors[0]
    place = f" {first.location}" if first.location else ""
    where = first.source if first.source and first.source.line else path
    return f"{where}: {first.code}{place}: {first.message}{more}"


def _chosen(
    path: Path, source: Document, findings: list[Finding], library: DataLibrary, element: str | None
) -> OpenDocument:
    from mrm_mtlx.shadergen import renderable_elements

    names = tuple(e.getNamePath() for e in renderable_elements(source.materialx))
    opened = OpenDocument(path, tuple(findings), names, source, library).only(element)
    if not opened.elements:
        msg = f"{path} has nothing to render"
        raise NothingToRenderError(msg, findings)
    return opened


def _scratch() -> Path:
    """An empty folder, removed when the process ends."""
    folder = tempfile.mkdtemp(prefix="mrm-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
