"""MaterialX's fits: how good they are, whose numbers they have, and what rounding does to them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick, diffuse, sheen
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.closures.sheen import LEAST_COSINE_ROUGHNESS

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Relative, for products and quotients without cancellation.
FORMULA_TOL = 64 * EPS

FITS = versions.installed()
MICROFACET, FIBRES, COSINE = FITS.microfacet_albedo, FITS.fibre_albedo, FITS.cloth_cosine

# Absolute error of MaterialX's fit, per factor, as measured here against quadrature over the lobe: 0.029 from alpha
# 0.05 up, 0.099 for narrower lobes at n.v = 0.1. Parity with MaterialX needs no better one; that it is a fit to this
# lobe is what is checked. The quadrature itself is good to 2e-3 (half the nodes against all of them).
FIT_ERROR = 0.031
NARROW_FIT_ERROR = 0.101

# Share of the cases in which a planted error has to show.
MOST = 0.5

COSINES = (0.05, 0.1, 0.3, 0.6, 0.9, 1.0)
BROAD = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0)


@pytest.fixture(scope="module")
def true_factors(lobe_directions, polar) -> Callable[[float, float], tuple[float, float]]:
    """Function from n.v and alpha to the factors A and B by quadrature over the lobe itself."""

    @cache
    def factors(cos_v: float, alpha: float) -> tuple[float, float]:
        v = polar(np.arccos(cos_v))
        l, solid_angle = lobe_directions(v, alpha, alpha)
        weight = l[:, 2] * solid_angle
        a, b = (
            float(np.sum(GeneralizedSchlick(f0, 1.0, f90, alpha=(alpha, alpha)).eval(v, l)[:, 0] * weight))
            for f0, f90 in ((1.0, 0.0), (0.0, 1.0))
        )
        return a, b

    return factors


def misfits(candidate: Callable, true_factors: Callable, widths: tuple[float, ...], tolerance: float) -> float:
    """Share of widths and angles at which either factor is off by more than the tolerance."""
    wrong = [
        np.max(np.abs(np.subtract(candidate(c, alpha), true_factors(c, alpha)))) > tolerance
        for alpha in widths
        for c in COSINES
    ]
    return float(np.mean(wrong))


def test_the_fit_is_the_albedo_of_the_lobe(true_factors):
    assert misfits(MICROFACET.factors, true_factors, BROAD, FIT_ERROR) == 0.0
    assert misfits(MICROFACET.factors, true_factors, (0.0025, 0.01), NARROW_FIT_ERROR) == 0.0


DAMAGED_FITS = {
    "factors exchanged": lambda c, a: MICROFACET.factors(c, a)[::-1],
    "width taken for roughness": lambda c, a: MICROFACET.factors(c, np.square(a)),
    "sine for cosine": lambda c, a: MICROFACET.factors(np.sqrt(1.0 - c * c), a),
}


@pytest.mark.parametrize("damage", sorted(DAMAGED_FITS))
def test_a_wrong_fit_is_seen(true_factors, damage):
    assert misfits(DAMAGED_FITS[damage], true_factors, BROAD, FIT_ERROR) > MOST


def test_the_fit_has_the_numbers_of_the_installed_materialx(upstream_library):
    # Good to a few percent either way, so that quadrature cannot tell a wrong digit: the shader's own text does.
    source = upstream_library.search_path.find("libraries/pbrlib/genglsl/lib/mx_microfacet_specular.glsl")
    body = Path(source.asString()).read_text(encoding="utf-8").partition("vec3 mx_ggx_dir_albedo_analytic(")[2]
    rows = re.findall(r"vec4\(([^)]*)\) ?\*? ?([xy2 *]*)", body.partition(";\n    vec2 AB")[0])
    monomials = ["", "x", "y", "x * y", "x2", "y2", "x2 * y", "x * y2", "x2 * y2"]
    assert [row[1].strip() for row in rows] == monomials
    columns = zip(*([float(number) for number in row[0].split(",")] for row in rows), strict=True)
    assert [*MICROFACET.factors_above, *MICROFACET.factors_below] == list(columns)


def test_the_albedo_is_a_share(rng):
    cos_v, alpha = rng.uniform(0.0, 1.0, (2, 5000))
    a, b = MICROFACET.factors(cos_v, alpha)
    white = MICROFACET.white(cos_v, alpha)
    assert np.all((a >= 0.0) & (b >= 0.0) & (white > 0.0))
    # The fit exceeds 1 a little where the lobe is narrow; it is not clamped as a sum.
    assert np.max(white) < 1.0 + FIT_ERROR
    assert np.ptp(white) > MOST


def float32_fit(cos_v: Array, alpha: Array) -> Array:
    """A + B in single precision, term by term."""
    x, y = np.float32(cos_v), np.float32(alpha)
    monomials = (np.ones_like(x), x, y, x * y, x * x, y * y, x * x * y, x * y * y, x * x * y * y)
    top_a, top_b, under_a, under_b = (
        np.sum([c * m for c, m in zip(np.float32(column), monomials, strict=True)], axis=0, dtype=np.float32)
        for column in (*MICROFACET.factors_above, *MICROFACET.factors_below)
    )
    return np.clip(top_a / under_a, 0, 1) + np.clip(top_b / under_b, 0, 1)


# Roundings that a term of the polynomials collects: its coefficient, at most 4 products, 9 sums, and the quotient's.
TERM_ROUNDINGS = 16.0
UNIT = 2.0**-24


def test_the_condition_bounds_what_single_precision_does_to_the_fit(rng):
    cos_v, alpha = np.float32(rng.uniform(0.0, 1.0, (2, 5000)))
    moved = np.abs(float32_fit(cos_v, alpha) - MICROFACET.white(cos_v, alpha))
    allowed = TERM_ROUNDINGS * UNIT * MICROFACET.condition(cos_v, alpha)
    assert np.all(moved <= allowed)
    # A bound that is never approached would let anything pass: a thousand times smaller, it must fail.
    assert np.mean(moved > 1e-3 * allowed) > MOST


def test_the_albedo_broadcasts():
    a, b = MICROFACET.factors(np.full((4, 1), 0.5), np.full(3, 0.2))
    assert a.shape == b.shape == (4, 3)


# Sheen of fibres ------------------------------------------------------------------------------------------------------

ROUGHNESSES = (0.05, 0.2, 0.5, 1.0)

# Absolute. What MaterialX's fit misses the lobe's albedo by, for n.v of 0.1 and more: 0.040 was measured (roughness
# 0.2, n.v 0.1).
FIBRE_ERROR = 0.042


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("cos_v", [0.1, 0.3, 0.5, 0.7, 1.0])
def test_the_fitted_albedo_of_fibres_is_about_that_of_the_lobe(hemisphere_grid, cos_v, roughness):
    l, solid_angle = hemisphere_grid()
    h = l + np.array([np.sqrt(1.0 - cos_v**2), 0.0, cos_v])
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    d = sheen.fibre_distribution(1.0 - h[:, 2] ** 2, roughness)
    expected = float(np.sum(d * sheen.fibre_visibility(cos_v, l[:, 2]) * l[:, 2] * solid_angle))
    assert FIBRES.albedo(cos_v, roughness) == pytest.approx(expected, abs=FIBRE_ERROR)
    if cos_v == 0.1:
        assert FIBRES.albedo(2.0 * cos_v, roughness) != pytest.approx(expected, abs=FIBRE_ERROR)


def test_the_fitted_albedo_of_fibres_is_clamped_where_the_fit_is_negative():
    # Numerator 13.673 - 68.78 c + 60.29 c^2 at roughness 0: negative from 0.26 to 0.88.
    assert FIBRES.albedo(0.5, 0.0) == 0.0
    assert FIBRES.albedo(0.2, 0.0) > 0.0
    assert FIBRES.albedo(0.95, 0.0) > 0.0


def test_an_error_of_the_terms_perturbs_the_albedo_of_fibres_upward_by_their_sum():
    c, r, step = 0.4, 0.3, 1e-9
    above = [13.67300, -68.78018 * c, 799.08825 * r, -905.00061 * c * r, 60.28956 * c * c, 1086.96473 * r * r]
    below = 1.0 + 61.57746 * c + 442.78211 * r + 2597.49308 * c * r + 121.81241 * c * c + 3045.55075 * r * r
    exact = FIBRES.albedo(c, r)
    expected = step * (sum(map(abs, above)) / below + exact)
    assert exact == pytest.approx(sum(above) / below, rel=FORMULA_TOL)
    # A difference of numbers below 1 keeps EPS of them.
    assert FIBRES.albedo(c, r, rounding=step) - exact == pytest.approx(expected, abs=4 * EPS)


# The transformed cosine -----------------------------------------------------------------------------------------------


def test_seen_along_the_normal_the_lobe_is_round():
    assert np.all(COSINE.shear(1.0, np.linspace(0.01, 1.0, 20)) == 0.0)
    assert np.all(COSINE.shear(0.5, np.linspace(0.01, 0.99, 20)) < 0.0)
    # Near the normal, what is lost of 1 - n.v is what there is.
    assert COSINE.shear(1.0, 0.5, lost=1e-6) == pytest.approx(COSINE.shear(1.0 - 1e-6, 0.5), rel=1e-5)


def test_the_albedo_of_the_cosine_is_an_albedo_but_for_a_dip_of_its_offset():
    c, r = np.meshgrid(np.linspace(0.0, 1.0, 201), np.linspace(LEAST_COSINE_ROUGHNESS, 1.0, 397))
    found = COSINE.albedo(c, r)
    assert np.max(found) < 1.0
    dip = found < 0.0
    assert -2.2e-5 < np.min(found) < -2.0e-5
    assert 0.04 < np.min(r[dip]) < np.max(r[dip]) < 0.135


def test_errors_perturb_the_albedo_of_the_cosine_upward(rng):
    c, r = rng.uniform(0.0, 1.0, 200), rng.uniform(LEAST_COSINE_ROUGHNESS, 1.0, 200)
    exact = COSINE.albedo(c, r)
    # The roundings of the evaluation itself, amplified as those that are given are: at least four times less.
    assert np.all(COSINE.albedo(c, r, rounding=1e-9) > exact)
    assert np.all(COSINE.albedo(c, r, exponential_error=1e-9) >= exact)
    # The Gaussian's exponent there is about a half, and the Gaussian nearly all of it.
    moved = COSINE.albedo(0.1, 0.5, exponential_error=1e-6) / COSINE.albedo(0.1, 0.5) - 1.0
    assert 1e-6 < moved < 2e-6


# Diffuse reflection ---------------------------------------------------------------------------------------------------

# Absolute. What the fit misses the albedo by: 0.0132 was measured, at roughness 0.5 and n.v 0.05; at roughness 0,
# where the albedo has the form of the fit, 1e-6, the digits of its coefficients.
BURLEY_ERROR = 0.014
SMOOTH_BURLEY_ERROR = 2e-6


def burleys_albedo(cos_v: float, roughness: float, hemisphere_grid) -> float:
    l, solid_angle = hemisphere_grid()
    h = l + np.array([np.sqrt(1.0 - cos_v**2), 0.0, cos_v])
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    f = diffuse.burley(cos_v, l[:, 2], np.sum(l * h, axis=-1), roughness)
    return float(np.sum(f * l[:, 2] * solid_angle))


@pytest.mark.parametrize("roughness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("cos_v", [0.05, 0.3, 0.7, 1.0])
def test_the_fitted_albedo_of_burleys_lobe_is_about_that_of_the_lobe(hemisphere_grid, cos_v, roughness):
    expected = burleys_albedo(cos_v, roughness, hemisphere_grid)
    tolerance = BURLEY_ERROR if roughness else SMOOTH_BURLEY_ERROR
    assert FITS.burley_albedo.albedo(cos_v, roughness) == pytest.approx(expected, abs=tolerance)
    if cos_v == 0.05:
        assert FITS.burley_albedo.albedo(cos_v, roughness + 0.1) != pytest.approx(expected, abs=tolerance)
