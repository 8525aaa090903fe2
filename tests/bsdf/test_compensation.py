"""Compensation for the energy that single scattering loses."""

from __future__ import annotations

import numpy as np

from mrm_mtlx.bsdf.compensation import compensation

EPS = np.finfo(float).eps


def test_compensation_gives_a_white_lobe_back_what_it_loses():
    white = np.linspace(0.2, 1.0, 9)
    # A difference, a quotient, a sum and a product, each within half a rounding.
    np.testing.assert_allclose(white * compensation(1.0, white), 1.0, rtol=4 * EPS)
    assert np.all(compensation(0.0, white) == 1.0)
    # Light that meets a grey surface twice is weakened twice: Turquin's factor is linear in F, not 1 / Ess.
    assert np.all(compensation(0.5, white[:-1]) < 1.0 / white[:-1])


def test_compensation_broadcasts():
    assert compensation(np.full((3, 4), 0.5), np.full(4, 0.9)).shape == (3, 4)
