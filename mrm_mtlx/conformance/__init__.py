"""The node library against the oracle, on every engine that runs here."""

from __future__ import annotations

from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING

from mrm_mtlx.conformance import hardware, osl, portable
from mrm_mtlx.conformance.cases import NODES, Case, cases
from mrm_mtlx.conformance.new_nodes import NewCase, new_cases
from mrm_mtlx.conformance.results import SCHEMA, Approximation, CaseResult
from mrm_mtlx.engines import registry
from mrm_mtlx.shadergen import HOST_TARGETS, TARGETS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from mrm_mtlx.engines.base import Engine
    from mrm_mtlx.library import Origin

__all__ = [
    "NODES", "SCHEMA", "Approximation", "Case", "CaseResult", "Form", "NewCase",
    "all_targets", "cases", "new_cases", "run", "run_portable", "targets",
]  # fmt: skip


class Form(StrEnum):
    """In which form a lobe is compared: by the node library's sources, or in nodes of the standard library alone."""

    LIBRARY = "library"
    PORTABLE = "portable"


def targets(form: Form = Form.LIBRARY) -> tuple[str, ...]:
    """Names of the targets that an engine runs, in the order of `shadergen.TARGETS`, then those of closures.

    The portable form is measured where colours are drawn.
    """
    return (*_served(registry.runs), *(_served(registry.measures_closures) if form is Form.LIBRARY else ()))


def all_targets(form: Form = Form.LIBRARY) -> tuple[str, ...]:
    """Those, and the hosts that generate their shaders themselves and that an engine runs."""
    return (*targets(form), *(_served(registry.runs, HOST_TARGETS) if form is Form.LIBRARY else ()))


def _served(fit: Callable[[Engine], bool], names: Iterable[str] = TARGETS) -> tuple[str, ...]:
    """Targets of the engines that fit."""
    fitting = registry.targets(fit)
    return tuple(name for name in names if name in fitting)


def run(
    chosen_targets: Sequence[str],
    samples: int,
    seed: int,
    origin: Origin,
    progress: Callable[[int, int], None] | None = None,
    chosen: Sequence[Case] | None = None,
) -> Iterator[CaseResult]:
    """Compare every case on every target; results in the order of the cases, those of closures last.

    MaterialX's own library has no implementation of the new nodes, so their cases are not among its.

    Raises
    ------
    ValueError
        If a target is not one of `all_targets`.
    """
    _check(chosen_targets, Form.LIBRARY)
    todo = list(chosen or [*cases(), *(new_cases() if origin == "mrm" else [])])
    drawn = [target for target in _served(registry.runs, (*TARGETS, *HOST_TARGETS)) if target in chosen_targets]
    steps: list[Callable[[], Iterator[CaseResult]]] = []
    if drawn:
        steps += [partial(hardware.run_case, case, drawn, samples, seed, origin) for case in todo]
    for target in _served(registry.measures_closures):
        steps += osl.steps(target, todo, samples, seed, origin) if target in chosen_targets else []
    yield from _results(steps, progress)


def run_portable(
    chosen_targets: Sequence[str], samples: int, seed: int, progress: Callable[[int, int], None] | None = None
) -> Iterator[CaseResult]:
    """Compare the portable form on every target; results in the order of the cases.

    Raises
    ------
    ValueError
        If a target is not one of `all_targets`.
    """
    _check(chosen_targets, Form.PORTABLE)
    drawn = [target for target in _served(registry.runs) if target in chosen_targets]
    yield from _results(portable.steps(drawn, samples, seed), progress)


def _check(chosen_targets: Sequence[str], form: Form) -> None:
    known = all_targets(form)
    unknown = sorted(set(chosen_targets) - set(known))
    if unknown:
        msg = f"conformance runs on {', '.join(known)}, not on {', '.join(unknown)}"
        raise ValueError(msg)


def _results(
    steps: Sequence[Callable[[], Iterator[CaseResult]]], progress: Callable[[int, int], None] | None
) -> Iterator[CaseResult]:
    for count, step in enumerate(steps, start=1):
        yield from step()
        if progress:
            progress(count, len(steps))
