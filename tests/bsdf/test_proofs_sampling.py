"""Samples against their densities: mass, histograms, estimators that agree, and the variance of a white furnace."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from scipy import stats

from mrm_mtlx.bsdf import (
    EON,
    Blend,
    Conductor,
    Dielectric,
    GeneralizedSchlick,
    Lambert,
    mirror,
    partially_retroreflective,
)
from mrm_mtlx.bsdf.fresnel import schlick_ior
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS, Rough
from mrm_mtlx.bsdf.vectors import components, normalize

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf import Lobe
    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

PLANTED = 0.03

# Chance of missing a planted error of 3 %, at most: the numbers of samples are such, and each test computes it.
MISS = 1e-3

VIEW = np.array([0.7, 0.1, 0.6]) / np.sqrt(0.86)


# Mass -----------------------------------------------------------------------------------------------------------------

# Absolute, of the quadrature over facets with six nodes to a panel: measured against twelve, 3.7e-6.
MASS_TOL, NODES_OF_FACETS = 1e-5, 6


@pytest.mark.parametrize("distribution", sorted(DISTRIBUTIONS))
@pytest.mark.parametrize("masking", ["smith", "v_cavity"])
def test_densities_and_lost_samples_make_one(seen_facets, distribution, masking):
    for alpha in ((0.0025, 0.0025), (0.3, 0.1), (1.0, 1.0)):
        for v in (-np.array([0.1, 0.3, 0.95]), np.array([0.7, 0.7, 0.02])):
            v, side = normalize(v), np.sign(v[2])
            for mode, retro in (("R", True), ("T", False)):
                lobe = Dielectric(
                    1.5, alpha=alpha, distribution=distribution, masking=masking, scatter_mode=mode,
                    sampling="visible", retroreflective=retro, retroreflective_btdf=retro,
                )  # fmt: skip
                w = side * (mirror(v) if retro else v)
                at = seen_facets(w, *alpha, eta=1.5**side if mode == "T" else None, nodes=NODES_OF_FACETS)
                found = float(lobe.pdf(v, side * at.l) @ at.solid_angle)
                # Facets that send light nowhere, in proportion to how they are seen.
                lost = at.solid_angle == 0.0
                m, angle = at.m[lost], at.facet_angle[lost]
                g1 = MASKINGS[masking].masking(Rough(DISTRIBUTIONS[distribution], *alpha), w[:, None], m.T)
                missing = float(np.sum(g1 * DISTRIBUTIONS[distribution].distribution(*m.T, *alpha) * (m @ w) * angle))
                assert abs(found + missing / w[2] - 1.0) < MASS_TOL
                assert found > 0.3
                assert abs((1.0 + PLANTED) * found + missing / w[2] - 1.0) > MASS_TOL


def test_the_density_on_the_bounded_cap_makes_one_with_what_is_lost(seen_facets):
    count = 512
    u = np.stack([*np.meshgrid(*[(np.arange(count) + 0.5) / count] * 2), np.zeros((count, count))], axis=-1)
    for alpha in ((0.0025, 0.0025), (0.3, 0.1), (1.0, 1.0)):
        for v in (VIEW, normalize(np.array([0.7, 0.7, 0.02]))):
            bounded = Dielectric(1.5, alpha=alpha, sampling="bounded")
            at = seen_facets(v, *alpha)
            mass = float(bounded.pdf(v, at.l) @ at.solid_angle)
            lost = np.mean(np.all(bounded.sample(v, u) == 0.0, axis=-1))
            # Squares that the boundary of what is lost runs through: not more than four rows of them.
            assert abs(mass + lost - 1.0) < 4.0 / count
            assert abs((1.0 + PLANTED) * mass + lost - 1.0) > 4.0 / count
            # Fewer are lost than of all visible normals; the density is what it should be, higher.
            assert mass >= float(replace(bounded, sampling="visible").pdf(v, at.l) @ at.solid_angle) - MASS_TOL


# Histograms -----------------------------------------------------------------------------------------------------------

# With 60 to 150 cells, a density that is off by 3 % everywhere, half of it up and half down, is missed less than once
# in a thousand at the level of the suite. A chi-square of n samples is then off by 9e-4 n.
SAMPLES = 1 << 18

# Expected counts below this are pooled, so that counts are near enough to normal.
POOLED = 10.0


class Pooled(NamedTuple):
    """Cells whose expected count is large enough, the rest as one."""

    cell: Array
    shares: Array


def pooled(shares: Array) -> Pooled:
    assert np.min(shares) > -MASS_TOL, "a negative density"
    small = shares * SAMPLES < POOLED
    cell = np.where(small, np.count_nonzero(~small), np.cumsum(~small) - 1)
    sums = np.bincount(cell, weights=np.maximum(shares, 0.0))
    # What is left of nearly empty cells, if it is nearly empty itself, goes to the largest.
    if len(sums) > 1 and np.any(small) and sums[-1] * SAMPLES < POOLED:
        largest = int(np.argmax(sums[:-1]))
        sums[largest] += sums[-1]
        cell, sums = np.where(small, largest, cell), sums[:-1]
    return Pooled(cell, sums / np.sum(sums))


def chi_square(counts: Array, cells: Pooled) -> float:
    """Probability of counts as far from the shares of the cells as these, or farther."""
    found = np.bincount(cells.cell, weights=counts, minlength=len(cells.shares))
    expected = cells.shares * np.sum(counts)
    return float(stats.chi2.sf(np.sum(np.square(found - expected) / expected), len(expected) - 1))


def chance_of_missing(true: Array, wrong: Array, level: float) -> float:
    """Chance that samples of the one density pass for samples of the other."""
    cells = pooled(wrong)
    sums = np.bincount(cells.cell, weights=true, minlength=len(cells.shares))
    off = SAMPLES * float(np.sum(np.square(sums / np.sum(sums) - cells.shares) / cells.shares))
    freedom = len(cells.shares) - 1
    return float(stats.ncx2.cdf(stats.chi2.isf(level, freedom), freedom, off))


@dataclass(frozen=True)
class Histogram:
    """Cells over directions; each adapter makes one for a view. The last cell is that of lost samples."""

    shares: Callable[[Callable[[Array], Array]], Array]  # of a density of l
    cell: Callable[[Array], Array]  # of directions

    def filled(self, pdf: Callable[[Array], Array]) -> Array:
        shares = self.shares(pdf)
        return np.append(shares, 1.0 - np.sum(shares))


def assert_follows(
    histogram: Histogram, lobe: Lobe, v: Array, l: Array, level: float, wrong: dict[str, Callable[[Array], Array]]
) -> None:
    """Samples l follow the density of a lobe, and would not follow the wrong ones."""
    shares = histogram.filled(lambda x: lobe.pdf(v, x))
    cell = histogram.cell(l)
    counts = np.bincount(cell, minlength=len(shares))
    never = (shares <= 0.0) & (counts > 0)
    assert not np.any(never[:-1]), f"{counts[never]} samples where the density is 0"
    # No sample but a lost one is without a density.
    assert np.all((lobe.pdf(v, l) > 0.0) == np.any(l != 0.0, axis=-1))
    p = chi_square(counts, pooled(shares))
    assert p > level, f"p = {p:.2g}, cells {np.argsort(np.abs(counts - SAMPLES * shares))[-5:]} are farthest"
    # Up and down by 3 %: nearer to the peak than half of the samples, and farther.
    near = np.cumsum(shares) < 0.5 * np.sum(shares)
    off = np.where(near, 1.0 + PLANTED, 1.0 - PLANTED) * shares
    planted = {"peak": off / np.sum(off), **{name: histogram.filled(pdf) for name, pdf in wrong.items()}}
    for name, other in planted.items():
        assert chance_of_missing(shares, other, level) < MISS, name
        assert chi_square(counts, pooled(other)) < level, name


RINGS, SECTORS = 6, 10


def index_inside(lobe: Conductor | Dielectric | GeneralizedSchlick) -> float:
    """Index of a lobe inside over outside; 1 where there is no inside."""
    if isinstance(lobe, Conductor):
        return 1.0
    return float(lobe.ior if isinstance(lobe, Dielectric) else schlick_ior(np.mean(lobe.color0)))


@pytest.fixture(scope="module")
def over_facets(seen_facets) -> Callable[..., Histogram]:
    """Adapter to interfaces of any width: cells are rings and sectors of the slopes that reflect or refract v to l.

    Three times the nodes move chi-square by 0.85 at most, where it has a deviation of 10.
    """

    def make(lobe: Dielectric, v: Array) -> Histogram:
        side = float(np.sign(v[2]))
        index = index_inside(lobe) ** side
        rings = tuple(np.sqrt(k / (RINGS - k)) for k in range(1, RINGS))
        parts = []
        for mode, eta, mirrored in (("R", None, lobe.retroreflective), ("T", index, lobe.retroreflective_btdf)):
            if mode in lobe.scatter_mode:
                w = side * (mirror(v) if mirrored else v)
                critical = index if index < 1.0 else None
                at = seen_facets(w, *lobe.alpha, eta=eta, critical=critical, rings=rings, sectors=SECTORS)
                parts.append((w, eta, at))

        def shares(pdf: Callable[[Array], Array]) -> Array:
            found = []
            for _, _, at in parts:
                mass = pdf(side * at.l) * at.solid_angle
                found.append(np.bincount(at.ring * SECTORS + at.sector, weights=mass, minlength=RINGS * SECTORS))
            return np.concatenate(found)

        def cell(l: Array) -> Array:
            found = np.full(len(l), len(parts) * RINGS * SECTORS)
            l = side * l
            for k, (w, eta, _) in enumerate(parts):
                mine = l[:, 2] > 0.0 if eta is None else l[:, 2] < 0.0
                m = w + l[mine] * (1.0 if eta is None else eta)
                m *= np.sign(m[:, 2:])
                x, y = -m[:, 0] / (m[:, 2] * lobe.alpha[0]), -m[:, 1] / (m[:, 2] * lobe.alpha[1])
                ring = np.searchsorted(np.asarray(rings), np.hypot(x, y))
                sector = np.floor(np.mod(np.arctan2(y, x) / (2.0 * np.pi), 1.0) * SECTORS).astype(int)
                found[mine] = k * RINGS * SECTORS + ring * SECTORS + sector % SECTORS
            return found

        return Histogram(shares, cell)

    return make


HEIGHTS, AZIMUTHS, NODES = 10, 12, 10


def over_the_sphere() -> Histogram:
    """Adapter to broad lobes of any kind: cells of equal solid angle, heights and azimuths.

    Eight times the nodes move chi-square by 0.02 at most, for the lobes here.
    """
    x, weight = np.polynomial.legendre.leggauss(NODES)
    x, weight = 0.5 * (x + 1.0), 0.5 * weight
    z = ((np.arange(HEIGHTS)[:, None] + x) * (2.0 / HEIGHTS) - 1.0).ravel()
    phi = ((np.arange(AZIMUTHS)[:, None] + x) * (2.0 * np.pi / AZIMUTHS)).ravel()
    sine = np.sqrt(1.0 - z * z)[:, None]
    l = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(z[:, None], (len(z), len(phi)))], axis=-1)

    def shares(pdf: Callable[[Array], Array]) -> Array:
        values = pdf(l).reshape(HEIGHTS, NODES, AZIMUTHS, NODES)
        cells = np.einsum("aibj,i,j->ab", values, weight, weight)
        return np.ravel(cells) * (4.0 * np.pi / (HEIGHTS * AZIMUTHS))

    def cell(l: Array) -> Array:
        height = np.minimum(np.floor((l[:, 2] + 1.0) * (0.5 * HEIGHTS)).astype(int), HEIGHTS - 1)
        azimuth = np.floor(np.mod(np.arctan2(l[:, 1], l[:, 0]) / (2.0 * np.pi), 1.0) * AZIMUTHS).astype(int)
        found = height * AZIMUTHS + azimuth % AZIMUTHS
        return np.where(np.any(l != 0.0, axis=-1), found, HEIGHTS * AZIMUTHS)

    return Histogram(shares, cell)


NARROW, BRUSHED, WIDE = (0.0025, 0.0025), (0.5, 0.2), (1.0, 1.0)

# Half of the light is reflected, so that a wrong choice shows.
HALF = {"color0": 0.5, "color90": 0.5, "sampling": "visible", "scatter_mode": "RT"}
FULL = {"retroreflective": True, "retroreflective_btdf": True}

GRAZING = normalize(np.array([0.5, 0.8, 0.05]))
INSIDE = -normalize(np.array([0.3, 0.2, 0.9]))

FACETED = {
    "bounded narrow": (Dielectric(alpha=NARROW, retroreflective=True), VIEW),
    "bounded brushed": (Dielectric(alpha=BRUSHED), VIEW),
    "bounded wide at grazing": (Dielectric(alpha=WIDE, retroreflective=True), GRAZING),
    "visible at grazing": (Conductor(0.2, 3.4, alpha=BRUSHED, sampling="visible"), GRAZING),
    "refraction narrow": (Dielectric(alpha=NARROW, scatter_mode="T", **FULL), VIEW),
    "refraction from inside": (Dielectric(alpha=BRUSHED, scatter_mode="T"), INSIDE),
    "interface, classic": (GeneralizedSchlick(alpha=BRUSHED, **HALF), VIEW),
    "interface, full": (GeneralizedSchlick(alpha=BRUSHED, **HALF, **FULL), VIEW),
    "interface, mixed": (GeneralizedSchlick(alpha=BRUSHED, **HALF, retroreflective=True), VIEW),
    "interface from inside": (Dielectric(alpha=(0.2, 0.1), scatter_mode="RT", retroreflective=True), INSIDE),
    "beckmann": (Dielectric(alpha=BRUSHED, distribution="beckmann", retroreflective=True), VIEW),
    "phong": (Dielectric(alpha=BRUSHED, distribution="phong", retroreflective=True), VIEW),
    "v-cavity": (Dielectric(alpha=BRUSHED, masking="v_cavity", retroreflective=True), GRAZING),
    "v-cavity, mixed": (
        GeneralizedSchlick(alpha=BRUSHED, **HALF, retroreflective=True, masking="v_cavity", distribution="phong"),
        VIEW,
    ),
}


@pytest.mark.parametrize("name", sorted(FACETED))
def test_samples_of_facets_follow_their_density(rng, significance, over_facets, name):
    lobe, v = FACETED[name]
    l = lobe.sample(v, rng.random((SAMPLES, 3)))
    scale = 1.0 + PLANTED if max(lobe.alpha) < 1.0 else 1.0 / (1.0 + PLANTED)
    wider = replace(lobe, alpha=tuple(scale * a for a in lobe.alpha))
    wrong = {"width": lambda x: wider.pdf(v, x)}
    if name.startswith("interface, "):
        # Of a half that is reflected, 3 % more.
        up, down = (replace(lobe, scatter_mode=mode) for mode in "RT")
        share = 0.5 * (1.0 + PLANTED)
        wrong["choice"] = lambda x: share * up.pdf(v, x) + (1.0 - share) * down.pdf(v, x)
    assert_follows(over_facets(lobe, v), lobe, v, l, significance.level(), wrong)


@dataclass(frozen=True)
class Unscaled(Blend):
    """A wrong blend: the number that chose is handed on as it was."""

    def sample(self, v: Array, u: Array) -> Array:
        chosen = components("u", u)[..., 2:] < self.w
        return np.where(chosen, self.b.sample(v, u), self.a.sample(v, u))


METAL = Conductor(0.2, 3.4, alpha=(0.6, 0.5))
GLASS = GeneralizedSchlick(alpha=(0.4, 0.4), distribution="beckmann", masking="v_cavity", **HALF)

BROAD = {
    "lambert": Lambert(0.5),
    "eon": EON(0.5, 0.8),
    "half retroreflective": partially_retroreflective(METAL, 0.5),
    "glass over paint": Blend(GLASS, EON(0.5, 0.8), 0.5),
    "nested": Blend(Blend(Lambert(), METAL, 0.4), replace(GLASS, **FULL), 0.5),
}


# Its two lobes do not overlap, so that a weight that is 3 % off shows.
APART = partially_retroreflective(replace(METAL, alpha=(0.3, 0.25)), 0.5)


@pytest.mark.parametrize("name", [*sorted(BROAD), "apart"])
def test_samples_of_broad_lobes_and_blends_follow_their_density(rng, significance, name):
    lobe = BROAD.get(name, APART)
    l = lobe.sample(VIEW, rng.random((SAMPLES, 3)))
    other = replace(APART, w=APART.w * (1.0 + PLANTED))
    wrong = {"weight": lambda x: other.pdf(VIEW, x)} if lobe is APART else {}
    assert_follows(over_the_sphere(), lobe, VIEW, l, significance.level(), wrong)


def test_a_blend_that_hands_its_number_on_unscaled_is_seen(rng, significance):
    lobe, histogram = BROAD["glass over paint"], over_the_sphere()
    u = rng.random((SAMPLES, 3))
    shares = pooled(histogram.filled(lambda x: lobe.pdf(VIEW, x)))
    p = [
        chi_square(np.bincount(histogram.cell(l), minlength=HEIGHTS * AZIMUTHS + 1), shares)
        for l in (lobe.sample(VIEW, u), Unscaled(lobe.a, lobe.b, lobe.w).sample(VIEW, u))
    ]
    assert p[0] > significance.level() > p[1]


@pytest.mark.parametrize("w", [-0.1, 1.1, np.nan])
def test_a_weight_that_is_no_share_is_refused(w):
    blend = Blend(Lambert(), METAL, w)
    for call in (lambda: blend.eval(VIEW, VIEW), lambda: blend.pdf(VIEW, VIEW), lambda: blend.sample(VIEW, VIEW)):
        with pytest.raises(ValueError, match=r"^w must be in \[0, 1\], got "):
            call()


def test_a_blend_of_all_or_nothing_is_one_of_its_lobes(rng):
    u = rng.random((1000, 3))
    for w, one in ((0.0, METAL), (1.0, GLASS)):
        blend = Blend(METAL, GLASS, w)
        l = one.sample(VIEW, u)
        assert np.array_equal(blend.sample(VIEW, u), l)
        assert np.array_equal(blend.pdf(VIEW, l), one.pdf(VIEW, l))
        assert np.array_equal(blend.eval(VIEW, l), one.eval(VIEW, l))


# Estimators -----------------------------------------------------------------------------------------------------------


def uniform_on_the_sphere(u: Array) -> tuple[Array, Array]:
    z, phi = 2.0 * u[:, 0] - 1.0, 2.0 * np.pi * u[:, 1]
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1), np.full(len(u), 0.25 / np.pi)


def cosine_on_both_sides(u: Array) -> tuple[Array, Array]:
    upper = Lambert().sample([0.0, 0.0, 1.0], u)
    l = upper * np.where(u[:, 2:] < 0.5, 1.0, [1.0, 1.0, -1.0])
    return l, np.abs(l[:, 2]) / (2.0 * np.pi)


def own(lobe: Lobe) -> Callable[[Array], tuple[Array, Array]]:
    def sample(u: Array) -> tuple[Array, Array]:
        l = lobe.sample(VIEW, u)
        return l, lobe.pdf(VIEW, l)

    return sample


@pytest.mark.parametrize("name", sorted(BROAD))
def test_estimators_agree_with_each_other_and_with_quadrature(rng, significance, name):
    lobe = BROAD[name]
    cosine = Histogram(over_the_sphere().shares, len)
    # The lobe times the cosine, integrated as if it were a density, over all cells.
    expected = float(np.sum(cosine.shares(lambda x: lobe.eval(VIEW, x)[..., 0] * np.abs(x[..., 2]))))
    for sampler in (uniform_on_the_sphere, cosine_on_both_sides, own(lobe)):
        l, pdf = sampler(rng.random((SAMPLES, 3)))
        weight = lobe.eval(VIEW, l)[:, 0] * np.abs(l[:, 2])
        each = np.where(pdf > 0.0, weight / np.where(pdf > 0.0, pdf, 1.0), 0.0)
        error = np.std(each) / np.sqrt(SAMPLES) + 1e-9  # samples of a constant have none but rounding
        # Two decisions more than estimators: the sums over the sphere are good to 1e-5.
        allowed = significance.sigmas(3) * error + 1e-5
        assert abs(np.mean(each) - expected) < allowed
        # One that is 3 % too bright is missed less than once in a thousand.
        assert allowed + stats.norm.isf(MISS) * error < PLANTED * expected
        assert abs((1.0 + PLANTED) * np.mean(each) - expected) > allowed


# White furnace --------------------------------------------------------------------------------------------------------

FURNACE = 1 << 16

WIDTHS = [0.0025, 0.01, 0.05, 0.2, 0.5, 1.0]


class Spread(NamedTuple):
    """Of the estimate's terms: mean, variance, and what squares of deviations from the mean vary by themselves."""

    mean: float
    variance: float
    fourth: float


