"""Directions of a comparison: unit, where lobes and difficulties are, and turned without loss."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf.vectors import half_vector, mirror
from mrm_mtlx.validation.comparison.sampling import (
    LIGHT,
    LobeShape,
    generator,
    local_directions,
    sample_local,
    shading_points,
)

COUNT = 20_000

# Of 2 (v.m) m - v in float64: m is normalised with 3 roundings and enters twice, doubled; v and the sums have 2 each.
UNIT_TOL = 16 * 2.0**-53

# Absolute, per component. A vector is rounded to float32 (2^-24 each component), three of the frame's enter a component
# of the result with it (6 * 2^-24), the report rounds to 7 digits (0.5e-7), and LIGHT is unit to float32 only (2^-24).
TURN_TOL = 8 * 2.0**-24 + 0.5e-7


def share_is(found: float, expected: float, sigmas: float, count: int = COUNT) -> bool:
    """Whether a share of independent samples is what is expected, within the spread of a binomial distribution."""
    return abs(found - expected) <= sigmas * np.sqrt(expected * (1.0 - expected) / count)


def width_of(v, l, lobe: LobeShape, *, retroreflective: bool | None = None):
    """Slope of the facet that takes v to l, in units of the lobe's widths."""
    turned = lobe.retroreflective if retroreflective is None else retroreflective
    m = half_vector(mirror(v) if turned else v, l)
    return np.hypot(m[:, 0] / lobe.alpha_x, m[:, 1] / lobe.alpha_y) / m[:, 2]


def peaks(alpha_x: float, alpha_y: float | None = None, *, retroreflective: bool) -> LobeShape:
    widths = (np.asarray(alpha_x), np.asarray(alpha_x if alpha_y is None else alpha_y))
    return LobeShape(*widths, retroreflective)


@pytest.mark.parametrize("lobes", [(), (peaks(0.0025, retroreflective=True), peaks(1.0, 0.1, retroreflective=False))])
def test_directions_are_unit_and_above_the_surface(rng, lobes):
    for a in sample_local(rng, COUNT, lobes):
        assert a.shape == (COUNT, 3)
        np.testing.assert_allclose(np.linalg.norm(a, axis=1), 1.0, rtol=0.0, atol=UNIT_TOL)
        assert np.all(a[:, 2] > 0.0)


def test_a_quarter_of_the_views_is_grazing_and_a_quarter_near_the_normal(rng, significance):
    sigmas = significance.sigmas(3)
    cosine = sample_local(rng, COUNT)[0][:, 2]
    # Grazing: log-uniform from 0.001 to 0.1, a half of it below 0.01; the half that is uniform adds its own 0.01, 0.1.
    assert share_is(np.mean(cosine < 0.1), 0.25 + 0.5 * 0.1, sigmas)
    assert share_is(np.mean(cosine < 0.01), 0.25 * 0.5 + 0.5 * 0.01, sigmas)
    assert np.min(cosine) >= 1e-3
    # Near the normal: cosine above sqrt(0.95).
    near = np.sqrt(0.95)
    assert share_is(np.mean(cosine > near), 0.25 + 0.5 * (1.0 - near), sigmas)
    # Anti-vacuity: directions uniform over the hemisphere are seen to be others.
    uniform = rng.random(COUNT)
    assert not share_is(np.mean(uniform < 0.01), 0.25 * 0.5 + 0.5 * 0.01, sigmas)
    assert not share_is(np.mean(uniform > near), 0.25 + 0.5 * (1.0 - near), sigmas)


def test_without_lobes_the_light_is_uniform_over_the_hemisphere(rng, significance):
    sigmas = significance.sigmas(7)
    l = sample_local(rng, COUNT)[1]
    for edge in (0.1, 0.5, 0.9):
        assert share_is(np.mean(l[:, 2] < edge), edge, sigmas)
    for quadrant in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        assert share_is(np.mean(np.all(l[:, :2] * quadrant > 0.0, axis=1)), 0.25, sigmas)


@pytest.mark.parametrize("retroreflective", [False, True])
@pytest.mark.parametrize("alpha", [(0.0025, 0.0025), (0.01, 0.0025), (0.1, 0.1)])
def test_lobes_are_hit_within_a_width_of_their_peak_and_in_their_tails(rng, significance, alpha, retroreflective):
    sigmas = significance.sigmas(2)
    lobe = peaks(*alpha, retroreflective=retroreflective)
    v, l = sample_local(rng, COUNT, [lobe])
    # Away from grazing, where no facet within reach of the lobe turns light below the surface.
    high = v[:, 2] > 0.9
    width = width_of(v[high], l[high], lobe)
    # Three quarters go to the lobe: half of them within one width, the others as GGX has it, half of which are within.
    # What is uniform over the hemisphere adds a per cent or less.
    uniform = 0.25 * 4.0 * max(alpha) ** 2
    inside = float(np.mean(width <= 1.0))
    assert share_is(min(inside, 0.5625), 0.5625, sigmas, np.count_nonzero(high))
    assert inside <= 0.5625 + uniform + sigmas * np.sqrt(0.25 / np.count_nonzero(high))
    # In the tails of GGX, a slope beyond ten widths has a share of 1 / 101.
    assert np.mean((width > 10.0) & (width < 100.0)) > 0.5 * 0.75 * 0.5 / 101.0
    # The peak of the other kind of lobe is not looked for; near the normal the two overlap.
    assert np.mean(width_of(v[high], l[high], lobe, retroreflective=not retroreflective) <= 1.0) < 0.5 * inside


