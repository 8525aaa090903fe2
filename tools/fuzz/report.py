"""Counts of a run, as a table."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tools.fuzz.target import Outcome

if TYPE_CHECKING:
    from tools.fuzz.run import Result


@dataclass
class Counts:
    """What came of the mutants of one kind."""

    outcomes: Counter[Outcome] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)
    memory: int = 0
    notable: list[Result] = field(default_factory=list)

    def add(self, result: Result) -> None:
        """Count one more."""
        self.outcomes[result.verdict.outcome] += 1
        self.codes.update(result.verdict.codes)
        self.memory = max(self.memory, result.memory)
        if result.verdict.outcome not in (Outcome.CLEAN, Outcome.FINDINGS):
            self.notable.append(result)

    @property
    def failures(self) -> list[Result]:
        """Those that are failures."""
        return [result for result in self.notable if result.verdict.outcome.failed]


def table(counts: dict[str, Counts], seconds: dict[str, float]) -> str:
    """A table in Markdown: a row per kind."""
    rows = [
        ["kind", "mutants", *(str(outcome) for outcome in Outcome), "largest process", "per second"],
        *(_row(kind, found, seconds[kind]) for kind, found in counts.items()),
    ]
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|---" * len(rows[0]) + "|", *lines[1:]])


def _row(kind: str, found: Counts, seconds: float) -> list[str]:
    total = sum(found.outcomes.values())
    outcomes = [f"{found.outcomes[outcome]:,}" for outcome in Outcome]
    return [kind, f"{total:,}", *outcomes, f"{found.memory / 2**20:.0f} MiB", f"{total / max(seconds, 1e-9):.0f}"]


def findings(counts: dict[str, Counts]) -> str:
    """How many mutants had a finding of each rule."""
    codes: Counter[str] = Counter()
    for found in counts.values():
        codes.update(found.codes)
    return ", ".join(f"{code} {number:,}" for code, number in sorted(codes.items()))


def notable(counts: dict[str, Counts]) -> str:
    """A line per time-out, death, end of memory and failure; those of one detail together."""
    grouped: dict[tuple[str, str], list[Result]] = {}
    for found in counts.values():
        for result in found.notable:
            grouped.setdefault((result.verdict.outcome, result.verdict.detail), []).append(result)
    ordered = sorted(grouped.items(), key=lambda item: -len(item[1]))
    return "\n".join(
        f"{len(results):5}  {outcome}: {' '.join(detail.split())[:240]}  [{', '.join(str(r.key) for r in results[:3])}]"
        for (outcome, detail), results in ordered
    )