def predicted_spread(lobe: GeneralizedSchlick, v: Array, seen_facets) -> Spread:
    """Of an ordinary lobe by quadrature over facets, from f and pdf alone; lost samples are terms of 0."""
    at = seen_facets(v, *lobe.alpha, nodes=NODES_OF_FACETS)
    pdf = lobe.pdf(v, at.l)
    share = pdf * at.solid_angle
    term = np.where(pdf > 0.0, lobe.eval(v, at.l)[:, 0] * at.l[:, 2] / np.where(pdf > 0.0, pdf, 1.0), 0.0)
    lost = max(1.0 - float(np.sum(share)), 0.0)
    mean = float(share @ term)
    variance = float(share @ np.square(term - mean)) + lost * mean**2
    return Spread(mean, variance, float(share @ (term - mean) ** 4) + lost * mean**4 - variance**2)


def bernstein(variance: float, largest: float, level: float) -> float:
    """What the mean of numbers of this variance may be off, at a level that holds for any distribution.

    Bernstein's inequality, P(|mean - expected| > t) <= 2 exp(-n t^2 / (2 (variance + largest t / 3))), where none is
    farther from its expectation than `largest`. A normal approximation would not do: terms of narrow lobes are all but
    the same, a few in a million excepted.
    """
    strength = np.log(2.0 / level) / FURNACE
    linear = strength * largest / 3.0
    return float(linear + np.sqrt(linear * linear + 2.0 * strength * max(variance, 0.0)))


