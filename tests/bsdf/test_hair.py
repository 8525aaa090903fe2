"""The factors of the hair model: each is a share of the light, or a distribution of it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mrm_mtlx.bsdf import hair

EPS = np.finfo(float).eps
FORMULA_TOL = 64 * EPS


@cache
def angles() -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights over [-pi / 2, pi / 2]: six per deviation of the narrowest lobe tried."""
    x, w = np.polynomial.legendre.leggauss(400)
    return 0.5 * np.pi * x, 0.5 * np.pi * w


# Relative. Ten terms of the series leave out (x/2)^20 / (10!)^2 and less; relative to I0, that is as stated.
@pytest.mark.parametrize(("x", "error"), [(0.0, EPS), (2.0, 1e-13), (5.0, 3e-7), (8.0, 2.4e-4), (12.0, 0.021)])
def test_the_series_of_the_bessel_function_is_as_good_as_ten_terms(x, error):
    assert hair.bessel_i0(x) == pytest.approx(float(np.i0(x)), rel=error)
    assert hair.bessel_i0(-x) == hair.bessel_i0(x)
    if x >= 5.0:
        assert hair.bessel_i0(x) != pytest.approx(float(np.i0(x)), rel=0.1 * error)


def test_the_logarithm_of_the_bessel_function_is_good_to_two_percent():
    x = np.concatenate([np.linspace(0.0, 30.0, 301), np.linspace(30.0, 600.0, 58)])
    error = np.abs(np.expm1(hair.log_bessel_i0(x) - np.log(np.i0(x))))
    assert 0.01 < np.max(error) < 0.021
    # Half of the asymptotic series' second term is missing: 1 / (16 x).
    assert error[-1] == pytest.approx(1.0 / (16.0 * 600.0), rel=0.01)


def test_the_logarithm_of_the_bessel_function_steps_where_the_series_change():
    steps = [hair.log_bessel_i0(12.0, switch=switch) for switch in (11.0, 13.0)]
    assert np.expm1(steps[0] - steps[1]) == pytest.approx(0.0148, abs=5e-4)


# Absolute. The integral is 1 but for the error of the Bessel function (measured: 0.7 % at most) and, below 0.1, for
# ln 2 = 0.6931 (5e-5).
NORMALISED = {0.002: 1.1e-3, 0.02: 2.4e-3, 0.05: 6.1e-3, 0.09: 7.2e-3, 0.1: 2.3e-3, 0.3: 2e-10, 1.0: 1e-13}


@pytest.mark.parametrize(("variance", "error"), NORMALISED.items())
@pytest.mark.parametrize("theta_o", [0.0, -0.7, 1.2])
def test_the_longitudinal_scattering_is_normalised(variance, error, theta_o):
    theta_i, weight = angles()
    m = hair.longitudinal(np.sin(theta_i), np.cos(theta_i), np.sin(theta_o), np.cos(theta_o), variance)
    assert np.sum(m * np.cos(theta_i) * weight) == pytest.approx(1.0, abs=error)


def test_the_longitudinal_scattering_peaks_at_the_mirrored_angle():
    theta_i, _ = angles()
    m = hair.longitudinal(np.sin(theta_i), np.cos(theta_i), np.sin(0.4), np.cos(0.4), 0.003)
    assert theta_i[np.argmax(m)] == pytest.approx(-0.4, abs=0.01)


def test_the_two_forms_of_the_longitudinal_scattering_differ_by_the_digits_of_ln_2(rng):
    theta_i, theta_o = rng.uniform(-1.5, 1.5, (2, 200))
    at = np.sin(theta_i), np.cos(theta_i), np.sin(theta_o), np.cos(theta_o), 0.1
    narrow, rough = (hair.longitudinal(*at, variance_switch=switch) for switch in (0.2, 0.05))
    # exp(0.6931) / 2 and 1 - exp(-2 / v): -4.7e-5.
    np.testing.assert_allclose(narrow / rough, 0.5 * np.exp(0.6931) * (1.0 - np.exp(-20.0)), rtol=1e-12)


@pytest.mark.parametrize("scale", [0.001, 0.03, 0.3, 1.0])
def test_the_azimuthal_scattering_is_normalised_and_periodic(scale, rng):
    x, w = np.polynomial.legendre.leggauss(200)
    # Exponentially finer towards the peak at 0, on both sides.
    t = 0.5 * (x + 1.0)
    phi = scale * np.sinh(t * np.arcsinh(np.pi / scale))
    weight = 0.5 * w * scale * np.cosh(t * np.arcsinh(np.pi / scale)) * np.arcsinh(np.pi / scale)
    assert 2.0 * np.sum(hair.azimuthal(phi, scale) * weight) == pytest.approx(1.0, rel=1e-9)
    turned = rng.uniform(-3.0, 3.0, 50)
    expected = hair.azimuthal(turned, scale)
    # The exponent's own rounding: phi / scale of it.
    error = 8 * EPS * (1.0 + 10.0 / scale)
    for turns in (-2, 1, 3):
        np.testing.assert_allclose(hair.azimuthal(turned + 2.0 * np.pi * turns, scale), expected, rtol=3 * error)
    np.testing.assert_allclose(hair.azimuthal(-turned, scale), expected, rtol=3 * error)


