"""A document in another format, and a file of another format as a document."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.api.errors import DocumentError, NoReferenceError, NothingToConvertError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import OpenDocument, PathLike, finding_lines, open_document
from mrm_mtlx.system.arguments import ArgumentError, check_choice, path_of
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import printable
from mrm_mtlx.system.writing import check_folder

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeVar

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.format import Comparison, Format
    from mrm_mtlx.formats.options import Options

    T = TypeVar("T")


@dataclass(frozen=True, repr=False)
class Converted(Shown):
    """A file that was written.

    Attributes
    ----------
    path
    lost
        Findings on what the format cannot say of the document.
    found
        Findings on the document, as it was read.
    """

    path: Path
    lost: tuple[Finding, ...]
    found: tuple[Finding, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All findings, those on the document first."""
        return (*self.found, *self.lost)

    @property
    def complete(self) -> bool:
        """True if nothing that matters was lost in writing: no finding of `lost` is an error."""
        return not any(found.severity == "error" for found in self.lost)

    def report(self) -> str:
        """All findings, and what was written."""
        written = f"WRITTEN  {self.path}{'' if self.complete else ', without what the format cannot say'}"
        return "\n".join(map(printable, [*finding_lines(self.findings), written]))


def convert(
    path: PathLike | OpenDocument,
    output: PathLike,
    *,
    to: str | None = None,
    portable: bool = False,
    root: PathLike | Sequence[PathLike] = (),
    force: bool = False,
    listener: Listener = SILENT,
    **options: Any,
) -> Converted:
    """Write a document in another format, or a file of another format as a document.

    A material is fitted to a file that holds coefficients of retroreflection and no more, as OpenMATERIAL's do.

    Parameters
    ----------
    path
        A document, or a file of another format.
    output
        What to write; its ending names the format.
    to
        The format, whatever the ending: "openmaterial".
    portable
        Whether to write nodes of MaterialX's standard library alone, with ordinary lobes, turned toward the viewer, in
        the place of each retroreflective one: for hosts without the node library. As MaterialX, which the document may
        be already, or as USD.
    root
        Folders from which files may be read besides the document's own.
    force
        Also replace files beside `output` that are there with other content.
    listener
        Told of findings and of the file.
    options
        Those of the format. USD has `preview`, False for no look by day for hosts without MaterialX; glTF has `exact`,
        True to leave out what it has no form for and not to write the nearest. OpenMATERIAL
        (`formats.openmaterial.options`) has `into`, a file of it whose other data are
        kept; `at`, the object of `into` for a new block, as "/parent"; `observation` and `entrance`, the angles of R_A
        [degrees], by default 0.2 and -4; and `element`, whose R_A it is, by default that of the first.

    Raises
    ------
    ArgumentError
        If the call is wrong, or a file cannot be written.
    DocumentError
        If the document cannot be used, or has nothing that the format can say.
    """
    from mrm_mtlx.formats.format import Capability
    from mrm_mtlx.formats.registry import format_of

    target = path_of("output", output)
    check_folder(target)
    written = _format_for(path, target, to, portable=portable)
    if force and not written.writes_beside:
        msg = "this format has no files beside OUTPUT, which is replaced"
        raise ArgumentError(msg, "force")
    if not isinstance(path, OpenDocument):
        source = format_of(path_of("path", path))
        if source is not None and not source.can(Capability.READ) and source.can(Capability.COEFFICIENTS):
            return _fitted(Path(path), source, target, written, options, listener)
    chosen = _options(written, path, options)
    opened = open_document(path, root=root, listener=listener)
    if not portable:
        return _write(opened, target, written, chosen, listener, force=force)
    made, lost = _portable(opened, listener)
    converted = _write(made, target, written, chosen, listener, force=force)
    return replace(converted, lost=(*lost, *converted.lost))


def compare(
    path: PathLike | OpenDocument,
    file: PathLike,
    *,
    root: PathLike | Sequence[PathLike] = (),
    listener: Listener = SILENT,
    **options: Any,
) -> Comparison:
    """Compare a document with what a file says of one, as OpenMATERIAL's say R_A.

    Parameters
    ----------
    path
        A document.
    file
        The file.
    root, listener
        As `convert`.
    options
        As `convert`; by default the angles are those that the file states.

    Raises
    ------
    ArgumentError
        If the call or the file is wrong.
    DocumentError
        If the document cannot be used.
    """
    from mrm_mtlx.formats.format import Capability
    from mrm_mtlx.formats.registry import format_of, formats_that

    known = (format_of(path_of("file", file)), *formats_that(Capability.COMPARE))
    compared = next(one for one in known if one is not None and one.can(Capability.COMPARE))
    chosen = _options(compared, path, options)
    opened = open_document(path, root=root, listener=listener)
    return _evaluated(opened, listener, lambda: compared.compare(opened.source, Path(file), chosen))


