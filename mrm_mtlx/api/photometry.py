"""Coefficients of retroreflection of documents, beside the minima of a class."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from mrm_mtlx.api.errors import DocumentError, NoReferenceError, NothingToRenderError, NoValueError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import OpenDocument, PathLike, documents_of, open_document
from mrm_mtlx.system.arguments import ArgumentError, check_angles, check_choice, check_positive, one_or_more, refuse

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.api.opening import OpenSurface
    from mrm_mtlx.photometry.coefficients import Brdf
    from mrm_mtlx.photometry.formatting import DocumentReport
    from mrm_mtlx.photometry.report import PhotometryOptions, SurfaceReport
    from mrm_mtlx.photometry.result import PhotometryReport, StandardsReport
    from mrm_mtlx.standards.tables import Limit

Method: TypeAlias = Literal["spectral", "rgb"]


def photometry(
    paths: PathLike | OpenDocument | Sequence[PathLike | OpenDocument],
    *,
    standard: str | None = None,
    class_name: str | None = None,
    color: str | None = None,
    observation: float | Sequence[float] = (),
    entrance: float | Sequence[float] = (),
    rotation: float | Sequence[float] = (),
    source_aperture: float = 0.0,
    receiver_aperture: float = 0.0,
    area: float | None = None,
    radius: float | None = None,
    method: Method = "spectral",
    element: str | None = None,
    plot: PathLike | None = None,
    root: PathLike | Sequence[PathLike] = (),
    exclude: str | Sequence[str] = (),
    listener: Listener = SILENT,
) -> PhotometryReport:
    """Measure documents in the geometries of a standard's class, beside its limits.

    Without a class: in a grid of angles, and without a verdict. docs/photometry.md explains quantities and angles.

    Parameters
    ----------
    paths
        Documents, or folders of documents.
    standard, class_name, color
        Names that choose a class: their beginning is enough, and what there is but one of may be left out.
    observation, entrance
        Observation angles and entrance angles beta1 [degrees], without a class.
    rotation
        Rotations of the sample [degrees], over which values are averaged. Default: 0; of R_A 0 and 90.
    source_aperture, receiver_aperture
        Diameters of source and receiver [degrees], seen from the sample.
    area
        Of the reflector [cm2], for limits of intensity.
    radius
        Inner radius of a reflective strip [cm], for R_I/r.
    method
        Colours under illuminant A: "spectral" or the product of "rgb".
    element
        Only this renderable element of each document.
    plot
        A picture of one surface to write, if any: .png, .svg or .pdf.
    root
        Folders from which files may be read besides each document's own.
    exclude
        Patterns of files and folders that are passed over where a folder is searched.
    listener
        Told of findings, of documents that are left out, and of the picture.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    """
    limits = _limits(standard, class_name, color)
    options = _options(
        one_or_more(rotation) or _rotations(limits), (source_aperture, receiver_aperture), area, radius, method
    )
    from mrm_mtlx.photometry.report import check_sizes
    from mrm_mtlx.photometry.result import PhotometryReport

    check_sizes(limits, options)
    grid = _grid(one_or_more(observation), one_or_more(entrance), limits)
    if plot is not None:
        from mrm_mtlx.plots.style import check_picture

        check_picture(Path(plot), "plot")
    run = _Run(limits, options, grid, listener)
    documents = tuple(run.document(path, element, root) for path in documents_of(paths, exclude))
    if plot is not None:
        run.draw(Path(plot))
    return PhotometryReport(documents, tuple(limits), options)


def list_standards() -> StandardsReport:
    """The standards and classes that are known: their minima and colour boxes, with sources."""
    from mrm_mtlx.photometry.result import StandardsReport
    from mrm_mtlx.standards.tables import boxes, standards

    return StandardsReport(standards(), boxes())


def _options(
    rotation: Sequence[float],
    apertures: tuple[float, float],
    area: float | None,
    radius: float | None,
    method: Method,
) -> PhotometryOptions:
    from mrm_mtlx.photometry.report import PhotometryOptions

    for argument, aperture in zip(("source_aperture", "receiver_aperture"), apertures, strict=True):
        if not 0.0 <= aperture < 180.0:
            msg = f"{aperture:g}: expected an angle from 0 to 180 degrees"
            raise ArgumentError(msg, argument)
    check_positive("area", area)
    check_positive("radius", radius)
    check_angles("rotation", rotation, -360.0, 360.0)
    check_choice("method", method, ("spectral", "rgb"))
    return PhotometryOptions(tuple(dict.fromkeys(rotation)), *apertures, str(method), area, radius)


def _rotations(limits: Sequence[Limit]) -> list[float]:
    """Rotations of a class, or of none; sheeting is measured turned (ASTM D4956)."""
    return [0.0, 90.0] if not limits or limits[0].quantity.is_turned else [0.0]


def _limits(standard: str | None, class_name: str | None, color: str | None) -> list[Limit]:
    from mrm_mtlx.standards import limits

    if standard is None and class_name is None:
        refuse({"color": color}, "only with `standard` or `class_name`")
        return []
    try:
        return limits(class_name, color, standard=standard)
    except ArgumentError as error:
        msg = f"{error.message} (mrm photometry --list)"
        raise ArgumentError(msg, error.argument) from error


def _grid(
    observation: Sequence[float], entrance: Sequence[float], limits: Sequence[Limit]
) -> tuple[Sequence[float], Sequence[float]]:
    from mrm_mtlx.photometry.report import ENTRANCES_DEG, OBSERVATIONS_DEG

    if limits:
        refuse({"observation": observation, "entrance": entrance}, "not with a class, which has its own angles")
    check_angles("observation", observation, 0.0, 180.0)
    check_angles("entrance", entrance, -90.0, 90.0)
    return tuple(dict.fromkeys(observation)) or OBSERVATIONS_DEG, tuple(dict.fromkeys(entrance)) or ENTRANCES_DEG


class _Run:
    """The documents of one call."""

    def __init__(
        self,
        limits: Sequence[Limit],
        options: PhotometryOptions,
        grid: tuple[Sequence[float], Sequence[float]],
        listener: Listener,
    ) -> None:
        self._limits, self._options, self._grid, self._listener = limits, options, grid, listener
        self._brdfs: list[tuple[str, Brdf]] = []

    def document(
        self, path: Path | OpenDocument, element: str | None, root: PathLike | Sequence[PathLike]
    ) -> DocumentReport:
        """Measure the surfaces of a document, or say why it is left out."""
        from mrm_mtlx.documents.files import shown_path
        from mrm_mtlx.photometry.formatting import DocumentReport

        name = shown_path(path.path if isinstance(path, OpenDocument) else path)
        try:
            opened = open_document(path, element=element, root=root, listener=self._listener)
            return DocumentReport(name, {surface.name: self._measured(surface) for surface in opened.surfaces()})
        except DocumentError as error:
            self._listener.not_measured(name, error)
            broken = not isinstance(error, NothingToRenderError | NoReferenceError)
            return DocumentReport(name, reason=str(error), broken=broken)

    def _measured(self, opened: OpenSurface) -> SurfaceReport:
        from mrm_mtlx.photometry import surface_brdf
        from mrm_mtlx.photometry.report import measure

        brdf = surface_brdf(opened.surface)
        try:
            report = measure(brdf, self._limits, self._options, *self._grid)
        except ValueError as error:
            msg = f"/{opened.name} has {error}"
            raise NoValueError(msg, opened.owner.findings) from error
        opened.refuse_missing_images(self._listener)
        opened.images.release()
        self._brdfs.append((opened.name, brdf))
        return report

    def draw(self, path: Path) -> None:
        """Write a picture of the one surface."""
        if len(self._brdfs) != 1:
            msg = f"a picture is of one surface, here are {len(self._brdfs)}; name one document and `element`"
            raise ArgumentError(msg, "plot")
        from mrm_mtlx.plots import coefficients, coefficients_drawing, drawing

        name, brdf = self._brdfs[0]
        panels = coefficients.class_panels(brdf, self._limits, self._options)
        try:
            drawing.save(coefficients_drawing.picture(panels), path)
        except ValueError as error:
            raise ArgumentError(str(error), "plot") from error
        self._listener.wrote(path, f"/{name}")
