"""`mrm fit`: a material from measurements, from coefficients, or for a class of a standard."""

from __future__ import annotations

import json
import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mrm_mtlx.cli.options import Seed, TableFormat
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.fitting.fit import FitOptions
    from mrm_mtlx.fitting.report import FitReport
    from mrm_mtlx.measured import CoefficientSamples, Measurement


class ModelName(StrEnum):
    """Which family is fitted."""

    AUTO = "auto"
    PAPER = "paper"


class ResidualName(StrEnum):
    """Of BRDF samples; the names of measured.samples.RESIDUALS, without importing NumPy."""

    LOG = "log"
    ROOT = "root"
    LINEAR = "linear"


class LossName(StrEnum):
    """The names of measured.fit.LOSSES."""

    SOFT_L1 = "soft_l1"
    LINEAR = "linear"


class CosineName(StrEnum):
    """Whose cosine the values had."""

    LIGHT = "light"
    VIEW = "view"


class CriterionName(StrEnum):
    """Information criteria."""

    BIC = "bic"
    AICC = "aicc"


# Largest R_A that is taken [cd/(lx m^2)]: full cube corners at 0.1 degrees stay below a hundredth of it.
LARGEST_RA = 1e6


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(fit)


def fit(
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DOC", help="The document to write; a folder for --classes.")
    ],
    data: Annotated[
        Path | None, typer.Argument(metavar="DATA", help="Measured data: CSV table, ALTA text or MERL binary.")
    ] = None,
    coefficients: Annotated[
        list[str] | None,
        typer.Option("--ra", metavar="OBS:ENTRANCE:VALUE", help="R_A in cd/(lx m^2) at two angles [deg]; repeatable."),
    ] = None,
    standard: Annotated[str | None, typer.Option("--standard", metavar="NAME", help="Of the class to meet.")] = None,
    class_name: Annotated[str | None, typer.Option("--class", metavar="NAME", help="Class to meet.")] = None,
    colour: Annotated[str | None, typer.Option("--colour", metavar="NAME", help="Of the class.")] = None,
    classes: Annotated[
        bool, typer.Option("--classes", help="Write a material of each class that is known into a folder.")
    ] = False,
    model: Annotated[
        ModelName | None,
        typer.Option("--model", help="auto: the layers that the data ask for; paper: one lobe. Default: auto."),
    ] = None,
    criterion: Annotated[
        CriterionName | None, typer.Option("--criterion", help="Chooses layers. Default: bic; of coefficients aicc.")
    ] = None,
    residual: Annotated[ResidualName | None, typer.Option("--residual", help="Of BRDF samples. Default: log.")] = None,
    loss: Annotated[LossName | None, typer.Option("--loss", help="Default: soft_l1; of coefficients linear.")] = None,
    loss_scale: Annotated[
        float | None, typer.Option("--loss-scale", metavar="X", help="Residual beyond which soft_l1 is linear.")
    ] = None,
    theta_max: Annotated[
        float | None, typer.Option("--theta-max", metavar="DEG", help="Largest angle from the normal. Default: 80.")
    ] = None,
    plane: Annotated[bool, typer.Option("--plane", help="Only samples in the plane of incidence.")] = False,
    around: Annotated[
        float | None, typer.Option("--around", metavar="DEG", help="Only samples so close to retroreflection.")
    ] = None,
    cosine: Annotated[
        CosineName | None,
        typer.Option("--cosine", help="Whose cosine is divided out of values that have one. Default: light."),
    ] = None,
    tint: Annotated[
        str | None, typer.Option("--tint", metavar="R,G,B", help="Colour of the lobe, for coefficients. Default: grey.")
    ] = None,
    base: Annotated[
        str | None,
        typer.Option("--base", metavar="R,G,B", help="Diffuse colour, for coefficients. Default: half the tint."),
    ] = None,
    name: Annotated[str | None, typer.Option("--name", help="Of the material. Default: that of the document.")] = None,
    seed: Seed = 0,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="IMAGE", help="Also draw data and model: .png, .svg or .pdf.")
    ] = None,
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
) -> None:
    """Fit a material to measured data, to coefficients of retroreflection, or to the minima of a class.

    Writes a MaterialX document and prints what was found. docs/fitting.md explains model, losses and formats.
    """
    of_data = {
        "--model": model, "--residual": residual, "--theta-max": theta_max, "--plane": plane or None,
        "--around": around, "--cosine": cosine,
    }  # fmt: skip
    of_coefficients = {"--tint": tint, "--base": base}
    of_both = {"--criterion": criterion, "--loss": loss, "--loss-scale": loss_scale, "--plot": plot}
    of_class = {"--standard": standard, "--class": class_name, "--colour": colour}
    given = [what for what, there in _sources(data, coefficients, of_class, classes).items() if there]
    if len(given) != 1:
        found = f"both {' and '.join(given)}" if given else "nothing"
        raise typer.BadParameter(
            f"{found} to fit; expected one of DATA, --ra, --class and --classes", param_hint="DATA"
        )
    if plot is not None:
        from mrm_mtlx.cli.plot import check_output

        check_output(plot, "--plot")
    if classes or given == ["--class"]:
        of_fits = {**of_data, **of_coefficients, **of_both, "--name": name, "--seed": seed or None}
        _refuse(of_fits, f"not with {given[0]}")
        _fit_classes(output, of_class, report_format, every=classes)
        return
    if model is ModelName.PAPER:
        _refuse({"--criterion": criterion}, "not with --model paper, whose layers are fixed")
    _check_positive({"--theta-max": theta_max, "--around": around, "--loss-scale": loss_scale})
    report = None
    if data is not None:
        if output.exists() and data.exists() and output.samefile(data):
            raise typer.BadParameter(f"{output} is the data; name another file", param_hint="--output")
        measured = _read(data)
        from mrm_mtlx.measured import CoefficientSamples

        if not isinstance(measured, CoefficientSamples):
            _refuse(of_coefficients, "only for coefficients; BRDF samples have their own colour")
            report = _fit_brdf(measured, data.name, _settings(loss, loss_scale, seed, "soft_l1"), of_data, criterion)
    else:
        measured = _coefficients(coefficients or [])
    if report is None:
        _refuse(of_data, "only for BRDF samples")
        source = data.name if data is not None else "coefficients of retroreflection"
        settings = _settings(loss, loss_scale, seed, "linear")
        report = _fit_coefficients(measured, source, settings, _tints(tint, base), criterion)  # type: ignore[arg-type]
    _write(report, output, name, _command(data, coefficients, {**of_data, **of_coefficients, **of_both}, seed))
    if plot is not None:
        _draw(measured, output, plot, viewed=cosine is CosineName.VIEW)
    _print(report, output, report_format)


