"""A material from measurements, from coefficients of retroreflection, or for a class of a standard."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

from mrm_mtlx.api.errors import DataError
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.system.arguments import (
    ArgumentError,
    check_choice,
    check_positive,
    check_whole,
    one_or_more,
    path_of,
    refuse,
)
from mrm_mtlx.system.shown import Shown
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mrm_mtlx.api.opening import PathLike
    from mrm_mtlx.fitting.class_report import ClassFit
    from mrm_mtlx.fitting.fit import FitOptions
    from mrm_mtlx.fitting.given import CoefficientLike, Color
    from mrm_mtlx.fitting.report import FitReport
    from mrm_mtlx.measured import CoefficientSamples, Measurement

MODELS, CRITERIA, RESIDUALS = ("auto", "paper"), ("bic", "aicc"), ("log", "root", "linear")
LOSSES, COSINES = ("soft_l1", "linear"), ("light", "view")


@dataclass(frozen=True, repr=False)
class FittedMaterial(Shown):
    """A material that was fitted to data.

    Attributes
    ----------
    fit
        Its parameters with their errors, how it was chosen, and warnings.
    document
        The text of its MaterialX document.
    path
        Where the document was written, if it was.
    """

    fit: FitReport
    document: str = field(repr=False)
    path: Path | None = None

    def report(self) -> str:
        """Parameters, layers and warnings, and the verdict."""
        return f"{self.fit.text()}\n\n{self.fit.verdict()}"

    def verdict(self) -> str:
        """The last line of the report."""
        return self.fit.verdict()

    def to_json(self) -> str:
        """The report as JSON, as docs/fitting.md explains it."""
        from mrm_mtlx.library.dialects import versions
        from mrm_mtlx.system.json_data import finite

        report = self.fit.to_json(versions(), self.path.name if self.path else "")
        return json.dumps(finite(report), indent=2, allow_nan=False)

    def save(self, path: PathLike) -> None:
        """Write the document."""
        from mrm_mtlx.system.writing import write_text

        write_text(Path(path), self.document, "path")


def fit(
    data: PathLike | Measurement | CoefficientSamples | None = None,
    *,
    ra: CoefficientLike | Sequence[CoefficientLike] = (),
    model: Literal["auto", "paper"] | None = None,
    criterion: Literal["bic", "aicc"] | None = None,
    residual: Literal["log", "root", "linear"] | None = None,
    loss: Literal["soft_l1", "linear"] | None = None,
    loss_scale: float | None = None,
    theta_max: float | None = None,
    plane: bool = False,
    around: float | None = None,
    cosine: Literal["light", "view"] | None = None,
    tint: Color | None = None,
    base: Color | None = None,
    name: str | None = None,
    seed: int = 0,
    output: PathLike | None = None,
    plot: PathLike | None = None,
    listener: Listener = SILENT,
) -> FittedMaterial:
    """Fit a material to measured data, or to coefficients of retroreflection.

    docs/fitting.md explains model, losses and formats.

    Parameters
    ----------
    data
        A file (CSV table, ALTA text, MERL binary), or what was read of one.
    ra
        Coefficients in its place, or one: (observation, entrance, R_A), in degrees and cd/(lx m^2), or "0.2:-4:250".
    model
        "auto": the layers that the data ask for; "paper": one lobe. Default: auto.
    criterion
        Chooses layers. Default: bic; of coefficients aicc.
    residual
        Of BRDF samples. Default: log.
    loss
        Default: soft_l1; of coefficients linear.
    loss_scale
        Residual beyond which soft_l1 is linear.
    theta_max
        Largest angle from the normal [degrees]. Default: 80.
    plane
        Only samples in the plane of incidence.
    around
        Only samples so close to retroreflection [degrees].
    cosine
        Whose cosine is divided out of values that have one. Default: light.
    tint
        Colour of the lobe, for coefficients. Default: grey.
    base
        Diffuse colour, for coefficients. Default: half the tint.
    name
        Of the material. Default: that of the document.
    seed
        Fixes the random starts.
    output
        The document to write, if any.
    plot
        A picture of data and model to write, if any: .png, .svg or .pdf.
    listener
        Told of progress and files.

    Raises
    ------
    ArgumentError
        If the call is wrong.
    DataError
        If the data cannot be read or fitted.
    """
    of_data: dict[str, Any] = {
        "model": model, "residual": residual, "theta_max": theta_max, "plane": plane or None,
        "around": around, "cosine": cosine,
    }  # fmt: skip
    of_coefficients: dict[str, Any] = {"tint": tint, "base": base}
    of_both: dict[str, Any] = {"criterion": criterion, "loss": loss, "loss_scale": loss_scale}
    _check(of_data, of_both, seed)
    target = _document_path(output)
    if plot is not None:
        from mrm_mtlx.plots.style import check_picture

        check_picture(Path(plot), "plot")
    coefficients = _coefficients(ra)
    measured, source = _data(data, coefficients, target)
    from mrm_mtlx.fitting.given import tints
    from mrm_mtlx.measured import CoefficientSamples

    options = _options(loss, loss_scale, seed, "linear" if isinstance(measured, CoefficientSamples) else "soft_l1")
    if isinstance(measured, CoefficientSamples):
        refuse(of_data, "only for BRDF samples")
        report = _fit_coefficients(measured, source, tints(tint, base), options, criterion or "aicc", listener)
    else:
        refuse(of_coefficients, "only for coefficients; BRDF samples have their own colour")
        report = _fit_measurement(measured, source, of_data, options, criterion or "bic", listener)
    command = _command(source, data, coefficients, {**of_data, **of_coefficients, **of_both}, seed)
    found = FittedMaterial(report, _document(report, name or _stem(target, source), command), target)
    if target is not None:
        from mrm_mtlx.system.writing import write_text

        write_text(target, found.document)
        listener.wrote(target)
    if plot is not None:
        _draw(measured, found.document, Path(plot), viewed=cosine == "view")
        listener.wrote(Path(plot))
    return found


def fit_class(
    class_name: str | None = None,
    color: str | None = None,
    *,
    standard: str | None = None,
    output: PathLike | None = None,
    listener: Listener = SILENT,
) -> ClassFit:
    """Fit a material to the minima of a class of a standard: from above, and as closely as a few lobes can.

    Parameters
    ----------
    class_name, color, standard
        Names that choose the class: their beginning is enough, and what there is but one of may be left out.
    output
        The document to write, if any.
    listener
        Told of files.

    Raises
    ------
    ArgumentError
        If there is no such class, or it is not known what a material of it is made of.
    """
    from mrm_mtlx.fitting import class_report
    from mrm_mtlx.system.writing import write_text

    target = _document_path(output)
    found = class_report.fit_class(class_name, color, standard)
    if target is not None:
        write_text(target, found.document)
        listener.wrote(target)
    return found


def fit_classes(output: PathLike, *, listener: Listener = SILENT) -> list[Path]:
    """Fit a material to each class whose make is known, and write their documents into a folder; the files.

    Parameters
    ----------
    output
        The folder, which is made.
    listener
        Told of progress and files.

    Raises
    ------
    ArgumentError
        If they cannot be written.
    """
    from mrm_mtlx.fitting import classes

    try:
        written = classes.write_documents(Path(output), listener.progress)
    except OSError as error:
        msg = f"{output} cannot be written: {error.strerror}"
        raise ArgumentError(msg, "output") from error
    for path in written:
        listener.wrote(path)
    return written


def _check(of_data: Mapping[str, Any], of_both: Mapping[str, Any], seed: int) -> None:
    """Options that are wrong whatever is fitted."""
    for argument, choices in (("model", MODELS), ("residual", RESIDUALS), ("cosine", COSINES)):
        check_choice(argument, of_data[argument], choices)
    for argument, choices in (("criterion", CRITERIA), ("loss", LOSSES)):
        check_choice(argument, of_both[argument], choices)
    if of_data["model"] == "paper":
        refuse({"criterion": of_both["criterion"]}, "not with `model` paper, whose layers are fixed")
    for argument in ("theta_max", "around"):
        check_positive(argument, of_data[argument])
    check_positive("loss_scale", of_both["loss_scale"])
    check_whole("seed", seed, 0)


def _coefficients(ra: CoefficientLike | Sequence[CoefficientLike]) -> list[CoefficientLike]:
    """Coefficients, of one or more; one that is three numbers is no list of three."""
    given: tuple[Any, ...] = one_or_more(cast("Any", ra))
    one = bool(given) and all(isinstance(number, Real) for number in given)
    return [cast("CoefficientLike", given)] if one else list(given)


def _document_path(output: PathLike | None) -> Path | None:
    """The file that a document is written to; its name may not promise something else."""
    if output is None:
        return None
    path = path_of("output", output)
    if path.suffix.lower() not in ("", ".mtlx"):
        msg = f"{path}: a MaterialX document is written; expected a name that ends in .mtlx"
        raise ArgumentError(msg, "output")
    return path


def _options(loss: str | None, scale: float | None, seed: int, default: str) -> FitOptions:
    from mrm_mtlx.fitting.fit import FitOptions

    return FitOptions(loss=str(loss) if loss else default, scale=scale, seed=seed)


def _data(
    data: PathLike | Measurement | CoefficientSamples | None, ra: Sequence[CoefficientLike], output: Path | None
) -> tuple[Measurement | CoefficientSamples, str]:
    """The data that are fitted, and their name."""
    from mrm_mtlx.fitting.given import coefficient_samples
    from mrm_mtlx.measured import CoefficientSamples, Measurement

    if (data is None) == (not ra):
        msg = f"{'nothing' if data is None else 'both'} to fit; expected either `data` or `ra`"
        raise ArgumentError(msg, "data")
    if data is None:
        return coefficient_samples(ra), "coefficients of retroreflection"
    if isinstance(data, Measurement | CoefficientSamples):
        return data, data.name or "data"
    path = path_of("data", data)
    if output is not None and output.exists() and path.exists() and output.samefile(path):
        msg = f"{output} is the data; name another file"
        raise ArgumentError(msg, "output")
    return _read(path), path.name


def _read(path: Path) -> Measurement | CoefficientSamples:
    from mrm_mtlx.measured import read

    try:
        return read(path)
    except (ValueError, OSError) as error:
        raise DataError(str(error)) from error


def _fit_measurement(
    measured: Measurement,
    source: str,
    of_data: Mapping[str, Any],
    options: FitOptions,
    criterion: str,
    listener: Listener,
) -> FitReport:
    from mrm_mtlx.fitting import residuals
    from mrm_mtlx.fitting.run import Sampling, fit_measurement
    from mrm_mtlx.fitting.selection import Criterion

    sampling = Sampling(
        residual=residuals.RESIDUALS[of_data["residual"] or "log"],
        theta_max_deg=80.0 if of_data["theta_max"] is None else of_data["theta_max"],
        plane=bool(of_data["plane"]),
        around_deg=of_data["around"],
        viewed=of_data["cosine"] == "view",
    )
    chosen_by = None if of_data["model"] == "paper" else Criterion[criterion.upper()]
    try:
        return fit_measurement(measured, source, sampling, options, chosen_by, listener.progress)
    except ValueError as error:
        raise DataError(str(error)) from error


def _fit_coefficients(
    measured: CoefficientSamples,
    source: str,
    colors: tuple[tuple[float, float, float], tuple[float, float, float]],
    options: FitOptions,
    criterion: str,
    listener: Listener,
) -> FitReport:
    from mrm_mtlx.fitting.run import fit_coefficients
    from mrm_mtlx.fitting.selection import Criterion

    try:
        return fit_coefficients(measured, source, *colors, options, Criterion[criterion.upper()], listener.progress)
    except ValueError as error:
        raise DataError(str(error)) from error


def _command(source: str, data: Any, ra: Sequence[CoefficientLike], options: Mapping[str, Any], seed: int) -> str:
    """The command line that fits the same, without its paths' folders and without where it wrote."""
    from mrm_mtlx.fitting.given import text

    words = ["mrm fit", *([printable(source)] if data is not None else [])]
    words += [f"--ra {text(one, ':')}" for one in ra]
    for argument, value in options.items():
        if value is not None:
            option = f"--{argument.replace('_', '-')}"
            words.append(option if value is True else f"{option} {text(value, ',')}")
    return " ".join([*words, *([f"--seed {seed}"] if seed else [])])


