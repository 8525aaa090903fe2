"""GGX: the distribution of facet normals and Smith's masking."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import ggx

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

WIDTHS = [(0.0025, 0.0025), (0.05, 0.05), (0.4, 0.4), (1.0, 1.0), (0.0025, 0.4), (0.3, 0.05), (1.0, 0.1)]

# Relative. The integrand is constant in the coordinates of `facets`, so that the quadrature is exact; left is the
# rounding of the slopes, twice squared, amplified where s is near 1 (1 - s is 2e-4 at the last of 96 Gauss nodes).
NORMALISATION_TOL = 16 * EPS / 2e-4

# Share of the samples in which a planted error has to show.
MOST = 0.9

# Below this, masking counts as strong.
DARK = 0.1

# Relative. A dozen operations without cancellation but sqrt(1 + x) - 1, which loses digits against 1 only.
FORMULA_TOL = 32 * EPS


def normalisation_error(distribution: Callable[..., Array], facets: Callable, alpha_x: float, alpha_y: float) -> float:
    """Departure from 1 of the integral of D(m) mz over the hemisphere."""
    m, solid_angle = facets(alpha_x, alpha_y)
    return abs(float(np.sum(distribution(*m.T, alpha_x, alpha_y) * m[:, 2] * solid_angle)) - 1.0)


@pytest.mark.parametrize(("alpha_x", "alpha_y"), WIDTHS)
def test_projected_facets_cover_the_surface_once(facets, alpha_x, alpha_y):
    assert normalisation_error(ggx.distribution, facets, alpha_x, alpha_y) < NORMALISATION_TOL


@pytest.mark.parametrize(("alpha_x", "alpha_y"), WIDTHS)
def test_a_distribution_that_is_one_percent_too_strong_is_seen(facets, alpha_x, alpha_y):
    def too_strong(*arguments: Array) -> Array:
        return 1.01 * ggx.distribution(*arguments)

    assert normalisation_error(too_strong, facets, alpha_x, alpha_y) > NORMALISATION_TOL


def test_a_distribution_normalised_for_one_width_is_seen(facets):
    def one_width(x: Array, y: Array, z: Array, alpha_x: float, alpha_y: float) -> Array:
        return ggx.distribution(x, y, z, alpha_x, alpha_y) * alpha_y / alpha_x

    assert normalisation_error(one_width, facets, 0.3, 0.05) > NORMALISATION_TOL


@pytest.mark.parametrize(("alpha_x", "alpha_y"), WIDTHS)
def test_the_distribution_at_the_normal_has_its_closed_form(alpha_x, alpha_y):
    peak = ggx.distribution(0.0, 0.0, 1.0, alpha_x, alpha_y)
    np.testing.assert_allclose(peak, 1.0 / (np.pi * alpha_x * alpha_y), rtol=FORMULA_TOL)


def test_the_first_width_belongs_to_the_tangent(polar):
    along, across = polar(0.3, 0.0), polar(0.3, np.pi / 2.0)
    # A surface that is rougher along x has more facets inclined along x.
    assert ggx.distribution(*along, 0.4, 0.1) > 2.0 * ggx.distribution(*across, 0.4, 0.1)


def test_equal_widths_give_walters_isotropic_form(rng, hemisphere):
    m = hemisphere(rng, 2000)
    alpha = rng.uniform(0.0025, 1.0, len(m))
    cos2 = np.square(m[:, 2])
    # Walter et al. 2007, eq. 33, in the angle alone.
    expected = np.square(alpha) / (np.pi * cos2**2 * np.square(np.square(alpha) + (1.0 - cos2) / cos2))
    # 1 - cos^2 loses digits near the normal: absolute EPS against alpha^2, squared in the denominator.
    tolerance = FORMULA_TOL + 4.0 * EPS / np.square(alpha)
    found = ggx.distribution(*m.T, alpha, alpha)
    assert np.all(np.abs(found - expected) <= tolerance * expected)
    assert not np.all(np.abs(ggx.distribution(*m.T, alpha, 1.001 * alpha) - expected) <= tolerance * expected)


def test_mirrored_facets_are_as_frequent(rng, hemisphere):
    # The symmetry about n that makes the retroreflective lobe reciprocal and of the same albedo.
    x, y, z = hemisphere(rng, 2000).T
    assert np.array_equal(ggx.distribution(x, y, z, 0.3, 0.05), ggx.distribution(-x, -y, z, 0.3, 0.05))
    assert not np.array_equal(ggx.distribution(x, y, z, 0.3, 0.05), ggx.distribution(y, x, z, 0.3, 0.05))


def visible_area_error(smith_lambda: Callable[..., Array], v: Array, alpha_x: float, alpha_y: float) -> float:
    """Relative departure of the area of the facets that face v, integral of max(v.m, 0) D(m), from n.v (1 + Lambda).

    That is what Smith's Lambda is (Heitz 2014, eq. 14 and 43), so it needs no second formula. In the coordinates of
    `facets`, v.m = (z - a r cos(phi)) mz with a the stretched tangential length of v; the azimuth integral of the
    positive part has a closed form and the radius is left to quadrature, split where the first facets turn away.
    """
    z = v[2]
    a = float(np.hypot(alpha_x * v[0], alpha_y * v[1]))
    turn = z * z / (a * a + z * z)  # s where a r = z
    x, w = np.polynomial.legendre.leggauss(200)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    s = np.concatenate([turn * x, turn + (1.0 - turn) * (1.0 - np.square(1.0 - x * x))])
    weight = np.concatenate([turn * w, (1.0 - turn) * 4.0 * x * (1.0 - x * x) * w])
    r = np.sqrt(s / (1.0 - s))
    start = np.where(a * r > z, np.arccos(np.minimum(z / (a * r), 1.0)), 0.0)
    # Over phi from `start` to 2 pi - `start`.
    facing = 2.0 * (np.pi - start) * z + 2.0 * a * r * np.sin(start)
    area = float(np.sum(weight * facing)) / (2.0 * np.pi)
    return abs(area / float(z * (1.0 + smith_lambda(*v, alpha_x, alpha_y))) - 1.0)


# Relative. 1 / (1 - s) amplifies roundings 3e4 times at the last of 200 nodes (1 - s is 3e-5); a hundred of them may
# add up before the weights, which are as small there.
VISIBLE_AREA_TOL = 100 * EPS / 3e-5


@pytest.mark.parametrize(("alpha_x", "alpha_y"), WIDTHS)
@pytest.mark.parametrize("degrees", [5.0, 60.0, 85.0, 89.5])
def test_smiths_lambda_is_the_share_of_facets_that_are_hidden(polar, alpha_x, alpha_y, degrees):
    v = polar(np.deg2rad(degrees), 0.7)
    assert visible_area_error(ggx.smith_lambda, v, alpha_x, alpha_y) < VISIBLE_AREA_TOL


def test_a_lambda_with_exchanged_widths_is_seen(polar):
    def exchanged(x: Array, y: Array, z: Array, alpha_x: float, alpha_y: float) -> Array:
        return ggx.smith_lambda(x, y, z, alpha_y, alpha_x)

    assert visible_area_error(exchanged, polar(np.deg2rad(60.0), 0.7), 0.3, 0.05) > VISIBLE_AREA_TOL


def test_masking_lies_between_nothing_and_everything(rng, hemisphere):
    v, l = hemisphere(rng, 4000), hemisphere(rng, 4000)
    alpha_x, alpha_y = rng.uniform(1e-8, 1.0, (2, 4000))
    g2 = ggx.masking_shadowing(ggx.smith_lambda(*v.T, alpha_x, alpha_y), ggx.smith_lambda(*l.T, alpha_x, alpha_y))
    assert np.all((g2 > 0.0) & (g2 <= 1.0))
    # Not a constant: grazing rays on rough ground are masked, perpendicular ones are not.
    assert g2.min() < DARK
    assert ggx.masking_shadowing(*ggx.smith_lambda(0.0, 0.0, np.ones(2), 1.0, 1.0)) == 1.0


def test_masking_of_one_width_from_cosines_equals_that_from_lambdas(rng, hemisphere):
    v, l = hemisphere(rng, 4000), hemisphere(rng, 4000)
    alpha = rng.uniform(0.0025, 1.0, 4000)
    from_lambdas = ggx.masking_shadowing(ggx.smith_lambda(*v.T, alpha, alpha), ggx.smith_lambda(*l.T, alpha, alpha))
    # The cosines know x^2 + y^2 as 1 - z^2 only, which differ by the rounding of a unit vector, over z^2 in tan^2;
    # G2 takes at most half of the relative change of tan.
    tolerance = FORMULA_TOL + 4.0 * EPS / np.square(np.minimum(v[:, 2], l[:, 2]))
    found = ggx.masking_shadowing_isotropic(v[:, 2], l[:, 2], alpha)
    assert np.all(np.abs(found - from_lambdas) <= tolerance * from_lambdas)
    wrong = ggx.masking_shadowing_isotropic(v[:, 2], l[:, 2], np.sqrt(alpha))
    assert np.mean(np.abs(wrong - from_lambdas) > tolerance * from_lambdas) > MOST


def test_masking_of_one_width_is_finite_where_a_cosine_vanishes():
    # The limit is 0 at one vanishing cosine and 1 at alpha 0.
    assert ggx.masking_shadowing_isotropic(0.0, 0.5, 0.3) == 0.0
    assert ggx.masking_shadowing_isotropic(0.2, 0.5, 0.0) == 1.0


def test_equal_widths_make_masking_independent_of_azimuth(rng, hemisphere):
    x, y, z = hemisphere(rng, 2000).T
    # Turning by an angle rounds x and y, their squares add up to the same.
    c, s = np.cos(1.0), np.sin(1.0)
    turned = ggx.smith_lambda(c * x - s * y, s * x + c * y, z, 0.3, 0.3)
    straight = ggx.smith_lambda(x, y, z, 0.3, 0.3)
    # sqrt(1 + t) - 1 cancels for small t, relative to it by 1 / t.
    np.testing.assert_allclose(turned, straight, rtol=FORMULA_TOL, atol=4.0 * EPS)
    assert np.max(np.abs(ggx.smith_lambda(c * x - s * y, s * x + c * y, z, 0.3, 0.2) - straight)) > FORMULA_TOL