def furnace_terms(lobe: GeneralizedSchlick, v: Array, l: Array, pdf: Array) -> Array:
    kept = pdf > 0.0
    return np.where(kept, lobe.eval(v, l)[:, 0] * l[:, 2] / np.where(kept, pdf, 1.0), 0.0)


def by_all_normals(lobe: GeneralizedSchlick, v: Array, u: Array) -> Array:
    """Terms of an ordinary lobe, wrongly sampled: facets with density D mz, seen or not."""
    m = DISTRIBUTIONS[lobe.distribution].sample_normal(u[:, 0], u[:, 1], *lobe.alpha).T
    cosine = m @ v
    l = 2.0 * cosine[:, None] * m - v
    density = DISTRIBUTIONS[lobe.distribution].distribution(*m.T, *lobe.alpha) * m[:, 2]
    kept = (cosine > 0.0) & (l[:, 2] > 0.0)
    pdf = np.where(kept, density / (4.0 * np.where(kept, cosine, 1.0)), 0.0)
    return furnace_terms(lobe, v, np.where(kept[:, None], l, 0.0), pdf)


def furnace_views(alpha: float) -> list[Array]:
    """Tilted, steep, and where the facets' slopes are as large as the view's."""
    cosines = np.array([0.7, 0.1, 0.5 * min(alpha, 0.1)])
    sines = np.sqrt(1.0 - cosines**2)
    return list(np.stack([sines * np.cos(0.7), sines * np.sin(0.7), cosines], axis=-1))