def _sources(
    data: Path | None, coefficients: list[str] | None, of_class: dict[str, Any], classes: bool
) -> dict[str, bool]:
    by_class = any(value is not None for value in of_class.values())
    return {"DATA": data is not None, "--ra": bool(coefficients), "--class": by_class, "--classes": classes}


def _refuse(options: dict[str, Any], why: str) -> None:
    """Options that do not go with the others are a usage error: nothing is accepted and ignored."""
    for option, value in options.items():
        if value is not None:
            raise typer.BadParameter(why, param_hint=option)


def _check_positive(options: dict[str, float | None]) -> None:
    for option, value in options.items():
        if value is not None and not 0.0 < value < math.inf:
            raise typer.BadParameter(f"{value:g}: expected a number above 0", param_hint=option)


def _settings(loss: LossName | None, scale: float | None, seed: int, default: str) -> FitOptions:
    from mrm_mtlx.fitting.fit import FitOptions

    return FitOptions(loss=loss.value if loss else default, scale=scale, seed=seed)


def _read(path: Path) -> Measurement | CoefficientSamples:
    """The data; a file that cannot be read is a finding."""
    from mrm_mtlx.measured import read

    try:
        return read(path)
    except (ValueError, OSError) as error:
        typer.echo(f"mrm: {error}", err=True)
        raise typer.Exit(1) from error


