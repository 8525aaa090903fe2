"""Mixtures: what a partially retroreflective surface sees of its environment."""

from __future__ import annotations

import numpy as np

from mrm_mtlx.bsdf import environment_radiance, mirror

EPS = np.finfo(float).eps


def test_an_ordinary_surface_looks_along_the_mirror_direction_and_a_retroreflective_one_back(rng, hemisphere):
    def radiance(direction: np.ndarray) -> np.ndarray:
        return 1.0 + direction * [0.5, 0.25, 0.125]

    v = hemisphere(rng, 100)
    along, back = radiance(mirror(v)), radiance(v)
    assert np.array_equal(environment_radiance(radiance, v, 0.0), along)
    assert np.array_equal(environment_radiance(radiance, v, 1.0), back)
    # Two products and a sum on either side, each within half a rounding.
    np.testing.assert_allclose(environment_radiance(radiance, v, 0.5), 0.5 * (along + back), rtol=4 * EPS)
    mask = np.arange(100) % 2
    each = environment_radiance(radiance, v, mask)
    assert np.array_equal(each, np.where(mask[:, None] == 1, back, along))
    assert not np.allclose(along, back)
