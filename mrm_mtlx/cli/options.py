"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from mrm_mtlx.cli.choices import Implementation
from mrm_mtlx.system import child
from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.writing import check_folder, write_text

Targets: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--target", metavar="NAME", help="Shading language, or the host storm; repeatable. Default: all languages."
    ),
]


def _writable(output: Path | None) -> Path | None:
    """Refuse a report's file whose folder is not there, before the work is done in vain."""
    if output is not None:
        try:
            check_folder(output)
        except ArgumentError as error:
            raise typer.BadParameter(error.message) from error
    return output


Output: TypeAlias = Annotated[
    Path | None,
    typer.Option("--output", "-o", callback=_writable, help="Write the report to this file instead of stdout."),
]
Samples: TypeAlias = Annotated[int, typer.Option("--samples", min=16, max=1 << 22, help="Samples per comparison.")]
Seed: TypeAlias = Annotated[int, typer.Option("--seed", min=0, help="Seed of all random numbers.")]
Roots: TypeAlias = Annotated[
    list[Path] | None,
    typer.Option(
        "--root",
        metavar="DIR",
        help="Files may be read from this folder too, and are looked for in it; repeatable. "
        "Default: only the folder that PATH is or lies in.",
    ),
]


Exclude: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--exclude",
        metavar="PATTERN",
        help="Files and folders that are passed over where a folder is searched, such as 'old_*'; repeatable.",
    ),
]


def _limited(seconds: float) -> float:
    """Hand the limit on to where documents are opened."""
    child.limit(seconds)
    return seconds


Timeout: TypeAlias = Annotated[
    float,
    typer.Option("--timeout", min=0.1, callback=_limited, help="Seconds that the document may take."),
]
Library: TypeAlias = Annotated[
    Implementation, typer.Option("--library", help="Whose implementation of the flag: this project's or MaterialX's.")
]


def write_report(text: str, output: Path | None) -> None:
    """Print a report, or write it to a file.

    Raises
    ------
    ArgumentError
        If the file cannot be written.
    """
    if output is None:
        typer.echo(text)
    else:
        write_text(output, text + "\n")
