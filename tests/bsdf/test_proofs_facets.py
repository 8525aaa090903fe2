"""Distributions of facets, their masking and their sampling, against what defines them; quadrature, no chance."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy import integrate, special

from mrm_mtlx.bsdf import beckmann, ggx, phong, slopes
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS, Rough

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.masking import Distribution, Masking

EPS = np.finfo(float).eps

# Share of the cases in which a planted error has to show.
MOST = 0.5

PLANTED = 0.03

WIDTHS = [(0.0025, 0.0025), (0.05, 0.05), (0.3, 0.05), (0.0025, 0.4), (1.0, 1.0), (1.0, 0.1)]
COSINES = [1.0, 0.7, 0.1, 1e-3]

by_distribution = pytest.mark.parametrize("name", sorted(DISTRIBUTIONS))

# Relative. Six nodes of Gauss's rule per panel: measured against sixteen, which leave 1e-12, below 4e-6.
QUADRATURE_TOL, NODES = 1e-5, 6


def view(cosine: float, azimuth: float = 0.7) -> Array:
    sine = np.sqrt(1.0 - cosine * cosine)
    return np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])


# What is seen ---------------------------------------------------------------------------------------------------------


@by_distribution
def test_projected_facets_of_every_distribution_cover_the_surface_once(seen_facets, name):
    def departure(candidate: Callable[..., Array], widths: tuple[float, float]) -> float:
        at = seen_facets(view(1.0), *widths, nodes=NODES)
        return abs(float(np.sum(candidate(*at.m.T, *widths) * at.m[:, 2] * at.facet_angle)) - 1.0)

    distribution = DISTRIBUTIONS[name].distribution

    def widened(x: Array, y: Array, z: Array, alpha_x: float, alpha_y: float) -> Array:
        return distribution(x, y, z, (1.0 + PLANTED) * alpha_x, alpha_y) * (1.0 + PLANTED)

    for widths in WIDTHS:
        assert departure(distribution, widths) < QUADRATURE_TOL
        # Wider, but normalised as if it were not.
        assert departure(widened, widths) > MOST * PLANTED


def furnace_departure(
    candidates: tuple[Masking, ...], name: str, w: Array, widths: tuple[float, float], seen_facets
) -> Array:
    """Relative departure of the visible projected area, integral of D G1 <w.m>, from n.w (Raab 2025, eq. 3)."""
    at = seen_facets(w, *widths, nodes=NODES)
    seen = DISTRIBUTIONS[name].distribution(*at.m.T, *widths) * (at.m @ w) * at.facet_angle / w[2]
    each = [seen @ g.masking(Rough(DISTRIBUTIONS[name], *widths), w[:, None], at.m.T) for g in candidates]
    return np.abs(np.array(each) - 1.0)


@dataclass(frozen=True)
class Stronger:
    """Masking that hides 3 % of what it leaves."""

    base: Masking

    def masking(self, *arguments: Array) -> Array:
        return self.base.masking(*arguments) * (1.0 - PLANTED)


@dataclass(frozen=True)
class Borrowed:
    """Smith's masking of another distribution, or with other widths."""

    other: Distribution
    exchanged: bool = False

    def masking(self, rough: Rough, w: Array, m: Array) -> Array:
        widths = (rough.alpha_x, rough.alpha_y)[:: -1 if self.exchanged else 1]
        return (w[:, 0] @ m > 0.0) / (1.0 + Rough(self.other, *widths).smith_lambda(w))


# "smith_separable" masks one direction as "smith" does.
by_masking = pytest.mark.parametrize("masking", ["smith", "v_cavity"])


@by_distribution
@by_masking
@pytest.mark.parametrize("widths", WIDTHS, ids=str)
def test_the_weak_white_furnace_holds(seen_facets, name, masking, widths):
    # Portsmouth et al. 2026, eq. 8, says that Smith's G1 is what makes this so; it is exact for all three.
    part = MASKINGS[masking]
    borrowed = Borrowed(DISTRIBUTIONS[name], exchanged=True)
    found = np.array(
        [furnace_departure((part, Stronger(part), borrowed), name, view(c), widths, seen_facets) for c in COSINES]
    )
    assert np.max(found[:, 0]) < QUADRATURE_TOL
    np.testing.assert_allclose(found[:, 1], PLANTED, rtol=0.0, atol=2 * QUADRATURE_TOL)
    assert np.max(found[:, 2]) > 1e-3 or widths[0] == widths[1]


@by_distribution
def test_another_distributions_masking_is_seen(seen_facets, name):
    # Beckmann's masking for Phong, as Walter et al. have it, is 1 % off for wide lobes.
    other = beckmann if name != "beckmann" else ggx
    assert furnace_departure((Borrowed(other),), name, view(0.1), (0.5, 0.4), seen_facets) > 1e-3


