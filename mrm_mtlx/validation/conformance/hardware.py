"""The cases in the OpenGL engine: generated GLSL and ESSL against the oracle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.engines import gl
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.reference import ShadingPoints, Surface, Tolerance
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.comparison import compare, draw
from mrm_mtlx.validation.conformance.cases import Case, case_document, case_points
from mrm_mtlx.validation.conformance.results import CaseResult

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from mrm_mtlx.bsdf.arrays import Array

TARGETS = ("glsl", "essl")

# Samples per draw: bounds the memory of the oracle's temporaries, whatever the number asked for.
_BATCH = 1 << 16


def run_case(case: Case, targets: Sequence[str], samples: int, seed: int, origin: Origin) -> Iterator[CaseResult]:
    """Results of a case, one per target; the oracle is evaluated once."""
    available = gl.availability()
    if not available.available:
        reason = f"{available.detail}; {available.remedy}"
        yield from (CaseResult(case, target, "gl", None, reason) for target in targets)
        return
    library = load_library(origin)
    document = case_document(case, library.document)
    element = renderable_elements(document)[0]
    surface = Surface(element)
    rng = sampling.generator(seed, case.name)
    batches: list[tuple[ShadingPoints, Tolerance]] = []
    for start in range(0, samples, _BATCH):
        points = case_points(case, min(_BATCH, samples - start), rng)
        batches.append((points, surface.tolerance(points)))
    for target in targets:
        shader = generate(element, target, library)
        with gl.SurfaceProgram(shader) as program:
            found = [draw(program, points) for points, _ in batches]
        points, tolerance = merged(batches)
        yield CaseResult(case, target, "gl", compare(np.concatenate(found), tolerance, points), None)


def merged(batches: Sequence[tuple[ShadingPoints, Tolerance]]) -> tuple[ShadingPoints, Tolerance]:
    """All samples of the batches as one, without their properties."""
    points = [p for p, _ in batches]

    def joined(name: str) -> Array:
        return np.concatenate([np.broadcast_to(getattr(p, name), (len(p), getattr(p, name).shape[-1])) for p in points])

    whole = ShadingPoints(
        view=joined("view"),
        light=joined("light"),
        normal=joined("normal"),
        tangent=joined("tangent"),
        position=joined("position"),
        texcoord=joined("texcoord"),
    )
    tolerances = [t for _, t in batches]
    return whole, Tolerance(
        np.concatenate([t.expected for t in tolerances]), np.concatenate([t.allowed for t in tolerances])
    )
