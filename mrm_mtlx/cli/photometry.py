"""`mrm photometry`: coefficients of retroreflection of documents, beside the minima of a class."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.options import Output, Roots, TableFormat, Timeout
from mrm_mtlx.system.process_limits import TIME_LIMIT_S
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.cli.documents import OpenSurface
    from mrm_mtlx.photometry.coefficients import Brdf
    from mrm_mtlx.photometry.forms import DocumentReport
    from mrm_mtlx.photometry.report import PhotometryOptions, SurfaceReport
    from mrm_mtlx.standards.tables import Limit

# What --standard takes besides names.
LIST = "list"


class Method(StrEnum):
    """How colours are taken under illuminant A; the values of photometry.color.METHODS, without importing NumPy."""

    SPECTRAL = "spectral"
    RGB = "rgb"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(photometry)


def photometry(
    paths: Annotated[
        list[Path] | None, typer.Argument(metavar="DOC...", help="Documents, or folders of documents.")
    ] = None,
    standard: Annotated[
        str | None, typer.Option("--standard", metavar="NAME", help="A standard; 'list' prints all, with sources.")
    ] = None,
    class_name: Annotated[str | None, typer.Option("--class", metavar="NAME", help="A class of a standard.")] = None,
    colour: Annotated[str | None, typer.Option("--colour", metavar="NAME", help="Of the class.")] = None,
    list_standards: Annotated[bool, typer.Option("--list", help="Print the standards and classes.")] = False,
    observation: Annotated[
        list[float] | None,
        typer.Option("--observation", metavar="DEG", help="Observation angle; repeatable, without a standard."),
    ] = None,
    entrance: Annotated[
        list[float] | None,
        typer.Option("--entrance", metavar="DEG", help="Entrance angle beta1; repeatable, without a standard."),
    ] = None,
    rotation: Annotated[
        list[float] | None,
        typer.Option(
            "--rotation",
            metavar="DEG",
            help="Rotation of the sample; repeatable, averaged. Default: 0; of R_A 0 and 90.",
        ),
    ] = None,
    source_aperture: Annotated[
        float, typer.Option("--source-aperture", metavar="DEG", help="Diameter of the source, seen from the sample.")
    ] = 0.0,
    receiver_aperture: Annotated[
        float, typer.Option("--receiver-aperture", metavar="DEG", help="Diameter of the receiver.")
    ] = 0.0,
    area: Annotated[
        float | None, typer.Option("--area", metavar="CM2", help="Of the reflector, for limits of intensity.")
    ] = None,
    radius: Annotated[
        float | None, typer.Option("--radius", metavar="CM", help="Inner radius of a reflective strip, for R_I/r.")
    ] = None,
    method: Annotated[
        Method, typer.Option("--colors", help="Colours under illuminant A: by spectra, or the product of RGB.")
    ] = Method.SPECTRAL,
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Only this renderable element of each document.")
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="IMAGE", help="Also draw one surface: a .png, .svg or .pdf file."),
    ] = None,
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    output: Output = None,
    root: Roots = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Coefficients of retroreflection of documents, in the geometries of a standard's class, beside its limits.

    Without a class: a grid of angles, and no verdict. docs/photometry.md explains quantities and angles.
    """
    del timeout  # its option has handed it on
    from mrm_mtlx.cli.options import write_report
    from mrm_mtlx.photometry import forms

    if list_standards or standard == LIST:
        write_report(forms.list_json() if report_format is TableFormat.JSON else forms.list_text(), output)
        return
    if not paths:
        raise typer.BadParameter("name a document, or --list for the standards", param_hint="DOC...")
    limits = _limits(standard, class_name, colour)
    settings = _settings(rotation or _rotations(limits), (source_aperture, receiver_aperture), area, radius, method)
    _check_sizes(limits, settings)
    grid = _grid(observation, entrance, limits)
    if plot is not None:
        from mrm_mtlx.cli.plot import check_output

        check_output(plot, "--plot")
    run = _Run(limits, settings, grid)
    for path in _documents(paths):
        run.document(path, element, root)
    if plot is not None:
        run.draw(plot)
    if report_format is TableFormat.JSON:
        write_report(run.json(), output)
        typer.echo(run.verdict(), err=True)
    else:
        write_report("\n".join([*run.text(), run.verdict()]), output)
        if output is not None:
            typer.echo(run.verdict(), err=True)
    raise typer.Exit(run.status())


