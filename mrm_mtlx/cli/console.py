"""What the commands share of terminal output: progress on stderr, tables on stdout."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import TextIO

    from rich.console import Console

# Width of tables where the output is not a terminal: wide enough that nothing wraps.
_WIDE = 200


def console(stream: TextIO | None = None) -> Console:
    """A console on stdout or a stream; colours and the width of a terminal only on one, NO_COLOR honoured."""
    from rich.console import Console

    target = stream or sys.stdout
    return Console(file=target, highlight=False, soft_wrap=True, width=None if target.isatty() else _WIDE)


@contextmanager
def progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr while it is a terminal, else nothing; yields a function of (finished, all).

    What has progressed has its time limit again, see `system.child`.
    """
    from mrm_mtlx.system.child import renew

    if not sys.stderr.isatty():
        yield lambda _finished, _total: renew()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)

        def report(finished: int, total: int) -> None:
            renew()
            bar.update(task, completed=finished, total=total)

        yield report