def _stem(output: Path | None, source: str) -> str:
    return output.stem if output is not None else Path(source).stem


def _document(report: FitReport, name: str, command: str) -> str:
    from mrm_mtlx.fitting.document import material_name, write
    from mrm_mtlx.system.versions import __version__

    notes = report.notes({"mrm-mtlx": __version__})
    return write(report.fit.stack, report.fit.values, material_name(name), notes, doc=f"Made by: {command}")


def _draw(measured: Measurement | CoefficientSamples, document: str, path: Path, *, viewed: bool) -> None:
    """Data and the fitted document: in the plane of incidence, or against observation and entrance angle."""
    import MaterialX as mx

    from mrm_mtlx.library import load_library
    from mrm_mtlx.measured import Measurement
    from mrm_mtlx.plots import coefficients_drawing, drawing, fits
    from mrm_mtlx.reference import Surface

    read = mx.createDocument()
    mx.readFromXmlString(read, document)
    read.setDataLibrary(load_library().document)
    surface = Surface(read.getMaterialNodes()[0])
    try:
        if isinstance(measured, Measurement):
            picture = drawing.by_light(fits.panels(measured, surface, viewed=viewed), "fitted")
        else:
            picture = coefficients_drawing.picture(fits.coefficient_panels(measured, surface), "given")
        drawing.save(picture, path)
    except ValueError as error:
        raise ArgumentError(str(error), "plot") from error