PARTS = [("ggx", "smith", a) for a in WIDTHS] + [("beckmann", "smith", 0.2), ("ggx", "v_cavity", 0.2)]


@pytest.mark.parametrize(("distribution", "masking", "alpha"), PARTS)
def test_a_white_furnace_has_the_mean_and_the_variance_of_visible_normals(
    rng, significance, seen_facets, distribution, masking, alpha
):
    samplings = ("bounded", "visible") if (distribution, masking) == ("ggx", "smith") else ("visible",)
    views = furnace_views(alpha)
    level = significance.level(len(views) * len(samplings) * 2 * 2)  # flags; mean and variance
    all_normals_seen = []
    for v in views:
        for sampling in samplings:
            ordinary = GeneralizedSchlick(
                alpha=(alpha, alpha), sampling=sampling, distribution=distribution, masking=masking
            )
            # One prediction for both: the retroreflective lobe is as good to sample as the ordinary one.
            spread = predicted_spread(ordinary, v, seen_facets)
            farthest = max(spread.mean, 1.0 - spread.mean)  # terms lie in [0, 1]
            allowed = bernstein(spread.variance, farthest, level)
            allowed_square = bernstein(spread.fourth, farthest**2, level)
            for retro in (False, True):
                lobe = replace(ordinary, retroreflective=retro)
                u = rng.random((FURNACE, 3))
                l = lobe.sample(v, u)
                terms = furnace_terms(lobe, v, l, lobe.pdf(v, l))
                # Of visible normals the weight is G2 / G1, and on the bounded cap less.
                assert np.max(terms) < 1.0 + 1e-9  # roundings of narrow lobes, EPS / alpha^2
                assert abs(np.mean(terms) - spread.mean) < allowed
                assert abs(np.mean(np.square(terms - spread.mean)) - spread.variance) < allowed_square
                # A lobe that is 3 % too bright; and facets drawn without regard to whether v sees them.
                assert abs((1.0 + PLANTED) * np.mean(terms) - spread.mean) > allowed
                if not retro and sampling == "visible":
                    wrong = np.mean(np.square(by_all_normals(lobe, v, u) - spread.mean))
                    all_normals_seen.append(abs(wrong - spread.variance) > allowed_square)
    assert all_normals_seen[-1]
