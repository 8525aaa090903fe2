"""`mrm conformance`: the node library itself against the oracle."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.options import Implementation, Library, Output, Samples, Seed, TableFormat, Targets

if TYPE_CHECKING:
    from mrm_mtlx.validation.conformance import CaseResult


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(conformance)


def conformance(
    target: Targets = None,
    samples: Samples = 1 << 18,
    seed: Seed = 0,
    library: Library = Implementation.MRM,
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    output: Output = None,
) -> None:
    """Compare every node, flag and shape of lobe with the oracle, over random parameters."""
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.cli.options import chosen_targets, write_report
    from mrm_mtlx.library import Origin
    from mrm_mtlx.validation.conformance import SCHEMA, TARGETS, run
    from mrm_mtlx.validation.reports import finite
    from mrm_mtlx.validation.runner import engines, versions

    with progress("comparing") as report:
        results = list(run(chosen_targets(target, TARGETS), samples, seed, Origin(library.value), report))
    statuses = [result.status for result in results]
    verdict = _verdict(statuses)
    if report_format is TableFormat.JSON:
        document = {
            "schema": SCHEMA,
            "versions": versions(),
            "engines": engines(),
            "library": library.value,
            "cases": [result.to_json() for result in results],
        }
        write_report(json.dumps(finite(document), indent=2, allow_nan=False), output)
        typer.echo(verdict, err=True)
    else:
        write_report(f"{_table(results)}\n{verdict}", output)
    raise typer.Exit(1 if "fail" in statuses else 0 if "pass" in statuses else 3)


def _verdict(statuses: list[str]) -> str:
    word = "FAILED" if "fail" in statuses else "PASSED" if "pass" in statuses else "NOTHING CHECKED"
    counts = [f"{statuses.count(status)} {status}ed" for status in ("pass", "fail")]
    return f"{word}  {', '.join(counts)}, {statuses.count('skip')} skipped"


def _table(results: list[CaseResult]) -> str:
    header = ("case", "target", "status", "samples", "largest", "median", "of allowed")
    rows = [header]
    for result in results:
        found = result.comparison
        figures = (
            (f"{found.samples}", f"{found.max_error:.2e}", f"{found.median_error:.2e}", f"{found.excess:.2f}")
            if found
            else ("-", "-", "-", result.reason or "-")
        )
        rows.append((result.case.name, result.target, result.status, *figures))
    widths = [max(len(row[column]) for row in rows) for column in range(len(header))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    note = "Relative errors per case; 'of allowed' is the largest ratio of an error to its own tolerance."
    return "\n".join([*lines, note])
