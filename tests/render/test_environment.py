"""Environments: directions of a latitude-longitude image, and the irradiance that it gives."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.render.environment import environment, irradiance_over_pi, latlong_directions, look_up

# Of sums over a thousand numbers in float64.
SUM_TOL = 1000 * 2.0**-53

# The coarse image has 32 rows: a hemisphere's edge falls within one of them, a 32nd of pi off at most, weighted with a
# cosine that vanishes there.
COARSE_TOL = 0.01


@pytest.mark.parametrize("shape", [(8, 16), (32, 64), (64, 128), (100, 200), (1, 2), (3, 7)])
def test_the_irradiance_of_a_constant_surrounding_is_that_constant(shape):
    color = np.array([0.25, 1.0, 3.0])
    found = irradiance_over_pi(np.broadcast_to(color, (*shape, 3)).astype(float))
    np.testing.assert_allclose(found, np.broadcast_to(color, found.shape), rtol=SUM_TOL)


def test_the_irradiance_under_a_white_sky_goes_with_the_height_of_the_normal():
    sky = np.zeros((64, 128, 3))
    sky[:32] = 1.0
    found = irradiance_over_pi(sky)
    directions, _ = latlong_directions(*found.shape[:2])
    # Of a half-space seen at an angle: (1 + cos) / 2.
    np.testing.assert_allclose(found[..., 0], (1.0 + directions[..., 1]) / 2.0, rtol=0.0, atol=COARSE_TOL)


@pytest.mark.parametrize("axis", [(1, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0)])
def test_a_spot_lights_most_what_faces_it(axis):
    directions, _ = latlong_directions(32, 64)
    spot = np.where(directions @ np.array(axis, dtype=float) > 0.98, 1.0, 0.0)[..., None] * np.ones(3)
    found = irradiance_over_pi(spot)[..., 0]
    targets, _ = latlong_directions(*found.shape)
    brightest = targets.reshape(-1, 3)[np.argmax(found)]
    assert brightest @ np.array(axis, dtype=float) > 0.98
    assert np.all(found[targets @ np.array(axis, dtype=float) < -0.25] == 0.0)


def test_the_solid_angles_of_the_pixels_are_those_of_the_sphere():
    _, solid_angle = latlong_directions(64, 128)
    # The midpoint rule in latitude is off by (pi / 64)^2 / 24.
    assert np.sum(solid_angle) == pytest.approx(4.0 * np.pi, rel=1.1 * (np.pi / 64) ** 2 / 24)


def test_directions_are_unit_with_up_in_the_first_row_and_ahead_in_the_middle():
    directions, _ = latlong_directions(64, 128)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=2), 1.0, rtol=0.0, atol=8 * 2.0**-53)
    step = np.pi / 64  # between two pixels
    for (row, column), axis in {
        (0, 0): (0, 1, 0),
        (63, 0): (0, -1, 0),
        (32, 64): (0, 0, -1),
        (32, 96): (1, 0, 0),
        (32, 32): (-1, 0, 0),
        (32, 0): (0, 0, 1),
    }.items():
        assert np.arccos(directions[row, column] @ np.array(axis, dtype=float)) < step


@pytest.mark.parametrize("shape", [(1, 2), (5, 9), (32, 64)])
def test_looking_into_a_pixels_direction_gives_that_pixel(rng, shape):
    image = rng.random((*shape, 3))
    directions, _ = latlong_directions(*shape)
    found = look_up(image, directions.reshape(-1, 3))
    assert np.array_equal(found, image.reshape(-1, 3))
    # Anti-vacuity: the image upside down, and its mirror image, are others.
    if shape[0] > 1:
        assert not np.array_equal(look_up(image[::-1], directions.reshape(-1, 3)), image.reshape(-1, 3))
    assert not np.array_equal(look_up(image[:, ::-1], directions.reshape(-1, 3)), image.reshape(-1, 3))


@pytest.mark.parametrize(
    ("direction", "row", "columns"),
    [
        ((0.0, 1.0, 0.0), 0, range(8)),  # at the poles every column is as good
        ((0.0, 1.0 + 1e-9, 0.0), 0, range(8)),
        ((0.0, -1.0, 0.0), 3, range(8)),
        ((0.0, 1e-9, 1.0), 1, (0, 7)),  # at the seam the two next to it
        ((-0.0, 1e-9, 1.0), 1, (0, 7)),
    ],
)
def test_straight_up_down_and_behind_are_in_the_image(direction, row, columns):
    image = np.arange(4 * 8 * 3, dtype=float).reshape(4, 8, 3)
    found = look_up(image, np.array([direction]))[0]
    assert found.tolist() in [image[row, column].tolist() for column in columns]


@pytest.mark.parametrize(("channels", "expected"), [(1, [0, 0, 0]), (2, [0, 0, 0]), (3, [0, 1, 2]), (4, [0, 1, 2])])
def test_grey_images_and_images_with_alpha_become_three_channels(rng, channels, expected):
    image = rng.random((8, 16, channels))
    found = environment(image, 4)
    assert np.array_equal(found.radiance, image[..., expected])
    assert found.irradiance.shape == (32, 64, 3)
    assert found.samples == 4
