"""A document in another format, and a file of another format as a document."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mrm_mtlx.api.errors import DocumentError, NothingToConvertError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import OpenDocument, PathLike, open_document
from mrm_mtlx.system.arguments import ArgumentError, check_choice, refuse
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.writing import check_folder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.openmaterial import Geometry, OpenMaterialFile
    from mrm_mtlx.photometry.coefficients import Brdf

# The ending of OpenMATERIAL's files; the other formats are in the table of `formats.registry`.
OPENMATERIAL_SUFFIX = ".json"
# R_A of a file and of a document that are called equal: labs state some percent, files a few digits.
EQUAL_WITHIN = 0.01


@dataclass(frozen=True)
class Converted:
    """A file that was written.

    Attributes
    ----------
    path
    findings
        What is to be said of the document, and what of it the format cannot say.
    """

    path: Path
    findings: tuple[Finding, ...]

    @property
    def complete(self) -> bool:
        """Whether nothing that matters was lost: no finding is an error."""
        return not any(found.severity == "error" for found in self.findings)


@dataclass(frozen=True, repr=False)
class CoefficientComparison(Shown):
    """R_A of a document [cd/(lx m^2)] and of an OpenMATERIAL file, in one geometry [degrees].

    `stated` is whether the file states these angles.
    """

    document: float
    file: float
    observation_deg: float
    entrance_deg: float
    stated: bool

    @property
    def equal(self) -> bool:
        """Whether they are the same within `EQUAL_WITHIN`."""
        return abs(self.document - self.file) <= EQUAL_WITHIN * max(self.document, self.file)

    def report(self) -> str:
        """Both values, and the verdict."""
        stated = "as the file states" if self.stated else "the file states other angles or none"
        angles = f"observation {self.observation_deg:g} deg, entrance {self.entrance_deg:g} deg ({stated})"
        words = ("PASSED", "equal") if self.equal else ("FAILED", "different")
        values = f"R_A, cd/(lx m^2), at {angles}: document {self.document:.6g}, file {self.file:.6g}"
        return f"{values}\n{words[0]}  {words[1]} within {EQUAL_WITHIN:.0%}"


def convert(
    path: PathLike | OpenDocument,
    output: PathLike,
    *,
    to: Literal["openmaterial"] | None = None,
    into: PathLike | None = None,
    at: str | None = None,
    observation: float | None = None,
    entrance: float | None = None,
    element: str | None = None,
    root: Sequence[PathLike] = (),
    force: bool = False,
    listener: Listener = SILENT,
) -> Converted:
    """Write a document as USD or glTF, read one from these, or write its R_A as OpenMATERIAL 3D has it.

    Parameters
    ----------
    path
        A document, or a file of another format.
    output
        What to write; its ending names the format.
    to
        The format, whatever the ending.
    into
        An OpenMATERIAL file whose other data are kept.
    at
        Object of `into` for a new block, as "/parent". Default: the top.
    observation, entrance
        Angles of R_A [degrees]. Default: 0.2 and -4.
    element
        Element whose R_A it is; default: the first.
    root
        Folders from which files may be read besides the document's own.
    force
        Also replace files beside `output` that are there with other content.
    listener
        Told of findings and of the file.

    Raises
    ------
    ArgumentError
        If the call is wrong, or a file cannot be written.
    DocumentError
        If the document cannot be used, or has nothing that the format can say.
    """
    target = Path(output)
    check_folder(target)
    check_choice("to", to, ("openmaterial",))
    geometry = {"observation": observation, "entrance": entrance}
    if to == "openmaterial" or target.suffix.lower() == OPENMATERIAL_SUFFIX:
        refuse({"force": force}, "this format has no files beside OUTPUT, which is replaced")
        refuse({"at": at if into is None else None}, "only with `into`, whose objects it names")
        file = None if into is None else _openmaterial_file(Path(into), "into")
        angles = _geometry(geometry, None)
        opened = open_document(path, element=element, root=root, listener=listener)
        _write_block(opened, target, file, at or "", angles, listener)
        return Converted(target, opened.findings)
    refuse({"into": into, "at": at, **geometry, "element": element}, f"only for {OPENMATERIAL_SUFFIX}, OpenMATERIAL")
    return _translate(path, target, root, listener, force=force)


def compare_openmaterial(
    path: PathLike | OpenDocument,
    compare: PathLike,
    *,
    observation: float | None = None,
    entrance: float | None = None,
    element: str | None = None,
    root: Sequence[PathLike] = (),
    listener: Listener = SILENT,
) -> CoefficientComparison:
    """Compare a document's R_A with that of an OpenMATERIAL file.

    Parameters
    ----------
    path
        A document.
    compare
        The file.
    observation, entrance
        Angles [degrees]. Default: those that the file states, else 0.2 and -4.
    element, root, listener
        As `convert`.

    Raises
    ------
    ArgumentError
        If the call or the file is wrong.
    DocumentError
        If the document cannot be used.
    """
    from mrm_mtlx.formats import openmaterial

    file = _openmaterial_file(Path(compare), "compare")
    stated = file.block.geometry if file.block is not None else None
    geometry = _geometry({"observation": observation, "entrance": entrance}, stated)
    brdf = _brdf(open_document(path, element=element, root=root, listener=listener), listener)
    if file.block is None:
        msg = f"{Path(compare).name} has no {openmaterial.BLOCK}"
        raise ArgumentError(msg, "compare")
    try:
        value = openmaterial.r_a(brdf, geometry)
    except ValueError as error:
        raise ArgumentError(str(error)) from error
    return CoefficientComparison(value, file.block.coefficient, *geometry, file.block.geometry == geometry)


def _openmaterial_file(path: Path, argument: str) -> OpenMaterialFile:
    from mrm_mtlx.formats import openmaterial

    try:
        return openmaterial.read(path)
    except (ValueError, OSError) as error:
        raise ArgumentError(str(error), argument) from error


def _write_block(
    opened: OpenDocument,
    output: Path,
    file: OpenMaterialFile | None,
    at: str,
    geometry: Geometry,
    listener: Listener,
) -> None:
    from mrm_mtlx.formats import openmaterial

    brdf = _brdf(opened, listener)
    try:
        block = openmaterial.of_brdf(brdf, opened.path.name, geometry)
        openmaterial.write(openmaterial.merged(file, block, at), output)
    except ValueError as error:
        raise ArgumentError(str(error)) from error
    except OSError as error:
        msg = f"{output} cannot be written: {error.strerror}"
        raise ArgumentError(msg, "output") from error
    listener.wrote(output)


def _geometry(given: dict[str, float | None], stated: Geometry | None) -> Geometry:
    """The angles that are given, else those that a file states, else the usual ones."""
    from mrm_mtlx.formats.openmaterial import Geometry

    values = [
        other if value is None else value for value, other in zip(given.values(), stated or Geometry(), strict=True)
    ]
    for value, lower, argument in zip(values, (0.0, -90.0), given, strict=True):
        if not lower <= value <= 90.0:
            msg = f"{value:g}: expected {lower:g} to 90 degrees"
            raise ArgumentError(msg, argument)
    return Geometry(*values)


def _brdf(opened: OpenDocument, listener: Listener) -> Brdf:
    """The BRDF of the document's first surface."""
    import numpy as np

    from mrm_mtlx.photometry import surface_brdf

    chosen = opened.surfaces()[0]
    brdf = surface_brdf(chosen.surface)
    normal = np.array([0.0, 0.0, 1.0])
    try:
        brdf(normal, normal)  # images are read when they are needed, and what is wrong with them is known then
    except ValueError as error:
        msg = f"{opened.path} has {error}"
        raise ArgumentError(msg, "path") from error
    chosen.refuse_missing_images(listener)
    return brdf


