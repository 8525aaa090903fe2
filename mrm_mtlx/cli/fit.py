"""`mrm fit`: a material from measurements, from coefficients, or for a class of a standard."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Cosine, Criterion, FitModel, Loss, Residual, TableFormat
from mrm_mtlx.cli.options import Seed
from mrm_mtlx.system.arguments import ArgumentError, refuse

if TYPE_CHECKING:
    from mrm_mtlx.api.fit import FittedMaterial


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, fit)


def fit(
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DOC", help="The document to write; a folder for --classes.")
    ],
    data: Annotated[
        Path | None, typer.Argument(metavar="DATA", help="Measured data: CSV table, ALTA text or MERL binary.")
    ] = None,
    ra: Annotated[
        list[str] | None,
        typer.Option("--ra", metavar="OBS:ENTRANCE:VALUE", help="R_A in cd/(lx m^2) at two angles [deg]; repeatable."),
    ] = None,
    standard: Annotated[str | None, typer.Option("--standard", metavar="NAME", help="Of the class to meet.")] = None,
    class_name: Annotated[str | None, typer.Option("--class", metavar="NAME", help="Class to meet.")] = None,
    color: Annotated[str | None, typer.Option("--color", metavar="NAME", help="Of the class.")] = None,
    classes: Annotated[
        bool, typer.Option("--classes", help="Write a material of each class that is known into a folder.")
    ] = False,
    model: Annotated[
        FitModel | None,
        typer.Option("--model", help="auto: the layers that the data ask for; paper: one lobe. Default: auto."),
    ] = None,
    criterion: Annotated[
        Criterion | None, typer.Option("--criterion", help="Chooses layers. Default: bic; of coefficients aicc.")
    ] = None,
    residual: Annotated[Residual | None, typer.Option("--residual", help="Of BRDF samples. Default: log.")] = None,
    loss: Annotated[Loss | None, typer.Option("--loss", help="Default: soft_l1; of coefficients linear.")] = None,
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
        Cosine | None,
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
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import terminal

    of_fits: dict[str, Any] = {
        "model": model, "residual": residual, "theta_max": theta_max, "plane": plane, "around": around,
        "cosine": cosine, "tint": tint, "base": base, "criterion": criterion, "loss": loss, "loss_scale": loss_scale,
        "plot": plot, "name": name, "seed": seed,
    }  # fmt: skip
    of_class = {"class_name": class_name, "color": color, "standard": standard}
    source = _source({"data": data, "ra": ra, "class_name": any(of_class.values()), "classes": classes})
    with terminal("fitting") as listener:
        if source in ("data", "ra"):
            found = mrm.fit(data, ra=ra or (), **of_fits, output=output, listener=listener)
            _print(found, report_format)
            return
        refuse({**of_fits, "seed": seed or None}, f"not with `{source}`")
        if report_format is not TableFormat.TEXT:
            raise ArgumentError("not with classes; mrm photometry reports values and limits", "report_format")
        if classes:
            written = mrm.fit_classes(output, listener=listener)
            typer.echo(f"FITTED  {len(written)} classes")
        else:
            typer.echo(mrm.fit_class(**of_class, output=output, listener=listener))


def _source(sources: dict[str, Any]) -> str:
    """The one thing that there is to fit.

    Raises
    ------
    ArgumentError
        If there is nothing, or more than one.
    """
    given = [source for source, there in sources.items() if there]
    if len(given) != 1:
        found = f"both {' and '.join(f'`{source}`' for source in given)}" if given else "nothing"
        raise ArgumentError(f"{found} to fit; expected one of `data`, `ra`, `class_name` and `classes`", "data")
    return given[0]


def _print(found: FittedMaterial, form: TableFormat) -> None:
    if form is TableFormat.JSON:
        typer.echo(found.to_json())
        typer.echo(found.verdict(), err=True)
    else:
        typer.echo(found)
