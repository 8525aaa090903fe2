"""`mrm conformance`: the node library itself against the oracle."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.choices import Implementation, TableFormat
from mrm_mtlx.cli.options import Library, Output, Samples, Seed, Targets
from mrm_mtlx.validation.results import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.conformance import CaseResult


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
    """Compare every node, flag and shape of lobe with the oracle, over random parameters.

    Targets: glsl and essl in the OpenGL driver, osl in Cycles.
    """
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.cli.options import chosen_targets, write_report
    from mrm_mtlx.conformance import SCHEMA, run
    from mrm_mtlx.conformance import targets as conformance_targets
    from mrm_mtlx.engines.base import CompileError, EngineFailure
    from mrm_mtlx.library import Origin
    from mrm_mtlx.system.versions import versions
    from mrm_mtlx.validation.reports import finite
    from mrm_mtlx.validation.runner import engines

    targets = chosen_targets(target, conformance_targets())
    try:
        with progress("comparing") as report:
            results = list(run(targets, samples, seed, Origin(library.value), report))
    except (CompileError, EngineFailure) as error:
        typer.echo(f"mrm: {error}", err=True)
        raise typer.Exit(2) from error
    statuses = [result.status for result in results]
    verdict = _verdict(statuses)
    if report_format is TableFormat.JSON:
        document = {
            "schema": SCHEMA,
            "versions": versions(),
            "engines": engines(targets),
            "library": library.value,
            "cases": [result.to_json() for result in results],
        }
        write_report(json.dumps(finite(document), indent=2, allow_nan=False), output)
        typer.echo(verdict, err=True)
    else:
        write_report(f"{_table(results)}\n{verdict}", output)
    raise typer.Exit(1 if Status.FAIL in statuses else 0 if Status.PASS in statuses else 3)


def _verdict(statuses: list[Status]) -> str:
    word = "FAILED" if Status.FAIL in statuses else "PASSED" if Status.PASS in statuses else "NOTHING CHECKED"
    counts = [f"{statuses.count(status)} {status}ed" for status in (Status.PASS, Status.FAIL)]
    return f"{word}  {', '.join(counts)}, {statuses.count(Status.SKIP)} skipped"


def _table(results: list[CaseResult]) -> str:
    header = ("case", "target", "status", "samples", "largest", "median", "of allowed")
    rows = [header]
    for result in results:
        found = result.comparison
        if found:
            samples, figures = f"{found.samples}", (f"{found.max_error:.2e}", f"{found.median_error:.2e}", found.excess)
        elif result.approximations:
            samples, figures = "-", ("-", "-", max(a.excess for a in result.approximations))
        else:
            rows.append((result.name, result.target, result.status, "-", "-", "-", result.reason or "-"))
            continue
        rows.append((result.name, result.target, result.status, samples, *figures[:2], f"{figures[2]:.2f}"))
    note = "Relative errors per case; 'of allowed' is the largest ratio of an error to its own tolerance."
    return "\n".join([*_aligned_columns(rows), note, *_approximations(results)])


def _approximations(results: list[CaseResult]) -> list[str]:
    """L1 error and albedo ratio of each approximate lobe, where there are any."""
    rows = [("aligned lobe", "material", "alpha", "view", "L1", "bound", "albedo", "bound", "")]
    for result in results:
        for a in result.approximations:
            rows.append(
                (
                    result.case.node,
                    a.material,
                    f"{a.alpha:g}",
                    f"{a.view_deg:g}",
                    f"{a.l1:.3f}",
                    f"{a.l1_bound:g}",
                    f"{a.albedo:.4f}",
                    f"1 ± {a.albedo_bound:g}",
                    "" if a.passed else "FAIL",
                )
            )
    if len(rows) == 1:
        return []
    note = "L1: integral of |found - exact| over that of exact; albedo: ratio of the integrals; view in degrees."
    return ["", *_aligned_columns(rows), note]


def _aligned_columns(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
