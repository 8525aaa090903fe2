"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from mrm_mtlx.cli.choices import Implementation
from mrm_mtlx.system import child

Targets: TypeAlias = Annotated[
    list[str] | None, typer.Option("--target", metavar="NAME", help="Shading language; repeatable. Default: all.")
]


def _writable(output: Path | None) -> Path | None:
    """Refuse a report's file whose folder is not there, before the work is done in vain."""
    if output is not None:
        refuse_missing_folder(output)
    return output


def refuse_missing_folder(output: Path, option: str | None = None) -> None:
    """Refuse a file whose folder is not there; `option` is the one that names it, by default the callback's own.

    Raises
    ------
    typer.BadParameter
        If it is so.
    """
    if not output.parent.is_dir():
        message = f"{output} cannot be written: the folder {output.parent} does not exist"
        raise typer.BadParameter(message, param_hint=option)


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
        exists=True,
        file_okay=False,
        help="Files may be read from this folder too, and are looked for in it; repeatable. "
        "Default: only the folder that PATH is or lies in.",
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


def chosen_targets(names: list[str] | None, allowed: tuple[str, ...]) -> tuple[str, ...]:
    """The targets asked for, or all; unknown ones are a usage error.

    Raises
    ------
    typer.BadParameter
        If a target is not among the allowed.
    """
    unknown = [name for name in names or () if name not in allowed]
    if unknown:
        raise typer.BadParameter(f"{', '.join(unknown)}: expected one of {', '.join(allowed)}", param_hint="--target")
    return tuple(dict.fromkeys(names)) if names else allowed


def write_report(text: str, output: Path | None) -> None:
    """Print a report, or write it to a file.

    Raises
    ------
    typer.BadParameter
        If the file cannot be written.
    """
    if output is None:
        typer.echo(text)
    else:
        write_file(output, text + "\n")


def write_file(path: Path, text: str) -> None:
    """Write a text file whole or not at all.

    Raises
    ------
    typer.BadParameter
        If it cannot be written.
    """
    from mrm_mtlx.system.writing import replacing

    try:
        with replacing(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    except OSError as error:
        raise typer.BadParameter(f"{path} cannot be written: {error.strerror}", param_hint="--output") from error
