"""The cases in OSL: the node library in a renderer that measures what closures reflect, against the oracle.

Four variants, as the library has them:

* functions: `f(v', l) cos(l)` in OSL, sample by sample;
* closures: flag off, what the renderer's own closures reflect of a sun;
* the mode that is exact in the renderer, in Cycles: flag on, the surface met again from v' through a ray portal;
* aligned: flag on, a standard closure in a turned frame, approximate: L1 error and albedo against stated bounds.

The nodes that MaterialX lacks are graphs of these: the share of prismatic sheeting is exact, as closures; partial
retroreflection is (1 - w) and w times what the standard node's two closures reflect (its parts).

MaterialX's own implementation has closures alone, with the flag off and on.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.conformance.approximation import Sky, measure_aligned
from mrm_mtlx.conformance.cases import ALPHA_RANGE, Case, case_points, shader_parameters
from mrm_mtlx.conformance.new_nodes import (
    AMOUNT,
    WEIGHT_NODE,
    NewCase,
    document_of,
    expected,
    properties_of,
    standard_document,
)
from mrm_mtlx.conformance.oracle import Oracle
from mrm_mtlx.conformance.results import CaseResult
from mrm_mtlx.engines import registry
from mrm_mtlx.library import Origin, load_library, node_library_folder
from mrm_mtlx.reference import Model, ShadingPoints, Surface, Tolerance
from mrm_mtlx.reference.float32.rounding import SMALLEST, UNIT
from mrm_mtlx.shadergen import OslMode, generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.closures import ANGLES_DEG
from mrm_mtlx.validation.comparison.samples import compare

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    import MaterialX as mx
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.engines.base import ClosureBench, ClosureProgram, Engine
    from mrm_mtlx.library import DataLibrary

# The weight of a closure may have its reflectance in it; what reflects less than this does not show in a sum.
_LEAST_REFLECTANCE = 0.016

# Of the sum of two closures' light: weights, products and the sum itself, on both sides.
_SUM_ROUNDINGS = 16


def steps(
    target: str, cases: Sequence[Case], samples: int, seed: int, origin: Origin
) -> list[Callable[[], Iterator[CaseResult]]]:
    """The work to do, in the order of the report; each step yields its results."""
    plain = [case for case in cases if not case.film]
    if origin is Origin.UPSTREAM:
        return [
            partial(_run, case, "closures", partial(_closures, origin=origin), target, samples, seed) for case in plain
        ]
    exact = _bench(target)[1].exact_mode
    variants: list[tuple[Case, str, Callable[..., CaseResult]]] = []
    for case in cases:
        if isinstance(case, NewCase):
            if case.node == WEIGHT_NODE:
                variants.append((case, "closures", partial(_closures, origin=origin)))
            elif not case.film:
                variants.append((case, "parts", _parts))
            continue
        variants.append((case, "functions", _functions))
        if case.film:
            continue
        if not case.retroreflective:
            variants.append((case, "closures", partial(_closures, origin=origin)))
            continue
        variants.append((case, exact, partial(_closures, origin=origin, mode=exact)))
        if not case.anisotropic:
            variants.append((case, OslMode.ALIGNED, _aligned))
    return [partial(_run, *variant, target, samples, seed) for variant in variants]


def _run(
    case: Case, variant: str, measure: Callable[..., CaseResult], target: str, samples: int, seed: int
) -> Iterator[CaseResult]:
    engine, bench = _bench(target)
    available = engine.availability()
    if not available.available:
        yield CaseResult(case, target, engine.name, None, available.reason, variant)
        return
    yield measure(case, variant, samples, seed, bench)


def _bench(target: str) -> tuple[Engine, ClosureBench]:
    engine = registry.engine_for(target, registry.measures_closures)
    if engine is None or engine.bench is None:
        msg = f"no engine runs {target}"
        raise ValueError(msg)
    return engine, engine.bench


def _functions(case: Case, variant: str, samples: int, seed: int, bench: ClosureBench) -> CaseResult:
    """The exact functions, at the samples that the hardware targets have."""
    points = case_points(case, samples, sampling.generator(seed, case.name))
    with Oracle(_surface(case, Origin.MRM), points) as oracle:
        name = case.node.removesuffix("_bsdf")
        program = compile_function(bench, name, points.properties, case.retroreflective)
        found = program.emitted(_function_inputs(points))
        comparison = compare(found, oracle.tolerance(), points)
    return CaseResult(case, bench.target, bench.name, comparison, None, variant)


def _surface(case: Case, origin: Origin) -> Surface:
    document = document_of(case, load_library(origin).document)
    return Surface(renderable_elements(document)[0], Model.CLOSURES)


def _function_inputs(points: ShadingPoints) -> dict[str, Array]:
    frame = {
        "to_view": points.view,
        "to_light": np.broadcast_to(points.light, points.view.shape),
        "facing": points.normal,
        "along": points.tangent,
    }
    return frame | shader_parameters(points.properties)


# The inputs of each function after v and l, before the flag, the film and the frame.
_ARGUMENTS = {
    "conductor": ("weight", "ior", "extinction", "roughness"),
    "dielectric": ("weight", "tint", "ior", "roughness"),
    "generalized_schlick": ("weight", "color0", "color82", "color90", "exponent", "roughness"),
}


def compile_function(
    bench: ClosureBench, name: str, properties: Mapping[str, Array], retroreflective: bool
) -> ClosureProgram:
    """Compile a shader that emits what `mrm_NAME_response` of the OSL library returns; for inputs of these shapes."""
    declared = [f"color {n} = 0" if v.ndim == 2 else f"float {n} = 0" for n, v in shader_parameters(properties).items()]
    declared += [f"vector {n} = 0" for n in ("to_view", "to_light", "facing", "along")]
    film = ["lobe_thinfilm_thickness", "lobe_thinfilm_ior"] if "thinfilm_ior" in properties else ["0.0", "1.5"]
    arguments = [n if n == "roughness" else f"lobe_{n}" for n in _ARGUMENTS[name]]
    call = ", ".join(["to_view", "to_light", *arguments, str(int(retroreflective)), *film, "normal(facing)", "along"])
    source = (
        '#include "mx_funcs.h"\n#include "mrm_response.osl"\n'
        f"shader evaluate_{name}({', '.join(declared)}, output closure color out = 0)\n{{\n"
        "    vector2 roughness = {roughness_in1, roughness_in2};\n"
        f"    out = emission() * mrm_{name}_response({call});\n}}\n"
    )
    headers = sorted((node_library_folder() / "pbrlib" / "genosl" / "lib").glob("*.osl"))
    return bench.compile(source, f"evaluate_{name}", headers)


def _closures(
    case: Case,
    variant: str,
    samples: int,
    seed: int,
    bench: ClosureBench,
    *,
    origin: Origin,
    mode: OslMode = OslMode.ALIGNED,
) -> CaseResult:
    """The light that the closures of the generated shader reflect, of suns at several angles."""
    library = load_library(origin)
    surface = _surface(case, origin)
    program = _compiled(bench, document_of(case, library.document, from_properties=False), library, mode)
    groups, points = _sun_points(case, samples, seed, bench)
    with Oracle(surface, points) as oracle:
        found = _reflected(program, groups)
        tolerance = expected(case, points, oracle.tolerance(), library.document)
    if case.node == WEIGHT_NODE:
        tolerance = Tolerance(tolerance.expected, tolerance.allowed + bench.smallest_weight / np.pi)
    return CaseResult(case, bench.target, bench.name, compare(found, tolerance, points), None, variant)


def _parts(case: NewCase, variant: str, samples: int, seed: int, bench: ClosureBench) -> CaseResult:
    """The light that the graph's closures reflect, beside the sum of that of the two closures in it."""
    library = load_library()
    groups, points = _sun_points(case, samples, seed, bench)
    document = document_of(case, library.document, from_properties=False)
    found = _reflected(_compiled(bench, document, library), groups)
    amount = _handed_on(bench, groups)
    plain = [replace(g, properties={n: v for n, v in g.properties.items() if n != AMOUNT}) for g in groups]
    documents = (standard_document(case, flag, library.document, from_properties=False) for flag in (False, True))
    ordinary, retroreflective = (_reflected(_compiled(bench, d, library), plain).astype(float) for d in documents)
    sums = (1.0 - amount) * ordinary + amount * retroreflective
    allowed = _SUM_ROUNDINGS * UNIT * np.abs(sums) + SMALLEST
    # A part whose closure weighs too little is left out by the renderer.
    weight = points.properties["weight"].astype(float)[:, None]
    if "tint" in points.properties:
        weight = weight * np.mean(points.properties["tint"], axis=1, keepdims=True)
    for share, part in ((1.0 - amount, ordinary), (amount, retroreflective)):
        allowed = allowed + np.where(share * weight * _LEAST_REFLECTANCE <= bench.smallest_weight, share * part, 0.0)
    comparison = compare(found, Tolerance(sums, allowed), points)
    return CaseResult(case, bench.target, bench.name, comparison, None, variant)


