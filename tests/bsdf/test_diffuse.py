"""Rough diffuse lobes: limits, and albedo by quadrature."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import diffuse
from mrm_mtlx.reference.float32.intermediates import Perturbed

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Relative, for products and quotients without cancellation.
FORMULA_TOL = 16 * EPS

# Absolute. The lobe has a kink where s = l.v - n.l n.v changes sign and where n.l = n.v: quadrature with 128 by 256
# nodes is good to 1.7e-5, measured against twice as many.
ALBEDO_TOL = 5e-5

# Relative. At roughness 0 no light is lost, up to the floor of 1e-8 that MaterialX puts under each share.
FLOOR_TOL = 2e-8

# Share of the samples in which a planted error has to show.
MOST = 0.9

ROUGHNESSES = (0.0, 0.3, 1.0)
COSINES = (0.05, 0.3, 0.7, 1.0)


def albedo_of(f: Callable[[Array, Array, Array], Array], cos_v: float, hemisphere_grid: Callable) -> float:
    """Directional albedo of a lobe of the three cosines."""
    l, solid_angle = hemisphere_grid()
    v = np.array([np.sqrt(1.0 - cos_v**2), 0.0, cos_v])
    return float(np.sum(f(np.asarray(cos_v), l[:, 2], l @ v) * l[:, 2] * solid_angle))


def test_a_smooth_diffuse_surface_is_lambertian(rng):
    cos_v, cos_l, v_l = rng.uniform(0.0, 1.0, (3, 100))
    np.testing.assert_allclose(diffuse.oren_nayar(cos_v, cos_l, v_l, 0.0), 1.0 / np.pi, rtol=FORMULA_TOL)
    compensated = diffuse.compensated_oren_nayar(np.maximum(cos_v, 0.1), np.maximum(cos_l, 0.1), v_l, 0.0, 0.6)
    np.testing.assert_allclose(compensated, 0.6 / np.pi, rtol=FLOOR_TOL)
    assert np.mean(np.abs(diffuse.oren_nayar(cos_v, cos_l, v_l, 0.01) * np.pi - 1.0) > FLOOR_TOL) > MOST


def test_the_qualitative_model_has_its_trigonometric_form(rng, polar):
    theta_v, theta_l, sigma = rng.uniform(0.05, 1.5, 1000), rng.uniform(0.05, 1.5, 1000), rng.uniform(0.0, 1.0, 1000)
    phi = rng.uniform(0.0, 2.0 * np.pi, 1000)
    v, l = polar(theta_v), polar(theta_l, phi)
    # Oren and Nayar 1994, eq. 30: A + B max(0, cos(phi)) sin(larger angle) tan(smaller angle).
    a = 1.0 - 0.5 * sigma**2 / (sigma**2 + 0.33)
    b = 0.45 * sigma**2 / (sigma**2 + 0.09)
    larger, smaller = np.maximum(theta_v, theta_l), np.minimum(theta_v, theta_l)
    expected = (a + b * np.maximum(0.0, np.cos(phi)) * np.sin(larger) * np.tan(smaller)) / np.pi
    cosines = v[:, 2], l[:, 2], np.sum(v * l, axis=-1)
    # The product of the sines is got as a difference of cosines, divided by the larger, which is above 0.07.
    tolerance = FORMULA_TOL / 0.07
    np.testing.assert_allclose(diffuse.oren_nayar(*cosines, sigma), expected, rtol=tolerance)
    assert np.max(np.abs(diffuse.oren_nayar(*cosines, 1.001 * sigma) / expected - 1.0)) > tolerance


def test_the_rough_surface_is_brightest_towards_the_light():
    s, c = np.sin(1.0), np.cos(1.0)
    towards, away = (diffuse.oren_nayar(c, c, v_l, 0.5) for v_l in (1.0, c * c - s * s))
    assert towards > away


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("cos_v", COSINES)
def test_fujiis_albedo_is_the_integral_of_his_lobe(hemisphere_grid, cos_v, roughness):
    # With the colour going to 0, only the single-scattering lobe is left.
    dim = 1e-6

    def single(cos_v: Array, cos_l: Array, v_l: Array) -> Array:
        return diffuse.compensated_oren_nayar(cos_v, cos_l, v_l, roughness, dim) / dim

    expected = albedo_of(single, cos_v, hemisphere_grid)
    assert diffuse.fujii_albedo(cos_v, roughness) == pytest.approx(expected, abs=ALBEDO_TOL)
    if roughness:
        assert diffuse.fujii_albedo(cos_v, 1.2 * roughness) != pytest.approx(expected, abs=ALBEDO_TOL)


@pytest.mark.parametrize("roughness", ROUGHNESSES)
@pytest.mark.parametrize("cos_v", COSINES)
def test_a_white_compensated_surface_returns_all_light(hemisphere_grid, cos_v, roughness):
    def white(cos_v: Array, cos_l: Array, v_l: Array) -> Array:
        return diffuse.compensated_oren_nayar(cos_v, cos_l, v_l, roughness, 1.0)

    def uncompensated(cos_v: Array, cos_l: Array, v_l: Array) -> Array:
        return diffuse.compensated_oren_nayar(cos_v, cos_l, v_l, roughness, 1e-6) * 1e6

    assert albedo_of(white, cos_v, hemisphere_grid) == pytest.approx(1.0, abs=ALBEDO_TOL)
    if roughness:
        assert albedo_of(uncompensated, cos_v, hemisphere_grid) != pytest.approx(1.0, abs=ALBEDO_TOL)


def test_diffuse_lobes_are_reciprocal(rng):
    cos_v, cos_l, v_l = rng.uniform(0.01, 1.0, (3, 1000))
    for f in (
        lambda a, b: diffuse.oren_nayar(a, b, v_l, 0.4),
        lambda a, b: diffuse.compensated_oren_nayar(a, b, v_l, 0.4, 0.5),
    ):
        np.testing.assert_allclose(f(cos_v, cos_l), f(cos_l, cos_v), rtol=FORMULA_TOL)
    tilted = (diffuse.oren_nayar(a, b, v_l, 0.4) * (1.0 + 0.01 * a) for a, b in ((cos_v, cos_l), (cos_l, cos_v)))
    assert not np.allclose(*tilted, rtol=FORMULA_TOL)


def test_a_coarse_arc_cosine_moves_the_albedo():
    exact = diffuse.fujii_albedo(0.3, 0.5)
    coarse = diffuse.fujii_albedo(0.3, 0.5, intermediates=Perturbed(arc_cosine_error=1e-3))
    # d/d(angle) of a sin(angle) r / pi, with angle = acos(0.3).
    sine = np.sqrt(1.0 - 0.09)
    a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * np.pi)) * 0.5)
    expected = a * 0.5 / np.pi * sine * np.arccos(0.3) * 1e-3
    # The difference of two numbers near 1 keeps EPS of them.
    assert coarse - exact == pytest.approx(expected, abs=8 * EPS)