@by_distribution
@pytest.mark.parametrize("masking", sorted(MASKINGS))
def test_masking_is_a_share_and_both_together_leave_less(rng, hemisphere, name, masking):
    facets, part = DISTRIBUTIONS[name], MASKINGS[masking]
    v, l, m = (hemisphere(rng, 4000).T for _ in range(3))
    alpha_x, alpha_y = rng.uniform(0.0025, 1.0, (2, 4000))
    down = l * np.array([[1.0], [1.0], [-1.0]])
    rough = Rough(facets, alpha_x, alpha_y)
    seen = part.masking(rough, v, m)
    assert np.all((seen >= 0.0) & (seen <= 1.0))
    assert np.ptp(seen[np.sum(v * m, axis=0) > 0.0]) > MOST  # not a constant
    assert not np.any(seen[np.sum(v * m, axis=0) <= 0.0])
    for transmitted, actual in ((False, l), (True, down)):
        facing = (np.sum(v * m, axis=0) > 0.0) & ((np.sum(actual * m, axis=0) < 0.0) == transmitted)
        # From below, a facet is seen from the mirrored side: its normal is -m, mirrored upwards.
        lit_normal = np.where(transmitted, m * np.array([[-1.0], [-1.0], [1.0]]), m)
        lit = part.masking(rough, l, lit_normal)
        both = part.masking_shadowing(rough, v, l, m, transmitted=transmitted)[facing]
        least, bound = both.min(), np.minimum(seen, lit)[facing]
        assert least >= 0.0
        # A dozen roundings on each side; a cosine is off by that, absolute.
        slack = 64 * EPS / np.minimum(np.sum(v * m, axis=0), np.abs(np.sum(actual * m, axis=0)))[facing]
        assert np.all(both <= bound * (1.0 + slack))
        assert np.ptp(both) > MOST
        # More is left where hiding is correlated than where it is not, for reflection; less for transmission.
        product = (seen * lit)[facing]
        less, more = (both, product) if transmitted else (product, both)
        assert np.all(less <= more * (1.0 + slack) + 64 * EPS)
        assert masking == "smith_separable" or np.mean(less < 0.99 * more) > 0.1


@dataclass(frozen=True)
class Fixed:
    """Lambda of a direction with x > 0, and of one with x < 0."""

    ahead: float
    behind: float

    def smith_lambda(self, x: float, *_: float) -> float:
        return self.ahead if x > 0.0 else self.behind


def test_transmission_through_correlated_heights_is_eulers_integral(rng):
    # Heights h uniform in [0, 1]: h^Lv of them seen from above, (1 - h)^Ll from below (Heitz et al. 2016).
    for lambda_v, lambda_l in rng.uniform(0.0, 3.0, (6, 2)):
        expected, _ = integrate.quad(lambda h, a=lambda_v, b=lambda_l: h**a * (1.0 - h) ** b, 0.0, 1.0, epsabs=1e-12)

        arguments = Rough(Fixed(lambda_v, lambda_l), 1.0, 1.0), view(0.8, 0.0), view(0.8, np.pi), view(1.0)
        found = MASKINGS["smith"].masking_shadowing(*arguments, transmitted=True)
        assert found == pytest.approx(expected, abs=1e-10)  # of the adaptive quadrature, ten times
        assert MASKINGS["smith"].masking_shadowing(*arguments, transmitted=False) != pytest.approx(expected, abs=1e-3)


# What is sampled ------------------------------------------------------------------------------------------------------

STEP = 1e-4


def area_ratio(function: Callable[[Array, Array], Array], u1: Array, u2: Array) -> tuple[Array, Array]:
    """Solid angle of the directions, components first, per area of random numbers, and the error of that.

    Central differences at two steps, extrapolated; what the extrapolation moves is more than what it leaves.
    """

    def at(step: float) -> Array:
        along = (function(u1 + step, u2) - function(u1 - step, u2)) / (2.0 * step)
        across = (function(u1, u2 + step) - function(u1, u2 - step)) / (2.0 * step)
        return np.asarray(np.linalg.norm(np.cross(along, across, axis=0), axis=0))

    coarse, fine = at(2.0 * STEP), at(STEP)
    return (4.0 * fine - coarse) / 3.0, np.abs(fine - coarse)


def density_misses(density: Array, ratio: Array, error: Array, width: float) -> float:
    """Share of the samples at which density times solid angle is not 1.

    A direction has a rounding of 16 EPS, over the step along which it moves, which is of the lobe's width.
    """
    return float(np.mean(np.abs(density * ratio - 1.0) > density * error + 64 * EPS / (STEP * width)))


