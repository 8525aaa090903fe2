"""Thin films against a scalar implementation from complex amplitudes, and against what must hold for any film."""

from __future__ import annotations

import cmath
import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import fresnel, reflectance, thin_film

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Gaussian fits of the colour-matching functions as Belcour and Barla published them (supplemental code): per curve the
# XYZ row, amplitude, position [1/m] and variance.
GAUSSIANS = [
    (0, 5.4856e-13, 1.6810e6, 4.3278e9),
    (0, 9.7470e-14, 2.2399e6, 4.5282e9),
    (1, 4.4201e-13, 1.7953e6, 9.3046e9),
    (2, 5.2481e-13, 2.2084e6, 6.6121e9),
]
RGB_FROM_XYZ = [
    [2.3706743, -0.9000405, -0.4706338],
    [-0.5138850, 1.4253036, 0.0885814],
    [0.0052982, -0.0146949, 1.0093968],
]

# Absolute, for XYZ in [0, 1]. A phase of a film of 1000 nm is at most 2 * 2 pi * 2.2e6 * 2 * 2.5e-6 = 140 rad, each of
# a few roundings. The amplitudes here are roots of reflectances there, which cancel to nothing at Brewster's angles: a
# rounding of one is the root of a rounding of the other.
XYZ_TOL = 140 * 8 * EPS + 4 * np.sqrt(EPS)

# The rows of the matrix to RGB add up to 3.8 in magnitude.
RGB_TOL = 4 * XYZ_TOL

# Share of the samples in which a planted error has to show.
MOST = 0.9


def amplitudes(cos_theta: float, from_index: float, index: complex) -> tuple[complex, complex]:
    """Fresnel amplitudes (parallel, perpendicular) from a medium to another, positive where the field keeps its sign.

    In that convention a denser far side turns neither by pi: the negative of the one of most optics books.
    """
    normal = cmath.sqrt(index**2 - from_index**2 * (1.0 - cos_theta**2))
    perpendicular = (normal - from_index * cos_theta) / (normal + from_index * cos_theta)
    parallel = (index**2 * cos_theta - from_index * normal) / (index**2 * cos_theta + from_index * normal)
    return parallel, perpendicular


def cosine_inside(cos_theta: float, film: float) -> float:
    """Cosine of the refracted ray."""
    return math.sqrt(1.0 - (1.0 - cos_theta**2) / film**2)


def scalar_film(cos_theta: float, thickness_nm: float, film: float, lower: tuple[complex, complex]) -> list[float]:
    """XYZ reflectance of one film over an interface of these amplitudes, one loop per term of Airy's series."""
    path = 2.0 * film * cosine_inside(cos_theta, film) * thickness_nm * 1e-9
    total = [0.0, 0.0, 0.0]
    for top, bottom in zip(amplitudes(cos_theta, 1.0, film), lower, strict=True):
        # Seen from inside the film, the upper interface has the opposite amplitude (Stokes).
        round_trip = -top * bottom
        reflected, base = abs(top) ** 2, abs(bottom) ** 2
        through = 1.0 - reflected
        constant = through**2 * base / (1.0 - reflected * base)
        for k in range(3):
            total[k] += 0.5 * (reflected + constant)
        for m in (1, 2):
            strength = (constant - through) * abs(round_trip) ** m
            for row, amplitude, position, variance in GAUSSIANS:
                omega = 2.0 * math.pi * m * path
                wave = math.cos(position * omega + m * cmath.phase(round_trip)) * math.exp(-variance * omega**2)
                weight = amplitude * math.sqrt(2.0 * math.pi * variance) / 1.0685e-7
                total[row] += 0.5 * 2.0 * strength * weight * wave
    return total


def rgb(xyz: list[float]) -> list[float]:
    """Linear RGB, clamped."""
    return [min(max(sum(m * x for m, x in zip(row, xyz, strict=True)), 0.0), 1.0) for row in RGB_FROM_XYZ]


def random_films(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array, Array, Array]:
    """Cosine, thickness, film index, and the complex index below: a third of it dielectrics."""
    cos_theta = np.concatenate([rng.uniform(0.02, 1.0, count - 2), [1e-4, 1.0]])
    thickness, film = rng.uniform(1.0, 1000.0, count), rng.uniform(1.0, 2.5, count)
    ior, extinction = rng.uniform(0.15, 3.0, count), rng.uniform(0.5, 5.0, count)
    ior[::3], extinction[::3] = rng.uniform(1.05, 3.0, len(ior[::3])), 0.0
    return cos_theta, thickness, film, ior, extinction


