"""The portable form holds its bounds in generated code, and a form that is wrong anywhere breaks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.conformance import NODES, Case, portable, run_portable
from mrm_mtlx.conformance.approximation import MATERIALS, Sky, bounds
from mrm_mtlx.conformance.portable import BOUNDS, QUADRATURE, measure_portable
from mrm_mtlx.conformance.report import ConformanceReport
from mrm_mtlx.engines import gl as engine
from mrm_mtlx.library.portable import aligned, definitions, lobes
from mrm_mtlx.library.portable.expressions import Expressions
from mrm_mtlx.system.shown import COLUMNS

# At the ends of both ranges of bounds, by a quadrature whose figures are within 0.004 (L1) and 0.002 (albedo) of the
# full one's: less than a tenth of the bounds of L1, a seventh of the tightest of the albedo.
ALPHAS, VIEWS = (0.04, 0.1), (60.0,)
SMALL = {"angles": 48, "azimuths": 24}
SAMPLES = 512


def measured(node: str, alphas=ALPHAS, views=VIEWS, **quadrature: int):
    sky = Sky(node, alphas, views, **(quadrature or SMALL))
    return list(measure_portable(engine.ENGINE, "glsl", sky))


@pytest.mark.parametrize("node", NODES)
def test_the_bounds_hold_where_they_are_tightest(gl, node):
    figures = measured(node)
    assert len(figures) == len(ALPHAS) * len([m for m in MATERIALS if m.node == node])
    assert all(figure.passed for figure in figures)
    # Two-sided: two lobes cannot follow the exact one, and light from below the surface is counted.
    assert 0.5 < max(figure.excess for figure in figures) <= 1.0


def test_the_sign_of_the_view_direction_does_not_matter(gl, monkeypatch):
    """Renderers differ in the sign of `viewdirection`; the lobe is the same."""
    before = measured("conductor_bsdf")
    plain = Expressions.node

    def turned(self, category, kind, inputs, **constants):
        found = plain(self, category, kind, inputs, **constants)
        return -found if category == "viewdirection" else found

    monkeypatch.setattr(Expressions, "node", turned)
    for one, other in zip(before, measured("conductor_bsdf"), strict=True):
        # A rounding of the frame moves the flank of the narrower lobe by 1e-6.
        assert (other.l1, other.albedo) == pytest.approx((one.l1, one.albedo), abs=1e-5)


def test_the_back_of_a_surface_reflects_as_its_front(gl):
    sky = Sky("generalized_schlick_bsdf", (0.04,), (60.0,), **SMALL)
    front = list(measure_portable(engine.ENGINE, "glsl", sky))

    class Back(Sky):
        @property
        def normals(self):
            return -super().normals

    back = list(measure_portable(engine.ENGINE, "glsl", Back(*(vars(sky)[name] for name in vars(sky)))))
    for one, other in zip(front, back, strict=True):
        # Roundings of the frame, as above.
        assert (other.l1, other.albedo) == pytest.approx((one.l1, one.albedo), abs=1e-5)


@pytest.mark.large
def test_the_figures_do_not_depend_on_the_quadrature(gl):
    node = "generalized_schlick_bsdf"
    coarse, as_it_is, fine = (
        np.array([(a.l1, a.albedo) for a in measured(node, (0.1,), angles=angles, azimuths=azimuths)])
        for angles, azimuths in ((12, 8), QUADRATURE.values(), (384, 128))
    )
    assert np.max(np.abs(as_it_is - fine)) < 1e-3
    assert np.max(np.abs(coarse - fine)) > 1e-3  # a quadrature that is too coarse is seen


def test_bounds_grow_with_the_width_and_end_where_nothing_is_promised():
    for node in NODES:
        promised = [bounds(BOUNDS, node, alpha) for alpha in (0.0025, 0.04, 0.1)]
        assert promised[0] == promised[1] < promised[2]
        assert bounds(BOUNDS, node, 0.11) == (np.inf, np.inf)


def test_a_run_has_every_case_in_both_variants(gl, monkeypatch):
    monkeypatch.setattr(
        portable,
        "measure_portable",
        lambda engine, target, sky: measure_portable(
            engine, target, replace(sky, alphas=(0.1,), views_deg=(45.0,), **SMALL)
        ),
    )
    results = list(run_portable(("glsl",), SAMPLES, 0))
    assert {(r.case.node, r.variant) for r in results} == {(n, v) for n in NODES for v in ("aligned", "definitions")}
    assert all(r.status == "pass" for r in results)
    assert all(r.comparison.samples == SAMPLES for r in results if r.variant == "definitions")
    report = ConformanceReport({}, {}, "mrm", tuple(results)).report()
    assert "generalized_schlick_bsdf  " in report
    assert max(map(len, report.splitlines())) <= COLUMNS


def test_without_the_engine_the_cases_are_skipped_with_the_reason(monkeypatch):
    absent = replace(engine.ENGINE.availability(), available=False, detail="there is no display")
    monkeypatch.setattr(type(engine.ENGINE), "availability", lambda _: absent)
    for result in run_portable(("glsl",), SAMPLES, 0):
        assert (result.status, result.reason) == ("skip", absent.reason)


def test_a_target_that_the_form_is_not_compared_on_is_told():
    with pytest.raises(ValueError, match="runs on glsl, essl, not on osl"):
        list(run_portable(("osl",), SAMPLES, 0))


# A form that is wrong -------------------------------------------------------------------------------------------------


def not_turned(nodes, frame, share, turn, widths):
    """About the surface's own normal."""
    return replace(PART(nodes, frame, share, turn, widths), normal=nodes.node("normal", "vector3", {}, space="world"))