# A shader whose light is what it is told.
_TOLD = "shader told(float a = 0, output closure color out = 0)\n{\n    out = emission() * a;\n}\n"


def _handed_on(bench: ClosureBench, groups: Sequence[ShadingPoints]) -> Array:
    """Amounts as shaders have them, (samples, 1): interpolated over facets, some of them a step up in Blender 5.3."""
    program = bench.compile(_TOLD, "told")
    found = [program.emitted({"a": group.properties[AMOUNT]})[:, :1] for group in groups]
    return np.concatenate(found).astype(float)


def _compiled(
    bench: ClosureBench, document: mx.Document, library: DataLibrary, mode: OslMode = OslMode.ALIGNED
) -> ClosureProgram:
    source = generate(renderable_elements(document)[0], bench.target, library, mode).sources["pixel"]
    return bench.compile(source, "case")


def _sun_points(case: Case, samples: int, seed: int, bench: ClosureBench) -> tuple[list[ShadingPoints], ShadingPoints]:
    """Samples per sun, and all of them with the normals that the renderer has for them."""
    rng = sampling.generator(seed, case.name)
    count = -(-samples // len(ANGLES_DEG))
    groups = [points_at_angle(case, count, float(angle), rng) for angle in np.deg2rad(ANGLES_DEG)]
    together = ShadingPoints.joined(groups)
    return groups, replace(together, normal=bench.true_normals(together.normal).astype(float))


def _reflected(program: ClosureProgram, groups: list[ShadingPoints]) -> NDArray[np.floating]:
    together = ShadingPoints.joined(groups)
    inputs = shader_parameters({**together.properties, "tangent": together.tangent})
    return program.direct_light_by_groups(together.normal, inputs, [group.light for group in groups])


def points_at_angle(case: Case, count: int, angle: float, rng: np.random.Generator) -> ShadingPoints:
    """Samples with v = z and one l at this angle [rad] from it, in the xz-plane; frames and parameters vary.

    Three in four lie around the lobe's peak. For a retroreflective lobe the angle itself says how far off the peak a
    sample is, so that its width follows from the angle: the facet's slope, half the angle, in units of the width is
    drawn from the distribution.
    """
    properties = properties_of(case, count, rng)
    if "color82" in properties:
        properties["color82"] = np.ones((count, 3))  # the closure has no such parameter
    radius = np.sqrt(rng.random(count) / np.maximum(rng.random(count), 1e-6))
    if case.retroreflective:
        wanted = np.clip(np.tan(angle / 2) / np.maximum(radius, 1e-3), *ALPHA_RANGE)
        near = rng.random(count) < 0.75
        properties["roughness"] = np.where(near[:, None], _spread(case, wanted, rng), properties["roughness"])
    v, l = _pairs(case, properties.get("roughness", np.ones((count, 2))), angle, rng)
    light = np.array([np.sin(angle), 0.0, np.cos(angle)])
    return ShadingPoints(
        view=np.broadcast_to([0.0, 0.0, 1.0], (count, 3)),
        light=sampling.float32(light),
        normal=_turned(v, l, np.array([0.0, 0.0, 1.0])),
        tangent=sampling.float32(_turned(v, l, np.array([1.0, 0.0, 0.0]))),
        position=np.zeros((count, 3)),
        texcoord=np.zeros((count, 2)),
        properties={name: sampling.float32(value) for name, value in properties.items()},
    )


def _spread(case: Case, width: Array, rng: np.random.Generator) -> Array:
    """Two widths of this geometric mean, up to a factor of 2 apart from it."""
    stretch = np.exp(rng.uniform(-0.7, 0.7, len(width))) if case.anisotropic else np.ones(len(width))
    return np.clip(np.stack([width * stretch, width / stretch], axis=1), *ALPHA_RANGE)


def _pairs(case: Case, alpha: Array, angle: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Local directions v and l at this angle, both above the surface."""
    count = len(alpha)
    v, l = np.zeros((count, 3)), np.zeros((count, 3))
    todo = np.arange(count)
    for attempt in range(64):
        phi = 2.0 * np.pi * rng.random(len(todo))
        around = rng.random(len(todo)) < (0.75 if attempt < 32 else 0.0)
        if case.retroreflective:
            seen = sampling.spherical(np.maximum(rng.random(len(todo)), 2e-3), rng.random(len(todo)))
            lit = sampling.rotated(seen, angle, phi)
        else:
            # The facet's normal, halfway between v and l: within the lobe, or anywhere.
            radius = np.sqrt(rng.random(len(todo)) / np.maximum(rng.random(len(todo)), 1e-6))
            slopes = [radius * np.cos(phi) * alpha[todo, 0], radius * np.sin(phi) * alpha[todo, 1]]
            near = np.stack([*slopes, np.ones(len(todo))], axis=1)
            anywhere = sampling.spherical(rng.random(len(todo)), rng.random(len(todo)))
            m = np.where(around[:, None], near / np.linalg.norm(near, axis=1, keepdims=True), anywhere)
            turn = 2.0 * np.pi * rng.random(len(todo))
            seen, lit = sampling.rotated(m, angle / 2, turn), sampling.rotated(m, angle / 2, turn + np.pi)
        good = (seen[:, 2] > 1e-3) & (lit[:, 2] > 1e-3)
        v[todo[good]], l[todo[good]] = seen[good], lit[good]
        todo = todo[~good]
        if not len(todo):
            break
    else:  # the mirror pair is always above
        mirror = np.array([np.sin(angle / 2), 0.0, np.cos(angle / 2)])
        v[todo], l[todo] = mirror, mirror * [-1.0, 1.0, 1.0]
    return v, l


def _turned(v: Array, l: Array, axis: Array) -> Array:
    """A local axis after the turn that takes v to z and l into the xz-plane, toward x."""
    side = l - np.sum(l * v, axis=1, keepdims=True) * v
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return np.stack([side @ axis, np.cross(v, side) @ axis, v @ axis], axis=1)


def _aligned(case: Case, variant: str, samples: int, seed: int, bench: ClosureBench) -> CaseResult:
    del samples, seed  # a quadrature, not a sample
    figures = tuple(measure_aligned(bench, Sky(case.node)))
    return CaseResult(case, bench.target, bench.name, None, None, variant, figures)
