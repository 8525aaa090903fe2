"""The node library against the oracle, on every engine that runs here."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from mrm_mtlx.conformance import hardware, osl
from mrm_mtlx.conformance.cases import NODES, Case, cases
from mrm_mtlx.conformance.new_nodes import NewCase, new_cases
from mrm_mtlx.conformance.results import SCHEMA, Approximation, CaseResult

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from mrm_mtlx.library import Origin

__all__ = ["NODES", "SCHEMA", "TARGETS", "Approximation", "Case", "CaseResult", "NewCase", "cases", "new_cases", "run"]

TARGETS = (*hardware.TARGETS, osl.TARGET)


def run(
    targets: Sequence[str],
    samples: int,
    seed: int,
    origin: Origin,
    progress: Callable[[int, int], None] | None = None,
    chosen: Sequence[Case] | None = None,
) -> Iterator[CaseResult]:
    """Compare every case on every target; results in the order of the cases, those of OSL last.

    MaterialX's own library has no implementation of the new nodes, so their cases are not among its.

    Raises
    ------
    ValueError
        If a target is not one that runs here by design (`TARGETS`).
    """
    unknown = sorted(set(targets) - set(TARGETS))
    if unknown:
        msg = f"conformance runs on {', '.join(TARGETS)}, not on {', '.join(unknown)}"
        raise ValueError(msg)
    todo = list(chosen or [*cases(), *(new_cases() if origin == "mrm" else [])])
    drawn = [target for target in hardware.TARGETS if target in targets]
    steps: list[Callable[[], Iterator[CaseResult]]] = []
    if drawn:
        steps += [partial(hardware.run_case, case, drawn, samples, seed, origin) for case in todo]
    if osl.TARGET in targets:
        steps += osl.steps(todo, samples, seed, origin)
    for count, step in enumerate(steps, start=1):
        yield from step()
        if progress:
            progress(count, len(steps))
