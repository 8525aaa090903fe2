"""The OSL of the node library in Cycles passes in all its variants, and one that is wrong anywhere fails there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf.vectors import half_vector, mirror
from mrm_mtlx.conformance import NODES, Case, approximation, cases, osl, run
from mrm_mtlx.conformance.approximation import BOUNDS, MATERIALS, Sky, bounds, measure_aligned
from mrm_mtlx.engines import osl as engine
from mrm_mtlx.library import Origin

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.conformance import Approximation, CaseResult

# A score per angle between v and l; the full size is that of `mrm conformance`.
SAMPLES = 240

# Aligned lobes are measured at the ends of both ranges of bounds, where one closure follows them worst, by a quadrature
# whose L1 errors are within 0.004 of the full one's: less than a tenth of the bounds of these.
ALPHAS, VIEWS = (0.04, 0.1), (60.0,)
SMALL = {"angles": 32, "azimuths": 16}


@pytest.fixture
def small(cycles, monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine, and aligned lobes measured at few widths and angles."""
    monkeypatch.setattr(
        osl, "measure_aligned", lambda bench, sky: measure_aligned(bench, Sky(sky.node, ALPHAS, VIEWS, **SMALL))
    )


def results_of(chosen: list[Case], origin: Origin = Origin.MRM) -> list[CaseResult]:
    """Cases on OSL, at the size of these tests."""
    return list(run(("osl",), SAMPLES, 0, origin, chosen=chosen))


def assert_passed(result: CaseResult) -> None:
    assert result.status == "pass", result.name
    assert (result.target, result.engine, result.reason) == ("osl", "cycles", None)
    if result.variant == "aligned":
        figures = len([m for m in MATERIALS if m.node == result.case.node]) * len(ALPHAS) * len(VIEWS)
        assert len(result.approximations) == figures
        # Two-sided: one closure cannot follow the lobe.
        assert 0.3 < max(figure.excess for figure in result.approximations) <= 1.0
    else:
        assert result.comparison.samples == SAMPLES
        # Two-sided: float32 was at work. Its errors are neither nothing nor as large as what is allowed; those of
        # closures are larger, whose narrow lobes have their peaks on facets that lie as float32 has them.
        assert 2.0**-26 < result.comparison.median_error < 2.0**-15
        assert 0.0 < result.comparison.excess < 1.0


@pytest.mark.parametrize("node", NODES)
def test_every_variant_of_every_node_passes(small, node):
    ordinary = Case(node, retroreflective=False, anisotropic=True, film=False)
    results = results_of([ordinary, Case(node, retroreflective=True, anisotropic=False, film=False)])
    variants = [result.variant for result in results]
    assert variants == ["functions", "closures", "functions", "cycles", "aligned"]
    for result in results:
        assert_passed(result)


def test_the_variants_are_those_that_the_library_has():
    planned = [step.args[:2] for step in osl.steps("osl", cases(), 16, 0, Origin.MRM)]
    assert len(planned) == len(set(planned))
    for case in cases():
        variants = [variant for planned_case, variant in planned if planned_case == case]
        # Closures take no film, and what is aligned is bounded for equal widths alone.
        expected = ["functions"]
        if not case.film:
            expected += ["cycles"] if case.retroreflective else ["closures"]
        if case.retroreflective and not case.film and not case.anisotropic:
            expected.append("aligned")
        assert variants == expected, case.name
    # MaterialX's own has closures alone, with and without the flag.
    upstream = [step.args[:2] for step in osl.steps("osl", cases(), 16, 0, Origin.UPSTREAM)]
    assert upstream == [(case, "closures") for case in cases() if not case.film]


@pytest.mark.parametrize("node", NODES)
def test_materialx_alone_passes_without_the_flag_and_fails_with_it(cycles, node):
    pair = [Case(node, flag, anisotropic=True, film=False) for flag in (False, True)]
    ordinary, retroreflective = results_of(pair, Origin.UPSTREAM)
    assert_passed(ordinary)
    # It accepts the flag and drops it: hardly a sample is right.
    assert retroreflective.status == "fail"
    assert retroreflective.comparison.differing > 0.5 * SAMPLES
    assert retroreflective.comparison.excess > 1e3


def test_results_depend_on_the_seed_and_not_on_what_else_runs(cycles):
    before, case = (Case("dielectric_bsdf", flag, anisotropic=True, film=True) for flag in (False, True))
    (alone,), (filmed, among) = results_of([case]), results_of([before, case])
    (other,) = run(("osl",), SAMPLES, 1, Origin.MRM, chosen=[case])
    for result in (filmed, among, other):
        assert_passed(result)
    assert alone.to_json() == among.to_json()
    assert alone.to_json()["worst"] != other.to_json()["worst"]


def test_without_the_runtime_the_cases_are_skipped_with_reason_and_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv(engine.process.VARIABLE, str(tmp_path / "nowhere"))
    monkeypatch.setattr(engine.process.RUNTIME, "_running", [])
    monkeypatch.setattr(engine.process.RUNTIME, "_state", None)  # the kept answer
    for result in results_of(cases()[:2]):
        assert result.status == "skip"
        assert "nowhere" in result.reason
        assert engine.process.VARIABLE in result.reason
        assert result.to_json()["samples"] == 0