def at_the_peak(nodes, facets, inputs):
    """The reflectance of the facet that lies in the surface, for all of them."""
    central = facets.weight * 0.0 + nodes.constant((0.0, 0.5, 0.5, 0.0), "vector4")
    return SCHLICK(nodes, facets._replace(weight=central), inputs)


def of_no_facet(nodes, facets, inputs):
    """White, whatever the reflectance."""
    return aligned.Reflectance(SCHLICK(nodes, facets, inputs).mean * 0.0 + 1.0, SCHLICK(nodes, facets, inputs).pulled)


def brighter(nodes, facets, inputs):
    found = SCHLICK(nodes, facets, inputs)
    return found._replace(mean=found.mean * 1.02)


PART, SCHLICK = aligned._part, aligned.schlick
# What is changed where; the node, width and view angle of which a figure breaks its bound.
DAMAGE = {
    "nothing": (aligned, "_WING", aligned._WING, "conductor_bsdf", 0.1, 60.0),
    "the frame not turned": (aligned, "_part", not_turned, "conductor_bsdf", 0.04, 30.0),
    "no wing": (aligned, "_WING", 0.0, "conductor_bsdf", 0.1, 60.0),
    "the wing not turned": (aligned, "_WING_TURN", 0.0, "conductor_bsdf", 0.1, 60.0),
    "as wide across as along": (aligned, "_GRAZING", 0.999, "conductor_bsdf", 0.04, 60.0),
    "the slope of Fresnel left out": (aligned, "_SHIFT", 0.0, "dielectric_bsdf", 0.1, 60.0),
    "the gain left out": (lobes, "_REFLECTANCES", {**lobes._REFLECTANCES, "generalized_schlick_bsdf": of_no_facet},
                          "generalized_schlick_bsdf", 0.04, 30.0),
    "a fiftieth brighter": (lobes, "_REFLECTANCES", {**lobes._REFLECTANCES, "generalized_schlick_bsdf": brighter},
                            "generalized_schlick_bsdf", 0.04, 45.0),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_form_breaks_its_bounds(gl, monkeypatch, damage):
    where, name, value, node, alpha, view = DAMAGE[damage]
    monkeypatch.setattr(where, name, value)
    figures = measured(node, (alpha,), (view,))
    assert all(figure.passed for figure in figures) == (damage == "nothing")


def test_a_changed_path_without_the_flag_is_seen(gl, monkeypatch):
    plain = lobes._ordinary
    monkeypatch.setattr(lobes, "_ordinary", lambda lobe, nodes, weight: plain(lobe, nodes, weight * 0.999))
    for cached in (definitions._documents, definitions.load_portable_library):
        cached.cache_clear()
    try:
        case = Case("conductor_bsdf", retroreflective=False, anisotropic=True, film=False)
        found = portable._definitions(case, "glsl", engine.ENGINE, samples=SAMPLES, seed=0)
    finally:
        for cached in (definitions._documents, definitions.load_portable_library):
            cached.cache_clear()
    assert found.status == "fail"
    assert found.comparison.differing > 0.5 * SAMPLES
