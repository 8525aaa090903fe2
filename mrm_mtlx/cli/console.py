"""Terminal output that the commands share: findings and progress on stderr."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from mrm_mtlx.api.listener import Listener
from mrm_mtlx.cli import errors
from mrm_mtlx.system import child
from mrm_mtlx.system.text import printable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from mrm_mtlx.api.errors import MrmError
    from mrm_mtlx.findings.finding import Finding


class Terminal(Listener):
    """Prints what a call tells to stderr; what has progressed has its time limit again, see `system.child`."""

    def __init__(self, bar: Callable[[int, int], None] | None = None) -> None:
        self._bar = bar

    def findings(self, found: Sequence[Finding]) -> None:
        """Print findings with their remedies."""
        for one in found:
            typer.echo(printable(str(one)), err=True)
            typer.echo(printable(f"    {one.hint}"), err=True)

    def image_findings(self, found: Sequence[Finding]) -> None:
        """Print findings alone."""
        for one in found:
            typer.echo(printable(str(one)), err=True)

    def not_measured(self, path: str, error: MrmError) -> None:
        """Print which document is left out, and why."""
        errors.tell(error)
        typer.echo(f"mrm: {printable(path)} is not measured", err=True)

    def progress(self, finished: int, total: int) -> None:
        """Advance the bar, if there is one."""
        child.renew()
        if self._bar is not None:
            self._bar(finished, total)

    def wrote(self, path: Path, what: str = "") -> None:
        """Print which file was written."""
        typer.echo(f"wrote {path}" if not what else printable(f"wrote {path} ({what})"), err=True)


@contextmanager
def terminal(what: str) -> Iterator[Terminal]:
    """A listener with a progress bar on stderr while that is a terminal, else without."""
    if not sys.stderr.isatty():
        yield Terminal()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield Terminal(lambda finished, total: bar.update(task, completed=finished, total=total))


@contextmanager
def progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A function of (finished, all) that draws a progress bar on stderr while that is a terminal."""
    with terminal(what) as listener:
        yield listener.progress