# What is drawn --------------------------------------------------------------------------------------------------------


def local(points, a: np.ndarray) -> np.ndarray:
    """Directions in the frames of the samples."""
    frame = np.stack([points.tangent, np.cross(points.normal, points.tangent), points.normal], axis=1)
    return np.einsum("nij,nj->ni", frame, np.broadcast_to(a, points.view.shape))


def near_peak(points, case: Case) -> float:
    """Share of the samples whose facet is within one width of the lobe's peak."""
    v, l = local(points, points.view), local(points, points.light)
    m = half_vector(mirror(v) if case.retroreflective else v, l)
    return float(np.mean(np.hypot(*(m[:, :2] / points.properties["roughness"]).T) <= m[:, 2]))


@pytest.mark.parametrize("retroreflective", [False, True], ids=["ordinary", "retroreflective"])
@pytest.mark.parametrize("angle_deg", osl.ANGLES_DEG)
def test_samples_at_an_angle_have_that_angle_and_cover_the_peaks(rng, angle_deg, retroreflective):
    case = Case("conductor_bsdf", retroreflective, anisotropic=True, film=False)
    angle = np.deg2rad(angle_deg)
    points = osl.points_at_angle(case, 2000, angle, rng)
    np.testing.assert_array_equal(points.view, np.broadcast_to([0.0, 0.0, 1.0], (2000, 3)))
    # The light is rounded to float32, the frames' tangents too.
    apart = 2.0 * np.arctan2(
        np.linalg.norm(points.view - points.light, axis=1), np.linalg.norm(points.view + points.light, axis=1)
    )
    np.testing.assert_allclose(apart, angle, rtol=0, atol=2.0**-24)
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, rtol=0, atol=2.0**-24)
    np.testing.assert_allclose(np.sum(points.normal * points.tangent, axis=1), 0.0, rtol=0, atol=2.0**-23)
    v, l = local(points, points.view), local(points, points.light)
    assert np.min(v[:, 2]) > 0.9e-3
    assert np.min(l[:, 2]) > 0.9e-3
    if angle_deg <= 70.0:
        # Half of three in four lie within one width of the peak; of a retroreflective lobe fewer do, the more the view
        # is inclined, and beyond 90 degrees none: a facet that sends light there is steeper than the widest lobe.
        assert near_peak(points, case) > (0.1 if retroreflective else 0.3)
        azimuth = np.arctan2(points.normal[:, 1], points.normal[:, 0])
        assert np.all(np.histogram(azimuth, 8, (-np.pi, np.pi))[0] > 0)


def test_samples_that_miss_the_peaks_are_seen(rng):
    # Widths that were drawn for another sample.
    case = Case("conductor_bsdf", retroreflective=True, anisotropic=True, film=False)
    points = osl.points_at_angle(case, 2000, np.deg2rad(45.0), rng)
    points.properties["roughness"][:] = 0.01
    assert near_peak(points, case) < 0.05


# Aligned lobes --------------------------------------------------------------------------------------------------------


def largest_move(first: list[Approximation], second: list[Approximation]) -> float:
    """By how much two quadratures differ, in any figure."""
    assert [(a.material, a.alpha, a.view_deg) for a in first] == [(a.material, a.alpha, a.view_deg) for a in second]
    return max(max(abs(a.l1 - b.l1), abs(a.albedo - b.albedo)) for a, b in zip(first, second, strict=True))


@pytest.mark.large
def test_the_figures_of_aligned_lobes_do_not_depend_on_the_quadrature(cycles):
    # Of all that is measured these move most: the widest lobes, at 60 degrees, end at the horizon.
    coarse, as_it_is, fine = (
        list(
            measure_aligned(
                engine.CYCLES.bench, Sky("generalized_schlick_bsdf", (0.1,), (60.0,), angles=angles, azimuths=azimuths)
            )
        )
        for angles, azimuths in ((12, 8), (approximation._ANGLES, approximation._AZIMUTHS), (192, 64))
    )
    assert largest_move(as_it_is, fine) < 1e-3  # what the module states
    assert largest_move(coarse, fine) > 1e-3  # a quadrature that is too coarse is seen


def test_bounds_grow_with_the_width_and_end_where_nothing_is_promised():
    for node in NODES:
        promised = [bounds(BOUNDS, node, alpha) for alpha in (0.0025, 0.04, 0.1)]
        assert promised[0] == promised[1] < promised[2]
        assert bounds(BOUNDS, node, 0.11) == (np.inf, np.inf)


# A library that is wrong ----------------------------------------------------------------------------------------------


@pytest.fixture
def changed(cycles, changed_library, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str, str], None]:
    """Function that puts a copy of the node library, with a change to an OSL file, in the place of ours."""

    def change(file: str, old: str, new: str) -> None:
        wrong, folder = changed_library(f"genosl/{file}", old, new)
        for module in (osl, approximation):
            monkeypatch.setattr(module, "load_library", lambda _origin=Origin.MRM: wrong)
        monkeypatch.setattr(osl, "node_library_folder", lambda: folder)

    return change


