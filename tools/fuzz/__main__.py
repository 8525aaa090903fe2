"""`python -m tools.fuzz`: runs mutants, prints a table, keeps what failed."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tools.fuzz import corpus
from tools.fuzz.kinds import KINDS
from tools.fuzz.mutants import Key, Maker
from tools.fuzz.report import Counts, findings, notable, table
from tools.fuzz.run import TIME_LIMIT_S, Settings, run

# The long run: half of all mutants are documents.
LONG = {"mtlx": 25_000, "usd": 10_000, "gltf": 8_000, "data": 3_500, "image": 3_500}


def main(arguments: list[str]) -> int:
    """Run the command; 0 if nothing failed, 1 if something did."""
    options = _parser().parse_args(arguments)
    if options.replay:
        return _replay(options.kind[0], options.replay, options.output)
    kinds = options.kind or list(KINDS)
    counts: dict[str, Counts] = {}
    seconds: dict[str, float] = {}
    for kind in kinds:
        total = LONG[kind] if options.count is None else options.count
        keys = [Key(kind, options.seed, number) for number in range(options.start, options.start + total)]
        began = time.perf_counter()
        counts[kind] = Counts()
        for number, result in enumerate(run(keys, Settings(options.jobs, options.time_limit)), start=1):
            counts[kind].add(result)
            if number % 500 == 0:
                print(f"{kind}: {number} of {total}, {len(counts[kind].notable)} notable", file=sys.stderr, flush=True)
        seconds[kind] = time.perf_counter() - began
        _keep(counts[kind], options.output)
    print(table(counts, seconds), findings(counts), notable(counts), sep="\n\n")
    failures = [result for found in counts.values() for result in found.failures]
    print(f"\n{'FAILED' if failures else 'PASSED'}  {len(failures)} failures")
    return 1 if failures else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.fuzz", description="Mutants against everything that opens them."
    )
    parser.add_argument("--kind", action="append", choices=list(KINDS), help="repeatable; default: all")
    parser.add_argument("--count", type=int, help="mutants of each kind; default: the long run of 50,000")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=int, default=0, help="number of the first mutant")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="worker processes")
    parser.add_argument("--time-limit", type=float, default=TIME_LIMIT_S, help="seconds per mutant")
    parser.add_argument("--output", "-o", type=Path, default=Path("fuzz-failures"), help="folder for what failed")
    parser.add_argument("--replay", metavar="SEED:NUMBER", help="only write one mutant of --kind into the folder")
    return parser


def _keep(counts: Counts, folder: Path) -> None:
    """Write the mutants that ended badly, each with what came of it."""
    if not counts.notable:
        return
    with tempfile.TemporaryDirectory(prefix="mrm-fuzz-") as name:
        maker = _maker(Path(name), counts.notable[0].key.kind)
        for result in counts.notable:
            path = _write(maker, result.key, folder)
            path.with_suffix(".txt").write_text(
                f"{result.verdict.outcome}: {result.verdict.detail}\n", encoding="utf-8"
            )


def _replay(kind: str, key: str, folder: Path) -> int:
    seed, number = key.split(":")
    with tempfile.TemporaryDirectory(prefix="mrm-fuzz-") as name:
        print(_write(_maker(Path(name), kind), Key(kind, int(seed), int(number)), folder))
    return 0


def _maker(folder: Path, kind: str) -> Maker:
    corpus.build(folder, frozenset([kind]))
    return Maker(folder)


def _write(maker: Maker, key: Key, folder: Path) -> Path:
    mutant = maker.make(key)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{key}{mutant.suffix}"
    path.write_bytes(mutant.content)
    return path


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