def test_several_lobes_share_the_samples(rng):
    lobes = [
        peaks(0.0025, retroreflective=True),
        peaks(0.01, retroreflective=False),
        peaks(0.005, retroreflective=True),
    ]
    v, l = sample_local(rng, COUNT, lobes)
    high = v[:, 2] > 0.9
    for lobe in lobes:
        # A quarter of all to each, three quarters of that within one width; the two retroreflective ones overlap.
        assert np.mean(width_of(v[high], l[high], lobe) <= 1.0) > 0.25 * 0.75 * 0.8


def test_each_sample_may_have_a_width_of_its_own(rng):
    alpha = np.exp(rng.uniform(np.log(0.0025), np.log(0.1), COUNT))
    lobe = LobeShape(alpha, alpha, retroreflective=True)
    v, l = sample_local(rng, COUNT, [lobe])
    high = v[:, 2] > 0.9
    chosen = LobeShape(alpha[high], alpha[high], retroreflective=True)
    assert np.mean(width_of(v[high], l[high], chosen) <= 1.0) > 0.5
    # Anti-vacuity: the widths of other samples do not fit.
    shuffled = LobeShape(alpha[high][::-1], alpha[high][::-1], retroreflective=True)
    assert np.mean(width_of(v[high], l[high], shuffled) <= 1.0) < 0.5


def test_samples_depend_on_the_seed_and_the_name_alone():
    def drawn(seed: int, name: str):
        return np.concatenate(sample_local(generator(seed, name), 100, [peaks(0.1, retroreflective=True)]))

    first = drawn(1, "sign")
    generator(1, "other").random(1000)  # what is checked before does not count
    assert np.array_equal(drawn(1, "sign"), first)
    assert not np.any(drawn(2, "sign") == first)
    assert not np.any(drawn(1, "tape") == first)


# Points ---------------------------------------------------------------------------------------------------------------


def test_points_give_back_the_directions_that_went_in(rng):
    v, l = sample_local(rng, 500, [peaks(0.01, retroreflective=True)])
    points = shading_points(rng, v, l)
    found = [local_directions(points, index) for index in range(500)]
    np.testing.assert_allclose([a for a, _ in found], v, rtol=0.0, atol=TURN_TOL)
    np.testing.assert_allclose([a for _, a in found], l, rtol=0.0, atol=TURN_TOL)


def test_points_of_other_directions_are_told_apart(rng):
    # The comparison above sees an error of two per million, and an exchange of v and l.
    v, l = sample_local(rng, 100)
    points = shading_points(rng, v * [1.0 + 4e-6, 1.0, 1.0], l)
    found_v, found_l = zip(*(local_directions(points, index) for index in range(100)), strict=True)
    assert np.max(np.abs(np.array(found_v) - v)) > TURN_TOL
    assert np.max(np.abs(np.array(found_v) - l)) > TURN_TOL
    assert np.max(np.abs(np.array(found_l) - v)) > TURN_TOL


def test_every_points_light_is_the_one_of_the_draw_and_its_eye_the_origin(rng):
    v, l = sample_local(rng, COUNT)
    points = shading_points(rng, v, l)
    assert points.light.tolist() == list(LIGHT)
    distance = np.linalg.norm(points.position, axis=1)
    np.testing.assert_allclose(-points.position / distance[:, None], points.view, rtol=0.0, atol=1e-15)
    assert 0.25 * (1.0 - TURN_TOL) <= np.min(distance) < 0.3
    assert 3.0 < np.max(distance) <= 4.0 * (1.0 + TURN_TOL)
    n = points.normal * np.sign(np.sum(points.normal * points.view, axis=1, keepdims=True))
    cosine_l = n @ np.array(LIGHT)
    np.testing.assert_allclose(cosine_l, l[:, 2], rtol=0.0, atol=TURN_TOL)
    np.testing.assert_allclose(np.sum(points.view * n, axis=1), v[:, 2], rtol=0.0, atol=TURN_TOL)
    np.testing.assert_allclose(
        np.sum(points.view * points.light, axis=1), np.sum(v * l, axis=1), rtol=0.0, atol=TURN_TOL
    )


def test_points_are_numbers_that_a_float32_holds_in_frames_of_all_kinds(rng):
    v, l = sample_local(rng, COUNT)
    points = shading_points(rng, v, l, {"tint": rng.random((COUNT, 3)), "weight": rng.random(COUNT)})
    # The view direction is what the shader makes of the position.
    for a in (
        points.normal,
        points.tangent,
        points.position,
        points.texcoord,
        *points.properties.values(),
    ):
        assert np.array_equal(np.asarray(a, dtype=np.float32).astype(float), a)
    for a in (points.view, points.normal, points.tangent):
        np.testing.assert_allclose(np.linalg.norm(a, axis=1), 1.0, rtol=0.0, atol=TURN_TOL)
    np.testing.assert_allclose(np.sum(points.normal * points.tangent, axis=1), 0.0, atol=TURN_TOL)
    # Normals point everywhere that a light above the surface allows, on both sides.
    assert np.all(np.min(points.normal, axis=0) < -0.9)
    assert np.all(np.max(points.normal, axis=0) > 0.9)


def test_one_sample_in_sixteen_is_seen_from_the_back(rng):
    v, l = sample_local(rng, 1600)
    points = shading_points(rng, v, l)
    back = np.sum(points.normal * points.view, axis=1) < 0.0
    assert np.flatnonzero(back).tolist() == list(range(15, 1600, 16))