def inner(rng: np.random.Generator, count: int = 300) -> tuple[Array, Array]:
    """Random numbers away from the ends of the interval, where the slopes are infinite."""
    u1, u2 = rng.uniform(0.02, 0.98, (2, count))
    return u1, u2


@by_distribution
@pytest.mark.parametrize("widths", WIDTHS, ids=str)
def test_sampled_normals_have_the_density_of_facets(rng, name, widths):
    facets, (u1, u2) = DISTRIBUTIONS[name], inner(rng)
    m = facets.sample_normal(u1, u2, *widths)
    ratio, error = area_ratio(lambda a, b: facets.sample_normal(a, b, *widths), u1, u2)
    density = facets.distribution(*m, *widths) * m[2]
    assert density_misses(density, ratio, error, min(widths)) == 0.0
    assert density_misses(density * (1.0 + PLANTED), ratio, error, min(widths)) == 1.0
    wrong = facets.distribution(*m, *((1.0 + PLANTED) * w if w < MOST else w / (1.0 + PLANTED) for w in widths)) * m[2]
    assert density_misses(wrong, ratio, error, min(widths)) > MOST


@by_distribution
@pytest.mark.parametrize("cosine", COSINES)
@pytest.mark.parametrize("widths", WIDTHS, ids=str)
def test_sampled_visible_normals_have_the_density_of_what_is_seen(rng, name, widths, cosine):
    facets, (u1, u2) = DISTRIBUTIONS[name], inner(rng)
    v = np.broadcast_to(view(cosine)[:, None], (3, len(u1)))
    alpha_x, alpha_y = np.asarray(widths[0]), np.asarray(widths[1])
    m = facets.sample_visible(v, u1, u2, alpha_x, alpha_y)
    ratio, error = area_ratio(lambda a, b: facets.sample_visible(v, a, b, alpha_x, alpha_y), u1, u2)
    # Weighed as the weak white furnace has it, which is tested above.
    seen = np.maximum(np.sum(v * m, axis=0), 0.0) / (cosine * (1.0 + facets.smith_lambda(*v, *widths)))
    density = seen * facets.distribution(*m, *widths)
    assert density_misses(density, ratio, error, min(widths)) == 0.0
    assert density_misses(density * (1.0 + PLANTED), ratio, error, min(widths)) > 0.9
    # All normals in place of the visible ones: the same where v is n.
    unseen = facets.distribution(*m, *widths) * m[2]
    assert (density_misses(unseen, ratio, error, min(widths)) > MOST) == (cosine < 1.0)


@pytest.mark.parametrize("cosine", COSINES)
@pytest.mark.parametrize("widths", WIDTHS, ids=str)
def test_directions_off_the_bounded_cap_have_its_density(rng, widths, cosine):
    (u1, u2), alpha = inner(rng), (np.asarray(widths[0]), np.asarray(widths[1]))
    v = np.broadcast_to(view(cosine)[:, None], (3, len(u1)))

    def reflected(a: Array, b: Array) -> Array:
        m = ggx.sample_bounded(v, a, b, *alpha)
        return 2.0 * np.sum(v * m, axis=0) * m - v

    m = ggx.sample_bounded(v, u1, u2, *alpha)
    ratio, error = area_ratio(reflected, u1, u2)
    density = ggx.bounded_density(v, ggx.distribution(*m, *widths), *alpha)
    assert density_misses(density, ratio, error, min(widths)) == 0.0
    assert density_misses(density * (1.0 + PLANTED), ratio, error, min(widths)) > 0.9
    # The whole cap has another density where the bound is felt, for wide lobes away from n.
    whole = ggx.distribution(*m, *widths) / (4.0 * cosine * (1.0 + ggx.smith_lambda(*v, *widths)))
    if max(widths) == 1.0 and cosine < 1.0:
        assert density_misses(whole, ratio, error, min(widths)) > MOST


