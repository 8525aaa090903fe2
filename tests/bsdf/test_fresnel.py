"""Reflectance of smooth interfaces, against closed forms and complex arithmetic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import fresnel

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Absolute, for reflectances in [0, 1]: a dozen operations, none of which amplifies away from the critical angle.
REFLECTANCE_TOL = 32 * EPS

# Share of the samples in which a planted error has to show.
MOST = 0.9

COSINES = np.concatenate([[0.0, 1e-6, 1e-3], np.linspace(0.01, 1.0, 100)])


def complex_polarized(cos_theta: Array, index: Array) -> tuple[Array, Array]:
    """Fresnel's amplitudes in complex arithmetic, squared: parallel, perpendicular."""
    normal = np.sqrt(np.square(index) - (1.0 - np.square(cos_theta)) + 0j)  # normal component of the wave vector inside
    perpendicular = (cos_theta - normal) / (cos_theta + normal)
    parallel = (np.square(index) * cos_theta - normal) / (np.square(index) * cos_theta + normal)
    return np.square(np.abs(parallel)), np.square(np.abs(perpendicular))


def conductor_tolerance(cos_theta: Array, ior: Array, extinction: Array) -> Array:
    """Absolute rounding error of `conductor_polarized`.

    It takes the real part a of sqrt(N^2 - sin^2) as the root of modulus + real part, which cancel for metals:
    2 a^2 = modulus + real is wrong by EPS modulus, and a by EPS modulus / (2 a). R moves by 4 c da / |c + a + ib|^2
    in either polarisation's scale; bounded here with |c + a + ib|^2 >= modulus and the cancelled terms counted 8 times.
    """
    squared = np.square(ior + 1j * extinction) - (1.0 - np.square(cos_theta))
    a, modulus = np.sqrt(squared).real, np.abs(squared)
    return REFLECTANCE_TOL + 8.0 * EPS / np.maximum(a, np.sqrt(EPS * modulus))


def conductor_misses(candidate: Callable[..., tuple[Array, Array]], rng: np.random.Generator) -> float:
    """Share of random metals for which a candidate differs from complex arithmetic."""
    cos_theta = rng.uniform(0.0, 1.0, 5000)
    ior, extinction = np.exp(rng.uniform(np.log(0.05), np.log(5.0), (2, 5000)))
    extinction[::5] = 10.0 * rng.uniform(size=1000)
    found = np.array(candidate(cos_theta, ior, extinction))
    expected = np.array(complex_polarized(cos_theta, ior + 1j * extinction))
    tolerance = conductor_tolerance(cos_theta, ior, extinction)
    return float(np.mean(np.any(np.abs(found - expected) > tolerance, axis=0)))


def test_metals_reflect_as_complex_arithmetic_says(rng):
    assert conductor_misses(fresnel.conductor_polarized, rng) == 0.0


DAMAGED_METALS = {
    "polarisations exchanged": lambda c, n, k: fresnel.conductor_polarized(c, n, k)[::-1],
    "index and extinction exchanged": lambda c, n, k: fresnel.conductor_polarized(c, k, n),
    "extinction off by a thousandth": lambda c, n, k: fresnel.conductor_polarized(c, n, 1.001 * k),
}


@pytest.mark.parametrize("damage", sorted(DAMAGED_METALS))
def test_a_wrong_metal_is_seen(rng, damage):
    assert conductor_misses(DAMAGED_METALS[damage], rng) > MOST


@pytest.mark.parametrize("eta", [0.5, 0.9, 1.1, 1.5, 2.4])
def test_dielectrics_reflect_as_complex_arithmetic_says(eta):
    # The critical angle itself, where the root of a rounding error enters, is not among the cosines.
    found = np.array(fresnel.dielectric_polarized(COSINES, eta))
    # The quotients' difference of nearly equal numbers: relative to the amplitude EPS, for eta near 1 more.
    tolerance = REFLECTANCE_TOL / abs(eta - 1.0)
    np.testing.assert_allclose(found, complex_polarized(COSINES, np.asarray(eta)), rtol=0.0, atol=tolerance)
    exchanged = np.array(fresnel.dielectric_polarized(COSINES, eta))[::-1]
    wrong = np.abs(exchanged - complex_polarized(COSINES, np.asarray(eta))) > tolerance
    assert np.any(wrong)


