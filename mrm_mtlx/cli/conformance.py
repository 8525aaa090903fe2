"""`mrm conformance`: the node library itself against the oracle."""

from __future__ import annotations

from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Form, Implementation, TableFormat
from mrm_mtlx.cli.options import Library, Output, Samples, Seed, Targets

# Exit status by how a run ends.
_STATUS = {"pass": 0, "fail": 1, "skip": 3}


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, conformance)


def conformance(
    target: Targets = None,
    samples: Samples = 1 << 18,
    seed: Seed = 0,
    library: Library = Implementation.MRM,
    form: Annotated[
        Form, typer.Option("--form", help="The library's sources, or nodes of the standard library alone.")
    ] = Form.LIBRARY,
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    output: Output = None,
) -> None:
    """Compare every node, flag and shape of lobe with the oracle, over random parameters.

    Targets: glsl and essl in the OpenGL driver, osl in Cycles; if named, storm in OpenUSD's Storm. The portable form is
    compared in the first two.
    """
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import terminal
    from mrm_mtlx.cli.options import write_report

    with terminal("comparing") as listener:
        found = mrm.conformance(
            target=target or (), samples=samples, seed=seed, library=library.value, form=form.value, listener=listener
        )
    if report_format is TableFormat.JSON:
        write_report(found.to_json(), output)
        typer.echo(found.verdict(), err=True)
    else:
        write_report(found.report(), output)
    raise typer.Exit(_STATUS[found.status])
