"""`mrm vectors`: test vectors of the model."""

from __future__ import annotations

from typing import Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import VectorFormat
from mrm_mtlx.cli.options import Output


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, vectors)


def vectors(
    form: Annotated[VectorFormat, typer.Option("--format", help="Form of the table.")] = VectorFormat.TEXT,
    output: Output = None,
) -> None:
    """Print test vectors: lobes, directions, and the values of the reference, to check an implementation against.

    docs/model.md explains them.
    """
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.options import write_report

    found = mrm.vectors()
    forms = {VectorFormat.JSON: found.to_json, VectorFormat.CSV: found.to_csv, VectorFormat.TEXT: found.report}
    write_report(forms[form](), output)
