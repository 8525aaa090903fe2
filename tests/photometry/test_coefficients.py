"""R_A, R_L and the retroreflected fraction, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick, Lambert
from mrm_mtlx.bsdf.ggx import distribution
from mrm_mtlx.bsdf.vectors import dot
from mrm_mtlx.photometry import coefficient, goniometer, r_l, retroreflected_fraction
from mrm_mtlx.photometry.coefficients import MARKING_ENTRANCE, MARKING_OBSERVATION, marking_geometry

# Relative, of what has a closed form: far below what is measured; products of cosines are a thousand times better.
CLOSED_FORM = 1e-9
# Relative, of a lobe of width ALPHA, whose facets take the differences of nearly equal directions: a rounding moves the
# facet by some 2e-16, a share 2e-16 / ALPHA of the lobe, and D by four times that.
ALPHA = 0.004
LOBE = 1e-12

WHITE = Lambert(1.0).eval


def grid():
    """Observation, beta1 and beta2 [rad] of classes, (...) each: up to the middle of what is sold."""
    angles = np.meshgrid([0.0, 0.1, 0.2, 0.5, 2.0], [-4.0, 0.0, 5.0, 30.0, 45.0], [0.0, 20.0], indexing="ij")
    return [np.deg2rad(angle) for angle in angles]


def test_a_diffuser_has_one_over_pi_times_both_cosines():
    observation, beta1, beta2 = grid()
    expected = np.cos(beta1) * np.cos(beta2) ** 2 * np.cos(beta1 - observation) / np.pi
    found = coefficient(WHITE, observation, beta1, beta2)
    np.testing.assert_allclose(found, np.repeat(expected[..., None], 3, axis=-1), rtol=CLOSED_FORM)


def test_a_white_diffuser_has_0_318_at_normal_incidence_and_6_9_mcd_in_the_geometry_of_markings():
    assert round(float(coefficient(WHITE, 0.0, 0.0)[0]), 3) == 0.318
    assert round(float(r_l(WHITE)[0]), 1) == 6.9
    assert round(float(r_l(WHITE, *marking_geometry())[0]), 2) == 6.90


def ideal_lobe(v, l):
    """A retroreflective lobe without masking: f = F D / (4 n.v n.l), F = 1."""
    b = v * [-1.0, -1.0, 1.0] + l
    b = b / np.sqrt(dot(b, b))[..., None]
    d = distribution(*np.moveaxis(b, -1, 0), ALPHA, ALPHA)
    return np.repeat((d / (4.0 * v[..., 2] * l[..., 2]))[..., None], 3, axis=-1)


def test_an_ideal_lobe_has_a_quarter_of_its_distribution():
    """R_A = F D G / 4, at the back-vector's angle: tan(theta_b) = tan(observation / 2) in one plane."""
    observation, beta1, _ = grid()
    slope = np.tan(0.5 * observation)
    d = 1.0 / (np.pi * ALPHA**2 * (1.0 + (slope / ALPHA) ** 2) ** 2 * np.cos(0.5 * observation) ** 4)
    found = coefficient(ideal_lobe, observation, beta1)[..., 0]
    np.testing.assert_allclose(found, 0.25 * d, rtol=CLOSED_FORM)


def test_a_public_lobe_has_the_same_with_its_masking():
    """Out of the plane too: theta_b is observation / (2 cos(beta2)) there, to first order."""
    lobe = GeneralizedSchlick(0.1, 1.0, 0.1, alpha=(ALPHA, ALPHA), retroreflective=True)
    peak = coefficient(lobe.eval, 0.0, 0.0)[0]
    # No masking along the normal.
    np.testing.assert_allclose(peak, 0.1 / (4.0 * np.pi * ALPHA**2), rtol=LOBE)
    observation, beta2 = np.deg2rad(0.2), np.deg2rad(60.0)
    turned = coefficient(lobe.eval, observation, 0.0, beta2)[0]
    plain = coefficient(lobe.eval, 2.0 * observation, 0.0)[0]
    # Masking at 60 degrees takes about alpha^2 tan^2 / 2 = 2e-5; second order in the angle, 1e-5, is as large.
    np.testing.assert_allclose(turned, plain, rtol=1e-4)


def test_r_a_is_symmetric_in_source_and_receiver(rng):
    """The geometry that exchanges v and l: beta1 becomes observation - beta1, the sample turns by half a turn."""
    lobe = GeneralizedSchlick(0.1, 1.0, 0.3, alpha=(0.1, 0.2), retroreflective=True)
    observation, beta1, beta2 = rng.uniform([[0.01], [-1.0], [-1.0]], [[0.5], [1.0], [1.0]], (3, 100))
    epsilon = rng.uniform(-np.pi, np.pi, 100)
    v, l = goniometer.directions(observation, beta1, beta2, epsilon)
    plain = coefficient(lobe.eval, observation, beta1, beta2, epsilon)
    np.testing.assert_allclose(plain, coefficient(lobe.eval, *goniometer.angles(l, v)), rtol=CLOSED_FORM)