def _translate(
    path: PathLike | OpenDocument, output: Path, root: Sequence[PathLike], listener: Listener, *, force: bool
) -> Converted:
    """Read a file of one format, write one of another."""
    from mrm_mtlx.documents.document import NothingToWriteError, ReadError

    source = path.path if isinstance(path, OpenDocument) else Path(path)
    form = _format(source, output)
    opened = open_document(path, root=root, listener=listener)

    def told(findings: Sequence[Finding]) -> tuple[Finding, ...]:
        found = [opened.imported.in_source(found) for found in findings]
        listener.findings(found)
        return (*opened.findings, *found)

    try:
        findings = told(form.write(opened.imported, output, opened.library, force=force))
    except ReadError as error:
        raise DocumentError(error.finding.message, told([error.finding])) from error
    except NothingToWriteError as error:
        msg = f"{source}: {error}"
        raise NothingToConvertError(msg, told(error.findings)) from error
    except ValueError as error:
        msg = f"{source}: {error}"
        raise ArgumentError(msg, "path") from error
    except OSError as error:
        msg = f"{output} cannot be written: {error.strerror}"
        raise ArgumentError(msg, "output") from error
    listener.wrote(output)
    return Converted(output, findings)


def _format(path: Path, output: Path) -> Any:
    """The format to be written."""
    from mrm_mtlx.formats.registry import DOCUMENT, SUFFIXES, format_of

    form, source = format_of(output), format_of(path) or DOCUMENT
    if form is None:
        msg = f"{output}: expected a name that ends in {', '.join((*SUFFIXES, OPENMATERIAL_SUFFIX))}, or `to`"
        raise ArgumentError(msg, "output")
    if output.exists() and path.exists() and output.samefile(path):
        msg = f"{output} is the file to be read"
        raise ArgumentError(msg, "output")
    if form is source:
        msg = f"{path} is {form.name} already"
        raise ArgumentError(msg, "output")
    return form
