"""The cases in the OpenGL engine: generated GLSL and ESSL against the oracle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.conformance.new_nodes import document_of, expected, points_of
from mrm_mtlx.conformance.oracle import Oracle
from mrm_mtlx.conformance.results import CaseResult
from mrm_mtlx.engines import gl
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.comparison import compare, draw

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from mrm_mtlx.conformance.cases import Case

TARGETS = ("glsl", "essl")


def run_case(case: Case, targets: Sequence[str], samples: int, seed: int, origin: Origin) -> Iterator[CaseResult]:
    """Results of a case, one per target; the oracle is evaluated once."""
    available = gl.availability()
    if not available.available:
        reason = available.reason
        yield from (CaseResult(case, target, "gl", None, reason) for target in targets)
        return
    library = load_library(origin)
    document = document_of(case, library.document)
    element = renderable_elements(document)[0]
    points = points_of(case, samples, sampling.generator(seed, case.name))
    with Oracle(Surface(element), points) as oracle:
        found = {}
        for target in targets:
            with gl.SurfaceProgram(generate(element, target, library)) as program:
                found[target] = draw(program, points)
        tolerance = expected(case, points, oracle.tolerance(), library.document)
    for target in targets:
        yield CaseResult(case, target, "gl", compare(found[target], tolerance, points), None)
