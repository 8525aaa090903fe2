"""Sheen: normalisation and limits."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import sheen
from mrm_mtlx.reference import versions

EPS = np.finfo(float).eps

# Coefficients of a transformation, as a renderer has them.
COSINE = versions.installed().cloth_cosine

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


def test_fibres_lie_flat():
    assert sheen.fibre_distribution(0.0, 0.3) == 0.0
    rising = sheen.fibre_distribution(np.linspace(0.0, 1.0, 50), 0.3)
    assert np.all(np.diff(rising) > 0.0)
    assert sheen.fibre_exponent(0.25) == 4.0


def test_the_visibility_is_reciprocal_and_no_less_than_that_of_unmasked_facets(rng):
    cos_v, cos_l = rng.uniform(1e-3, 1.0, (2, 1000))
    found = sheen.fibre_visibility(cos_v, cos_l)
    np.testing.assert_allclose(found, sheen.fibre_visibility(cos_l, cos_v), rtol=FORMULA_TOL)
    # a + b - a b is between the larger cosine and 1; 4 n.l n.v would be less than either.
    assert np.all(found >= 0.25 * (1.0 - FORMULA_TOL))
    assert np.all(found * 4.0 * np.maximum(cos_v, cos_l) <= 1.0 + FORMULA_TOL)


# Linearly transformed cosines -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("cos_v", "roughness"), [(0.1, 0.1), (0.5, 0.3), (0.9, 0.6), (1.0, 1.0), (0.02, 1.0)])
def test_the_transformed_cosine_integrates_to_one(cos_v, roughness):
    a, b = COSINE.scale(cos_v, roughness), COSINE.shear(cos_v, roughness)
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
    density = sheen.ltc_density(*l.T, COSINE.scale(0.5, 0.5), COSINE.shear(0.5, 0.5))
    assert np.sum(density * solid_angle) == pytest.approx(1.0, abs=INTEGRAL_TOL)


def test_the_transformed_cosine_is_dark_below_and_symmetric_about_the_plane_of_view(rng):
    x, y, z = rng.normal(size=(3, 100))
    assert not np.any(sheen.ltc_density(x, y, -np.abs(z), 0.5, -0.1))
    up = np.abs(z)
    np.testing.assert_array_equal(sheen.ltc_density(x, y, up, 0.5, -0.1), sheen.ltc_density(x, -y, up, 0.5, -0.1))
    assert np.all(sheen.ltc_density(x, y, up, 0.5, -0.1) != sheen.ltc_density(-x, y, up, 0.5, -0.1))
