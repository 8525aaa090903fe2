"""Where rays meet the shapes of a picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.render.shapes import EYE, SHAPES, camera_rays, intersect

SIZE = 64

# Absolute, in units of the scene. The distance is a root of a quadratic: it loses digits by cancellation where a ray
# grazes the shape, with a factor of |EYE| / (height above the tangent plane), below 1e4 for these rays.
TOL = 1e4 * 2.0**-52

# Of quantities that are normalised after that.
UNIT_TOL = 8 * 2.0**-53

APEX, BASE, RADIUS = 1.05, -1.0, 0.72  # of the cone
PLANE_HALF, PLANE_TURN = 0.95, np.deg2rad(18.0)


def off_sphere(p):
    return np.abs(np.linalg.norm(p, axis=1) - 1.0)


def off_plane(p):
    across = np.abs(p @ [np.cos(PLANE_TURN), 0.0, -np.sin(PLANE_TURN)])
    beyond = np.maximum(np.maximum(across, np.abs(p[:, 1])) - PLANE_HALF, 0.0)
    return np.abs(p @ [np.sin(PLANE_TURN), 0.0, np.cos(PLANE_TURN)]) + beyond


def off_cone(p):
    radius = RADIUS * (APEX - p[:, 1]) / (APEX - BASE)
    beyond = np.maximum(np.maximum(p[:, 1] - APEX, BASE - p[:, 1]), 0.0)
    return np.abs(np.hypot(p[:, 0], p[:, 2]) - radius) + beyond


OFF = {"sphere": off_sphere, "plane": off_plane, "cone": off_cone}

# Height over the surface along the normal, as a function: its gradient is what the normal has to be.
HEIGHT = {
    "sphere": lambda p: np.linalg.norm(p, axis=1),
    "plane": lambda p: p @ np.array([np.sin(PLANE_TURN), 0.0, np.cos(PLANE_TURN)]),
    "cone": lambda p: np.hypot(p[:, 0], p[:, 2]) + RADIUS / (APEX - BASE) * p[:, 1],
}


@pytest.fixture(params=list(SHAPES))
def shape(request) -> str:
    return request.param


@pytest.fixture
def rays():
    return camera_rays(SIZE)


@pytest.fixture
def hits(shape, rays):
    """The hits on the shape, those rays that miss left out."""
    found = intersect(shape, rays)
    return replace(
        found, **{name: getattr(found, name)[found.found] for name in ("position", "normal", "tangent", "texcoord")}
    )


def test_every_shape_is_tested():
    assert OFF.keys() == HEIGHT.keys() == SHAPES.keys()


def test_rays_start_at_the_top_left_and_are_unit(rays):
    assert rays.shape == (SIZE * SIZE, 3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, rtol=0.0, atol=UNIT_TOL)
    grid = rays.reshape(SIZE, SIZE, 3)
    assert np.all(np.diff(grid[:, 0, 1]) < 0.0)  # down the picture
    assert np.all(np.diff(grid[0, :, 0]) > 0.0)  # to the right
    middle = grid[SIZE // 2 - 1 : SIZE // 2 + 1, SIZE // 2 - 1 : SIZE // 2 + 1].mean(axis=(0, 1))
    np.testing.assert_allclose(middle / np.linalg.norm(middle), -EYE / np.linalg.norm(EYE), rtol=0.0, atol=UNIT_TOL)


def test_a_shape_fills_a_good_part_of_the_picture_and_not_its_border(shape, rays):
    found = intersect(shape, rays).found.reshape(SIZE, SIZE)
    assert 0.1 < np.mean(found) < 0.8
    for border in (found[0], found[-1], found[:, 0], found[:, -1]):
        assert not np.any(border)


def test_hits_lie_on_the_surface_and_on_their_rays(shape, rays, hits):
    assert np.max(OFF[shape](hits.position)) < TOL
    along = hits.position - EYE
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    np.testing.assert_allclose(along, rays[intersect(shape, rays).found], rtol=0.0, atol=TOL)
    # Anti-vacuity: a hit a ten-thousandth of the way off is told.
    assert np.min(OFF[shape](EYE + (hits.position - EYE) * 1.0001)) > TOL


def test_hits_are_the_nearest_ones(shape, rays, hits):
    # Between the eye and the hit the ray stays on the outer side of the surface.
    for part in (0.5, 0.9, 0.99):
        before = EYE + part * (hits.position - EYE)
        assert np.all(HEIGHT[shape](before) > HEIGHT[shape](hits.position))


def test_normals_are_unit_face_the_eye_and_stand_on_the_surface(shape, hits):
    np.testing.assert_allclose(np.linalg.norm(hits.normal, axis=1), 1.0, rtol=0.0, atol=UNIT_TOL)
    assert np.all(np.sum(hits.normal * (EYE - hits.position), axis=1) > 0.0)
    step = 1e-5
    gradient = np.stack(
        [
            (HEIGHT[shape](hits.position + step * e) - HEIGHT[shape](hits.position - step * e)) / (2 * step)
            for e in np.eye(3)
        ],
        axis=1,
    )
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    # Central differences: step^2 times the third derivative, which is up to 1 / radius^2 = 1e4 near the apex, and
    # rounding of 2^-53 / step.
    near = 1e-10 * 1e4 + 2.0**-53 / step * 4
    np.testing.assert_allclose(hits.normal, gradient, rtol=0.0, atol=near)


def test_tangents_are_unit_and_lie_in_the_surface(hits):
    np.testing.assert_allclose(np.linalg.norm(hits.tangent, axis=1), 1.0, rtol=0.0, atol=UNIT_TOL)
    np.testing.assert_allclose(np.sum(hits.tangent * hits.normal, axis=1), 0.0, atol=UNIT_TOL)


def test_texture_coordinates_cover_the_unit_square_and_grow_along_the_tangent(shape, rays, hits):
    assert np.all((hits.texcoord >= 0.0) & (hits.texcoord <= 1.0))
    assert np.ptp(hits.texcoord[:, 1]) > 0.5
    # From pixel to pixel to the right, u grows where the tangent points to the right.
    found = intersect(shape, rays)
    grid = found.found.reshape(SIZE, SIZE)
    both = grid[:, :-1] & grid[:, 1:]
    u = found.texcoord[:, 0].reshape(SIZE, SIZE)
    p = found.position.reshape(SIZE, SIZE, 3)
    t = found.tangent.reshape(SIZE, SIZE, 3)
    along = np.sum((p[:, 1:] - p[:, :-1]) * t[:, :-1], axis=2)[both]
    assert np.all(np.sign(along) == np.sign((u[:, 1:] - u[:, :-1])[both]))


def test_rays_that_pass_by_find_nothing(shape):
    away = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    assert not np.any(intersect(shape, away).found)


def test_there_is_no_other_shape(rays):
    with pytest.raises(KeyError):
        intersect("cube", rays)