def test_r_l_is_r_a_over_the_cosine_of_the_viewer_in_thousandths():
    v, _ = goniometer.directions(MARKING_OBSERVATION, MARKING_ENTRANCE)
    r_a = coefficient(WHITE, MARKING_OBSERVATION, MARKING_ENTRANCE)
    np.testing.assert_allclose(r_l(WHITE), 1000.0 * r_a / v[2], rtol=CLOSED_FORM)


def test_below_the_surface_nothing_is_read_and_nothing_is_asked_of_the_brdf():
    def picky(v, l):
        assert np.all(v[..., 2] > 0.0)
        assert np.all(l[..., 2] > 0.0)
        return np.ones((*v.shape[:-1], 3))

    beta1 = np.deg2rad([-89.9, 89.9, 95.0])
    found = coefficient(picky, np.deg2rad(1.0), beta1)[:, 0]
    np.testing.assert_array_equal(found > 0.0, [False, True, False])


@pytest.mark.parametrize(("source", "receiver"), [(0.2, 0.0), (0.0, 0.2), (1.0, 3.0)])
def test_discs_of_a_diffuser_lower_it_as_the_mean_of_a_cap(source, receiver):
    """The mean direction of a cap of half-angle r is its axis times (1 + cos r) / 2."""
    observation, beta1, beta2 = grid()
    apertures = np.deg2rad([source, receiver])
    found = coefficient(WHITE, observation, beta1, beta2, source_aperture=apertures[0], receiver_aperture=apertures[1])
    shares = 0.5 * (1.0 + np.cos(0.5 * apertures))
    np.testing.assert_allclose(found, coefficient(WHITE, observation, beta1, beta2) * np.prod(shares), rtol=CLOSED_FORM)


def by_observation(width):
    """BRDF whose R_A is 1 / (width^2 + 2 (1 - cos(observation))), a lobe with tails."""

    def brdf(v, l):
        apart = v - l
        value = 1.0 / ((width**2 + dot(apart, apart)) * v[..., 2] * l[..., 2])
        return np.repeat(value[..., None], 3, axis=-1)

    return brdf


@pytest.mark.parametrize("source", [False, True])
def test_a_disc_about_the_peak_of_a_lobe_reads_its_mean(source):
    """Of 1 / (w^2 + 2 u) over a cap of depth d = 1 - cos r: ln(1 + 2 d / w^2) / (2 d)."""
    aperture = np.deg2rad(0.2)
    depth = 2.0 * np.sin(0.25 * aperture) ** 2
    options = {"source_aperture": aperture} if source else {"receiver_aperture": aperture}
    found = coefficient(by_observation(2.0 * ALPHA), 0.0, np.deg2rad(5.0), **options)
    np.testing.assert_allclose(found, np.log1p(2.0 * depth / (2.0 * ALPHA) ** 2) / (2.0 * depth), rtol=CLOSED_FORM)


@pytest.mark.parametrize("diameter_deg", [0.05, 0.2])
def test_a_disc_about_the_peak_of_an_ideal_lobe_reads_its_mean(diameter_deg):
    """Of D / 4 along the normal, D = a^2 / (pi (a^2 + (1 - a^2) u / 2)^2), over u = 1 - cos(observation) up to d."""
    aperture = np.deg2rad(diameter_deg)
    depth = 2.0 * np.sin(0.25 * aperture) ** 2
    expected = 0.25 / (np.pi * (ALPHA**2 + (1.0 - ALPHA**2) * 0.5 * depth))
    found = coefficient(ideal_lobe, 0.0, 0.0, receiver_aperture=aperture)
    np.testing.assert_allclose(found, expected, rtol=CLOSED_FORM)
    assert coefficient(ideal_lobe, 0.0, 0.0)[0] > 1.001 * expected  # a point reads more