def _coefficients(texts: list[str]) -> CoefficientSamples:
    """Values of --ra."""
    import numpy as np

    from mrm_mtlx.measured import CoefficientSamples

    rows = []
    for text in texts:
        try:
            observation, entrance, value = (float(part) for part in text.split(":"))
        except ValueError:
            raise typer.BadParameter(
                f"'{text}': expected OBS:ENTRANCE:VALUE, such as 0.2:-4:250", param_hint="--ra"
            ) from None
        if not (0.0 <= observation < 90.0 and -90.0 < entrance < 90.0 and 0.0 < value <= LARGEST_RA):
            expected = "angles of 0 to 90 and -90 to 90 degrees, and an R_A above 0 (at most 1e6)"
            raise typer.BadParameter(f"'{text}': expected {expected}", param_hint="--ra")
        rows.append((observation, entrance, value))
    observation, entrance, value = np.array(rows).T
    return CoefficientSamples("", np.deg2rad(observation), np.deg2rad(entrance), np.zeros(len(rows)), value)


def _tints(tint: str | None, base: str | None) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    lobe = _color(tint, "--tint") if tint is not None else (1.0, 1.0, 1.0)
    if max(lobe) <= 0.0:
        raise typer.BadParameter(f"'{tint}': expected a colour that is not black", param_hint="--tint")
    red, green, blue = (x / max(lobe) for x in lobe)
    return (red, green, blue), _color(base, "--base") if base is not None else (red / 2, green / 2, blue / 2)


def _color(text: str, option: str) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"'{text}': expected three numbers, R,G,B", param_hint=option) from None
    if not all(0.0 <= x <= 1.0 for x in (red, green, blue)):
        raise typer.BadParameter(f"'{text}': expected numbers from 0 to 1", param_hint=option)
    return red, green, blue


def _fit_brdf(
    measured: Measurement, source: str, settings: FitOptions, options: dict[str, Any], criterion: CriterionName | None
) -> FitReport:
    """The family that the data ask for, or the paper's."""
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.fitting import fit as fitting
    from mrm_mtlx.fitting.model import Family
    from mrm_mtlx.fitting.report import FitReport
    from mrm_mtlx.fitting.samples import doubts, from_measurement

    around, theta_max = options["--around"], options["--theta-max"]
    cosine = options["--cosine"] or CosineName.LIGHT
    try:
        samples = from_measurement(
            measured,
            residual=(options["--residual"] or ResidualName.LOG).value,
            largest=math.radians(theta_max if theta_max is not None else 80.0),
            plane=bool(options["--plane"]),
            around=None if around is None else math.radians(around),
            cosine="v" if cosine is CosineName.VIEW else "l",
            seed=settings.seed,
        )
        selection = None
        with progress("fitting") as report:
            if options["--model"] is ModelName.PAPER:
                family = Family(lobes=1, diffuse=False, paper=True, channels=samples.value.shape[1])
                found = fitting.fit_family(family, samples, settings)
            else:
                name = "AICc" if criterion is CriterionName.AICC else "BIC"
                selection = fitting.select(samples, settings, criterion=name, progress=report)
                found = selection.fit
    except ValueError as error:
        raise _finding(error) from error
    warnings = [*doubts(measured, viewed=cosine is CosineName.VIEW), *fitting.warnings(found, samples)]
    return FitReport(source, samples, settings, found, selection, warnings)


def _fit_coefficients(
    measured: CoefficientSamples,
    source: str,
    settings: FitOptions,
    colors: tuple[tuple[float, float, float], tuple[float, float, float]],
    criterion: CriterionName | None,
) -> FitReport:
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.fitting import fit as fitting
    from mrm_mtlx.fitting.report import FitReport
    from mrm_mtlx.fitting.samples import from_coefficients

    try:
        samples = from_coefficients(measured)
        family = fitting.coefficient_family(samples, *colors)
        name = "BIC" if criterion is CriterionName.BIC else "AICc"
        with progress("fitting") as report:
            selection = fitting.select(samples, settings, base=family, criterion=name, progress=report)
        if not math.isfinite(selection.fit.rms):
            raise ValueError(f"no lobe returns as little as {measured.ra.min():g} cd/(lx m2); is the unit right?")
    except ValueError as error:
        raise _finding(error) from error
    return FitReport(source, samples, settings, selection.fit, selection, fitting.warnings(selection.fit, samples))


def _finding(error: ValueError) -> typer.Exit:
    """Data that cannot be fitted."""
    typer.echo(f"mrm: {error}", err=True)
    return typer.Exit(1)