def _settings(
    rotation: list[float],
    apertures: tuple[float, float],
    area: float | None,
    radius: float | None,
    method: Method,
) -> PhotometryOptions:
    from mrm_mtlx.photometry.report import PhotometryOptions

    for name, aperture in zip(("--source-aperture", "--receiver-aperture"), apertures, strict=True):
        if not 0.0 <= aperture < 180.0:
            raise typer.BadParameter(f"{aperture:g}: expected an angle from 0 to 180 degrees", param_hint=name)
    for name, size in (("--area", area), ("--radius", radius)):
        if size is not None and not 0.0 < size < float("inf"):
            raise typer.BadParameter(f"{size:g}: expected a number above 0", param_hint=name)
    _check_angles("--rotation", rotation, 360.0)
    return PhotometryOptions(tuple(dict.fromkeys(rotation)), *apertures, method.value, area, radius)


def _rotations(limits: list[Limit]) -> list[float]:
    """Sheeting is measured turned (ASTM D4956); a reflector and a marking stand as they are mounted."""
    return [0.0, 90.0] if not limits or limits[0].quantity == "R_A" else [0.0]


def _check_angles(option: str, angles: list[float] | None, largest: float, smallest: float | None = None) -> None:
    low = -largest if smallest is None else smallest
    for angle in angles or ():
        if not low <= angle <= largest:
            message = f"{angle:g}: expected an angle from {low:g} to {largest:g} degrees"
            raise typer.BadParameter(message, param_hint=option)


def _limits(standard: str | None, class_name: str | None, colour: str | None) -> list[Limit]:
    from mrm_mtlx.standards import limits

    if standard is None and class_name is None:
        if colour is not None:
            raise typer.BadParameter("only with --standard or --class", param_hint="--colour")
        return []
    try:
        return limits(class_name, colour, standard=standard)
    except ValueError as error:
        # The message names what was not told apart: a standard, a class or a colour.
        option = next(name for name in ("standard", "class", "colour") if f" {name} is" in str(error))
        raise typer.BadParameter(f"{error} (mrm photometry --list)", param_hint=f"--{option}") from error


def _check_sizes(limits: list[Limit], settings: PhotometryOptions) -> None:
    """What the class does not need is refused, and what it needs and lacks too: before any document is opened."""
    from mrm_mtlx.photometry.report import check_sizes

    try:
        check_sizes(limits, settings)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def _grid(
    observation: list[float] | None, entrance: list[float] | None, limits: list[Limit]
) -> tuple[Sequence[float], Sequence[float]]:
    from mrm_mtlx.photometry.report import ENTRANCES_DEG, OBSERVATIONS_DEG

    for name, angles in (("--observation", observation), ("--entrance", entrance)):
        if angles and limits:
            raise typer.BadParameter("not with a class, which has its own angles", param_hint=name)
    _check_angles("--observation", observation, 180.0, 0.0)
    _check_angles("--entrance", entrance, 90.0)
    return (
        tuple(dict.fromkeys(observation)) if observation else OBSERVATIONS_DEG,
        tuple(dict.fromkeys(entrance)) if entrance else ENTRANCES_DEG,
    )


def _documents(paths: list[Path]) -> list[Path]:
    """Each document once, those of folders in order."""
    from mrm_mtlx.validation.runner import documents_of

    found = []
    for path in paths:
        found += documents_of(path) if path.is_dir() else [path]
    return list(dict.fromkeys(found))