def test_a_disc_beside_the_peak_reads_the_mean_of_many_points():
    """Against plain sums over a fine grid of the flat disc."""
    observation, aperture = np.deg2rad(0.2), np.deg2rad(0.2)
    found = coefficient(by_observation(2.0 * ALPHA), observation, 0.0, receiver_aperture=aperture)[0]
    radius, phi = np.meshgrid(
        np.sqrt((np.arange(400) + 0.5) / 400) * aperture / 2, 2 * np.pi * np.arange(256) / 256, indexing="ij"
    )
    squared = observation**2 + radius**2 + 2.0 * observation * radius * np.cos(phi)
    # The midpoint rule is off by its step squared over 24, 3e-7; flat instead of round by the angle's square, 1e-5.
    np.testing.assert_allclose(found, np.mean(1.0 / ((2.0 * ALPHA) ** 2 + squared)), rtol=2e-5)
    # A point reads another value: this is not a comparison of two points.
    assert abs(found / coefficient(by_observation(2.0 * ALPHA), observation, 0.0)[0] - 1.0) > 1e-3


def test_a_disc_of_the_source_and_one_of_the_receiver_do_the_same():
    both = [
        coefficient(ideal_lobe, np.deg2rad(0.2), np.deg2rad(5.0), **{name: np.deg2rad(0.2)})[0]
        for name in ("source_aperture", "receiver_aperture")
    ]
    # Exchanged, they stand at 5 and 4.8 degrees: an ideal lobe tells no difference beyond the angle's square.
    np.testing.assert_allclose(both[0], both[1], rtol=1e-4)


@pytest.mark.parametrize("name", ["source_aperture", "receiver_aperture"])
@pytest.mark.parametrize("size", [-0.1, np.pi, np.nan])
def test_a_disc_that_cannot_be_is_refused(name, size):
    with pytest.raises(ValueError, match=rf"{name} must be in \[0, pi\), got"):
        coefficient(WHITE, 0.0, 0.0, **{name: size})


@pytest.mark.parametrize("alpha", [0.0025, 0.02])
def test_a_lobe_returns_the_fraction_of_its_closed_form(alpha):
    """F t^2 / (alpha^2 + t^2), t = tan(within / 2), near the normal."""
    lobe = GeneralizedSchlick(0.3, 1.0, 0.3, alpha=(alpha, alpha), retroreflective=True)
    within = np.deg2rad([0.2, 0.5, 2.0])
    found = [retroreflected_fraction(lobe.eval, 0.0, within=angle)[0] for angle in within]
    slope = np.tan(0.5 * within)
    # Masking of the tail, about alpha^2 theta^2, is below 1e-6 here; the rule is a hundred times better.
    np.testing.assert_allclose(found, 0.3 * slope**2 / (alpha**2 + slope**2), rtol=1e-6)


def test_a_diffuser_returns_the_squared_sine_of_the_cone():
    """At normal incidence; obliquely the mean cosine of the cone takes the place of the normal's."""
    within, beta1 = np.deg2rad([2.0, 30.0, 90.0]), np.deg2rad(40.0)
    straight = [retroreflected_fraction(WHITE, 0.0, within=angle)[0] for angle in within]
    np.testing.assert_allclose(straight, np.sin(within) ** 2, rtol=CLOSED_FORM)
    oblique = [retroreflected_fraction(WHITE, beta1, within=angle)[0] for angle in within[:2]]
    np.testing.assert_allclose(oblique, np.cos(beta1) * np.sin(within[:2]) ** 2, rtol=CLOSED_FORM)


@pytest.mark.parametrize("within", [0.0, 2.0, np.nan])
def test_a_cone_that_cannot_be_is_refused(within):
    with pytest.raises(ValueError, match="within must be in"):
        retroreflected_fraction(WHITE, 0.0, within=within)


@pytest.mark.parametrize(("of_v", "of_l"), [(0, 1), (1, 0), (0, 0)])
def test_a_cosine_that_is_left_out_is_seen(of_v, of_l):
    observation, beta1, beta2 = grid()
    v, l = goniometer.directions(observation, beta1, beta2)
    wrong = v[..., 2] ** of_v * l[..., 2] ** of_l / np.pi
    assert np.max(np.abs(wrong / coefficient(WHITE, observation, beta1, beta2)[..., 0] - 1.0)) > 0.3


def test_a_halved_observation_is_seen_in_a_lobe():
    observation, beta1, _ = grid()
    moved = coefficient(ideal_lobe, 0.5 * observation, beta1) / coefficient(ideal_lobe, observation, beta1)
    assert np.max(moved) > 2.0


def test_the_wrong_sign_of_beta1_is_seen_where_the_cosines_are_steep():
    observation, beta1 = np.deg2rad(1.0), np.deg2rad(45.0)
    wrong = coefficient(WHITE, observation, -beta1)[0] / coefficient(WHITE, observation, beta1)[0]
    np.testing.assert_allclose(wrong, np.cos(beta1 + observation) / np.cos(beta1 - observation), rtol=CLOSED_FORM)
    assert abs(wrong - 1.0) > 0.03
