"""Angles of the goniometer to directions and back, held against a construction from the definitions."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf.vectors import dot
from mrm_mtlx.photometry import goniometer

COUNT = 2000
# Absolute [rad] or of components: some ten roundings of 1.1e-16 in numbers up to 1, here and in what is expected.
TOLERANCE = 4e-15


@pytest.fixture
def geometry(rng):
    """Observation, beta1, beta2 and epsilon [rad]: from narrow to wide, all turns."""
    observation = np.exp(rng.uniform(np.log(1e-3), np.log(1.5), COUNT))
    beta1, beta2 = rng.uniform(-1.55, 1.55, (2, COUNT))
    return observation, beta1, beta2, rng.uniform(-np.pi, np.pi, COUNT)


def constructed(observation, beta1, beta2, epsilon):
    """v and l built in the laboratory's frame (z = l, x towards v, y = the first axis), then read in the sample's."""
    zero = np.zeros_like(observation)
    l = np.stack([zero, zero, zero + 1.0], axis=-1)
    v = np.stack([np.sin(observation), zero, np.cos(observation)], axis=-1)
    n = np.stack([np.sin(beta1) * np.cos(beta2), np.sin(beta2), np.cos(beta1) * np.cos(beta2)], axis=-1)
    e2 = np.stack([np.cos(beta1), zero, -np.sin(beta1)], axis=-1)
    m = np.cross(n, e2)
    t = np.cos(epsilon)[:, None] * e2 + np.sin(epsilon)[:, None] * m
    frame = np.stack([t, np.cross(n, t), n], axis=1)
    return np.einsum("kij,kj->ki", frame, v), np.einsum("kij,kj->ki", frame, l)


def difference(a, b):
    """Largest distance of two angles on the circle."""
    return np.max(np.abs(np.angle(np.exp(1j * (a - b)))))


def test_directions_are_those_of_the_construction(geometry):
    for found, expected in zip(goniometer.directions(*geometry), constructed(*geometry), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=TOLERANCE)


def test_angles_are_those_the_directions_were_made_of(geometry):
    # What v - l has lost of its digits, and once more where the first axis is steep (beta2 near 90 degrees).
    lost = TOLERANCE / geometry[0] / np.cos(geometry[2])
    for found, given in zip(goniometer.angles(*goniometer.directions(*geometry)), geometry, strict=True):
        assert np.all(np.abs(np.angle(np.exp(1j * (found - given)))) <= lost)


def test_directions_come_back_from_their_angles(rng, direction_pairs):
    v, l = direction_pairs(rng, COUNT)
    again_v, again_l = goniometer.directions(*goniometer.angles(v, l))
    # Angles of pairs that are nearly the same are uncertain together: what they say of directions is not.
    np.testing.assert_allclose(again_v, v, rtol=0.0, atol=10 * TOLERANCE)
    np.testing.assert_allclose(again_l, l, rtol=0.0, atol=10 * TOLERANCE)


def test_identities_of_the_cosines_hold(geometry):
    observation, beta1, beta2, _ = geometry
    v, l = goniometer.directions(*geometry)
    np.testing.assert_allclose(l[:, 2], np.cos(beta1) * np.cos(beta2), rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(v[:, 2], np.cos(beta2) * np.cos(beta1 - observation), rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(dot(l, v), np.cos(observation), rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(dot(l, l), 1.0, rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(dot(v, v), 1.0, rtol=0.0, atol=TOLERANCE)


def test_without_observation_v_is_l_to_the_last_digit(geometry):
    v, l = goniometer.directions(0.0, *geometry[1:])
    np.testing.assert_array_equal(v, l)


def test_in_one_plane_the_viewer_stands_at_the_difference_of_the_angles():
    v, l = goniometer.directions(np.deg2rad(0.2), np.deg2rad([-4.0, 4.0]))
    polar = np.rad2deg(np.arccos([v[:, 2], l[:, 2]]))
    # Degrees; an arccosine this close to 0 loses a digit and a half.
    np.testing.assert_allclose(polar, [[4.2, 3.8], [4.0, 4.0]], rtol=0.0, atol=1e-12)
    # 8.2 and 7.8 degrees from the mirror ray.
    mirrored = l * np.array([-1.0, -1.0, 1.0])
    np.testing.assert_allclose(np.rad2deg(np.arccos(dot(v, mirrored))), [8.2, 7.8], rtol=0.0, atol=1e-12)


def test_a_positive_beta1_puts_the_viewer_between_the_light_and_the_normal():
    """16 CFR 1512.18(o)."""
    v, l = goniometer.directions(0.1, 0.5)
    assert v[2] > l[2]
    assert goniometer.directions(0.1, -0.5)[0][2] < l[2]


def test_the_20_degrees_of_a_reflector_up_5_and_left_20_are_20_59_in_all():
    """UN R3, classes IA to IIIB; the printed digits."""
    found = np.rad2deg(goniometer.entrance(np.deg2rad(5.0), np.deg2rad(20.0)))
    assert round(float(found), 2) == 20.59


def test_application_angles_come_back(geometry):
    _, beta1, beta2, epsilon = geometry
    again = goniometer.from_application(*goniometer.to_application(beta1, beta2, epsilon))
    # Once more, as the inverse divides by the sine of beta, and by that of 90 degrees less beta2.
    lost = 10 * TOLERANCE / np.min(np.abs(np.sin(goniometer.entrance(beta1, beta2)))) / np.min(np.cos(beta2))
    for found, given in zip(again, (beta1, beta2, epsilon), strict=True):
        assert difference(found, given) <= lost


def test_application_angles_obey_their_definitions(geometry):
    _, beta1, beta2, epsilon = geometry
    beta, gamma, omega_s = goniometer.to_application(beta1, beta2, epsilon)
    np.testing.assert_allclose(np.cos(beta), np.cos(beta1) * np.cos(beta2), rtol=0.0, atol=TOLERANCE)
    np.testing.assert_allclose(np.sin(beta2), -np.sin(beta) * np.sin(gamma), rtol=0.0, atol=TOLERANCE)
    # tan(beta1) = tan(beta) cos(gamma), without the poles.
    left, right = np.sin(beta1) * np.cos(beta), np.cos(beta1) * np.sin(beta) * np.cos(gamma)
    np.testing.assert_allclose(left, right, rtol=0.0, atol=TOLERANCE)
    # omega_s goes from the trace of the entrance half-plane, -l without its part along n, to t, which is x here.
    _, l = goniometer.directions(0.1, beta1, beta2, epsilon)
    trace = np.arctan2(-l[:, 1], -l[:, 0])
    assert difference(omega_s, -trace) <= TOLERANCE / np.min(np.abs(np.sin(beta)))


def test_the_other_choice_of_signs_is_the_mirror_image(geometry):
    observation, beta1, beta2, epsilon = geometry
    plain, other = goniometer.directions(*geometry), goniometer.directions(*geometry, mirrored=True)
    for a, b in zip(plain, other, strict=True):
        np.testing.assert_array_equal(a * [1.0, -1.0, 1.0], b)
    # ... which turns over beta2 and epsilon together.
    turned = goniometer.directions(observation, beta1, -beta2, -epsilon)
    np.testing.assert_allclose(other, turned, rtol=0.0, atol=TOLERANCE)
    again = goniometer.angles(*other, mirrored=True)
    np.testing.assert_allclose(goniometer.directions(*again, mirrored=True), other, rtol=0.0, atol=10 * TOLERANCE)


def test_where_the_observation_plane_is_not_given_it_is_that_of_the_normal(polar):
    l = polar([0.0, 0.7], [0.0, -2.0])
    observation, beta1, beta2, epsilon = goniometer.angles(l, l)
    np.testing.assert_allclose(observation, 0.0, atol=TOLERANCE)
    np.testing.assert_allclose(beta1, [0.0, 0.7], atol=TOLERANCE)
    np.testing.assert_allclose(beta2, 0.0, atol=TOLERANCE)
    assert epsilon[0] == 0.0
    np.testing.assert_allclose(goniometer.directions(observation, beta1, beta2, epsilon)[1], l, atol=TOLERANCE)


def wrong_sign_of_beta1(observation, beta1, beta2, epsilon):
    return goniometer.directions(observation, -beta1, beta2, epsilon)


def halved_observation(observation, beta1, beta2, epsilon):
    return goniometer.directions(0.5 * observation, beta1, beta2, epsilon)


def second_axis_in_the_wrong_place(observation, beta1, beta2, epsilon):
    return goniometer.directions(observation, beta1, beta2, epsilon + np.pi / 2)


@pytest.mark.parametrize("wrong", [wrong_sign_of_beta1, halved_observation, second_axis_in_the_wrong_place])
def test_a_wrong_goniometer_is_seen(geometry, wrong):
    assert np.max(np.abs(np.subtract(wrong(*geometry), constructed(*geometry)))) > 0.1