class _Run:
    """The documents of one call: what was measured, and what could not be."""

    def __init__(
        self, limits: list[Limit], settings: PhotometryOptions, grid: tuple[Sequence[float], Sequence[float]]
    ) -> None:
        self._limits, self._settings, self._grid = limits, settings, grid
        self._documents: list[DocumentReport] = []
        self._brdfs: list[tuple[str, Brdf]] = []

    def document(self, path: Path, element: str | None, roots: list[Path] | None) -> None:
        """Measure the surfaces of a document. What is wrong with it goes to stderr, and the next one is taken."""
        from mrm_mtlx.cli.documents import open_surfaces
        from mrm_mtlx.photometry.forms import DocumentReport
        from mrm_mtlx.validation.runner import shown

        found = DocumentReport(shown(path))
        self._documents.append(found)
        try:
            for opened in open_surfaces(path, element, roots):
                found.surfaces[opened.name] = self._measured(opened)
        except typer.Exit as stopped:
            found.surfaces.clear()
            found.status = stopped.exit_code
            typer.echo(f"mrm: {printable(found.path)} is not measured", err=True)

    def _measured(self, opened: OpenSurface) -> SurfaceReport:
        from mrm_mtlx.photometry import surface_brdf
        from mrm_mtlx.photometry.report import measure

        brdf = surface_brdf(opened.surface)
        try:
            report = measure(brdf, self._limits, self._settings, *self._grid)
        except ValueError as error:
            typer.echo(printable(f"mrm: /{opened.name} has {error}"), err=True)
            raise typer.Exit(1) from error
        opened.refuse_missing_images()
        opened.images.release()
        self._brdfs.append((opened.name, brdf))
        return report

    def status(self) -> int:
        """0 all met; 1 a limit that is not, or a document that is wrong; 3 where something could not be measured."""
        reports, wrong = self._reports(), {document.status for document in self._documents} - {0}
        if 1 in wrong or not all(report.met for report in reports):
            return 1
        return 3 if wrong or not reports else 0

    def verdict(self) -> str:
        """The last line."""
        from mrm_mtlx.photometry.forms import plural

        reports, wrong = self._reports(), sum(document.status != 0 for document in self._documents)
        measured = plural(len(reports), "surface") + (f", {plural(wrong, 'document')} not measured" if wrong else "")
        if not self._limits:
            word = {0: "MEASURED", 1: "FAILED", 3: "NOT ALL MEASURED"}[self.status()]
            return f"{word}  {measured}; no limits asked for (--list)"
        cells = [cell for report in reports for cell in report.cells]
        met = sum(cell.met for cell in cells)
        outside = sum(not color.met for report in reports for color in report.colors)
        colors = f", {plural(outside, 'colour')} outside of the standard's box" if outside else ""
        word = {0: "PASSED", 1: "FAILED", 3: "NOT ALL MEASURED"}[self.status()]
        return f"{word}  {met} of {plural(len(cells), 'limit')} met{colors}, {measured}"

    def text(self) -> list[str]:
        """Lines of the text report."""
        from mrm_mtlx.photometry import forms

        lines = [*forms.heading(self._limits, self._settings), ""]
        for document in self._documents:
            lines.append(printable(document.path) + (": not measured" if document.status else ""))
            for name, report in document.surfaces.items():
                lines += [f"  /{printable(name)}", *forms.surface_lines(report)]
            lines.append("")
        return lines

    def json(self) -> str:
        """The report by docs/photometry.schema.json."""
        from mrm_mtlx.photometry import forms

        return forms.to_json(self._documents, self._limits, self._settings, passed=self.status() == 0)

    def draw(self, path: Path) -> None:
        """A picture of the one surface."""
        if len(self._brdfs) != 1:
            found = f"a picture is of one surface, here are {len(self._brdfs)}"
            raise typer.BadParameter(f"{found}; name one document and --element", param_hint="--plot")
        from mrm_mtlx.plots import coefficients, coefficients_drawing, drawing

        name, brdf = self._brdfs[0]
        panels = coefficients.panels(brdf, self._limits, self._settings)
        try:
            drawing.save(coefficients_drawing.picture(panels), path)
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--plot") from error
        typer.echo(printable(f"wrote {path} (/{name})"), err=True)

    def _reports(self) -> list[SurfaceReport]:
        return [report for document in self._documents for report in document.surfaces.values()]
