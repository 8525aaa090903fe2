"""Burley's diffuse lobe: limits, reciprocity, and how good the fit of its albedo is."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import diffuse

EPS = np.finfo(float).eps
FORMULA_TOL = 32 * EPS

# Absolute. What the fit misses the albedo by: 0.0132 was measured, at roughness 0.5 and n.v 0.05; at roughness 0,
# where the albedo has the form of the fit, 1e-6, the digits of its coefficients.
FIT_ERROR = 0.014
SMOOTH_FIT_ERROR = 2e-6


def albedo_of(cos_v: float, roughness: float, hemisphere_grid) -> float:
    l, solid_angle = hemisphere_grid()
    h = l + np.array([np.sqrt(1.0 - cos_v**2), 0.0, cos_v])
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    f = diffuse.burley(cos_v, l[:, 2], np.sum(l * h, axis=-1), roughness)
    return float(np.sum(f * l[:, 2] * solid_angle))


def test_the_edge_is_dark_for_smooth_and_bright_for_rough_surfaces():
    # Burley 2012, section 5.3: F90 is 1/2 for roughness 0, and 2.5 for roughness 1 where l = h.
    assert diffuse.burley(0.0, 1.0, 1.0, 0.0) * np.pi == pytest.approx(0.5, rel=FORMULA_TOL)
    assert diffuse.burley(0.0, 1.0, 1.0, 1.0) * np.pi == pytest.approx(2.5, rel=FORMULA_TOL)
    assert diffuse.burley(1.0, 1.0, 1.0, 0.7) * np.pi == pytest.approx(1.0, rel=FORMULA_TOL)
    assert diffuse.burley(0.5, 0.3, 0.5, 1.0) * np.pi == pytest.approx(1.0, rel=FORMULA_TOL)


def test_the_lobe_is_reciprocal(rng):
    cos_v, cos_l, l_h = rng.uniform(0.0, 1.0, (3, 1000))
    found, exchanged = diffuse.burley(cos_v, cos_l, l_h, 0.8), diffuse.burley(cos_l, cos_v, l_h, 0.8)
    np.testing.assert_allclose(found, exchanged, rtol=FORMULA_TOL)
    assert not np.allclose(found * (1.0 + 0.01 * cos_v), exchanged * (1.0 + 0.01 * cos_l), rtol=FORMULA_TOL)


@pytest.mark.parametrize("roughness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("cos_v", [0.05, 0.3, 0.7, 1.0])
def test_the_fitted_albedo_is_about_that_of_the_lobe(hemisphere_grid, cos_v, roughness):
    expected = albedo_of(cos_v, roughness, hemisphere_grid)
    tolerance = FIT_ERROR if roughness else SMOOTH_FIT_ERROR
    assert diffuse.burley_albedo_fit(cos_v, roughness) == pytest.approx(expected, abs=tolerance)
    if cos_v == 0.05:
        assert diffuse.burley_albedo_fit(cos_v, roughness + 0.1) != pytest.approx(expected, abs=tolerance)
