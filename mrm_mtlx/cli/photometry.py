"""`mrm photometry`: coefficients of retroreflection of documents, beside the minima of a class."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Method, TableFormat
from mrm_mtlx.cli.options import Exclude, Output, Roots, Timeout
from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

# What --standard takes besides names.
LIST = "list"
# Exit status by how a measurement ends.
_STATUS = {"met": 0, "failed": 1, "incomplete": 3}


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, photometry)


def photometry(
    paths: Annotated[
        list[Path] | None, typer.Argument(metavar="DOC", help="Documents, or folders of documents.")
    ] = None,
    standard: Annotated[
        str | None, typer.Option("--standard", metavar="NAME", help="A standard; 'list' prints all, with sources.")
    ] = None,
    class_name: Annotated[str | None, typer.Option("--class", metavar="NAME", help="A class of a standard.")] = None,
    color: Annotated[str | None, typer.Option("--color", metavar="NAME", help="Of the class.")] = None,
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
        Method, typer.Option("--method", help="Colours under illuminant A: by spectra, or the product of RGB.")
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
    exclude: Exclude = None,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Coefficients of retroreflection of documents, in the geometries of a standard's class, beside its limits.

    Without a class: a grid of angles, and no verdict. docs/photometry.md explains quantities and angles.
    """
    del timeout  # its option has handed it on
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import Terminal
    from mrm_mtlx.cli.options import write_report

    as_json = report_format is TableFormat.JSON
    if list_standards or standard == LIST:
        known = mrm.list_standards()
        write_report(known.to_json() if as_json else known.report(), output)
        return
    if not paths:
        raise ArgumentError("name a document, or --list for the standards", "paths")
    found = mrm.photometry(
        paths,
        standard=standard,
        class_name=class_name,
        color=color,
        observation=observation or (),
        entrance=entrance or (),
        rotation=rotation or (),
        source_aperture=source_aperture,
        receiver_aperture=receiver_aperture,
        area=area,
        radius=radius,
        method=method.value,
        element=element,
        plot=plot,
        root=root or (),
        exclude=exclude or (),
        listener=Terminal(),
    )
    write_report(found.to_json() if as_json else found.report(), output)
    if as_json or output is not None:
        typer.echo(found.verdict(), err=True)
    raise typer.Exit(_STATUS[found.outcome])