@by_distribution
def test_v_cavities_choose_between_a_facet_and_its_image_as_they_are_seen(rng, name):
    facets, cavity, widths = DISTRIBUTIONS[name], MASKINGS["v_cavity"], (0.6, 0.3)
    u = rng.random((3, 4000))
    v = np.broadcast_to(view(0.3)[:, None], u.shape)
    m, rest = cavity.sample_visible(Rough(facets, *widths), v, u)
    drawn = facets.sample_normal(u[0], u[1], *widths)
    image = drawn * np.array([[-1.0], [-1.0], [1.0]])
    here, there = (np.maximum(np.sum(v * x, axis=0), 0.0) for x in (drawn, image))
    share = here / (here + there)
    np.testing.assert_array_equal(m, np.where(u[2] < share, drawn, image))
    # The rest of the third number is uniform: it rises from 0 to 1 over either part.
    back = np.where(u[2] < share, rest * share, share + rest * (1.0 - share))
    np.testing.assert_allclose(back, u[2], rtol=0.0, atol=4 * EPS)
    assert np.all((rest >= 0.0) & (rest < 1.0 + 4 * EPS))
    # D mz is that of either; together they make the density of what is seen, G1 <v.m> D / (n.v) = 2 mz D share.
    kept = np.sum(v * m, axis=0)
    share_of_kept = kept / (kept + np.maximum(2.0 * v[2] * m[2] - kept, 0.0))
    expected = cavity.masking(Rough(facets, *widths), v, m) * kept / v[2]
    np.testing.assert_allclose(2.0 * m[2] * share_of_kept, expected, rtol=64 * EPS)
    assert np.mean(np.abs(m[2] / expected - 1.0) > PLANTED) > MOST


U_ENDS = np.array([0.0, 2.0**-53, 1e-9, 0.1, 0.5, 0.9, 1.0 - 1e-9, 1.0 - 2.0**-53])


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.2, 1.57, 0.5 * np.pi])
@pytest.mark.parametrize("nu", [None, 2.0, 8.0, 2.0 / 0.0025**2])
def test_slopes_are_where_the_share_below_them_is_the_random_number(theta, nu):
    # Independent of the cumulative function in use: the density, integrated adaptively.
    if nu is None:
        scale, p = 1.0, lambda q: np.exp(-q * q) / np.sqrt(np.pi)
        marginal = slopes.Marginal(
            lambda s: s, lambda s: 0.5 * special.erfc(-s), lambda s: np.exp(-s * s) / np.sqrt(4.0 * np.pi), p, -7.0
        )
        end = 7.0 if np.tan(theta) * 7.0 < 1.0 else 1.0 / np.tan(theta)
    else:
        scale, marginal = 1.0 / np.sqrt(nu), phong._student(np.asarray(nu))
        constant = 1.0 / (special.beta(0.5, 0.5 * nu))
        p = lambda q: constant * np.exp(-0.5 * (nu + 1.0) * np.log1p(q * q))  # noqa: E731
        end = min(np.arcsinh(np.sqrt(nu) / max(np.tan(theta), 1e-30)), 40.0)
    c, s = np.asarray(np.cos(theta)), np.asarray(np.sin(theta))
    q = slopes.sample_visible(U_ENDS, c, s, np.full_like(U_ENDS, end), marginal)
    assert np.all(np.isfinite(q))
    assert np.all(np.diff(q) > 0.0)
    assert np.all(c - q * s > -1e-15)  # seen, or at the edge
    grid = np.sinh(np.linspace(-40.0, float(np.arcsinh(q[-1] / scale)), 41)) * scale
    total = _integral(p, c, s, grid)
    for share, slope in zip(U_ENDS[2:6], q[2:6], strict=True):
        found = _integral(p, c, s, np.append(grid[grid < slope], slope)) / total
        # Absolute; forty adaptive quadratures of 1e-12 each. The inversion itself is exact to rounding.
        assert found == pytest.approx(share, abs=1e-10)


def _integral(p: Callable[[float], float], c: Array, s: Array, edges: Array) -> float:
    """Of (c - q s) p(q) between neighbouring edges, summed."""
    return sum(
        integrate.quad(lambda q: float((c - q * s) * p(q)), a, b, epsabs=1e-14, limit=200)[0]
        for a, b in pairwise(edges)
    )


@by_distribution
@pytest.mark.parametrize("widths", [*WIDTHS, (1.0, 0.0025)], ids=str)
def test_at_the_ends_of_all_ranges_facets_are_unit_and_finite(name, widths):
    facets = DISTRIBUTIONS[name]
    u = np.stack(np.meshgrid(*[U_ENDS[[0, 1, 4, 7]]] * 3)).reshape(3, -1)
    for cosine in (1.0, 0.5, 1e-3, 1e-6):
        for azimuth in (0.7, 0.5 * np.pi):
            v = np.broadcast_to(view(cosine, azimuth)[:, None], u.shape)
            for masking in MASKINGS.values():
                m, rest = masking.sample_visible(Rough(facets, *map(np.asarray, widths)), v, u)
                np.testing.assert_allclose(np.linalg.norm(m, axis=0), 1.0, rtol=8 * EPS)
                assert np.all(m[2] >= 0.0)
                # A facet at the edge of what is seen is off by a rounding in the stretched frame.
                assert np.all(np.sum(v * m, axis=0) > -8 * EPS / min(widths))
                assert np.all((rest >= 0.0) & (rest <= 1.0))
                assert np.all(np.isfinite(facets.distribution(*m, *widths)))
