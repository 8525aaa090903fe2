"""The diffusion profile against its integral in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.bsdf.subsurface import diffusion_profile

EPS = np.finfo(float).eps


def share_within(radius: float, shape: float) -> float:
    """Share of the light that leaves within a radius, by quadrature (Gauss, 64 nodes, exact for this to rounding)."""
    x, w = np.polynomial.legendre.leggauss(64)
    r = 0.5 * radius * (x + 1.0)
    return float(np.sum(0.5 * radius * w * 2.0 * np.pi * r * diffusion_profile(r, shape)))


@pytest.mark.parametrize("shape", [0.3, 1.0, 7.0])
@pytest.mark.parametrize("depths", [0.1, 1.0, 5.0, 20.0])
def test_the_light_within_a_radius_is_that_of_the_closed_form(shape, depths):
    # Christensen and Burley 2015, eq. 11: 1 - exp(-s r) / 4 - 3 exp(-s r / 3) / 4; it goes to 1.
    expected = 1.0 - 0.25 * np.exp(-depths) - 0.75 * np.exp(-depths / 3.0)
    assert share_within(depths / shape, shape) == pytest.approx(expected, rel=1e-12, abs=16 * EPS)
    assert share_within(depths / shape, 1.01 * shape) != pytest.approx(expected, rel=1e-6)


def test_a_white_surface_returns_all_light():
    assert share_within(120.0, 1.0) == pytest.approx(1.0, rel=1e-12)


def test_a_longer_path_carries_light_farther():
    assert diffusion_profile(5.0, 0.5) > diffusion_profile(5.0, 1.0)
    assert diffusion_profile(0.05, 0.5) < diffusion_profile(0.05, 1.0)
