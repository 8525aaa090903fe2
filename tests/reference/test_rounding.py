"""Tolerances: what float32 may do is allowed, what it may not is seen."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.reference import ROUNDING_FACTOR, Surface, Tolerance, rounding
from mrm_mtlx.reference.rounding import EXACT, Move, moves, value_sign

# Relative error of one correctly rounded operation in float32.
UNIT = float(np.finfo(np.float32).eps) / 2.0

# Share of the samples in which a movement has to show.
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


def test_there_is_a_move_for_each_direction_the_numbers_and_each_delicate_part():
    all_moves = list(moves())
    assert sum(np.ndim(m.view) == 1 for m in all_moves) == 3
    assert sum(np.ndim(m.light) == 1 for m in all_moves) == 3
    assert sorted(m.values for m in all_moves if m.values) == [1, 2]
    parts = [m.part for m in all_moves if m.part]
    assert {"albedo", "reflectance"} <= set(parts)
    assert len(set(parts)) == len(parts)
    assert all(m != EXACT for m in all_moves if not np.ndim(m.view) and not np.ndim(m.light))
    assert ROUNDING_FACTOR > 1.0


def test_the_signs_of_the_numbers_are_all_up_and_then_by_turns():
    assert [value_sign(1, k) for k in range(4)] == [1.0] * 4
    assert [value_sign(2, k) for k in range(4)] == [1.0, -1.0, 1.0, -1.0]


# Relative. One rounding of a direction moves a lobe of alpha 0.3 by 2 u / alpha, a cosine above 0.1 by 10 u.
ONE_MOVE = 100 * UNIT


def test_every_move_is_a_rounding_and_directions_and_numbers_move_every_metal(
    surface_document, turned_points, rng, direction_pairs
):
    document = surface_document(METAL.format(0.3))
    v, l = direction_pairs(rng, 400)
    steep = (v[:, 2] > 0.1) & (l[:, 2] > 0.1) & (v[:, 2] < 0.9)
    surface, points = Surface(document.getNode("m")), turned_points(rng, v[steep], l[steep])
    exact = surface.response(points)
    for move in moves():
        moved = np.max(np.abs(surface.response(points, move) - exact) / exact, axis=-1)
        assert np.max(moved) < ONE_MOVE
        if not move.part:
            assert np.mean(moved > 0.0) > MOST


def test_a_move_of_the_wrong_size_is_seen(surface_document, turned_points, rng, direction_pairs):
    document = surface_document(METAL.format(0.3))
    surface, points = Surface(document.getNode("m")), turned_points(rng, *direction_pairs(rng, 400))
    exact = surface.response(points)
    moved = np.abs(surface.response(points, Move(view=1000.0 * UNIT * np.eye(3)[0])) - exact) / exact
    assert np.mean(np.max(moved, axis=-1) > ONE_MOVE) > MOST
