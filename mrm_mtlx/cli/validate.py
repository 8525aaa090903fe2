"""`mrm validate`: documents go in, verdicts come out."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.choices import Format, Implementation
from mrm_mtlx.cli.options import Library, Output, Roots, Samples, Seed, Targets
from mrm_mtlx.system.process_limits import TIME_LIMIT_S
from mrm_mtlx.system.text import printable
from mrm_mtlx.validation.results import Stage, Status

if TYPE_CHECKING:
    from rich.console import Console

    from mrm_mtlx.validation.results import DocumentResult, TargetResult, ValidationResult


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(validate)


def validate(
    paths: Annotated[list[Path], typer.Argument(metavar="PATH...", help="Documents, or folders of documents.")],
    target: Targets = None,
    report_format: Annotated[Format, typer.Option("--format", help="Form of the report.")] = Format.TEXT,
    output: Output = None,
    select: Annotated[
        list[str] | None,
        typer.Option("--select", metavar="CODE", help="Only findings whose code starts so; repeatable."),
    ] = None,
    ignore: Annotated[
        list[str] | None, typer.Option("--ignore", metavar="CODE", help="No findings whose code starts so; repeatable.")
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Warnings and skips count as failures.")] = False,
    samples: Samples = 16384,
    seed: Seed = 0,
    jobs: Annotated[int, typer.Option("-j", "--jobs", min=0, help="Processes; 0 is one per processor.")] = 0,
    retro_sweep: Annotated[
        bool,
        typer.Option(
            "--retro-sweep", help="Also switch the flag on in each specular node, one at a time, and compare again."
        ),
    ] = False,
    timeout: Annotated[
        float,
        typer.Option("--timeout", min=0.1, help="Seconds for reading a document, and for each surface on each target."),
    ] = TIME_LIMIT_S,
    library: Library = Implementation.MRM,
    root: Roots = None,
) -> None:
    """Read, check, generate, compile, run and compare documents with the reference."""
    from mrm_mtlx.cli.console import progress
    from mrm_mtlx.cli.options import chosen_targets, write_report
    from mrm_mtlx.library import Origin
    from mrm_mtlx.shadergen import available_targets
    from mrm_mtlx.validation import reports
    from mrm_mtlx.validation.options import ValidationOptions
    from mrm_mtlx.validation.runner import validate

    options = ValidationOptions(
        targets=chosen_targets(target, available_targets()),
        samples=samples,
        seed=seed,
        origin=Origin(library.value),
        jobs=jobs,
        timeout_s=timeout,
        retro_sweep=retro_sweep,
        roots=tuple(root or ()),
        select=_codes(select, "--select"),
        ignore=_codes(ignore, "--ignore"),
    )
    with progress("checking") as report:
        result = validate(paths, options, report)
    if report_format is Format.TEXT:
        _print_text(result, output, strict=strict)
    else:
        form = {Format.JSON: reports.to_json, Format.JUNIT: reports.to_junit, Format.GITHUB: reports.to_github}
        write_report(form[report_format](result), output)
        typer.echo(reports.verdict(result, strict=strict), err=True)
    raise typer.Exit(reports.exit_status(result, strict=strict))


def _codes(codes: list[str] | None, option: str) -> tuple[str, ...]:
    from mrm_mtlx.findings.catalogue import rules_from

    for code in codes or ():
        if not rules_from(code):
            raise typer.BadParameter(f"no rule starts with '{code}'; `mrm rules` lists them", param_hint=option)
    return tuple(codes or ())


def _print_text(result: ValidationResult, output: Path | None, *, strict: bool) -> None:
    from mrm_mtlx.cli.console import console
    from mrm_mtlx.cli.options import write_report
    from mrm_mtlx.validation import reports

    stream = None if output is None else io.StringIO()
    screen = console(stream)
    for document in result.documents:
        _print_document(screen, document)
    if any(r.median_error is not None for _, r in result.results()):
        screen.print("Figures are median relative errors; every sample is held to its own tolerance.", style="dim")
    verdict = reports.verdict(result, strict=strict)
    screen.print(verdict, markup=False, style="bold")
    if stream is not None:
        write_report(stream.getvalue().rstrip(), output)
        typer.echo(verdict, err=True)


def _print_document(screen: Console, document: DocumentResult) -> None:
    from rich.table import Table
    from rich.text import Text

    screen.print(printable(document.path), style="bold", markup=False)
    colours = {"error": "red", "warning": "yellow"}
    for found in document.findings:
        line = found.source.within(document.path) if found.source else ""
        place = f" {found.code} {printable(found.location)}".rstrip()
        severity = (found.severity.value, colours[found.severity.value])
        screen.print(Text.assemble("  ", printable(f"{line} ").lstrip(), severity, place))
        screen.print(f"      {printable(found.message)}", markup=False)
        screen.print(f"      {printable(found.hint)}", markup=False, style="dim")
    if document.renderables:
        table = Table(box=None, pad_edge=False, padding=(0, 3, 0, 0), header_style="dim")
        table.add_column("  surface", no_wrap=True)
        targets = list(document.renderables[0].targets)
        for target in targets:
            table.add_column(target, no_wrap=True)
        for renderable in document.renderables:
            cells = [_cell(renderable.targets[target]) if target in renderable.targets else "" for target in targets]
            table.add_row(Text(f"  {printable(renderable.name)}"), *cells)
        screen.print(table)
    screen.print()


def _cell(result: TargetResult) -> str:
    if result.status is Status.FAIL:
        return f"[red]FAIL {result.stage}[/red]"
    if result.status is Status.SKIP:
        return "[dim]-[/dim]" if result.stage is Stage.GENERATE else f"[dim]- {_SHORT[result.stage]}[/dim]"
    if result.median_error is not None:
        return f"[green]ok[/green] {result.median_error:.1e}"
    return f"[green]ok[/green] {_SHORT[result.stage]}"


_SHORT = {
    Stage.COMPILE: "compiled",
    Stage.COMPARE: "compared",
    Stage.GENERATE: "generated",
    Stage.READ: "not run",
}
