"""The substitution of v by v', and the back-vector that follows from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import back_vector, half_vector, mirror
from mrm_mtlx.bsdf.vectors import dot, normalize

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Absolute, for scalar products of unit vectors: three products, two sums, and a normalisation of each factor.
COSINE_TOL = 16 * EPS

# Share of the samples in which a planted error has to show; v.b = l.b where v = l and where the two are as steep.
MOST = 0.5

NORMAL = np.array([0.0, 0.0, 1.0])


def reflect(v: Array, n: Array) -> Array:
    """GLSL's reflect: the incident direction v mirrored at the plane of normal n."""
    return v - 2.0 * dot(n, v)[..., None] * n


def mirror_error(candidate: Callable[[Array], Array], v: Array) -> float:
    """Largest difference from v' = 2 (n.v) n - v, from twice mirrored being v, and of n.v' from n.v."""
    seen = candidate(v)
    difference = (seen - (2.0 * v[:, 2:] * NORMAL - v), candidate(seen) - v, (seen - v)[:, 2:])
    return max(float(np.max(np.abs(d))) for d in difference)


def test_mirror_turns_the_view_about_the_normal_and_back_exactly(rng, hemisphere):
    assert mirror_error(mirror, hemisphere(rng, 1000)) == 0.0


def test_a_view_mirrored_at_the_plane_instead_of_the_normal_is_seen(rng, hemisphere):
    assert mirror_error(lambda v: -mirror(v), hemisphere(rng, 1000)) > COSINE_TOL
    assert mirror_error(lambda v: v * [-1.0, 1.0, 1.0], hemisphere(rng, 1000)) > COSINE_TOL


def test_mirror_is_the_negative_of_the_shading_languages_reflect(rng, hemisphere):
    v = hemisphere(rng, 1000)
    np.testing.assert_allclose(mirror(v), reflect(-v, NORMAL), rtol=0.0, atol=COSINE_TOL)


def test_back_vector_is_the_normal_where_the_light_is_at_the_viewer(rng, hemisphere):
    v = hemisphere(rng, 1000)
    # Exactly: the tangential parts of v' and l cancel without rounding.
    assert np.array_equal(back_vector(v, v), np.broadcast_to(NORMAL, v.shape))
    assert np.max(np.abs(half_vector(v, v) - NORMAL)) > COSINE_TOL


def test_back_vector_is_the_half_vector_of_the_mirrored_view(rng, direction_pairs):
    v, l = direction_pairs(rng, 1000)
    b = back_vector(v, l)
    np.testing.assert_allclose(dot(b, b), 1.0, rtol=0.0, atol=COSINE_TOL)
    # Where v' and l nearly cancel, their sum keeps the rounding of both and loses their length.
    tolerance = COSINE_TOL / np.linalg.norm(mirror(v) + l, axis=-1)
    assert np.all(np.abs(dot(mirror(v), b) - dot(l, b)) <= tolerance)
    # The angle to v itself is another one, which Fresnel must not use.
    assert np.mean(np.abs(dot(v, b) - dot(l, b)) > tolerance) > MOST


def test_a_vector_without_direction_normalises_to_nan_and_says_nothing():
    assert np.all(np.isnan(normalize([0.0, 0.0, 0.0])))
    assert np.all(np.isnan(half_vector([0.6, 0.0, 0.8], [-0.6, 0.0, -0.8])))


def test_directions_broadcast():
    assert half_vector(np.ones((4, 1, 3)), np.ones((5, 3))).shape == (4, 5, 3)
    assert dot(np.ones((4, 1, 3)), np.ones((5, 3))).shape == (4, 5)
