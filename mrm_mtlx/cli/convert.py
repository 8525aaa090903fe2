"""`mrm convert`: a document in another format, and a file of another format as a document."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mrm_mtlx.cli.options import Roots, Timeout, refuse_missing_folder
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from mrm_mtlx.cli.openmaterial import Options
    from mrm_mtlx.findings.finding import Finding


class FormatName(StrEnum):
    """Formats that a file of any ending may have."""

    OPENMATERIAL = "openmaterial"


# The ending of OpenMATERIAL's files; the other formats are in the table of `formats.registry`.
OPENMATERIAL_SUFFIX = ".json"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(convert)


def convert(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="A document, or a file of another format.")],
    written: Annotated[
        Path | None, typer.Argument(metavar="OUTPUT", help="What to write; its ending names the format.")
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="The same as OUTPUT.")] = None,
    to: Annotated[FormatName | None, typer.Option("--to", help="The format, whatever the ending.")] = None,
    into: Annotated[
        Path | None, typer.Option("--into", metavar="FILE", help="An OpenMATERIAL file whose other data are kept.")
    ] = None,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="POINTER", help="Object of --into for a new block, as /parent. Default: the top."),
    ] = None,
    compare: Annotated[
        Path | None,
        typer.Option("--compare", metavar="FILE", help="Write nothing; compare with this OpenMATERIAL file."),
    ] = None,
    observation: Annotated[
        float | None, typer.Option("--observation", metavar="DEG", help="Observation angle of R_A. Default: 0.2.")
    ] = None,
    entrance: Annotated[
        float | None, typer.Option("--entrance", metavar="DEG", help="Entrance angle of R_A. Default: -4.")
    ] = None,
    element: Annotated[
        str | None, typer.Option("--element", metavar="NAME", help="Element whose R_A it is; default: the first.")
    ] = None,
    root: Roots = None,
    force: Annotated[
        bool, typer.Option("--force", help="Also replace files beside OUTPUT that are there with other content.")
    ] = False,
    timeout: Timeout = TIME_LIMIT_S,
) -> None:
    """Write a document as USD or glTF, read one from these, or write its R_A as OpenMATERIAL 3D has it."""
    del timeout  # its option has handed it on
    from mrm_mtlx.cli import openmaterial

    if written is not None and output is not None:
        raise typer.BadParameter(f"{written} is to be written already", param_hint="--output")
    output = written or output
    options = openmaterial.Options(into, at, compare, observation, entrance, element)
    if compare is not None:
        of_writing = {"--output": output, "--to": to, "--into": into, "--at": at, "--force": force or None}
        for name, value in of_writing.items():
            if value is not None:
                raise typer.BadParameter("not with --compare, which writes nothing", param_hint=name)
        openmaterial.convert(path, None, options, root)
        return
    if output is None:
        raise typer.BadParameter("expected a file to write, or --compare", param_hint="OUTPUT")
    refuse_missing_folder(output, "OUTPUT")
    if to is FormatName.OPENMATERIAL or output.suffix.lower() == OPENMATERIAL_SUFFIX:
        if force:
            raise typer.BadParameter("this format has no files beside OUTPUT, which is replaced", param_hint="--force")
        openmaterial.convert(path, output, options, root)
    else:
        _refuse(options)
        _translate(path, output, root, force=force)


def _refuse(options: Options) -> None:
    """Options that are for OpenMATERIAL alone."""
    for name, value in options._asdict().items():
        if value is not None:
            raise typer.BadParameter(f"only for {OPENMATERIAL_SUFFIX}, OpenMATERIAL", param_hint=f"--{name}")


def _translate(path: Path, output: Path, roots: list[Path] | None, *, force: bool) -> None:
    """Read a file of one format, write one of another; what is lost goes to stderr."""
    from mrm_mtlx.cli.documents import open_document, print_findings
    from mrm_mtlx.documents.document import NothingToWriteError, ReadError
    from mrm_mtlx.findings.finding import Severity
    from mrm_mtlx.formats.registry import DOCUMENT, SUFFIXES, format_of
    from mrm_mtlx.library import load_library

    form, source = format_of(output), format_of(path) or DOCUMENT
    if form is None:
        expected = f"expected a name that ends in {', '.join((*SUFFIXES, OPENMATERIAL_SUFFIX))}, or --to"
        raise typer.BadParameter(f"{output}: {expected}", param_hint="OUTPUT")
    if output.exists() and path.exists() and output.samefile(path):
        raise typer.BadParameter(f"{output} is the file to be read", param_hint="OUTPUT")
    if form is source:
        raise typer.BadParameter(f"{path} is {form.name} already", param_hint="OUTPUT")
    library = load_library()
    opened = open_document(path, library, None, roots)

    def said(findings: list[Finding]) -> list[Finding]:
        found = [replace(found, location=opened.imported.source_location(found.location)) for found in findings]
        print_findings(found)
        return found

    try:
        findings = said(form.write(opened.imported, output, library, force=force))
    except ReadError as error:
        said([error.finding])
        raise typer.Exit(1) from error
    except NothingToWriteError as error:
        said(error.findings)
        typer.echo(f"mrm: {path}: {error}", err=True)
        raise typer.Exit(1) from error
    except ValueError as error:
        raise typer.BadParameter(f"{path}: {error}", param_hint="PATH") from error
    except OSError as error:
        message = f"{output} cannot be written: {error.strerror}"
        raise typer.BadParameter(message, param_hint="OUTPUT") from error
    typer.echo(f"wrote {output}", err=True)
    if any(found.severity is Severity.ERROR for found in findings):
        raise typer.Exit(1)
