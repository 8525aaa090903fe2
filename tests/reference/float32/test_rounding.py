"""Tolerances: what float32 may do is allowed, what it may not is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.reference import ROUNDING_FACTOR, Model, Surface, Tolerance
from mrm_mtlx.reference.float32 import rounding
from mrm_mtlx.reference.float32.rounding import (
    EXACT,
    PATTERNS,
    QUANTITIES,
    Perturbation,
    Quantity,
    farthest,
    on_the_way,
    opposite_perturbations,
    perturbations,
    range_perturbations,
    value_sign,
)

# Relative error of one correctly rounded operation in float32.
UNIT = float(np.finfo(np.float32).eps) / 2.0

# Share of the samples in which a change has to show.
MOST = 0.5

METAL = (
    '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="{0}, {0}"/></conductor_bsdf>'
)


@pytest.fixture
def tolerance(surface_document, turned_points, rng, direction_pairs):
    """Function from a width to the tolerance of a metal over samples of every kind."""

    def make(alpha: float, count: int = 500) -> Tolerance:
        document = surface_document(METAL.format(alpha))
        return Surface(document.getNode("m")).tolerance(turned_points(rng, *direction_pairs(rng, count)))

    return make


@pytest.mark.parametrize("alpha", [0.0025, 0.05, 1.0])
def test_a_result_rounded_to_float32_is_allowed(tolerance, alpha):
    found = tolerance(alpha)
    assert np.max(found.excess(found.expected.astype(np.float32))) <= 1.0
    assert np.all(found.excess(found.expected) == 0.0)


@pytest.mark.parametrize("alpha", [0.0025, 0.05, 1.0])
def test_a_result_beyond_the_allowance_is_a_difference(tolerance, alpha):
    found = tolerance(alpha)
    for sign in (1.0, -1.0):
        assert np.all(found.excess(found.expected + sign * 1.001 * found.allowed) > 1.0)
        assert np.all(found.excess(found.expected + sign * 0.999 * found.allowed) <= 1.0)


def test_one_wrong_channel_of_three_is_enough():
    given = Tolerance(np.ones((2, 3)), np.full((2, 3), 0.5))
    found = np.ones((2, 3))
    found[1, 2] = 2.0
    assert given.excess(found).tolist() == [0.0, 2.0]


def test_a_result_that_is_no_number_is_infinitely_wrong():
    given = Tolerance(np.ones((1, 3)), np.full((1, 3), 0.5))
    for bad in (np.nan, np.inf, -np.inf):
        assert given.excess(np.array([[1.0, bad, 1.0]])).tolist() == [np.inf]


def test_errors_are_relative_to_the_largest_channel_and_near_zero_to_the_lobes_scale():
    given = Tolerance(np.array([[4.0, 2.0, 0.0], [0.0, 0.0, 0.0]]), np.ones((2, 3)))
    assert given.scale == 4.0
    assert given.relative_errors(given.expected + 1.0).tolist() == [0.25, 1.0 / (4.0 * UNIT)]
    assert given.relative_allowed().tolist() == [0.25, 1.0 / (4.0 * UNIT)]


# Relative allowances on the shoulder of a lobe, one width off its peak. There a rounding u of the half-vector moves D
# by 2 u / alpha of it. Below ROUNDING_FACTOR of these no shader could be allowed its roundings; above ten times as
# much, the check would see less than it could.
MOST_MOVES = 10.0


def shoulder(surface_document, flat_points, alpha: float) -> float:
    """Relative allowance for a metal of this width, one width off its peak."""
    document = surface_document(METAL.format(alpha))
    v, m = np.array([0.6, 0.0, 0.8]), np.array([0.0, alpha, 1.0]) / np.hypot(alpha, 1.0)
    l = 2.0 * (v @ m) * m - v
    return float(Surface(document.getNode("m")).tolerance(flat_points(v, l)).relative_allowed()[0])


@pytest.mark.parametrize("alpha", [0.0025, 0.02, 0.2])
def test_the_allowance_follows_the_width_of_the_lobe(surface_document, flat_points, alpha):
    least = ROUNDING_FACTOR * 2.0 * UNIT / alpha
    assert least < shoulder(surface_document, flat_points, alpha) < MOST_MOVES * least


def test_the_unit_is_that_of_float32():
    assert rounding.UNIT == UNIT


@pytest.mark.parametrize("model", list(Model))
def test_there_is_a_perturbation_for_each_direction_the_numbers_and_each_quantity(model):
    every = list(perturbations(model))
    assert sum(np.ndim(m.view) == 1 for m in every) == 3
    assert sum(np.ndim(m.light) == 1 for m in every) == 3
    assert [m.values for m in every if m.values] == list(PATTERNS)
    assert [m.quantity for m in every if m.quantity] == list(QUANTITIES[model])
    assert len(set(QUANTITIES[model])) == len(QUANTITIES[model])
    assert all(m != EXACT for m in every if not np.ndim(m.view) and not np.ndim(m.light))
    assert ROUNDING_FACTOR > 1.0


def test_every_perturbation_is_allowed_the_same_number_of_roundings():
    for perturbation in (*perturbations(), *opposite_perturbations()):
        size = abs(perturbation.step) / UNIT if perturbation.values else 1.0
        assert size * perturbation.factor == ROUNDING_FACTOR


def test_the_opposite_perturbations_are_those_of_the_numbers_with_the_other_sign():
    forth = [m for m in perturbations() if m.values]
    assert [(m.values, -m.step) for m in opposite_perturbations()] == [(m.values, m.step) for m in forth]


def test_any_two_numbers_within_a_stretch_of_eight_differ_in_a_pattern():
    assert [value_sign(1, k) for k in range(4)] == [1.0] * 4
    assert [value_sign(2, k) for k in range(4)] == [1.0, -1.0, 1.0, -1.0]
    for first in range(20):
        for second in range(first + 1, first + 8):
            assert any(value_sign(p, first) != value_sign(p, second) for p in PATTERNS)


# Relative. One rounding of a direction moves a lobe of alpha 0.3 by 2 u / alpha, a cosine above 0.1 by 10 u.
ONE_ROUNDING = 100 * UNIT


def test_every_perturbation_is_a_rounding_and_those_of_directions_and_numbers_change_every_metal(
    surface_document, turned_points, rng, direction_pairs
):
    document = surface_document(METAL.format(0.3))
    v, l = direction_pairs(rng, 400)
    steep = (v[:, 2] > 0.1) & (l[:, 2] > 0.1) & (v[:, 2] < 0.9)
    surface, points = Surface(document.getNode("m")), turned_points(rng, v[steep], l[steep])
    exact = surface.response(points)
    for perturbation in perturbations():
        moved = np.max(np.abs(surface.response(points, perturbation) - exact) / exact, axis=-1)
        assert np.max(moved) * perturbation.factor < ONE_ROUNDING * ROUNDING_FACTOR
        if not perturbation.quantity:
            assert np.mean(moved > 0.0) > MOST


# A shade that steps from black to white where the texture coordinate reaches a half, and one that steps everywhere or
# nowhere: where the value of a constant is.
STEP = """
  <texcoord name="uv" type="vector2"/>
  <extract name="u" type="float"><input name="in" type="vector2" nodename="uv"/></extract>
  <constant name="half" type="float"><input name="value" type="float" value="{0}"/></constant>
  <ifgreater name="step" type="float">
    <input name="value1" type="float" nodename="{1}"/><input name="value2" type="float" nodename="half"/>
    <input name="in1" type="float" value="1"/><input name="in2" type="float" value="0"/>
  </ifgreater>
  <surface_unlit name="s" type="surfaceshader"><input name="emission" type="float" nodename="step"/></surface_unlit>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