def film_misses(candidate: Callable[..., Array], rng: np.random.Generator) -> float:
    """Share of random films whose colour differs from the scalar implementation's."""
    films = random_films(rng, 600)
    found = candidate(*films).T
    expected = []
    for c, d, eta, n, k in zip(*films, strict=True):
        lower = amplitudes(cosine_inside(c, eta), eta, complex(n, k))
        expected.append(rgb(scalar_film(c, d, eta, lower)))
    return float(np.mean(np.any(np.abs(found - expected) > RGB_TOL, axis=-1)))


def film_on_metal(cos_theta: Array, thickness: Array, film: Array, ior: Array, extinction: Array) -> Array:
    return reflectance.conductor_reflectance(cos_theta, ior[None], extinction[None], thickness, film)


def test_films_on_metals_and_dielectrics_match_complex_amplitudes(rng):
    assert film_misses(film_on_metal, rng) == 0.0


DAMAGED_FILMS = {
    "a thousandth too thick": lambda c, d, film, n, k: film_on_metal(c, 1.001 * d, film, n, k),
    "denser by a thousandth": lambda c, d, film, n, k: film_on_metal(c, d, 1.001 * film, n, k),
    "metal off by a thousandth": lambda c, d, film, n, k: film_on_metal(c, d, film, 1.001 * n, 0.999 * k),
    "thickness in metres": lambda c, d, film, n, k: film_on_metal(c, 1e-9 * d, film, n, k),
}


@pytest.mark.parametrize("damage", sorted(DAMAGED_FILMS))
def test_a_wrong_film_is_seen(rng, damage):
    assert film_misses(DAMAGED_FILMS[damage], rng) > MOST


def test_a_third_term_of_the_series_is_seen(rng, monkeypatch):
    monkeypatch.setattr(thin_film, "SERIES_TERMS", 3)
    # Where neither interface reflects much, the term is below any rounding; most films show it.
    assert film_misses(film_on_metal, rng) > 0.5 * MOST


def test_a_film_on_schlicks_curve_gives_half_of_it_to_each_polarisation(rng):
    cos_theta, thickness, film, *_ = random_films(rng, 200)
    color0 = rng.uniform(0.02, 0.9, 200)
    found = reflectance.schlick_reflectance(cos_theta, color0, 0.8, 1.0, 5.0, thickness, film)
    cos_film = thin_film.cosine_in_film(cos_theta, film)
    half = 0.5 * fresnel.generalized_schlick(cos_film, color0, 0.8, 1.0, 5.0)
    expected = []
    for c, d, eta, f0, below in zip(cos_theta, thickness, film, color0, half, strict=True):
        root = math.sqrt(min(max(f0, 0.01), 0.99))
        lower = cmath.rect(math.sqrt(below), math.pi if (1.0 + root) / (1.0 - root) < eta else 0.0)
        expected.append(rgb(scalar_film(c, d, eta, (lower, lower))))
    np.testing.assert_allclose(found.T, expected, rtol=0.0, atol=RGB_TOL)


def test_no_film_leaves_the_bare_surface_where_it_is_absent_alone():
    cos_theta, thickness = np.full(4, 0.7), np.array([0.0, 300.0, 0.0, 500.0])
    bare = fresnel.conductor(0.7, 0.2, 3.4)
    found = reflectance.conductor_reflectance(cos_theta, np.full((3, 1), 0.2), np.full((3, 1), 3.4), thickness, 1.5)
    assert np.all(found[:, [0, 2]] == bare)
    assert np.all(np.abs(found[:, [1, 3]] - bare) > RGB_TOL)


def white() -> Array:
    """XYZ of a reflectance of 1 under the Gaussian fits: nearly, not exactly, 1."""
    total = np.zeros(3)
    for row, amplitude, _, variance in GAUSSIANS:
        total[row] += amplitude * math.sqrt(2.0 * math.pi * variance) / 1.0685e-7
    return total


# The fits' white point, as published, is within this of 1.
WHITE_TOL = 2e-3


def test_the_fitted_colour_matching_functions_see_white_as_white():
    assert np.max(np.abs(white() - 1.0)) < WHITE_TOL


