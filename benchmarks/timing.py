"""How a benchmark takes times, and how it prints and keeps its table."""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

REPOSITORY = Path(__file__).parents[1]
REPEATS = 5


@dataclass(frozen=True)
class Table:
    """Figures of a subject.

    Attributes
    ----------
    columns : tuple of str
        Heads of the columns, the first of which names the rows.
    rows : iterable of tuple of str
        Cells, printed as they come.
    packages : tuple of str
        Distributions whose versions the figures depend on, besides Python.
    """

    columns: tuple[str, ...]
    rows: Iterable[tuple[str, ...]]
    packages: tuple[str, ...] = field(default=("numpy",))


def best_time(
    function: Callable[[], object], repeats: int | None = None, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Shortest of several times (REPEATS, or `repeats`) in seconds, by the wall's clock or another."""
    times = []
    for _ in range(repeats or REPEATS):
        start = clock()
        function()
        times.append(clock() - start)
    return min(times)


def per_second(count: int, functions: Iterable[Callable[[], object]]) -> tuple[str, ...]:
    """Millions of samples per second of each function, which does `count` at once."""
    return tuple(f"{count / best_time(function) / 1e6:.1f}" for function in functions)


def page(text: str, table: Table) -> Iterator[str]:
    """Lines of a subject's page: what is measured, on what, and the figures."""
    name, _, about = text.partition("\n\n")
    yield f"# {name.rstrip('.')}"
    yield ""
    if about:
        yield about.strip()
        yield ""
    yield machine(table.packages)
    yield ""
    yield f"| {' | '.join(table.columns)} |"
    yield f"|---|{'---:|' * (len(table.columns) - 1)}"
    for row in table.rows:
        yield f"| {' | '.join(row)} |"


def machine(packages: Iterable[str]) -> str:
    """The machine's class, what else it was doing, and the versions of what was measured."""
    versions = [f"Python {platform.python_version()}", *(f"{name} {metadata.version(name)}" for name in packages)]
    busy = f", {os.getloadavg()[0]:.1f} processes running at the start" if hasattr(os, "getloadavg") else ""
    return f"On {platform.system()} {platform.machine()} with {os.cpu_count()} processors{busy}; {', '.join(versions)}."


def run(text: str | None, measure: Callable[[], Table], module: str) -> None:
    """The command of a subject: print its page; with `--save`, keep it beside the module.

    Parameters
    ----------
    text : str
        The module's docstring: the title, then what there is to know.
    measure : callable
        Gives the table.
    module : str
        The module's file.
    """
    parser = argparse.ArgumentParser(description=(text or "").partition("\n")[0])
    kept = Path(module).with_suffix(".md")
    parser.add_argument("--save", action="store_true", help=f"also write the page to benchmarks/{kept.name}")
    save = parser.parse_args().save
    lines = []
    for line in page(text or "", measure()):
        print(line, flush=True)
        lines.append(line)
    if save:
        head = f"<!-- Made by: python -m benchmarks.{kept.stem} --save -->"
        kept.write_text("\n".join([head, *lines, ""]), encoding="utf-8")
        print(f"wrote benchmarks/{kept.name}", file=sys.stderr)