def _command(data: Path | None, coefficients: Sequence[str] | None, options: dict[str, Any], seed: int) -> str:
    """The command without its paths' folders and without where it wrote."""
    words = ["mrm fit", *([printable(data.name)] if data else []), *(f"--ra {text}" for text in coefficients or [])]
    for option, value in options.items():
        if option == "--plot" or value is None:
            continue
        words.append(option if value is True else f"{option} {value}")
    return " ".join([*words, *([f"--seed {seed}"] if seed else [])])


def _write(report: FitReport, output: Path, name: str | None, command: str) -> None:
    from mrm_mtlx import __version__
    from mrm_mtlx.cli.options import write_file
    from mrm_mtlx.fitting.document import material_name, write

    notes = report.notes({"mrm-mtlx": __version__})
    title = material_name(name or output.stem)
    write_file(output, write(report.fit.family, report.fit.values, title, notes, doc=f"Made by: {command}"))
    typer.echo(f"wrote {output}", err=True)


def _print(report: FitReport, output: Path, form: TableFormat) -> None:
    if form is TableFormat.JSON:
        from mrm_mtlx.validation.reports import finite
        from mrm_mtlx.validation.runner import versions

        typer.echo(json.dumps(finite(report.to_json(versions(), output.name)), indent=2, allow_nan=False))
        typer.echo(report.verdict(), err=True)
    else:
        typer.echo(f"{report.text()}\n\n{report.verdict()}")


def _draw(measured: Measurement | CoefficientSamples, document: Path, path: Path, *, viewed: bool) -> None:
    """Data and the written document: in the plane of incidence, or against observation and entrance angle."""
    from mrm_mtlx.cli.documents import open_surfaces
    from mrm_mtlx.measured import Measurement
    from mrm_mtlx.plots import drawing, fits

    surface = open_surfaces(document, None)[0].surface
    try:
        if isinstance(measured, Measurement):
            picture = drawing.by_light(fits.panels(measured, surface, viewed=viewed), "fitted")
        else:
            from mrm_mtlx.plots import coefficients_drawing

            picture = coefficients_drawing.picture(fits.coefficient_panels(measured, surface), "given")
        drawing.save(picture, path)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--plot") from error
    typer.echo(f"wrote {path}", err=True)


def _fit_classes(output: Path, of_class: dict[str, Any], form: TableFormat, *, every: bool) -> None:
    """Materials that meet the minima of one class, or of all whose make is known."""
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.cli.options import write_file
    from mrm_mtlx.fitting import classes
    from mrm_mtlx.fitting.performance import MARGIN, meet
    from mrm_mtlx.standards import limits

    if form is not TableFormat.TEXT:
        raise typer.BadParameter("not with classes; mrm photometry reports values and limits", param_hint="--format")
    if every:
        try:
            with progress("fitting") as report:
                written = classes.write_documents(output, report)
        except OSError as error:
            raise typer.BadParameter(f"{output} cannot be written: {error.strerror}", param_hint="--output") from error
        for path in written:
            typer.echo(f"wrote {path}", err=True)
        typer.echo(f"FITTED  {len(written)} classes")
        return
    names = of_class["--class"], of_class["--colour"]
    try:
        wanted = limits(*names, standard=of_class["--standard"])
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--class") from error
    material = next((material for material in classes.MATERIALS if material.limits() == wanted), None)
    if material is None:
        known = ", ".join(f"{m.standard} {m.class_name} {m.colour}" for m in classes.MATERIALS)
        message = f"what a material of this class is made of is not known here; known are: {known}"
        raise typer.BadParameter(message, param_hint="--class")
    met = meet(wanted, material.make)
    write_file(output, classes.document(material, met))
    typer.echo(f"wrote {output}", err=True)
    lines = [
        f"{'observation':>12}{'entrance':>10}{'minimum':>12}{'of the fit':>12}  {wanted[0].quantity} {wanted[0].unit}"
    ]
    for limit, ratio in zip(wanted, met.ratios * MARGIN, strict=True):
        value = ratio * limit.minimum
        lines.append(f"{limit.observation_deg:>12g}{limit.entrance_deg:>10g}{limit.minimum:>12g}{value:>12.4g}")
    typer.echo("\n".join(lines))
    typer.echo(
        f"\nFITTED  {len(wanted)} minima met by {float(min(met.ratios)) * MARGIN - 1.0:.1%}, share {met.share:.3f}"
    )
