"""Points in pixels of their own: what is changed of them, and that each is where a camera sees it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.conformance.cases import Case, case_points
from mrm_mtlx.engines.base import DirectionalLight, Lighting, SurfacePoints
from mrm_mtlx.engines.storm import facets
from mrm_mtlx.engines.storm.facets import layout, tangents, texture_coordinates

# A pixel of a face of the cube, seen from the eye, and a rounding of float32.
PIXEL, UNIT = 2.0 / facets.SIZE, 2.0**-24


@pytest.fixture
def points(rng) -> SurfacePoints:
    """Samples of a narrow retroreflective lobe, most of them near the light, and their light."""
    drawn = case_points(Case("conductor_bsdf", True, False, False), 3000, rng)
    return SurfacePoints(drawn.position, drawn.normal, drawn.tangent, drawn.texcoord, drawn.properties)


@pytest.fixture
def lighting(points) -> Lighting:
    return Lighting(DirectionalLight((0.26726124, 0.5345225, 0.8017837)))


def unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def test_each_point_is_in_one_pixel_and_no_two_share_one(points, lighting):
    placed = layout(points, lighting)
    which = np.concatenate([frame.which for frame in placed.frames])
    assert sorted(which) == list(range(len(points)))
    for frame in placed.frames:
        assert len(np.unique(frame.pixels, axis=0)) == len(frame.which)
        assert frame.pixels.min() >= 0
        assert frame.pixels.max() < facets.SIZE


def test_a_point_is_turned_about_the_eye_by_less_than_a_pixel_and_its_normal_with_it(points, lighting):
    moved = layout(points, lighting).points
    before, after = (np.linalg.norm(p.position, axis=1) for p in (points, moved))
    # Positions are float32: three components rounded, and their norm.
    np.testing.assert_allclose(after, before, rtol=4.0 * UNIT)
    assert np.max(np.linalg.norm(unit(moved.position) - unit(points.position), axis=1)) < PIXEL / np.sqrt(2.0)
    # The angle that it is seen at is the same, from the back as well: sums of three products of components in float32.
    seen = [np.sum(unit(p.position) * p.normal, axis=1) for p in (points, moved)]
    np.testing.assert_allclose(seen[1], seen[0], atol=16.0 * UNIT)


def test_near_the_light_a_point_is_turned_by_less(points, lighting):
    moved = layout(points, lighting).points
    light = -np.array(lighting.light.to_light)
    away = np.linalg.norm(unit(points.position) - light, axis=1)
    turned = np.linalg.norm(unit(moved.position) - unit(points.position), axis=1)
    near = (away > 8.0**-4) & (away < 1.0 / 8.0)
    assert np.count_nonzero(near) > 500
    # Half a pixel of a window that is 8 times as wide as what may be nearest, and a little.
    assert np.max((turned / away)[near]) < 0.08


def test_the_corners_are_around_the_middle_of_the_pixel_that_the_camera_has_there(points, lighting):
    eye = np.array([0.25, -1.0, 2.0])
    placed = layout(replace(points, position=points.position + eye), replace(lighting, view_position=tuple(eye)))
    for frame in placed.frames:
        matrix = np.array(frame.camera["matrix"])
        left, right, bottom, top = frame.camera["window"]
        local = (frame.corners - matrix[:3, 3]) @ matrix[:3, :3]
        assert np.all(-local[..., 2] > frame.camera["clip"][0])
        assert np.all(-local[..., 2] < frame.camera["clip"][1])
        plane = local[..., :2] / -local[..., 2:]
        column = (plane[..., 0] - left) / (right - left) * facets.SIZE
        row = (top - plane[..., 1]) / (top - bottom) * facets.SIZE
        found = np.stack([column, row], axis=-1)
        # Pixels, from the camera's numbers in double precision; a pixel is 1e-3 of what the window has.
        np.testing.assert_allclose(found.mean(axis=1), frame.pixels + 0.5, atol=1e-6)
        np.testing.assert_allclose(np.ptp(found, axis=1), 1.0, atol=1e-6)


def test_texture_coordinates_have_the_tangents_that_storm_makes_without_them(rng, hemisphere):
    normal = hemisphere(rng, 200)
    steps = np.stack([np.tile([0.01, 0.0, 0.0], (200, 1)), np.tile([0.0, 0.01, 0.0], (200, 1))])
    corners = texture_coordinates(rng.random((200, 2)), normal, steps)
    dx, dy = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    # As Storm says it: the first column of the inverse of the differences, times the sign of the determinant.
    s, t = (step - np.sum(step * normal, axis=1, keepdims=True) * normal for step in steps)
    sign = np.sign(dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0])[:, None]
    # In double precision, but for 1 - z^2 of normals that lie near an axis.
    found = unit(sign * (s * dy[:, 1:] - t * dx[:, 1:]))
    np.testing.assert_allclose(found, tangents(normal), atol=1e-9)


def test_a_normal_along_y_has_a_tangent_too():
    found = tangents(np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]))
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)