def _format_for(path: PathLike | OpenDocument, output: Path, to: str | None, *, portable: bool) -> Format:
    """The format to be written."""
    from mrm_mtlx.formats.format import Capability
    from mrm_mtlx.formats.registry import MATERIALX, format_for, format_of, formats_that, suffixes

    named = {known.name: known for known in formats_that(Capability.WRITE) if known.ambiguous}
    check_choice("to", to, named)
    found = named[to] if to is not None else format_for(output)
    if found is None:
        msg = f"{output}: expected a name that ends in {', '.join(suffixes(Capability.WRITE))}, or `to`"
        raise ArgumentError(msg, "output")
    source = path.path if isinstance(path, OpenDocument) else path_of("path", path)
    if output.exists() and source.exists() and output.samefile(source):
        msg = f"{output} is the file to be read"
        raise ArgumentError(msg, "output")
    if portable and not found.holds_networks:
        msg = f"{found.title} has no nodes of MaterialX; write the document itself as {found.title}"
        raise ArgumentError(msg, "portable")
    if not portable and (format_of(source) or (MATERIALX if source.exists() else None)) is found:
        hint = ": `portable` writes it for hosts without the node library" if found.holds_networks else ""
        msg = f"{source} is {found.title} already{hint}"
        raise ArgumentError(msg, "output")
    return found


def _options(owner: Format, path: PathLike | OpenDocument, given: dict[str, Any]) -> Options:
    """The options of a format; of an open document, the element that was chosen is its own."""
    from mrm_mtlx.formats.registry import options_for

    if isinstance(path, OpenDocument) and "element" in owner.options_class.names() and given.get("element") is None:
        given = {**given, "element": path.elements[0]}
    return options_for(owner, given)


def _portable(opened: OpenDocument, listener: Listener) -> tuple[OpenDocument, tuple[Finding, ...]]:
    """An open document in its portable form, and what that has lost.

    Raises
    ------
    ArgumentError
        If the nodes of the document cannot be replaced.
    """
    from mrm_mtlx.documents.portable import portable
    from mrm_mtlx.library import Origin, load_library

    try:
        document, findings = portable(opened.document)
    except ValueError as error:
        msg = f"{opened.path} has no portable form: {error}"
        raise ArgumentError(msg, "path") from error
    lost = tuple(opened.source.in_source(found) for found in findings)
    listener.findings(lost)
    source = replace(opened.source, materialx=document, original=opened.document)
    return replace(opened, source=source, library=load_library(Origin.UPSTREAM)), lost


def _write(
    opened: OpenDocument, output: Path, written: Format, options: Options, listener: Listener, *, force: bool
) -> Converted:
    """Write a document that was opened."""
    from mrm_mtlx.documents.document import ReadError
    from mrm_mtlx.formats.format import NothingToWriteError

    def told(findings: Sequence[Finding]) -> tuple[Finding, ...]:
        found = [opened.source.in_source(one) for one in findings]
        listener.findings(found)
        return tuple(found)

    def write() -> list[Finding]:
        return written.write(opened.source, output, opened.library, options, force=force)

    try:
        lost = told(_evaluated(opened, listener, write))
    except ReadError as error:
        raise DocumentError(error.finding.message, (*opened.findings, *told([error.finding]))) from error
    except NothingToWriteError as error:
        msg = f"{opened.path}: {error}"
        raise NothingToConvertError(msg, (*opened.findings, *told(error.findings))) from error
    except ArgumentError:
        raise
    except ValueError as error:
        msg = f"{opened.path}: {error}"
        raise ArgumentError(msg, "path") from error
    except OSError as error:
        msg = f"{output} cannot be written: {error.strerror}"
        raise ArgumentError(msg, "output") from error
    listener.wrote(output)
    return Converted(output, lost, opened.findings)


def _evaluated(opened: OpenDocument, listener: Listener, work: Callable[[], T]) -> T:
    """The result of work that may evaluate surfaces of a document.

    Raises
    ------
    DocumentError
        If one cannot be evaluated.
    """
    from mrm_mtlx.formats.format import UnevaluatedSurfaceError, UnreadableImagesError

    try:
        return work()
    except UnevaluatedSurfaceError as error:
        raise NoReferenceError(str(error), opened.findings) from error
    except UnreadableImagesError as error:
        problems = [opened.source.in_source(found) for found in error.findings]
        listener.image_findings(problems)
        raise DocumentError(str(error), (*opened.findings, *problems)) from error


def _fitted(
    path: Path, source: Format, output: Path, written: Format, options: dict[str, Any], listener: Listener
) -> Converted:
    """Write a material that has the coefficients of a file."""
    from mrm_mtlx.api.fit import fit
    from mrm_mtlx.documents.document import ReadError
    from mrm_mtlx.documents.files import shown_path
    from mrm_mtlx.findings import rules
    from mrm_mtlx.formats.registry import MATERIALX

    try:
        coefficients = source.coefficients(path, _options(source, path, options))
    except ReadError as error:
        refused = error.finding.in_file(shown_path(path))
        listener.findings([refused])
        raise DocumentError(refused.message, (refused,)) from error
    values = ", ".join(f"{one.value:g} at {one.observation_deg:g} and {one.entrance_deg:g} deg" for one in coefficients)
    message = f"the file says no more of the material than R_A, {values}; its colours and its lobe's width are assumed"
    said = rules.INTERCHANGE_LOST.at("", message, "Give what is known besides to mrm fit --ra.")
    said = said.in_file(shown_path(path))
    listener.findings([said])
    if written is MATERIALX:
        fit(ra=coefficients, output=output, listener=listener)
        return Converted(output, (said,))
    with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
        document = Path(folder, f"{output.stem}.mtlx")
        fit(ra=coefficients, output=document)
        return _write(open_document(document), output, written, _options(written, path, {}), listener, force=False)
