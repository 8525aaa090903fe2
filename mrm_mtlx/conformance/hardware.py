"""The cases in the engines that give colours at points: generated code of the GLSL family against the oracle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.conformance.new_nodes import document_of, expected, points_of
from mrm_mtlx.conformance.oracle import Oracle
from mrm_mtlx.conformance.results import CaseResult
from mrm_mtlx.engines import registry
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.shadergen.precision import with_highp
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import compare, draw

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from mrm_mtlx.conformance.cases import Case
    from mrm_mtlx.engines.base import Engine
    from mrm_mtlx.validation.comparison.samples import Comparison


def run_case(case: Case, targets: Sequence[str], samples: int, seed: int, origin: Origin) -> Iterator[CaseResult]:
    """Results of a case, one per target; the oracle is evaluated once."""
    engines = {target: engine_of(target) for target in targets}
    states = {target: engine.availability() for target, engine in engines.items()}
    working = {target: engine for target, engine in engines.items() if states[target].available}
    compared = _compare(case, working, samples, seed, origin) if working else {}
    for target, engine in engines.items():
        reason = None if target in working else states[target].reason
        yield CaseResult(case, target, engine.name, compared.get(target), reason)


def engine_of(target: str) -> Engine:
    """The engine that runs a target."""
    engine = registry.engine_for(target, registry.runs)
    if engine is None:
        msg = f"no engine runs {target}"
        raise ValueError(msg)
    return engine


def _compare(
    case: Case, engines: Mapping[str, Engine], samples: int, seed: int, origin: Origin
) -> dict[str, Comparison]:
    """The comparison of a case on each target, in its engine."""
    library = load_library(origin)
    document = document_of(case, library.document)
    element = renderable_elements(document)[0]
    points = points_of(case, samples, sampling.generator(seed, case.name))
    surface = Surface(element)
    with Oracle(surface, points) as oracle:
        found = {}
        for target, engine in engines.items():
            # What is asked here is whether the functions are right, not what a driver makes of ESSL's precision.
            with engine.compile(with_highp(generate(element, target, library))) as program:
                found[target] = draw(program, points)
        as_asked = expected(case, points, oracle.tolerance(), library.document)
    compared = {}
    for target, drawing in found.items():
        tolerance = as_asked
        if drawing.points is not points:
            placed = Surface(element, version=drawing.capabilities.materialx)
            with Oracle(placed, drawing.points) as oracle:
                tolerance = expected(case, drawing.points, oracle.tolerance(), library.document)
        compared[target] = compare(drawing.colors, drawing.allowed(tolerance), drawing.points)
    return compared