def vanishing_film_excess(film: Array, ior: float, extinction: float, bare: Array) -> Array:
    """How far a film of no thickness is from the bare surface, over what the truncated series may leave.

    Airy's series of a vanishing film adds up to the bare interface. MaterialX stops after two terms: the rest is at
    most sum over m > 2 of 2 |C| r^m = 2 |C| r^3 / (1 - r) per polarisation, the white point's error comes on top.
    """
    under = thin_film.metal_substrate(thin_film.cosine_in_film(COSINES, film), film, ior, extinction)
    found = thin_film.reflectance_xyz(COSINES, 1e-6, film, under)
    rest = np.zeros(len(COSINES))
    for top, base in zip(
        fresnel.dielectric_polarized(COSINES, film), (under.parallel, under.perpendicular), strict=True
    ):
        r = np.sqrt(top * base)
        strength = np.abs((1.0 - top) ** 2 * base / (1.0 - top * base) - (1.0 - top))
        rest += 0.5 * 2.0 * strength * r**3 / (1.0 - r)
    return np.abs(found - bare) / (rest + 4.0 * WHITE_TOL)


COSINES = np.linspace(0.05, 1.0, 60)


@pytest.mark.parametrize(("ior", "extinction"), [(1.5, 0.0), (1.2, 0.0), (2.4, 0.0), (0.2, 3.4), (1.4, 1.8)])
@pytest.mark.parametrize("film", [1.0, 1.3, 1.6])
def test_a_vanishing_film_leaves_the_bare_surface_up_to_the_truncated_series(film, ior, extinction):
    bare = fresnel.conductor(COSINES, ior, extinction)
    assert np.max(vanishing_film_excess(film, ior, extinction, bare)) <= 1.0


def test_a_film_with_the_wrong_phase_does_not_vanish():
    # With the metal's own phase left out, the series adds up to something else.
    film, ior, extinction = 1.6, 1.4, 1.8
    bare = fresnel.conductor(COSINES, ior, extinction)
    phased = thin_film.metal_substrate

    def without_phase(*arguments: Array) -> thin_film.Substrate:
        under = phased(*arguments)
        return thin_film.Substrate(
            under.parallel, under.perpendicular, 0.0 * under.phase_parallel, 0.0 * under.phase_perpendicular
        )

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(thin_film, "metal_substrate", without_phase)
        assert np.mean(np.max(vanishing_film_excess(film, ior, extinction, bare), axis=0) > 1.0) > 0.5 * MOST


# Cosines on both sides of the switch, and how much larger than its neighbours a step across it may be. The reflectance
# is smooth there, so that three neighbouring steps are equal up to the curve's bend, which is small over 1e-6.
STEP, STEP_RATIO = 1e-6, 1.5


def step_ratio(film: float, reflectance: Callable[[Array], Array]) -> float:
    """Step of a film's reflectance across Brewster's angle over the larger one of the two beside it."""
    cos_brewster = 1.0 / math.sqrt(1.0 + film * film)
    values = reflectance(cos_brewster + STEP * np.array([-1.5, -0.5, 0.5, 1.5]))
    steps = np.max(np.abs(np.diff(values, axis=-1)), axis=0)
    return float(steps[1] / max(steps[0], steps[2]))


@pytest.mark.parametrize("film", [1.2, 1.5, 2.2])
def test_the_reflectance_does_not_jump_where_the_films_phase_does(film):
    def reflectance(c: Array) -> Array:
        under = thin_film.metal_substrate(thin_film.cosine_in_film(c, film), film, 0.9, 2.5)
        return thin_film.reflectance_xyz(c, 400.0, film, under)

    def jumping(c: Array) -> Array:
        return reflectance(c) + 1e-4 * (c < 1.0 / math.sqrt(1.0 + film * film))

    assert step_ratio(film, reflectance) < STEP_RATIO
    assert step_ratio(film, jumping) > STEP_RATIO


def test_the_colour_of_a_film_is_a_reflectance(rng):
    films = random_films(rng, 4000)
    color = film_on_metal(*films)
    assert np.all((color >= 0.0) & (color <= 1.0))
    # The clamp hides what the fits and two terms leave; the colours themselves vary.
    assert np.ptp(color) > MOST


def test_a_film_thinner_than_the_outside_counts_as_none_of_its_index():
    cos_theta = np.linspace(0.1, 1.0, 20)
    below = reflectance.dielectric_reflectance(cos_theta, 1.5, 300.0, 0.8)
    assert np.array_equal(below, reflectance.dielectric_reflectance(cos_theta, 1.5, 300.0, 1.0))
