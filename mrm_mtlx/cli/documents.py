"""Opening a document for the commands that work on one."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from mrm_mtlx.system import child
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.documents.image_checks import CheckedImages
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.reference import Surface


class OpenDocument(NamedTuple):
    """A document and the renderable elements in question; the elements live as long as the document is held."""

    imported: Document
    elements: list[Any]

    @property
    def document(self) -> Any:
        """The document itself."""
        return self.imported.materialx


def open_document(
    path: Path, library: DataLibrary, element: str | None, roots: list[Path] | None = None
) -> OpenDocument:
    """A document, or a file of another format as one, with its renderable elements, or the one that is named.

    `roots` are folders from which its files may be read besides its own.

    Raises
    ------
    typer.BadParameter
        If the named element does not exist, or the path is a folder.
    typer.Exit
        With status 1 and the findings on stderr, if the document cannot be read or is broken; with 3, if it has nothing
        to render.
    """
    from mrm_mtlx.documents.document import ReadError
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings import rules
    from mrm_mtlx.findings.finding import capped
    from mrm_mtlx.formats.reading import read_document
    from mrm_mtlx.shadergen import renderable_elements
    from mrm_mtlx.validation.file_checks import check_files
    from mrm_mtlx.validation.graph_checks import check_graph

    child.opening(path)
    if path.is_dir():
        raise typer.BadParameter(f"{path} is a folder; name one document", param_hint="PATH")
    imported = None
    if not path.exists():
        findings = [rules.READ_MISSING.at("", f"'{path}' does not exist")]
    else:
        try:
            imported = read_document(path, Reach.beside(path, tuple(roots or ())), library, _scratch())
            checked = check_graph(imported.materialx)
            checked += check_files(imported.materialx, imported.reach, library)
            findings = imported.findings + [imported.in_source(found) for found in checked]
        except ReadError as error:
            findings = [error.finding]
    # What else USD thinks of a stage is for `mrm validate`: here its materials are used.
    print_findings(capped(found for found in findings if not found.rule.of_host))
    if imported is None or any(found.blocks for found in findings):
        raise typer.Exit(1)
    elements = renderable_elements(imported.materialx)
    names = [e.getNamePath() for e in elements]
    if element is not None and element not in names:
        raise typer.BadParameter(f"{element}: expected one of {', '.join(names)}", param_hint="--element")
    if not elements:
        typer.echo(f"{path} has nothing to render", err=True)
        raise typer.Exit(3)
    chosen = [e for e, name in zip(elements, names, strict=True) if element in (None, name)]
    return OpenDocument(imported, chosen)


def print_findings(findings: list[Finding]) -> None:
    """Findings with their remedies, on stderr."""
    for found in findings:
        typer.echo(printable(str(found)), err=True)
        typer.echo(printable(f"    {found.hint}"), err=True)


def _scratch() -> Path:
    """An empty folder, removed when the process ends."""
    folder = tempfile.mkdtemp(prefix="mrm-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


class OpenSurface(NamedTuple):
    """A surface of a document, ready to be evaluated, and the images that it reads then."""

    name: str
    surface: Surface
    images: CheckedImages

    def refuse_missing_images(self) -> None:
        """Raise typer.Exit with status 1, and the findings on stderr, if an image could not be read."""
        for problem in self.images.findings:
            typer.echo(printable(str(problem)), err=True)
        if self.images.findings:
            raise typer.Exit(1)


def open_surfaces(path: Path, element: str | None, roots: list[Path] | None = None) -> list[OpenSurface]:
    """The surfaces of a document, or the one that is named; `roots` as for `open_document`.

    Raises
    ------
    typer.BadParameter, typer.Exit
        As `open_document`; Exit also with 3, if the reference does not know what a surface uses.
    """
    from mrm_mtlx.documents.image_checks import CheckedImages
    from mrm_mtlx.library import load_library
    from mrm_mtlx.reference import Surface, UnsupportedError

    found = []
    opened = open_document(path, load_library(), element, roots)
    for renderable in opened.elements:
        name = renderable.getNamePath()
        images = CheckedImages(opened.imported.reach, f"/{name}")
        try:
            found.append(OpenSurface(name, Surface(renderable, images=images), images))
        except (UnsupportedError, RecursionError) as error:
            typer.echo(printable(f"mrm: /{name} has no reference: {error}"), err=True)
            raise typer.Exit(3) from error
    return found
