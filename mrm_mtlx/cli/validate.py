"""`mrm validate`: documents go in, verdicts come out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli import errors
from mrm_mtlx.cli.choices import Implementation, ReportFormat
from mrm_mtlx.cli.options import Exclude, Library, Output, Roots, Samples, Seed, Targets
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from mrm_mtlx.validation.screen import ValidationReport


def register(app: typer.Typer) -> None:
    """Add the command."""
    errors.register(app, validate)


def validate(
    paths: Annotated[list[Path], typer.Argument(metavar="PATH", help="Documents, or folders of documents.")],
    target: Targets = None,
    report_format: Annotated[ReportFormat, typer.Option("--format", help="Form of the report.")] = ReportFormat.TEXT,
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
    exclude: Exclude = None,
) -> None:
    """Read, check, generate, compile, run and compare documents with the reference."""
    import mrm_mtlx as mrm
    from mrm_mtlx.cli.console import terminal

    with terminal("checking") as listener:
        result = mrm.validate(
            paths,
            target=target or (),
            select=select or (),
            ignore=ignore or (),
            strict=strict,
            samples=samples,
            seed=seed,
            jobs=jobs,
            retro_sweep=retro_sweep,
            timeout=timeout,
            library=library.value,
            root=root or (),
            exclude=exclude or (),
            listener=listener,
        )
    _print(result, report_format, output)
    raise typer.Exit(result.exit_status)


def _print(result: ValidationReport, form: ReportFormat, output: Path | None) -> None:
    """The report to stdout or a file; the verdict to stderr, unless it is in what stdout has."""
    from mrm_mtlx.cli.options import write_report
    from mrm_mtlx.validation import reports, screen

    if form is ReportFormat.TEXT and output is None:
        screen.print_result(screen.console(), result)
        return
    forms = {
        ReportFormat.TEXT: screen.text, ReportFormat.JSON: reports.to_json,
        ReportFormat.JUNIT: reports.to_junit, ReportFormat.GITHUB: reports.to_github,
    }  # fmt: skip
    write_report(forms[form](result), output)
    typer.echo(result.verdict(), err=True)
