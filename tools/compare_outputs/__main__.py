"""`python -m tools.compare_outputs OLD NEW`: whether two checkouts of the project give the same output.

Runs the commands of both on copies of the old one's documents, and compares what they print, write and exit with.
Prints a line per subject and the first differences; the exit status is 1 if there are any.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from tools.compare_outputs.comparison import Comparison, records
from tools.compare_outputs.outputs import Checkout, Outputs
from tools.compare_outputs.subjects import DOCUMENTS, SUBJECTS, Run

if TYPE_CHECKING:
    from collections.abc import Sequence

# Differences that are printed at most.
_DIFFERENCES = 8


def main(arguments: Sequence[str]) -> int:
    """Run the command; 0 if all outputs are equal, 1 if not."""
    options = _parser().parse_args(arguments)
    checkouts = [Checkout(options.old.resolve(), []), Checkout(options.new.resolve(), options.argument)]
    for checkout in checkouts:
        checkout.check()
    total = Comparison()
    with tempfile.TemporaryDirectory(prefix="mrm-outputs-") as scratch:
        kept = (options.keep or Path(scratch)).resolve()
        folders = _copies(options.old, options.documents, kept / "documents")
        both = [
            Outputs(checkout, kept / "documents", folder)
            for checkout, folder in zip(checkouts, (kept / "old", Path(scratch) / "new"), strict=True)
        ]
        for name, runs in _chosen(folders, kept / "documents", tuple(options.only or [""])).items():
            seconds = [_all(outputs, runs, options.jobs) for outputs in both]
            compared = Comparison()
            for run in runs:
                compared.add(*(records(outputs.files(run), options.allow) for outputs in both))
            print(f"{name:12} {compared}  ({' and '.join(f'{each:.0f} s' for each in seconds)})", flush=True)
            total.extend(compared)
    for difference in total.differences[:_DIFFERENCES]:
        print(f"\n{difference}")
    print(f"\n{'FAILED' if total.failed else 'PASSED'}       {total}")
    return int(total.failed)


def _chosen(folders: Sequence[str], documents: Path, names: tuple[str, ...]) -> dict[str, list[Run]]:
    """The runs whose names begin with one of some names, by subject."""
    runs = {
        name: [Run(f"{name}/{run.name}", run.steps) for run in subject(folders, documents)]
        for name, subject in SUBJECTS.items()
    }
    chosen = {name: [run for run in some if run.name.startswith(names)] for name, some in runs.items()}
    return {name: some for name, some in chosen.items() if some}


def _copies(old: Path, extra: Sequence[Path], place: Path) -> list[str]:
    """Names of the folders of documents, whose copies are made unless they are there."""
    sources = {**{name: old / name for name in DOCUMENTS}, **{path.resolve().name: path for path in extra}}
    for name, source in sources.items():
        if not source.is_dir():
            print(f"no folder {source}", file=sys.stderr)
        elif not (place / name).is_dir():
            shutil.copytree(source, place / name, symlinks=True)
    return [name for name, source in sources.items() if source.is_dir()]


def _all(outputs: Outputs, runs: Sequence[Run], jobs: int) -> float:
    """Do runs, some at a time; the seconds that it took."""
    began = time.perf_counter()
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(outputs.add, runs))
    return time.perf_counter() - began


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.compare_outputs", description="Compare two checkouts' output."
    )
    parser.add_argument("old", type=Path, help="checkout whose output is right, and whose documents are used")
    parser.add_argument("new", type=Path, help="checkout to compare with it")
    parser.add_argument("--only", action="append", metavar="NAME", help="subject, or the beginning of a run's name")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keeps the old output: the next call has it at once")
    parser.add_argument("--documents", type=Path, action="append", default=[], metavar="DIR", help="more documents")
    parser.add_argument(
        "--allow", action="append", default=[], metavar="SECTION.KEY", help="entry of a report to ignore"
    )
    parser.add_argument(
        "--argument", type=_change, action="append", default=[], metavar="COMMAND:OLD=NEW",
        help="what the new checkout calls an argument; an empty OLD adds one",
    )  # fmt: skip
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count() or 1, help="commands at a time")
    return parser


def _change(text: str) -> tuple[str, str, str]:
    match = re.fullmatch(r"(\w+):([^=]*)=(.*)", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"not COMMAND:OLD=NEW: {text}")
    return match[1], match[2], match[3]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
