"""The node library against the oracle: every node, flag and shape of lobe, with parameters that vary per sample.

Each case is a small document whose BSDF takes its inputs from geometric properties, so that one draw of the unmodified
generated shader covers a different set of parameters in every sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx
import numpy as np

from mrm_mtlx.engines import gl
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.comparison import compare, draw

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference import ShadingPoints, Tolerance
    from mrm_mtlx.validation.comparison import Comparison

SCHEMA = "mrm.conformance/1"
NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")
TARGETS = ("glsl", "essl")

# Samples per draw: bounds the memory of the oracle's temporaries, whatever the number asked for.
_BATCH = 1 << 16
# Range of widths: from the sharpest real retroreflector to a fully rough surface.
ALPHA_RANGE = (0.0025, 1.0)


@dataclass(frozen=True)
class Case:
    """One configuration of one node.

    `anisotropic` gives the two widths apart, `film` covers the lobe with a thin film.
    """

    node: str
    retroreflective: bool
    anisotropic: bool
    film: bool

    @property
    def name(self) -> str:
        """What the case is called; also seeds its random numbers."""
        shape = "anisotropic" if self.anisotropic else "isotropic"
        flag = "retroreflective" if self.retroreflective else "ordinary"
        return " ".join((self.node, flag, shape, *(["film"] if self.film else [])))


@dataclass(frozen=True)
class CaseResult:
    """Result of a case on a target; `comparison` is None where it was skipped, with `reason`."""

    case: Case
    target: str
    engine: str
    comparison: Comparison | None
    reason: str | None

    @property
    def status(self) -> str:
        """Pass, fail or skip."""
        if self.comparison is None:
            return "skip"
        return "pass" if self.comparison.passed else "fail"

    def to_json(self) -> dict[str, Any]:
        """The entry of the report's list of cases."""
        found = self.comparison
        return {
            "node": self.case.node,
            "target": self.target,
            "engine": self.engine,
            "retroreflective": self.case.retroreflective,
            "anisotropic": self.case.anisotropic,
            "film": self.case.film,
            "status": self.status,
            "samples": found.samples if found else 0,
            "max_error": found.max_error if found else None,
            "median_error": found.median_error if found else None,
            "excess": found.excess if found else None,
            "worst": found.worst if found else None,
            "reason": self.reason,
        }


def cases() -> list[Case]:
    """All cases, in the order of the report."""
    return [
        Case(node, retroreflective, anisotropic, film)
        for node in NODES
        for retroreflective in (False, True)
        for anisotropic in (False, True)
        for film in (False, True)
    ]


def run(
    targets: Sequence[str],
    samples: int,
    seed: int,
    origin: Origin,
    progress: Callable[[int, int], None] | None = None,
    chosen: Sequence[Case] | None = None,
) -> Iterator[CaseResult]:
    """Compare every case on every target; the oracle is evaluated once per case.

    Raises
    ------
    ValueError
        If a target is not one that runs here by design (`TARGETS`).
    """
    unknown = sorted(set(targets) - set(TARGETS))
    if unknown:
        msg = f"conformance runs on {' and '.join(TARGETS)}, not on {', '.join(unknown)}"
        raise ValueError(msg)
    todo = list(chosen or cases())
    available = gl.availability()
    for count, case in enumerate(todo, start=1):
        if available.available:
            yield from _run_case(case, targets, samples, seed, origin)
        else:
            reason = f"{available.detail}; {available.remedy}"
            yield from (CaseResult(case, target, "gl", None, reason) for target in targets)
        if progress:
            progress(count, len(todo))


def case_document(case: Case, library_document: mx.Document) -> mx.Document:
    """The document of a case: every input but the flag comes from a geometric property of the same name."""
    document = mx.createDocument()
    document.setDataLibrary(library_document)
    lobe = document.addNode(case.node, "lobe", "BSDF")
    definition = lobe.getNodeDef()
    for name in (*_RANGES[case.node], "roughness", "weight"):
        kind = definition.getActiveInput(name).getType()
        source = document.addNode("geompropvalue", name, kind)
        source.setInputValue("geomprop", name)
        lobe.addInput(name, kind).setNodeName(name)
    if case.film:
        for name in ("thinfilm_thickness", "thinfilm_ior"):
            source = document.addNode("geompropvalue", name, "float")
            source.setInputValue("geomprop", name)
            lobe.addInput(name, "float").setNodeName(name)
    lobe.setInputValue("retroreflective", case.retroreflective)
    surface = document.addNode("surface", "surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setNodeName("lobe")
    document.addMaterialNode("material", surface)
    return document


def case_points(case: Case, count: int, rng: np.random.Generator) -> ShadingPoints:
    """Samples of a case: parameters drawn per sample, directions by `sampling.sample_local` for those widths."""
    properties = {name: draw_values(rng, count) for name, draw_values in _RANGES[case.node].items()}
    low, high = np.log(ALPHA_RANGE)
    alpha_x = np.exp(rng.uniform(low, high, count))
    alpha_y = np.exp(rng.uniform(low, high, count)) if case.anisotropic else alpha_x
    properties["roughness"] = np.stack([alpha_x, alpha_y], axis=1)
    properties["weight"] = rng.uniform(0.05, 1.0, count)
    if case.film:
        properties["thinfilm_thickness"] = rng.uniform(1.0, 1200.0, count)
        properties["thinfilm_ior"] = rng.uniform(1.0, 2.5, count)
    shape = sampling.LobeShape(alpha_x, alpha_y, case.retroreflective)
    v, l = sampling.sample_local(rng, count, [shape])
    return sampling.shading_points(rng, v, l, properties)


def _uniform(low: float, high: float, components: int = 1) -> Callable[[np.random.Generator, int], Array]:
    def values(rng: np.random.Generator, count: int) -> Array:
        return rng.uniform(low, high, (count, components) if components > 1 else count)

    return values


# What the nodes' own inputs are drawn from: metals of all kinds, dielectrics from water to diamond and, relative to a
# denser outside, below 1; all colours.
_RANGES: Mapping[str, Mapping[str, Callable[[np.random.Generator, int], Array]]] = {
    "conductor_bsdf": {"ior": _uniform(0.04, 4.0, 3), "extinction": _uniform(0.0, 8.0, 3)},
    "dielectric_bsdf": {"tint": _uniform(0.0, 1.0, 3), "ior": _uniform(0.7, 2.6)},
    "generalized_schlick_bsdf": {
        "color0": _uniform(0.0, 1.0, 3),
        "color82": _uniform(0.0, 1.0, 3),
        "color90": _uniform(0.0, 1.0, 3),
        "exponent": _uniform(1.0, 8.0),
    },
}


def _run_case(case: Case, targets: Sequence[str], samples: int, seed: int, origin: Origin) -> Iterator[CaseResult]:
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
        yield CaseResult(case, target, "gl", _merge(found, batches), None)


def _merge(found: list[Any], batches: list[tuple[ShadingPoints, Tolerance]]) -> Comparison:
    from mrm_mtlx.reference import Tolerance

    points = [p for p, _ in batches]
    whole = type(points[0])(
        view=np.concatenate([p.view for p in points]),
        light=points[0].light,
        normal=np.concatenate([p.normal for p in points]),
        tangent=np.concatenate([p.tangent for p in points]),
        position=np.concatenate([p.position for p in points]),
        texcoord=np.concatenate([p.texcoord for p in points]),
    )
    tolerance = Tolerance(
        np.concatenate([t.expected for _, t in batches]), np.concatenate([t.allowed for _, t in batches])
    )
    return compare(np.concatenate(found), tolerance, whole)
