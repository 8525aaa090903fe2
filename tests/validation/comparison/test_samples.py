"""What a comparison says about shader and reference: figures, the worst sample, and what passes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import Surface, Tolerance
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.drawing import describe
from mrm_mtlx.validation.comparison.samples import compare, draw
from mrm_mtlx.validation.comparison.sampling import LobeShape, generator, sample_local, shading_points
from tests.fixtures.versions import planted

# Exact: what is compared are powers of two.
EXPECTED = np.array([[1.0, 0.5, 0.25], [4.0, 2.0, 1.0], [0.25, 0.25, 0.25], [0.5, 0.5, 0.5]])
ALLOWED = np.full((4, 3), 2.0**-10)
STEP = 2.0**-10


@pytest.fixture
def points(rng):
    return shading_points(rng, *sample_local(rng, 4))


def test_equal_results_pass_with_no_error(points):
    found = compare(EXPECTED, Tolerance(EXPECTED, ALLOWED), points)
    assert (found.passed, found.samples, found.differing) == (True, 4, 0)
    assert (found.max_error, found.median_error, found.excess) == (0.0, 0.0, 0.0)


def test_an_error_of_exactly_what_is_allowed_passes_and_twice_that_fails(points):
    moved = EXPECTED.copy()
    moved[1, 2] += STEP
    edge = compare(moved, Tolerance(EXPECTED, ALLOWED), points)
    assert (edge.passed, edge.excess) == (True, 1.0)
    moved[1, 2] += STEP
    beyond = compare(moved, Tolerance(EXPECTED, ALLOWED), points)
    assert (beyond.passed, beyond.excess, beyond.differing) == (False, 2.0, 1)


def test_the_figures_are_those_of_their_samples(points):
    moved = EXPECTED.copy()
    moved[0, 0] += 2 * STEP  # relative to 1: 2 steps
    moved[1, 1] += 4 * STEP  # relative to 4: 1 step, and most of the allowance
    moved[2, 2] += 1 * STEP  # relative to 0.25: 4 steps, the largest error
    allowed = ALLOWED * np.array([[4.0], [1.0], [2.0], [1.0]])
    found = compare(moved, Tolerance(EXPECTED, allowed), points)
    assert found.max_error == 4 * STEP
    assert found.tolerance == 2 * STEP / 0.25  # of the sample with that error
    assert found.median_error == 1.5 * STEP  # of 2, 1, 4 and 0
    assert (found.excess, found.differing) == (4.0, 1)
    # The worst sample is the one that misses its allowance by most, not the one with the largest error.
    assert found.worst["expected"] == [4.0, 2.0, 1.0]
    assert found.worst["found"] == [4.0, 2.0 + 4 * STEP, 1.0]
    assert (found.worst["error"], found.worst["tolerance"]) == (STEP, STEP / 4.0)


def test_the_worst_samples_directions_are_its_own(rng):
    v, l = sample_local(rng, 4)
    points = shading_points(rng, v, l)
    for index in range(4):
        moved = EXPECTED.copy()
        moved[index] += 1.0
        worst = compare(moved, Tolerance(EXPECTED, ALLOWED), points).worst
        # Absolute: float32 frames and 7 digits, see test_sampling.
        np.testing.assert_allclose(worst["v"], v[index], rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(worst["l"], l[index], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_a_number_never_passes(points, bad):
    moved = EXPECTED.copy()
    moved[3, 1] = bad
    found = compare(moved, Tolerance(EXPECTED, ALLOWED), points)
    assert not found.passed
    assert found.differing == 1
    assert found.excess == np.inf


def test_a_failed_comparison_is_described_by_its_worst_sample(points):
    moved = EXPECTED.copy()
    moved[1] += 3.0
    line = describe(compare(moved, Tolerance(EXPECTED, ALLOWED), points))
    assert line.startswith("1 of 4 samples differ; worst at v = (")
    assert "found (7, 5, 4), expected (4, 2, 1), relative error 0.75, allowed 0.000244" in line
    assert "\n" not in line


# The whole way --------------------------------------------------------------------------------------------------------

TAPE = """
<oren_nayar_diffuse_bsdf name="paper" type="BSDF"><input name="color" type="color3" value="0.4, 0.5, 0.6"/>
</oren_nayar_diffuse_bsdf>
<generalized_schlick_bsdf name="beads" type="BSDF"><input name="color0" type="color3" value="0.1, 0.2, 0.3"/>
<input name="roughness" type="vector2" value="0.02, 0.01"/>
<input name="retroreflective" type="boolean" value="true"/></generalized_schlick_bsdf>
<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="beads"/>
<input name="base" type="BSDF" nodename="paper"/></layer>
"""


@pytest.fixture(scope="module")
def compared(gl, surface_document, library):
    """Function from a change of the generated source (old, new) and of uniforms to the comparison of a layered tape."""
    document = surface_document(TAPE)
    surface, rng = Surface(document.getNode("m")), generator(0, "tape")
    lobe = LobeShape(np.asarray(0.02), np.asarray(0.01), retroreflective=True)
    points = shading_points(rng, *sample_local(rng, 2048, [lobe]))
    tolerance = surface.tolerance(points)
    shader = generate(document.getNode("m"), "glsl", library)
    whole = SurfaceProgram(shader)  # compiled once for all uniforms; compiling takes most of the time here

    def run(old: str = "", new: str = "", **uniforms: object):
        if not old:
            return compare(draw(whole, points, uniforms or None).colors, tolerance, points)
        pixel = planted(shader.sources["pixel"], old, new)
        with SurfaceProgram(replace(shader, sources={**shader.sources, "pixel": pixel})) as damaged:
            return compare(draw(damaged, points).colors, tolerance, points)

    yield run
    whole.release()


def test_the_generated_shader_passes(compared):
    found = compared()
    assert found.passed
    # Two-sided: the errors of float32 are there, and of its size.
    assert 2.0**-26 < found.median_error < 2.0**-18


@pytest.mark.parametrize(
    ("old", "new"),
    [
        pytest.param("(retroreflective && reflects)", "(reflects && !reflects)", id="the flag ignored"),
        pytest.param("reflect(-closureData.V, N)", "-closureData.V", id="the view turned round, not reflected"),
        pytest.param("mx_ggx_NDF(Ht, safeAlpha)", "mx_ggx_NDF(Ht, safeAlpha.yx)", id="widths exchanged"),
        pytest.param("mx_ggx_NDF(Ht, safeAlpha)", "mx_ggx_NDF(Ht, safeAlpha) * 1.001", id="a thousandth brighter"),
        pytest.param("top.throughput", "base.throughput", id="throughput of the wrong layer"),
    ],
)
def test_a_damaged_shader_fails(compared, old, new):
    found = compared(old, new)
    assert not found.passed
    assert found.excess > 2.0


GIVEN = {
    "beads_color0": (0.1, 0.2, 0.3),
    "beads_roughness": (0.02, 0.01),
    "beads_retroreflective": True,
    "paper_color": (0.4, 0.5, 0.6),
}


@pytest.mark.parametrize(
    "changed",
    [
        {"beads_color0": (0.1001, 0.2, 0.3)},
        {"beads_roughness": (0.01, 0.02)},
        {"beads_roughness": (0.02002, 0.01)},
        {"beads_retroreflective": False},
        {"paper_color": (0.4, 0.5, 0.6006)},
    ],
)
def test_an_input_off_by_a_thousandth_fails(compared, changed):
    assert compared(**GIVEN).passed
    found = compared(**{**GIVEN, **changed})
    assert not found.passed
    assert found.excess > 2.0
    assert compared(**GIVEN).passed