def test_the_deviation_of_the_azimuthal_scattering_is_its_scale():
    # sqrt(pi / 8) makes the logistic's peak that of a normal distribution: 1 / (4 s sqrt(pi / 8)) = 1 / (s sqrt(2 pi)).
    assert hair.azimuthal(0.0, 0.05) == pytest.approx(1.0 / (0.05 * np.sqrt(2.0 * np.pi)), rel=1e-9)


def test_paths_leave_where_geometry_sends_them():
    # Straight through the middle: back, on, back.
    assert [float(hair.exit_azimuth(p, 0.0, 0.0)) for p in range(3)] == [0.0, np.pi, 2.0 * np.pi]
    # Reflected off the side at 30 degrees: turned by twice that; without refraction, straight on.
    assert hair.exit_azimuth(0, np.pi / 6.0, 0.1) == pytest.approx(-np.pi / 3.0, rel=FORMULA_TOL)
    assert hair.exit_azimuth(1, 0.4, 0.4) == pytest.approx(np.pi, rel=FORMULA_TOL)


def test_without_absorption_the_paths_share_all_light(rng):
    f = rng.uniform(0.0, 1.0, 100)
    paths = hair.attenuations(f, 1.0)
    np.testing.assert_allclose(sum(paths), 1.0, rtol=FORMULA_TOL)
    assert np.all(sum(paths[:3]) < 1.0)
    assert [float(a) for a in hair.attenuations(1.0, 1.0)] == [1.0, 0.0, 0.0, 0.0]


def test_the_last_path_stands_for_all_further_reflections(rng):
    f, t = rng.uniform(0.05, 0.9, 50), rng.uniform(0.0, 0.9, 50)
    paths = hair.attenuations(f, t)
    series = sum((1.0 - f) ** 2 * t**p * f ** (p - 1) for p in range(3, 200))
    np.testing.assert_allclose(paths[3], series, rtol=1e-9)
    np.testing.assert_allclose(paths[1], (1.0 - f) ** 2 * t, rtol=FORMULA_TOL)
    np.testing.assert_allclose(paths[2], (1.0 - f) ** 2 * t * t * f, rtol=FORMULA_TOL)


def test_the_factors_together_return_all_light_of_a_white_furnace():
    theta_i, weight = angles()
    phi = (np.arange(720) + 0.5) * (2.0 * np.pi / 720)
    theta_o, gamma_o, gamma_t, variance, scale = 0.3, 0.5, 0.3, 0.3, 0.4
    m = hair.longitudinal(np.sin(theta_i), np.cos(theta_i), np.sin(theta_o), np.cos(theta_o), variance)
    total = 0.0
    for path, share in enumerate(hair.attenuations(0.2, 1.0)):
        if path < 3:
            n = hair.azimuthal(phi - hair.exit_azimuth(path, gamma_o, gamma_t), scale)
        else:
            n = np.full_like(phi, 0.5 / np.pi)
        total += share * np.sum(m * np.cos(theta_i) * weight) * np.sum(n) * (2.0 * np.pi / 720)
    # The trapezoidal rule on a periodic function with a kink at its ends, trimmed.
    assert total == pytest.approx(1.0, abs=1e-4)


def test_variances_are_chiangs_and_errors_of_their_powers_perturb_them():
    exact = hair.variances(0.5, 0.25)
    assert exact[0] == pytest.approx((0.726 * 0.5 + 0.812 * 0.25 + 3.7 * 0.5**20) ** 2, rel=FORMULA_TOL)
    assert exact[1] == pytest.approx(0.265 * 0.25 + 1.194 * 0.0625 + 5.372 * 0.25**22, rel=FORMULA_TOL)
    moved = hair.variances(0.5, 0.25, high_powers=(0.5**20 + 1e-6, 0.25**22 + 1e-6))
    assert moved[0] - exact[0] == pytest.approx(2.0 * np.sqrt(exact[0]) * 3.7e-6, rel=1e-4)
    assert moved[1] - exact[1] == pytest.approx(5.372e-6, rel=1e-6)


def test_the_fit_of_absorption_is_a_sum_of_terms_that_cancel():
    assert hair.absorption_fit(1.0) == pytest.approx(5.969 - 0.215 + 2.532 - 10.73 + 5.574 + 0.245, rel=FORMULA_TOL)
    assert np.sum(np.abs(hair.ABSORPTION_FIT)) > 2.0 * abs(np.sum(hair.ABSORPTION_FIT))
    assert hair.absorption_fit(0.0) == 5.969
