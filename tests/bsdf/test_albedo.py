"""The fit of the directional albedo and what is built on it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick, albedo

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

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
    assert misfits(albedo.albedo_factors, true_factors, BROAD, FIT_ERROR) == 0.0
    assert misfits(albedo.albedo_factors, true_factors, (0.0025, 0.01), NARROW_FIT_ERROR) == 0.0


DAMAGED_FITS = {
    "factors exchanged": lambda c, a: albedo.albedo_factors(c, a)[::-1],
    "width taken for roughness": lambda c, a: albedo.albedo_factors(c, np.square(a)),
    "sine for cosine": lambda c, a: albedo.albedo_factors(np.sqrt(1.0 - c * c), a),
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
    assert albedo._FIT.tolist() == [[float(number) for number in row[0].split(",")] for row in rows]


def test_the_albedo_is_a_share(rng):
    cos_v, alpha = rng.uniform(0.0, 1.0, (2, 5000))
    a, b = albedo.albedo_factors(cos_v, alpha)
    white = albedo.white_albedo(cos_v, alpha)
    assert np.all((a >= 0.0) & (b >= 0.0) & (white > 0.0))
    # The fit exceeds 1 a little where the lobe is narrow; it is not clamped as a sum.
    assert np.max(white) < 1.0 + FIT_ERROR
    assert np.ptp(white) > MOST


def float32_fit(cos_v: Array, alpha: Array) -> Array:
    """A + B in single precision, term by term."""
    x, y = np.float32(cos_v), np.float32(alpha)
    monomials = (np.ones_like(x), x, y, x * y, x * x, y * y, x * x * y, x * y * y, x * x * y * y)
    table = np.float32(albedo._FIT)
    top_a, top_b, under_a, under_b = (
        np.sum([c * m for c, m in zip(column, monomials, strict=True)], axis=0, dtype=np.float32) for column in table.T
    )
    return np.clip(top_a / under_a, 0, 1) + np.clip(top_b / under_b, 0, 1)


# Roundings that a term of the polynomials collects: its coefficient, at most 4 products, 9 sums, and the quotient's.
TERM_ROUNDINGS = 16.0
UNIT = 2.0**-24


def test_the_condition_bounds_what_single_precision_does_to_the_fit(rng):
    cos_v, alpha = np.float32(rng.uniform(0.0, 1.0, (2, 5000)))
    moved = np.abs(float32_fit(cos_v, alpha) - albedo.white_albedo(cos_v, alpha))
    allowed = TERM_ROUNDINGS * UNIT * albedo.albedo_condition(cos_v, alpha)
    assert np.all(moved <= allowed)
    # A bound that is never approached would let anything pass: a thousand times smaller, it must fail.
    assert np.mean(moved > 1e-3 * allowed) > MOST


def test_compensation_gives_a_white_lobe_back_what_it_loses():
    white = np.linspace(0.2, 1.0, 9)
    np.testing.assert_allclose(white * albedo.compensation(1.0, white), 1.0, rtol=4 * EPS)
    assert np.all(albedo.compensation(0.0, white) == 1.0)
    # Light that meets a grey surface twice is weakened twice: Turquin's factor is linear in F, not 1 / Ess.
    assert np.all(albedo.compensation(0.5, white[:-1]) < 1.0 / white[:-1])


def test_the_albedo_broadcasts():
    a, b = albedo.albedo_factors(np.full((4, 1), 0.5), np.full(3, 0.2))
    assert a.shape == b.shape == (4, 3)
    assert albedo.compensation(np.full((3, 4), 0.5), np.full(4, 0.9)).shape == (3, 4)
