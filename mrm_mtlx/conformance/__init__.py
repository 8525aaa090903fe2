"""The node library against the oracle, on every engine that runs here."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from mrm_mtlx.conformance import hardware, osl
from mrm_mtlx.conformance.cases import NODES, Case, cases
from mrm_mtlx.conformance.new_nodes import NewCase, new_cases
from mrm_mtlx.conformance.results import SCHEMA, Approximation, CaseResult
from mrm_mtlx.engines import registry
from mrm_mtlx.shadergen import TARGETS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from mrm_mtlx.library import Origin

__all__ = ["NODES", "SCHEMA", "Approximation", "Case", "CaseResult", "NewCase", "cases", "new_cases", "run", "targets"]


def targets() -> tuple[str, ...]:
    """Names of the targets that an engine runs, in the order of `shadergen.TARGETS`, then OSL."""
    return (*_drawn(), *([osl.TARGET] if osl.TARGET in registry.targets(registry.measures_closures) else []))


def _drawn() -> tuple[str, ...]:
    """Targets of which an engine gives colours at points."""
    running = registry.targets(registry.runs)
    return tuple(name for name in TARGETS if name in running)


def run(
    chosen_targets: Sequence[str],
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
        If a target is not one of `targets`.
    """
    unknown = sorted(set(chosen_targets) - set(targets()))
    if unknown:
        msg = f"conformance runs on {', '.join(targets())}, not on {', '.join(unknown)}"
        raise ValueError(msg)
    todo = list(chosen or [*cases(), *(new_cases() if origin == "mrm" else [])])
    drawn = [target for target in _drawn() if target in chosen_targets]
    steps: list[Callable[[], Iterator[CaseResult]]] = []
    if drawn:
        steps += [partial(hardware.run_case, case, drawn, samples, seed, origin) for case in todo]
    if osl.TARGET in chosen_targets:
        steps += osl.steps(todo, samples, seed, origin)
    for count, step in enumerate(steps, start=1):
        yield from step()
        if progress:
            progress(count, len(steps))