@pytest.mark.parametrize("eta", [0.5, 1.0, 1.33, 1.5, 3.0])
def test_the_reflectance_at_normal_incidence_has_its_closed_form(eta):
    expected = ((eta - 1.0) / (eta + 1.0)) ** 2
    assert fresnel.dielectric(1.0, eta) == pytest.approx(expected, abs=REFLECTANCE_TOL)
    assert fresnel.reflectance_at_normal(eta) == pytest.approx(expected, abs=REFLECTANCE_TOL)
    # Squaring the quotient twice, a usual slip, is another number.
    assert fresnel.dielectric(1.0, eta + 0.01) != pytest.approx(expected, abs=REFLECTANCE_TOL)


def test_glass_in_air_reflects_four_percent():
    assert fresnel.dielectric(1.0, 1.5) == pytest.approx(0.04, abs=REFLECTANCE_TOL)


@pytest.mark.parametrize("eta", [0.7, 1.33, 1.5, 2.4])
def test_at_brewsters_angle_parallel_light_is_not_reflected(eta):
    cos_brewster = 1.0 / np.sqrt(1.0 + eta * eta)
    parallel, perpendicular = fresnel.dielectric_polarized(cos_brewster, eta)
    # Brewster: the two rays are perpendicular and r_s = (1 - eta^2) / (1 + eta^2).
    expected = ((1.0 - eta**2) / (1.0 + eta**2)) ** 2
    assert parallel == pytest.approx(0.0, abs=REFLECTANCE_TOL)
    assert perpendicular == pytest.approx(expected, abs=REFLECTANCE_TOL)
    aside, _ = fresnel.dielectric_polarized(cos_brewster + 1e-3, eta)
    assert aside > REFLECTANCE_TOL


def test_beyond_the_critical_angle_everything_is_reflected():
    eta = 1.0 / 1.5
    critical = np.sqrt(1.0 - eta * eta)
    assert np.all(fresnel.dielectric(np.linspace(0.0, critical - 1e-9, 100), eta) == 1.0)
    assert fresnel.dielectric(critical + 1e-3, eta) < 1.0
    assert fresnel.dielectric(0.0, eta) == 1.0


def test_at_grazing_incidence_everything_is_reflected():
    etas = np.array([0.5, 1.0, 1.0 + 1e-9, 1.5])
    # Two media without a boundary between them, eta 1, reflect nothing but in the limit.
    assert np.all(fresnel.dielectric(0.0, etas) == 1.0)
    assert np.all(fresnel.conductor(0.0, [0.2, 1.5], [3.0, 0.0]) == 1.0)
    assert np.all(fresnel.dielectric(np.array([0.1, 0.5, 1.0]), 1.0) == 0.0)


@pytest.mark.parametrize("ior", [0.6, 1.2, 1.5, 2.4])
def test_a_metal_without_extinction_is_a_dielectric(ior):
    found = np.array(fresnel.conductor_polarized(COSINES, ior, 0.0))
    expected = np.array(fresnel.dielectric_polarized(COSINES, ior))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=REFLECTANCE_TOL / abs(ior - 1.0))
    assert np.max(np.abs(np.array(fresnel.conductor_polarized(COSINES, ior, 0.01)) - expected)) > REFLECTANCE_TOL


