"""The portable form against the oracle: code generated from nodes of the standard library alone, where it is drawn.

Two variants:

* aligned: flag on, as `mrm convert --portable` writes it, approximate: L1 error and albedo against stated bounds. Light
  from below the surface, which a turned lobe reflects and the exact one does not, counts as an error;
* definitions: flag off, by the graphs that hosts load in the place of sources, which have to be the ordinary lobes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.conformance.approximation import Sky, measured_document
from mrm_mtlx.conformance.cases import case_document, case_points, cases
from mrm_mtlx.conformance.hardware import engine_of
from mrm_mtlx.conformance.oracle import Oracle
from mrm_mtlx.conformance.results import CaseResult
from mrm_mtlx.documents.portable import portable
from mrm_mtlx.engines.base import DirectionalLight, Lighting, SurfacePoints
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.library.portable.definitions import load_portable_library
from mrm_mtlx.library.surface_models import FLAG
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import compare, draw

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.conformance.approximation import Bounds
    from mrm_mtlx.conformance.cases import Case
    from mrm_mtlx.conformance.results import Approximation
    from mrm_mtlx.engines.base import Engine

# Promised L1 error and distance of the albedo ratio from 1, by node and up to a width; incidence up to 60 degrees.
BOUNDS: Bounds = {
    "conductor_bsdf": ((0.04, 0.06, 0.015), (0.1, 0.12, 0.03)),
    "dielectric_bsdf": ((0.04, 0.08, 0.015), (0.1, 0.17, 0.03)),
    "generalized_schlick_bsdf": ((0.04, 0.08, 0.015), (0.1, 0.17, 0.03)),
}

# Finer than for closures of OSL: light from below the surface counts here, up to where the lobe itself ends. Twice as
# many of both move the L1 errors and the albedos by less than 0.001.
QUADRATURE = {"angles": 192, "azimuths": 64}


def steps(targets: Sequence[str], samples: int, seed: int) -> list[Callable[[], Iterator[CaseResult]]]:
    """The work to do, in the order of the report; each step yields its results."""
    found: list[Callable[[], Iterator[CaseResult]]] = []
    for case in cases():
        if not case.retroreflective:
            found.append(partial(_run, case, targets, "definitions", partial(_definitions, samples=samples, seed=seed)))
        elif not case.anisotropic and not case.film:
            found.append(partial(_run, case, targets, "aligned", _aligned))
    return found


def _run(
    case: Case, targets: Sequence[str], variant: str, measure: Callable[[Case, str, Engine], CaseResult]
) -> Iterator[CaseResult]:
    for target in targets:
        engine = engine_of(target)
        state = engine.availability()
        found = measure(case, target, engine) if state.available else None
        yield replace(found or CaseResult(case, target, engine.name, None, state.reason), variant=variant)


def _aligned(case: Case, target: str, engine: Engine) -> CaseResult:
    figures = tuple(
        measure_portable(engine, target, Sky(case.node, angles=QUADRATURE["angles"], azimuths=QUADRATURE["azimuths"]))
    )
    return CaseResult(case, target, engine.name, None, None, approximations=figures)


def _definitions(case: Case, target: str, engine: Engine, *, samples: int, seed: int) -> CaseResult:
    """An ordinary node by the graphs, and the oracle of the standard one."""
    library = load_portable_library()
    document, standard = (case_document(case, known.document) for known in (library, load_library(Origin.UPSTREAM)))
    standard.getNode("lobe").removeInput(FLAG)  # which the definitions have from MaterialX 1.39.5 on
    points = case_points(case, samples, sampling.generator(seed, case.name))
    shader = generate(renderable_elements(document)[0], target, library)
    with Oracle(Surface(renderable_elements(standard)[0]), points) as oracle, engine.compile(shader) as program:
        return CaseResult(
            case, target, engine.name, compare(draw(program, points).colors, oracle.tolerance(), points), None
        )


def measure_portable(engine: Engine, target: str, sky: Sky) -> Iterator[Approximation]:
    """L1 error and albedo of the portable form of a node, see `Sky.figures`.

    Raises
    ------
    CompileError, EngineFailure
        If the engine refuses the shader, or dies.
    """
    exact = measured_document(sky.node, load_library().document, from_properties=True)
    document, lost = portable(exact)
    if lost:
        msg = f"the portable form of {sky.node} lacks something: {lost[0]}"
        raise ValueError(msg)
    surface = Surface(renderable_elements(exact)[0])
    facets = _facets(sky)
    points = SurfacePoints(facets.position, facets.normal, facets.tangent, facets.texcoord, facets.properties)
    shader = generate(renderable_elements(document)[0], target, load_library(Origin.UPSTREAM))
    with engine.compile(shader) as program:

        def lit(sun: Array) -> tuple[Array, Array]:
            found = program.evaluate(points, Lighting(DirectionalLight(tuple(map(float, sun)))))
            expected = surface.shade(replace(facets, light=sun))
            above = (facets.normal @ sun * facets.normal[:, 2] > 0.0)[:, None]  # on the side that is seen
            return found[:, :3].astype(float), np.where(above, expected[:, :3], 0.0)

        yield from sky.figures((lit(sun) for sun in sampling.float32(sky.suns())), BOUNDS)


def _facets(sky: Sky) -> ShadingPoints:
    """The facets of a measurement, seen along z from the origin."""
    normal = sampling.float32(sky.normals)
    count = len(normal)
    return ShadingPoints(
        view=np.broadcast_to([0.0, 0.0, 1.0], (count, 3)),
        light=np.array([0.0, 0.0, 1.0]),
        normal=normal,
        tangent=sampling.float32(sampling.perpendicular(normal.astype(float))),
        position=sampling.float32(np.tile([0.0, 0.0, -1.0], (count, 1))),
        texcoord=sampling.float32(np.zeros((count, 2))),
        properties={name: sampling.float32(value) for name, value in sky.inputs().items()},
    )
