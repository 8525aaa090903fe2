"""Burley's diffuse lobe: limits and reciprocity."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf import diffuse

EPS = np.finfo(float).eps
FORMULA_TOL = 32 * EPS


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
