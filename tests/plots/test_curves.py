"""Curves: the right value at the right angle, with its sign, and no peak missed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx import bsdf
from mrm_mtlx.plots.curves import LARGEST, LUMINANCE, directions, lobe_curve, luminance, view_angles

LIGHTS_DEG = (0.0, 30.0, 80.0)


def white(alpha: float, **options: object) -> bsdf.GeneralizedSchlick:
    """A lobe that reflects everything."""
    return bsdf.GeneralizedSchlick(alpha=(alpha, alpha), **options)


@pytest.mark.parametrize("degrees", LIGHTS_DEG)
def test_view_angles_ascend_over_the_half_circle_and_hold_both_peaks(degrees):
    theta_l = float(np.deg2rad(degrees))
    angles = view_angles(theta_l)
    assert (angles[0], angles[-1]) == (-LARGEST, LARGEST)
    steps = np.diff(angles)
    assert steps.min() > 0.0
    # Half a degree, but for what the sum of many steps rounds.
    assert steps.max() <= np.deg2rad(0.5) * (1.0 + 1e-12)
    assert {theta_l, -theta_l} <= set(angles.tolist())
    assert len(angles) < 1200  # small enough for a picture in a document


@pytest.mark.parametrize("azimuth_deg", [0.0, 45.0, -120.0, 180.0])
@pytest.mark.parametrize("degrees", LIGHTS_DEG)
@pytest.mark.parametrize("retroreflective", [False, True])
def test_a_curve_has_the_values_of_the_lobe(is_the_curve_of, degrees, azimuth_deg, retroreflective):
    lobe = bsdf.Conductor(
        (0.2, 0.9, 1.1), (3.9, 2.5, 2.2), alpha=(0.1, 0.3), retroreflective=retroreflective
    )  # anisotropic and coloured: nothing is equal by symmetry
    azimuth = np.deg2rad(azimuth_deg)
    curve = lobe_curve("metal", "", lobe, np.deg2rad(degrees), azimuth)
    assert is_the_curve_of(curve, lobe.eval, azimuth)


DAMAGE = {
    "shifted by a degree": lambda c: replace(c, theta_v=c.theta_v + np.deg2rad(1.0)),
    "the other sign": lambda c: replace(c, theta_v=-c.theta_v),
    "light elsewhere": lambda c: replace(c, theta_l=c.theta_l + np.deg2rad(1.0)),
    "with the cosine": lambda c: replace(c, value=c.value * np.cos(c.theta_l)),
    "scaled": lambda c: replace(c, value=c.value * (1.0 + 1e-6)),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_curve_is_seen(is_the_curve_of, damage):
    lobe = white(0.1, retroreflective=True)
    curve = lobe_curve("white", "", lobe, 0.5)
    assert is_the_curve_of(curve, lobe.eval)
    assert not is_the_curve_of(DAMAGE[damage](curve), lobe.eval)


def test_a_wrong_azimuth_is_seen(is_the_curve_of):
    lobe = white(0.3)
    assert not is_the_curve_of(lobe_curve("white", "", lobe, 0.5, 0.3), lobe.eval, -0.3 + 0.61)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alpha", [2.5e-5, 0.0025, 0.1])
@pytest.mark.parametrize("degrees", [0.0, 33.3, 60.0])
@pytest.mark.parametrize("retroreflective", [False, True])
def test_the_peak_is_where_the_lobe_has_it_however_narrow(distribution, alpha, degrees, retroreflective):
    theta_l = np.deg2rad(degrees)
    curve = lobe_curve("white", "", white(alpha, distribution=distribution, retroreflective=retroreflective), theta_l)
    found = curve.theta_v[curve.value.argmax()]
    # What masking, cosines and Jacobian shift a peak by is of second order in its width; 2 alpha is a width in angles.
    assert abs(found - (theta_l if retroreflective else -theta_l)) <= 1e-9 + 4.0 * alpha**2
    # D(n) / (4 cos^2 theta), masking left out: for these widths and angles it takes less than 2 %, and the shift
    # raises the highest value by no more.
    peak = 1.0 / (4.0 * np.pi * alpha**2 * np.cos(theta_l) ** 2)
    assert curve.value.max() == pytest.approx(peak, rel=0.04)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
@pytest.mark.parametrize("alpha", [2.5e-5, 0.0025, 0.1, 1.0])
def test_between_its_samples_a_curve_is_nearly_straight(distribution, alpha, rng):
    lobe = white(alpha, distribution=distribution, retroreflective=True)
    theta_l = 0.6
    curve = lobe_curve("white", "", lobe, theta_l)
    anywhere = theta_l + np.concatenate([rng.uniform(-20.0, 20.0, 500) * alpha, rng.uniform(-2.1, 0.9, 500)])
    anywhere = anywhere[np.abs(anywhere) < LARGEST]
    exact = luminance(lobe.eval(directions(anywhere), directions(theta_l)))
    drawn = np.interp(anywhere, curve.theta_v, curve.value)
    # A step of 24 to a decade is 10 % of the distance from the peak; a parabola leaves its chord by an eighth of the
    # squared step times its curvature, at most 0.4 % of the peak for both distributions. A picture has 1,000 pixels.
    assert np.max(np.abs(drawn - exact)) < 0.004 * curve.value.max()


def test_an_even_grid_would_miss_a_narrow_peak():
    lobe = white(0.0025, retroreflective=True)
    even = np.arange(-LARGEST, LARGEST, np.deg2rad(0.5))
    seen = luminance(lobe.eval(directions(even), directions(0.6)))
    assert seen.max() < 0.5 * lobe_curve("white", "", lobe, 0.6).value.max()


def test_ordinary_and_retroreflective_are_mirror_images():
    ordinary, retro = (lobe_curve("", "", white(0.2, retroreflective=flag), 0.7) for flag in (False, True))
    np.testing.assert_array_equal(ordinary.theta_v, -ordinary.theta_v[::-1])
    # Roundings of the two half-vectors.
    np.testing.assert_allclose(ordinary.value, retro.value[::-1], rtol=1e-12)


def test_a_grey_keeps_its_value_and_green_weighs_most():
    assert luminance(np.full((4, 3), 0.7)) == pytest.approx(0.7, rel=1e-15)
    weights = luminance(np.eye(3))
    np.testing.assert_array_equal(weights, LUMINANCE)
    assert weights.argmax() == 1
