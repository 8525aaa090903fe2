"""Sheen: normalisation, limits, and how good the fits are."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import sheen

EPS = np.finfo(float).eps

# Relative, for products and quotients without cancellation.
FORMULA_TOL = 64 * EPS

# Absolute. Gauss quadrature with 128 cosines is exact to rounding for smooth integrands; sin^(1 / r) has a cusp at the
# normal for 1 / r < 2, where 1e-6 was measured against twice as many.
INTEGRAL_TOL = 5e-6

ROUGHNESSES = (0.05, 0.2, 0.5, 1.0)


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_the_distribution_of_fibres_is_normalised(hemisphere_grid, roughness):
    h, solid_angle = hemisphere_grid(cosines=512, azimuths=4)

    def projected_area(exponent_factor: float) -> float:
        d = sheen.fibre_distribution(1.0 - h[:, 2] ** 2, roughness / exponent_factor)
        return float(np.sum(d * h[:, 2] * solid_angle)) * (2.0 + 1.0 / roughness) / (2.0 + exponent_factor / roughness)

    assert projected_area(1.0) == pytest.approx(1.0, abs=INTEGRAL_TOL)
    # With the exponent of one roughness and the normalisation of another it is not.
    assert projected_area(1.05) != pytest.approx(1.0, abs=INTEGRAL_TOL)


def test_fibres_lie_flat_and_the_least_roughness_bounds_the_exponent():
    assert sheen.fibre_distribution(0.0, 0.3) == 0.0
    rising = sheen.fibre_distribution(np.linspace(0.0, 1.0, 50), 0.3)
    assert np.all(np.diff(rising) > 0.0)
    assert sheen.fibre_exponent(0.001) == pytest.approx(1.0 / sheen.LEAST_FIBRE_ROUGHNESS, rel=FORMULA_TOL)
    assert sheen.fibre_exponent(0.25) == 4.0


def test_the_visibility_is_reciprocal_and_no_less_than_that_of_unmasked_facets(rng):
    cos_v, cos_l = rng.uniform(1e-3, 1.0, (2, 1000))
    found = sheen.fibre_visibility(cos_v, cos_l)
    np.testing.assert_allclose(found, sheen.fibre_visibility(cos_l, cos_v), rtol=FORMULA_TOL)
    # a + b - a b is between the larger cosine and 1; 4 n.l n.v would be less than either.
    assert np.all(found >= 0.25 * (1.0 - FORMULA_TOL))
    assert np.all(found * 4.0 * np.maximum(cos_v, cos_l) <= 1.0 + FORMULA_TOL)


# Absolute. What MaterialX's fit misses the lobe's albedo by, for n.v of 0.1 and more: 0.040 was measured (roughness
# 0.2, n.v 0.1).
FIT_ERROR = 0.042


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("cos_v", [0.1, 0.3, 0.5, 0.7, 1.0])
def test_the_fitted_albedo_is_about_that_of_the_lobe(hemisphere_grid, cos_v, roughness):
    l, solid_angle = hemisphere_grid()
    h = l + np.array([np.sqrt(1.0 - cos_v**2), 0.0, cos_v])
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    d = sheen.fibre_distribution(1.0 - h[:, 2] ** 2, roughness)
    expected = float(np.sum(d * sheen.fibre_visibility(cos_v, l[:, 2]) * l[:, 2] * solid_angle))
    assert sheen.fibre_albedo(cos_v, roughness) == pytest.approx(expected, abs=FIT_ERROR)
    if cos_v == 0.1:
        assert sheen.fibre_albedo(2.0 * cos_v, roughness) != pytest.approx(expected, abs=FIT_ERROR)


def test_the_fitted_albedo_is_clamped_where_the_fit_is_negative():
    # Numerator 13.673 - 68.78 c + 60.29 c^2 at roughness 0: negative from 0.26 to 0.88.
    assert sheen.fibre_albedo(0.5, 0.0) == 0.0
    assert sheen.fibre_albedo(0.2, 0.0) > 0.0
    assert sheen.fibre_albedo(0.95, 0.0) > 0.0


def test_an_error_of_the_terms_moves_the_albedo_up_by_their_sum():
    c, r, step = 0.4, 0.3, 1e-9
    above = [13.67300, -68.78018 * c, 799.08825 * r, -905.00061 * c * r, 60.28956 * c * c, 1086.96473 * r * r]
    below = 1.0 + 61.57746 * c + 442.78211 * r + 2597.49308 * c * r + 121.81241 * c * c + 3045.55075 * r * r
    exact = sheen.fibre_albedo(c, r)
    expected = step * (sum(map(abs, above)) / below + exact)
    assert exact == pytest.approx(sum(above) / below, rel=FORMULA_TOL)
    # A difference of numbers below 1 keeps EPS of them.
    assert sheen.fibre_albedo(c, r, rounding=step) - exact == pytest.approx(expected, abs=4 * EPS)


# Linearly transformed cosines -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("cos_v", "roughness"), [(0.1, 0.1), (0.5, 0.3), (0.9, 0.6), (1.0, 1.0), (0.02, 1.0)])
def test_the_transformed_cosine_integrates_to_one(cos_v, roughness):
    a, b = sheen.ltc_scale(cos_v, roughness), sheen.ltc_shear(cos_v, roughness)
    # In the directions before the transformation the density is the cosine over pi: the points are dense where it is.
    count = 2000
    z = np.sqrt((np.arange(count) + 0.5) / count)
    phi = np.arange(64) * (2.0 * np.pi / 64)
    sine = np.sqrt(1.0 - z * z)[:, None]
    z = np.broadcast_to(z[:, None], (count, 64))
    x, y = (sine * np.cos(phi) - b * z) / a, sine * np.sin(phi) / a
    length = np.sqrt(x * x + y * y + z * z)
    # The solid angle of M w is |M| / |M w|^3, |M| = 1 / a^2; before it, each point has its share of pi / z.
    solid_angle = np.pi / z / (count * 64) / (a**2 * length**3)
    density = sheen.ltc_density(x / length, y / length, z / length, a, b)
    assert np.sum(density * solid_angle) == pytest.approx(1.0, rel=1e-12)
    forgotten = density / a**2
    if a != 1.0:
        assert np.sum(forgotten * solid_angle) != pytest.approx(1.0, rel=1e-3)


def test_the_transformed_cosine_integrates_to_one_over_plain_directions_too(hemisphere_grid):
    l, solid_angle = hemisphere_grid(cosines=256, azimuths=512)
    density = sheen.ltc_density(*l.T, sheen.ltc_scale(0.5, 0.5), sheen.ltc_shear(0.5, 0.5))
    assert np.sum(density * solid_angle) == pytest.approx(1.0, abs=INTEGRAL_TOL)


def test_the_transformed_cosine_is_dark_below_and_symmetric_about_the_plane_of_view(rng):
    x, y, z = rng.normal(size=(3, 100))
    assert not np.any(sheen.ltc_density(x, y, -np.abs(z), 0.5, -0.1))
    up = np.abs(z)
    np.testing.assert_array_equal(sheen.ltc_density(x, y, up, 0.5, -0.1), sheen.ltc_density(x, -y, up, 0.5, -0.1))
    assert np.all(sheen.ltc_density(x, y, up, 0.5, -0.1) != sheen.ltc_density(-x, y, up, 0.5, -0.1))


def test_seen_along_the_normal_the_lobe_is_round():
    assert np.all(sheen.ltc_shear(1.0, np.linspace(0.01, 1.0, 20)) == 0.0)
    assert np.all(sheen.ltc_shear(0.5, np.linspace(0.01, 0.99, 20)) < 0.0)
    # Near the normal, what is lost of 1 - n.v is what there is.
    assert sheen.ltc_shear(1.0, 0.5, lost=1e-6) == pytest.approx(sheen.ltc_shear(1.0 - 1e-6, 0.5), rel=1e-5)


def test_the_ltc_albedo_is_an_albedo_but_for_a_dip_of_its_offset():
    c, r = np.meshgrid(np.linspace(0.0, 1.0, 201), np.linspace(sheen.LEAST_LTC_ROUGHNESS, 1.0, 397))
    found = sheen.ltc_albedo(c, r)
    assert np.max(found) < 1.0
    dip = found < 0.0
    assert -2.2e-5 < np.min(found) < -2.0e-5
    assert 0.04 < np.min(r[dip]) < np.max(r[dip]) < 0.135


def test_errors_move_the_ltc_albedo_up(rng):
    c, r = rng.uniform(0.0, 1.0, 200), rng.uniform(sheen.LEAST_LTC_ROUGHNESS, 1.0, 200)
    exact = sheen.ltc_albedo(c, r)
    # The roundings of the evaluation itself, amplified as those that are given are: at least four times less.
    assert np.all(sheen.ltc_albedo(c, r, rounding=1e-9) > exact)
    assert np.all(sheen.ltc_albedo(c, r, exponential_error=1e-9) >= exact)
    # The Gaussian's exponent there is about a half, and the Gaussian nearly all of it.
    moved = sheen.ltc_albedo(0.1, 0.5, exponential_error=1e-6) / sheen.ltc_albedo(0.1, 0.5) - 1.0
    assert 1e-6 < moved < 2e-6