"""


def stepped(make_document, flat_points, u: list[float], value: float = 0.5, what: str = "u") -> Tolerance:
    up = np.array([0.0, 0.0, 1.0])
    points = flat_points(np.tile(up, (len(u), 1)), up)
    texcoord = np.stack([np.array(u), np.zeros(len(u))], axis=1)
    document = make_document(STEP.format(value, what))
    return Surface(document.getNode("m")).tolerance(replace(points, texcoord=texcoord))


def test_a_step_is_allowed_either_way_where_roundings_reach_it_and_nowhere_else(make_document, flat_points):
    reach = ROUNDING_FACTOR * UNIT
    found = stepped(make_document, flat_points, [0.5 * (1.0 + k * reach) for k in (-4.0, -0.9, 0.9, 4.0)])
    assert found.expected[:, 0].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert (found.allowed[:, 0] > 0.5).tolist() == [False, True, True, False]


def test_a_step_of_constants_is_settled_however_close_they_are(make_document, flat_points):
    found = stepped(make_document, flat_points, [0.1, 0.9], 0.5, "half")
    assert np.max(found.allowed) < 1e-6


# Lobes whose half-vector is no more than roundings where v is near -l, at widths that show it.
NEAR_OPPOSITE = {
    "sheen": '<sheen_bsdf name="bsdf" type="BSDF"><input name="roughness" type="float" value="0.02"/></sheen_bsdf>',
    "burley": '<burley_diffuse_bsdf name="bsdf" type="BSDF"><input name="roughness" type="float" value="1"/>'
    "</burley_diffuse_bsdf>",
    "metal": METAL.format(0.0),
}


@pytest.fixture
def opposite_points(rng, turned_points):
    """Samples whose l is near -v, or near its mirror image at grazing angles, by a hundred-millionth to a tenth."""
    count = 12000
    cos_l, phi = 10.0 ** rng.uniform(-6.0, -0.5, count), rng.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - np.square(cos_l))
    l = np.stack([sine * np.cos(phi), sine * np.sin(phi), cos_l], axis=1)
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    v = l * np.stack([-np.ones(count), -np.ones(count), side], axis=1)
    v = v + 10.0 ** rng.uniform(-7.5, -1.0, (count, 1)) * rng.normal(size=(count, 3))
    points = turned_points(rng, v / np.linalg.norm(v, axis=1, keepdims=True), l)
    apart = np.linalg.norm(points.view + points.light, axis=1) > 1e-7  # where they are opposite, all is 0/0
    return replace(
        points, **{n: getattr(points, n)[apart] for n in ("view", "normal", "tangent", "position", "texcoord")}
    )


@pytest.mark.parametrize("lobe", NEAR_OPPOSITE)
def test_a_half_vector_that_is_no_more_than_roundings_is_allowed_them(drawn, surface_document, opposite_points, lobe):
    document = surface_document(NEAR_OPPOSITE[lobe])
    tolerance = Surface(document.getNode("m")).tolerance(opposite_points)
    assert np.max(tolerance.excess(drawn(document, opposite_points))) <= 1.0


def test_where_the_half_vector_is_known_no_more_is_allowed_for_it(
    surface_document, turned_points, rng, direction_pairs
):
    document = surface_document(METAL.format(0.0025))
    v, l = direction_pairs(rng, 400)
    apart = (np.linalg.norm(v + l, axis=1) > 0.5) & (v[:, 2] > 0.05) & (l[:, 2] > 0.05)
    surface, points = Surface(document.getNode("m")), turned_points(rng, v[apart], l[apart])
    exact, most = surface.response(points), surface.response(points, Perturbation(quantity=Quantity.MOST))
    assert np.max((most - exact) / exact) < 1e-5


def test_a_perturbation_of_the_wrong_size_is_seen(surface_document, turned_points, rng, direction_pairs):
    document = surface_document(METAL.format(0.3))
    surface, points = Surface(document.getNode("m")), turned_points(rng, *direction_pairs(rng, 400))
    exact = surface.response(points)
    moved = np.abs(surface.response(points, Perturbation(view=1000.0 * UNIT * np.eye(3)[0])) - exact) / exact
    assert np.mean(np.max(moved, axis=-1) > ONE_ROUNDING) > MOST


@pytest.mark.parametrize("top", [0.3, 0.47, 0.99, 2.0])
def test_a_parabola_is_met_between_the_steps_on_the_way(top):
    way = np.array([perturbation.share for perturbation in on_the_way(next(iter(range_perturbations())))])
    off = way * (2.0 * top - way)
    fine = np.linspace(0.0, 1.0, 10001)
    highest = np.max(np.abs(fine * (2.0 * top - fine)))
    assert highest <= farthest(off[:, None])[0] <= highest + (1.0 / 8.0) ** 2 / 4.0 + 1e-12
    # What is in proportion has nothing between.
    np.testing.assert_allclose(farthest(top * way[:, None]), top, rtol=1e-14)