def failing(case: Case, variant: str) -> bool:
    """Whether a variant of a case fails."""
    (step,) = (step for step in osl.steps("osl", [case], SAMPLES, 0, Origin.MRM) if step.args[1] == variant)
    (result,) = step()
    assert result.status in ("pass", "fail")
    return result.status == "fail"


ORDINARY, RETRO = (Case("conductor_bsdf", flag, anisotropic=True, film=False) for flag in (False, True))
RESPONSE, MODES, WRAPPER = "lib/mrm_response.osl", "lib/mrm_retroreflection.osl", "mrm_conductor_bsdf.osl"

# What is wrong with the functions, where, and which cases fail.
FUNCTIONS = {
    "nothing": ("retroreflective", "retroreflective", set()),
    "the view not reflected": ("v = retroreflective ? 2.0 * dot(n, V) * n - V : V", "v = V", {RETRO}),
    "Fresnel left with the view": ("min(dot(v, s) / sqrt(size)", "min(abs(dot(V, s)) / sqrt(size)", {RETRO}),
    "widths exchanged": ("clamp(roughness.x, 1e-8, 1.0)", "clamp(roughness.y, 1e-8, 1.0)", {ORDINARY, RETRO}),
    "a thousandth brighter": (
        "return weight * lobe * mrm_c",
        "return 1.001 * weight * lobe * mrm_c",
        {ORDINARY, RETRO},
    ),
}


@pytest.mark.parametrize("damage", FUNCTIONS)
def test_wrong_functions_fail_in_the_cases_that_they_are_wrong_in(changed, damage):
    old, new, expected = FUNCTIONS[damage]
    changed(RESPONSE, old, new)
    assert {case for case in expected or {ORDINARY, RETRO} if failing(case, "functions")} == expected


STANDARD = "conductor_bsdf(N, U, roughness.x, roughness.y, ior_n, ior_k, distribution, "

# What is wrong with the closures, where, and which cases fail; those with the flag are seen through the portal.
CLOSURES = {
    "the flag ignored": (MODES, "    if (retroreflective)\n", "    if (0)\n", {RETRO}),
    "the view not reflected": (MODES, "MRM_PORTAL_STEP * mirrored, -mirrored", "MRM_PORTAL_STEP * v, -v", {RETRO}),
    "the portal never left": (MODES, "travelled < 4.0 *", "travelled < 0.0 *", {RETRO}),
    "widths exchanged": (WRAPPER, STANDARD, STANDARD.replace("x, roughness.y", "y, roughness.x"), {ORDINARY, RETRO}),
    "a thousandth brighter": (WRAPPER, f"weight * {STANDARD}", f"1.001 * weight * {STANDARD}", {ORDINARY, RETRO}),
}


@pytest.mark.parametrize("damage", CLOSURES)
def test_wrong_closures_fail_in_the_cases_that_they_are_wrong_in(changed, damage):
    file, old, new, expected = CLOSURES[damage]
    changed(file, old, new)
    variants = {ORDINARY: "closures", RETRO: "cycles"}
    assert {case for case in expected if failing(case, variants[case])} == expected


@pytest.mark.parametrize("node", NODES[1:])
def test_a_thousandth_more_is_seen_in_every_node(changed, node):
    name = node.removesuffix("_bsdf")
    changed(RESPONSE, f"mrm_{name}_reflectance(", f"1.001 * mrm_{name}_reflectance(")
    assert failing(Case(node, retroreflective=True, anisotropic=True, film=False), "functions")


# What is wrong with the aligned lobe, where, and where it shows: node, width, view angle.
MEAN = "mrm_dielectric_reflectance(facets.cosine[i], "
AT_PEAK = MEAN.replace("facets.cosine[i]", "facets.cos_v")
ALIGNED = {
    "nothing": (MODES, "retroreflective", "retroreflective", "dielectric_bsdf", 0.04, 60.0),
    "the turn by the slope of Fresnel left out": (MODES, "- atan(shift)", "", "dielectric_bsdf", 0.04, 60.0),
    "Fresnel at the peak alone": ("mrm_dielectric_bsdf.osl", MEAN, AT_PEAK, "dielectric_bsdf", 0.04, 60.0),
    "the flag ignored": (MODES, "retroreflective ? MRM_OSL_MODE", "retroreflective ? 0", "conductor_bsdf", 0.04, 60.0),
    "as wide across as along": (MODES, "f.a22 / (widened * widened)", "f.a22", "conductor_bsdf", 0.04, 60.0),
    "a fiftieth brighter": (MODES, "lobe.scale = (1.0 +", "lobe.scale = (1.02 +", "conductor_bsdf", 0.04, 60.0),
}


@pytest.mark.parametrize("damage", ALIGNED)
def test_a_wrong_aligned_lobe_breaks_its_bounds(changed, damage):
    file, old, new, node, alpha, view = ALIGNED[damage]
    changed(file, old, new)
    figures = list(measure_aligned(engine.CYCLES.bench, Sky(node, (alpha,), (view,), **SMALL)))
    assert all(figure.passed for figure in figures) == (damage == "nothing")
