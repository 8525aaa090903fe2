"""`mrm doctor`: what this machine can run, and what adds what it lacks."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.choices import TableFormat

if TYPE_CHECKING:
    from mrm_mtlx.engines.base import Availability


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(doctor)


def doctor(
    report_format: Annotated[TableFormat, typer.Option("--format", help="Form of the report.")] = TableFormat.TEXT,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Say instead which of MaterialX's nodes the reference evaluates.")
    ] = False,
) -> None:
    """Say which targets can be generated, compiled and run here, and what to install for the others.

    The exit status is 0 if generated GLSL can be run and compared, else 1.
    """
    if coverage:
        _print_coverage(report_format)
        return
    from mrm_mtlx.engines import registry
    from mrm_mtlx.library import load_library, node_library_folder
    from mrm_mtlx.shadergen import available_targets
    from mrm_mtlx.system.versions import versions

    engines, models = survey(), load_library().surface_models
    if report_format is TableFormat.JSON:
        report = {
            "schema": "mrm.doctor/1",
            "versions": versions(),
            "targets": list(available_targets()),
            "surface_models": [{"node": x.model.node, "input": x.model.amount, "reason": x.reason} for x in models],
            "engines": {
                name: {"use": use, "available": a.available, "detail": a.detail, "remedy": a.remedy}
                for name, (use, a) in engines.items()
            },
        }
        typer.echo(json.dumps(report, indent=2))
    else:
        typer.echo("versions   " + ", ".join(f"{name} {version}" for name, version in versions().items()))
        typer.echo(f"library    {'found' if node_library_folder().is_dir() else 'missing'}")
        typer.echo(f"targets    {', '.join(available_targets())} (source can be generated)")
        extended = [f"{x.model.node} {x.model.amount}" for x in models if not x.reason]
        typer.echo(f"models     {', '.join(extended) or 'none'} (partly retroreflective)")
        for left_out in (x for x in models if x.reason):
            typer.echo(f"{'':11}{left_out.model.node} is left out: {left_out.reason}")
        width = max(len(use) for use, _ in engines.values())
        for name, (use, state) in engines.items():
            typer.echo(
                f"{name.ljust(9)}  {'ok     ' if state.available else 'missing'}  {use.ljust(width)}  {state.detail}"
            )
            if state.remedy:
                typer.echo(f"{'':20}to add it: {state.remedy}")
    runner = registry.engine_for("glsl", registry.runs)
    raise typer.Exit(0 if runner and runner.availability().available else 1)


def _print_coverage(report_format: TableFormat) -> None:
    from collections import Counter

    from mrm_mtlx.library import load_library
    from mrm_mtlx.reference.coverage import How, coverage
    from mrm_mtlx.system.versions import versions

    definitions = coverage(load_library().document)
    if report_format is TableFormat.JSON:
        nodes = [{"name": c.name, "library": c.library, "how": c.how, "reason": c.reason} for c in definitions]
        covered = sum(bool(c.how) for c in definitions)
        report = {"schema": "mrm.coverage/1", "versions": versions(), "covered": covered, "definitions": nodes}
        typer.echo(json.dumps(report, indent=2))
        return
    every, how = Counter(c.library for c in definitions), Counter((c.library, c.how) for c in definitions)
    typer.echo(f"{'library':<9}{'nodes':>7}{'functions':>11}{'graphs':>8}{'covered':>9}")
    for name, total in every.items():
        functions, graphs = how[name, How.FUNCTION], how[name, How.GRAPH]
        share = (functions + graphs) / total
        typer.echo(f"{name:<9}{total:>7}{functions:>11}{graphs:>8}{share:>9.1%}")
    covered = sum(bool(c.how) for c in definitions)
    typer.echo(f"{'all':<9}{len(definitions):>7}{'':>19}{covered / len(definitions):>9.1%}")
    for missing in (c for c in definitions if not c.how):
        typer.echo(f"not covered: {missing.name} ({missing.library}): {missing.reason}")


def survey() -> dict[str, tuple[str, Availability]]:
    """Engines by name: what each is for, and whether it works here."""
    from mrm_mtlx.engines import registry

    return {name: (engine.use, engine.availability()) for name, engine in registry.engines().items()}