def test_reflectances_stay_between_nothing_and_everything(rng):
    cos_theta = np.concatenate([rng.uniform(0.0, 1.0, 4000), [0.0, 1.0]])
    ior, extinction = rng.uniform(0.01, 10.0, (2, len(cos_theta)))
    for polarized in (
        fresnel.conductor_polarized(cos_theta, ior, extinction),
        fresnel.dielectric_polarized(cos_theta, ior),
    ):
        parallel, perpendicular = polarized
        assert np.min(parallel) > -REFLECTANCE_TOL
        assert np.max(perpendicular) < 1.0 + REFLECTANCE_TOL
        # Parallel light is always reflected less, short of rounding; both vary.
        assert np.all(parallel <= perpendicular + REFLECTANCE_TOL)
        assert np.ptp(parallel) > MOST


# The curve with a tint, at the three cosines that define it.
F0, F82, F90, EXPONENT = 0.19, 0.3, 0.95, 4.0


def test_the_curve_goes_through_its_three_points():
    plain = F0 + (F90 - F0) * (6.0 / 7.0) ** EXPONENT
    found = fresnel.generalized_schlick(np.array([1.0, fresnel.COS_82, 0.0]), F0, F82, F90, EXPONENT)
    np.testing.assert_allclose(found, [F0, F82 * plain, F90], rtol=0.0, atol=REFLECTANCE_TOL)
    # Taken as the reflectance itself instead of a factor on the plain curve, it misses the middle point.
    assert abs(found[1] - F82) > REFLECTANCE_TOL


def test_a_white_tint_leaves_schlicks_curve():
    expected = 0.04 + 0.96 * (1.0 - COSINES) ** 5
    found = fresnel.generalized_schlick(COSINES, 0.04, 1.0, 1.0, 5.0)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=REFLECTANCE_TOL)
    assert np.max(np.abs(fresnel.generalized_schlick(COSINES, 0.04, 0.99, 1.0, 5.0) - expected)) > REFLECTANCE_TOL


def test_the_tinted_curve_of_the_yellow_tape_matches_its_formula():
    c = COSINES
    plain = 0.19 + 0.81 * (1.0 - c) ** 5
    # Portsmouth et al. 2026: F(c) = S(c) - c (1 - c)^6 (1 - F82) S(1/7) / ((1/7) (6/7)^6), with F82 = 0.
    anchor = 0.19 + 0.81 * (6.0 / 7.0) ** 5
    expected = plain - c * (1.0 - c) ** 6 * anchor / ((1.0 / 7.0) * (6.0 / 7.0) ** 6)
    found = fresnel.generalized_schlick(c, 0.19, 0.0, 1.0, 5.0)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=REFLECTANCE_TOL)


def test_a_black_tint_takes_the_curve_below_zero_and_it_stays_there():
    # The published curve has a sign change at 1/7, since its slope is not 0 there; clamping is the caller's affair.
    beside = fresnel.generalized_schlick(fresnel.COS_82 + np.array([-0.02, 0.02]), 0.19, 0.0, 1.0, 5.0)
    assert np.min(beside) < 0.0 < np.max(beside)


def test_the_index_of_a_reflectance_reflects_as_much():
    reflectance = np.linspace(0.01, 0.99, 50)
    back = fresnel.reflectance_at_normal(fresnel.schlick_ior(reflectance))
    # 1 - sqrt(F) loses digits for bright surfaces: 1 / (1 - sqrt(0.99)) is 200.
    tolerance = 200 * REFLECTANCE_TOL
    np.testing.assert_allclose(back, reflectance, rtol=0.0, atol=tolerance)
    assert np.max(np.abs(back - 1.001 * reflectance)) > tolerance


def test_reflectances_broadcast():
    assert fresnel.dielectric(np.ones((4, 1)), np.full(3, 1.5)).shape == (4, 3)
    assert fresnel.conductor(np.ones((4, 1)), np.full(3, 1.5), 2.0).shape == (4, 3)
    assert fresnel.generalized_schlick(np.ones((4, 1)), np.full(3, 0.5), 1.0, 1.0, 5.0).shape == (4, 3)
