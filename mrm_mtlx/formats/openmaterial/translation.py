"""The R_A of documents: written into files, compared with files, and taken from them to be fitted to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.format import UnevaluatedSurfaceError, UnreadableImagesError
from mrm_mtlx.formats.openmaterial import block
from mrm_mtlx.formats.openmaterial.block import (
    BLOCK,
    LARGEST,
    SMALLEST,
    Geometry,
    OpenMaterialFile,
    RetroreflectivityData,
)
from mrm_mtlx.measured import Coefficient
from mrm_mtlx.photometry import coefficient, luminance, surface_brdf
from mrm_mtlx.reference import Surface, UnsupportedError
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.system.arguments import ArgumentError, refuse
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import printable
from mrm_mtlx.system.versions import __version__

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.openmaterial.options import OpenMaterialOptions
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.photometry.coefficients import Brdf
    from mrm_mtlx.system.writing import FileSet

# Digits of the coefficient that is written.
DIGITS = 6
# R_A of a file and of a document that are called equal: labs state some percent, files a few digits.
EQUAL_WITHIN = 0.01

_OF_WRITING = "only where a file of this format is written"


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
        """True if they are the same within `EQUAL_WITHIN`."""
        return abs(self.document - self.file) <= EQUAL_WITHIN * max(self.document, self.file)

    def report(self) -> str:
        """Both values, and the verdict."""
        stated = "as the file states" if self.stated else "the file states other angles or none"
        angles = f"observation {self.observation_deg:g} deg, entrance {self.entrance_deg:g} deg ({stated})"
        words = ("PASSED", "equal") if self.equal else ("FAILED", "different")
        values = f"R_A, cd/(lx m^2), at {angles}: document {self.document:.6g}, file {self.file:.6g}"
        return f"{values}\n{words[0]}  {words[1]} within {EQUAL_WITHIN:.0%}"


def recognises(start: bytes) -> bool:
    """True if a file may hold a JSON object; what else it is, its reader says."""
    return start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"{")


def write(
    document: Document, path: Path, library: DataLibrary, files: FileSet, options: OpenMaterialOptions
) -> list[Finding]:
    """Write the R_A of a document's surface; see `formats.format`."""
    del library  # the document's own is set
    file = None if options.into is None else _loaded(options.into, "into")
    brdf = _brdf(document, options.element)
    try:
        data = block.merged(file, of_brdf(brdf, document.path.name, options.geometry()), options.at or "")
    except ValueError as error:
        raise ArgumentError(str(error)) from error
    files.named(path).write_bytes(block.as_json(data))
    return []


def compare(document: Document, path: Path, options: OpenMaterialOptions) -> CoefficientComparison:
    """Compare the R_A of a document's surface with that of a file; see `formats.format`."""
    refuse({"into": options.into}, _OF_WRITING)
    found = _loaded(path, "file").block
    brdf = _brdf(document, options.element)
    if found is None:
        msg = f"{path.name} has no {BLOCK}"
        raise ArgumentError(msg, "file")
    geometry = options.geometry(found.geometry)
    try:
        value = r_a(brdf, geometry)
    except ValueError as error:
        raise ArgumentError(str(error)) from error
    return CoefficientComparison(value, found.coefficient, *geometry, found.geometry == geometry)


def coefficients(path: Path, options: OpenMaterialOptions) -> list[Coefficient]:
    """The R_A of a file, at the angles that it states, if the options have no others; see `formats.format`."""
    refuse({"into": options.into, "element": options.element}, _OF_WRITING)
    try:
        file = block.load(path)
    except ValueError as error:
        raise ReadError(rules.READ_FORMAT.at("", str(error))) from error
    except OSError as error:
        message = f"the file cannot be opened: {error.strerror}"
        raise ReadError(rules.READ_FAILED.at("", message)) from error
    if file.pointer is None or file.block is None:
        raise ReadError(rules.READ_FORMAT.at("", f"it has no {BLOCK}"))
    if file.block.coefficient <= 0.0:
        raise ReadError(rules.READ_FORMAT.at(file.pointer, "its R_A is 0, which no retroreflecting material has"))
    return [Coefficient(*options.geometry(file.block.geometry), file.block.coefficient)]


def r_a(brdf: Brdf, geometry: Geometry = Geometry()) -> float:  # noqa: B008  a tuple of numbers
    """R_A of a BRDF under illuminant A, photopic [cd/(lx m^2)]."""
    angles = np.deg2rad(geometry)
    return float(luminance(coefficient(brdf, *angles)))


def of_brdf(brdf: Brdf, name: str, geometry: Geometry = Geometry()) -> RetroreflectivityData:  # noqa: B008
    """The block of a document's surface.

    Parameters
    ----------
    brdf
        See `photometry.surface_brdf`.
    name
        Of the document, for the sources.
    geometry
        Where R_A is taken.

    Raises
    ------
    ValueError
        If R_A is beyond what the block may hold.
    """
    value = float(f"{r_a(brdf, geometry):.{DIGITS}g}")
    angles = f"observation angle {geometry.observation_deg:g} deg, entrance angle {geometry.entrance_deg:g} deg"
    if not SMALLEST <= value <= LARGEST:
        msg = f"R_A is {value:g} cd/(lx m^2) at {angles}; {BLOCK} may hold {SMALLEST:g} to {LARGEST:g}"
        raise ValueError(msg)
    sources = (
        f"computed from the MaterialX document {_plain(name)}",
        f"by mrm-mtlx {__version__}",
        angles,
        "coplanar goniometer geometry (beta2 0 deg; epsilon 0 deg) with point apertures",
        "CIE illuminant A with photopic weighting of the linear Rec.709 colours (spectra of Mallett and Yuksel 2019)",
    )
    return RetroreflectivityData(value, ", ".join(sources))


def _loaded(path: Path, argument: str) -> OpenMaterialFile:
    try:
        return block.load(path)
    except (ValueError, OSError) as error:
        raise ArgumentError(str(error), argument) from error


def _brdf(document: Document, name: str | None) -> Brdf:
    """The BRDF of a surface of a document, by default of the first."""
    elements = {element.getNamePath(): element for element in renderable_elements(document.materialx)}
    name = name or next(iter(elements))
    if name not in elements:
        msg = f"{name}: expected one of {', '.join(elements)}"
        raise ArgumentError(msg, "element")
    images = CheckedImages(document.reach, f"/{name}")
    try:
        brdf = surface_brdf(Surface(elements[name], images=images))
    except (UnsupportedError, RecursionError) as error:
        msg = f"/{name} has no reference: {error}"
        raise UnevaluatedSurfaceError(msg) from error
    normal = np.array([0.0, 0.0, 1.0])
    try:
        brdf(normal, normal)  # images are read when they are needed, and what is wrong with them is known then
    except ValueError as error:
        msg = f"{document.path} has {error}"
        raise ArgumentError(msg, "path") from error
    if images.findings:
        raise UnreadableImagesError(images.findings)
    return brdf


def _plain(text: str) -> str:
    """Text without what separates sources, and without control characters."""
    return printable(text.replace(",", ";"))
