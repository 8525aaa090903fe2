"""Replacing v by v': Jacobians, reciprocity, symmetry and limits, for all distributions, maskings and combinations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import (
    EON,
    Blend,
    Conductor,
    Dielectric,
    GeneralizedSchlick,
    Lambert,
    back_vector,
    fresnel,
    half_vector,
    mirror,
    partially_retroreflective,
)
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS, Rough
from mrm_mtlx.bsdf.microfacet import refracting
from mrm_mtlx.bsdf.vectors import dot, normalize

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf import Lobe
    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Share of the samples in which a planted error has to show.
MOST = 0.5

PLANTED = 0.03

# Ordinary; retroreflective; retroreflective reflection over ordinary transmission (Portsmouth et al. 2026, Figure 6).
COMBINATIONS = {"classic": (False, False), "full": (True, True), "mixed": (True, False)}

by_distribution = pytest.mark.parametrize("distribution", sorted(DISTRIBUTIONS))
by_masking = pytest.mark.parametrize("masking", sorted(MASKINGS))
by_combination = pytest.mark.parametrize("combination", sorted(COMBINATIONS))

DOWN = np.array([1.0, 1.0, -1.0])


def glass(combination: str = "classic", **parameters) -> Dielectric:
    """Both sides of an interface; the fields of `Dielectric`, by default rough glass."""
    retroreflective, btdf = COMBINATIONS[combination]
    given = {"ior": 1.5, "alpha": (0.3, 0.2), "scatter_mode": "RT", "sampling": "visible", **parameters}
    return Dielectric(retroreflective=retroreflective, retroreflective_btdf=btdf, **given)


@pytest.fixture(scope="module")
def scattered_pairs(hemisphere) -> Callable[..., tuple[Array, Array]]:
    """Function that draws v on both sides, and l as a lobe scatters it; pairs without light are left out."""

    def draw(rng: np.random.Generator, lobe: Lobe, count: int = 3000, steep: float = 0.0) -> tuple[Array, Array]:
        v = hemisphere(rng, count) * rng.choice([-1.0, 1.0], (count, 1))
        l = lobe.sample(v, rng.random((count, 3)))
        kept = (np.abs(l[:, 2]) > steep) & (np.abs(v[:, 2]) > steep)
        return v[kept], l[kept]

    return draw


# Jacobians (Portsmouth et al. 2026, eq. 4 and 5) ----------------------------------------------------------------------

STEP = 1e-5

# Relative. The third derivative of a half-vector, over its length, is at most a few thousand where |v' + eta l| is
# above 0.1: its square step, 1e-10, leaves 1e-6; a rounding over the step, 1e-11, is less.
JACOBIAN_TOL = 1e-5


def half_transmitted(v: Array, l: Array, eta_v: float, eta_l: float) -> Array:
    """h_t of v and l, the indices on their sides given: unit, on the side of the smaller index."""
    return -normalize(eta_v * v + eta_l * l)


def measured_jacobian(facet: Callable[[Array], Array], l: Array) -> Array:
    """Solid angle of the facets per solid angle of l, by central differences along two tangents of l."""
    first = normalize(np.cross(l, np.where(np.abs(l[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])))
    second = np.cross(l, first)

    def along(tangent: Array) -> Array:
        return (facet(normalize(l + STEP * tangent)) - facet(normalize(l - STEP * tangent))) / (2.0 * STEP)

    return np.linalg.norm(np.cross(along(first), along(second)), axis=-1)


def jacobian_misses(candidate: Array, measured: Array) -> float:
    return float(np.mean(np.abs(candidate / measured - 1.0) > JACOBIAN_TOL))


def test_the_jacobian_of_reflection_is_a_quarter_over_the_cosine(rng, hemisphere):
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000)
    far = np.linalg.norm(mirror(v) + l, axis=-1) > 0.1
    v, l = v[far], l[far]
    measured = measured_jacobian(lambda x: back_vector(v, x), l)
    b = back_vector(v, l)
    assert jacobian_misses(1.0 / (4.0 * np.abs(dot(l, b))), measured) == 0.0
    assert jacobian_misses(1.0 / (4.0 * np.abs(dot(v, b))), measured) > MOST  # v is not v'
    assert jacobian_misses((1.0 + PLANTED) / (4.0 * np.abs(dot(l, b))), measured) == 1.0


@pytest.mark.parametrize(("eta_v", "eta_l"), [(1.0, 1.5), (1.5, 1.0), (1.3, 2.0)])
def test_the_jacobian_of_refraction_has_the_index_of_the_light(rng, hemisphere, eta_v, eta_l):
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000) * DOWN
    seen = mirror(v)
    path = eta_v * seen + eta_l * l
    far = np.linalg.norm(path, axis=-1) > 0.1
    seen, l = seen[far], l[far]
    measured = measured_jacobian(lambda x: half_transmitted(seen, x, eta_v, eta_l), l)
    b = half_transmitted(seen, l, eta_v, eta_l)
    form = np.abs(dot(l, b)) / np.square(eta_v * dot(seen, b) + eta_l * dot(l, b))
    # Walter et al. 2007, eq. 17: of the direction that varies. Eq. 5 as printed has the other one.
    assert jacobian_misses(eta_l**2 * form, measured) == 0.0
    assert jacobian_misses(eta_v**2 * form, measured) == 1.0
    assert jacobian_misses((1.0 + PLANTED) * eta_l**2 * form, measured) == 1.0


@by_distribution
@by_masking
@by_combination
def test_densities_are_those_of_facets_times_the_jacobian(rng, scattered_pairs, distribution, masking, combination):
    for mode in ("R", "T"):
        lobe = glass(combination, distribution=distribution, masking=masking, scatter_mode=mode)
        # Seen from above; from below the same, with the inverse index.
        v, l = scattered_pairs(rng, lobe, 300, steep=0.05)
        sign = np.sign(v[:, 2:])
        eta = np.where(sign[:, 0] > 0.0, 1.5, 1.0 / 1.5)
        turned = mirror(v) if COMBINATIONS[combination][mode == "T"] else v

        def facet(x: Array, turned=turned, sign=sign, eta=eta, mode=mode) -> Array:
            m = normalize(turned + x) if mode == "R" else normalize(turned + eta[:, None] * x)
            return m * np.sign(m[:, 2:]) * sign

        m = facet(l) * sign
        w = turned * sign
        widths = lobe.alpha
        g1 = MASKINGS[masking].masking(Rough(DISTRIBUTIONS[distribution], *widths), w.T, m.T)
        visible = g1 * np.abs(dot(w, m)) * DISTRIBUTIONS[distribution].distribution(*m.T, *widths) / w[:, 2]
        measured = measured_jacobian(facet, l)
        far = np.linalg.norm(turned + (1.0 if mode == "R" else eta[:, None]) * l, axis=-1) > 0.1
        found = lobe.pdf(v, l)
        # Where nearly nothing is, a rounding of the facet is a large part of the density.
        counts = far & (visible * measured > 1e-6)
        assert np.mean(counts) > MOST
        assert jacobian_misses(found[counts], (visible * measured)[counts]) == 0.0
        assert jacobian_misses((1.0 + PLANTED) * found[counts], (visible * measured)[counts]) == 1.0


# Back-vectors under the swap (eq. 12 to 15) ---------------------------------------------------------------------------


def test_the_mirror_keeps_scalar_products_and_undoes_itself(rng, hemisphere):
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000) * rng.choice([-1.0, 1.0], (1000, 1))
    # Exactly: only signs change (eq. 12).
    assert np.array_equal(dot(mirror(v), mirror(l)), dot(v, l))
    assert np.array_equal(mirror(mirror(l)), l)
    matrix = mirror(np.eye(3)).T
    assert np.array_equal(matrix @ matrix, np.eye(3))
    assert np.array_equal(matrix, 2.0 * np.outer([0, 0, 1], [0, 0, 1]) - np.eye(3))


def test_the_back_vectors_are_mirrored_under_the_swap(rng, hemisphere):
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000)
    # Exactly (eq. 13): sums commute and signs change; the half-vector itself is unchanged, not mirrored.
    assert np.array_equal(mirror(back_vector(v, l)), back_vector(l, v))
    assert not np.any(np.all(mirror(half_vector(v, l)) == half_vector(l, v), axis=-1))
    l = l * DOWN
    for eta_v, eta_l in ((1.0, 1.5), (1.5, 1.0)):
        b = half_transmitted(mirror(v), l, eta_v, eta_l)
        assert np.array_equal(mirror(b), half_transmitted(mirror(l), v, eta_l, eta_v))


def test_the_facet_of_a_transmission_is_mirrored_under_the_swap(rng, scattered_pairs):
    v, l = scattered_pairs(rng, glass("full", scatter_mode="T"))
    v, l = v[v[:, 2] > 0.0], l[v[:, 2] > 0.0]
    there = refracting(mirror(v).T, l.T, np.asarray(1.5)).m
    # From below: point inversion brings the viewer above.
    back = refracting(-mirror(l).T, -v.T, np.asarray(1.0 / 1.5)).m
    length = np.linalg.norm(mirror(v) + 1.5 * l, axis=-1)
    # The index is divided out of the sum: a few roundings over its length.
    assert np.all(np.abs(mirror(there.T) - back.T) <= 8 * EPS / length[:, None])
    assert np.max(np.abs(there - back)) > MOST


@by_distribution
@by_masking
def test_masking_is_the_same_on_the_swapped_path(rng, hemisphere, distribution, masking):
    part, rough = MASKINGS[masking], Rough(DISTRIBUTIONS[distribution], 0.4, 0.1)
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000)
    b = back_vector(v, l)
    # Exactly (eq. 14 and 15): squares and products of two changed signs.
    there, back = (part.masking(rough, w.T, m.T) for w, m in ((mirror(v), b), (v, mirror(b))))
    assert np.array_equal(there, back)
    assert np.ptp(there) > MOST
    if masking == "v_cavity":
        assert np.max(np.abs(part.masking(rough, v.T, b.T) - there)) > 0.1


# Reciprocity (eq. 11, 16 and 17) --------------------------------------------------------------------------------------


def index_ratio(v: Array, l: Array, ior: float) -> Array:
    """(eta_v / eta_l)^2, shape (..., 1): the index is inside, below."""
    index_v, index_l = (np.where(w[..., 2:] > 0.0, 1.0, ior) for w in (v, l))
    return np.square(index_v / index_l)


def rounding(lobe: Dielectric, v: Array, l: Array) -> Array:
    """Relative error that a rounding of the facet can make, (...).

    It is turned by EPS over the length of what is normalised, and its slope t changes by (1 + t^2) of that; a Gaussian
    changes by 2 t / alpha^2 of it, and Phong's and GGX's by less. Cosines with the facet on both of its sides, to which
    masking and Fresnel's sines refer, lose their size twice. How many such roundings add up is measured: 97 in 720,000
    pairs of another seed; allowed are 128.
    """
    eta = np.where(v[:, 2] * l[:, 2] > 0.0, 1.0, np.where(v[:, 2] > 0.0, lobe.ior, 1.0 / lobe.ior))
    turned = [mirror(v) if flag else v for flag in (lobe.retroreflective, lobe.retroreflective_btdf)]
    w = np.where((eta == 1.0)[:, None], *turned)
    path = w + eta[:, None] * l
    length = np.linalg.norm(path, axis=-1)
    m = path / length[:, None]
    slope = np.hypot(m[:, 0], m[:, 1]) / np.abs(m[:, 2])
    far = np.where(v[:, 2] > 0.0, lobe.ior, 1.0 / lobe.ior)
    cosine = np.abs(dot(w, m))
    cosines = np.minimum(cosine, np.sqrt(np.abs(1.0 - (1.0 - np.square(cosine)) / np.square(far))))
    turn = EPS * (1.0 + np.square(slope)) / length
    return 128 * (EPS + turn * (1.0 + 2.0 * slope / min(lobe.alpha) ** 2)) / np.square(cosines)


def asymmetry(candidate: Lobe, lobe: Dielectric, v: Array, l: Array) -> float:
    """Share of the pairs for which f(v, l) is not (eta_v / eta_l)^2 f(l, v)."""
    there, back = candidate.eval(v, l), index_ratio(v, l, float(lobe.ior)) * candidate.eval(l, v)
    allowed = rounding(lobe, v, l)[:, None] * np.maximum(there, back)
    return float(np.mean(np.any(np.abs(there - back) > allowed, axis=-1)))


@dataclass(frozen=True)
class Tilted:
    """A wrong lobe: 3 % more for views along the normal."""

    base: Lobe

    def eval(self, v: Array, l: Array) -> Array:
        return self.base.eval(v, l) * (1.0 + PLANTED * np.abs(v[:, 2:]))


@dataclass(frozen=True)
class EnergyNotRadiance:
    """A wrong lobe: transmission without the factor of the indices."""

    base: Dielectric

    def eval(self, v: Array, l: Array) -> Array:
        return self.base.eval(v, l) / index_ratio(v, l, float(self.base.ior))


@by_distribution
@by_masking
@by_combination
def test_interfaces_are_reciprocal_from_both_sides(rng, scattered_pairs, distribution, masking, combination):
    for ior, alpha in ((1.5, (0.3, 0.2)), (0.75, (1.0, 0.5)), (1.5, (0.0025, 0.0025)), (1.1, (0.05, 0.4))):
        lobe = glass(combination, ior=ior, alpha=alpha, distribution=distribution, masking=masking)
        v, l = scattered_pairs(rng, lobe, 1000)
        # The bound says something: it is below a thousandth for most, where the planted errors are percents.
        assert np.mean(rounding(lobe, v, l) < 1e-3) > MOST
        assert asymmetry(lobe, lobe, v, l) == 0.0
        assert asymmetry(Tilted(lobe), lobe, v, l) > 0.2
        transmitted = (v[:, 2] * l[:, 2] < 0.0) & (lobe.eval(v, l)[:, 0] > 0.0)
        assert asymmetry(EnergyNotRadiance(lobe), lobe, v[transmitted], l[transmitted]) > 0.9


@pytest.mark.parametrize("name", ["lambert", "eon", "blend", "partial", "metal", "curve"])
def test_other_lobes_are_reciprocal(rng, hemisphere, name):
    metal = Conductor([0.2, 0.9, 1.4], 2.0, alpha=(0.3, 0.5), distribution="beckmann", masking="v_cavity")
    lobe = {
        "lambert": Lambert([0.2, 0.5, 0.9]),
        "eon": EON([0.2, 0.5, 0.9], 0.7),
        "blend": Blend(EON(0.5, 1.0), replace(metal, retroreflective=True), 0.3),
        "partial": partially_retroreflective(metal, 0.4),
        "metal": metal,
        "curve": GeneralizedSchlick([0.9, 0.3, 0.1], 0.8, 1.0, alpha=(0.6, 0.5), distribution="phong"),
    }[name]
    v, l = hemisphere(rng, 2000), hemisphere(rng, 2000)
    there, back = lobe.eval(v, l), lobe.eval(l, v)
    # Relative: widths of 0.3 and more; the sums of unit vectors are mostly not short, and half-vectors of grazing
    # directions steep: slopes up to 1000, of which GGX and Phong lose a few hundred roundings.
    np.testing.assert_allclose(there, back, rtol=1e-9, atol=1e-12)
    assert np.ptp(there) > 0.1 or name == "lambert"
    tilted = Tilted(lobe)
    assert np.mean(np.abs(tilted.eval(v, l) - tilted.eval(l, v)) > 1e-9 * there + 1e-12) > MOST


@dataclass(frozen=True)
class Shifted:
    """A distribution that is not reflection-symmetric: GGX over slopes shifted along x."""

    shift: float

    def distribution(self, mx, my, mz, alpha_x, alpha_y):
        # D mz^4 is the density of slopes.
        x, y = -mx / mz + self.shift, my / mz
        z = 1.0 / np.sqrt(1.0 + x * x + y * y)
        return DISTRIBUTIONS["ggx"].distribution(x * z, y * z, z, alpha_x, alpha_y) * (z / mz) ** 4


def test_only_a_symmetric_distribution_makes_a_retroreflective_lobe_reciprocal(rng, scattered_pairs):
    # Portsmouth et al. 2026, section 3.1: the ordinary lobe needs no symmetry, the retroreflective one does.
    for shift in (0.0, 0.05, 0.3):
        for mode in ("R", "T"):
            pairs = scattered_pairs(rng, glass("full", scatter_mode=mode), 1000)
            for combination in ("classic", "full"):
                lobe = glass(combination, masking="v_cavity", scatter_mode=mode)
                odd = replace(lobe, distribution=Shifted(shift))
                misses = asymmetry(odd, lobe, *pairs)
                if combination == "classic" or shift == 0.0:
                    assert misses == 0.0
                else:
                    assert misses > MOST


# The substitution in densities and samples ----------------------------------------------------------------------------


@by_distribution
@by_masking
def test_a_retroreflective_lobe_samples_as_the_ordinary_one_does_from_the_mirrored_view(
    rng, scattered_pairs, distribution, masking
):
    for mode, sampling in (("R", "bounded"), ("R", "visible"), ("T", "visible"), ("RT", "visible")):
        parameters = {"distribution": distribution, "masking": masking, "scatter_mode": mode, "sampling": sampling}
        full, classic, mixed = (glass(name, **parameters) for name in ("full", "classic", "mixed"))
        v, l = scattered_pairs(rng, full, 500)
        # Bit for bit: it is the same arithmetic.
        assert np.array_equal(full.pdf(v, l), classic.pdf(mirror(v), l))
        assert np.array_equal(full.eval(v, l), classic.eval(mirror(v), l))
        assert np.mean(full.pdf(v, l) == classic.pdf(v, l)) < MOST
        reflected = (v[:, 2] * l[:, 2] > 0.0)[:, None]
        assert np.array_equal(mixed.pdf(v, l), classic.pdf(np.where(reflected, mirror(v), v), l))
        assert np.array_equal(mixed.eval(v, l), classic.eval(np.where(reflected, mirror(v), v), l))
        if mode != "RT":  # there, one facet serves both, and is mirrored after
            u = rng.random((len(v), 3))
            assert np.array_equal(full.sample(v, u), classic.sample(mirror(v), u))
            assert np.array_equal(mixed.sample(v, u), (full if mode == "R" else classic).sample(v, u))


def test_along_the_normal_a_retroreflective_lobe_is_the_ordinary_one(rng, hemisphere):
    v = np.tile([0.0, 0.0, 1.0], (500, 1)) * rng.choice([-1.0, 1.0], (500, 1))
    u, l = rng.random((500, 3)), hemisphere(rng, 500) * rng.choice([-1.0, 1.0], (500, 1))
    for distribution in DISTRIBUTIONS:
        for masking in MASKINGS:
            for mode in ("R", "T"):
                classic, full = (
                    glass(name, distribution=distribution, masking=masking, scatter_mode=mode)
                    for name in ("classic", "full")
                )
                assert np.array_equal(full.eval(v, l), classic.eval(v, l))
                assert np.array_equal(full.pdf(v, l), classic.pdf(v, l))
                assert np.array_equal(full.sample(v, u), classic.sample(v, u))
    tilted = normalize(v + np.array([0.01, 0.0, 0.0]))
    assert np.mean(full.pdf(tilted, l) == classic.pdf(tilted, l)) < 0.9


# Limits ---------------------------------------------------------------------------------------------------------------


@by_distribution
@by_masking
def test_light_from_the_viewer_meets_facets_along_the_normal(polar, distribution, masking):
    # b = n: D is 1 / (pi ax ay), the cosines are all n.v, and V-cavities hide nothing.
    facets = DISTRIBUTIONS[distribution]
    for alpha in ((0.0025, 0.0025), (0.3, 0.1), (1.0, 1.0)):
        lobe = Dielectric(1.5, alpha=alpha, retroreflective=True, distribution=distribution, masking=masking)
        for cosine in (1.0, 0.6, 0.1, 1e-3):
            v = polar(np.arccos(cosine), 0.4)
            hidden = float(facets.smith_lambda(*mirror(v), *alpha))
            g2 = {"smith": 1.0 / (1.0 + 2.0 * hidden), "smith_separable": (1.0 + hidden) ** -2.0, "v_cavity": 1.0}
            f = fresnel.dielectric(v[2], 1.5)
            expected = g2[masking] * f / (4.0 * np.pi * alpha[0] * alpha[1] * v[2] ** 2)
            # A cosine of the normal with v that comes out of 2 n.v / |2 n.v| exactly; Fresnel's steepest slope is 1e2.
            np.testing.assert_allclose(lobe.eval(v, v), expected, rtol=1e3 * EPS)
            if cosine < 1.0 and masking != "v_cavity":
                away = replace(lobe, retroreflective=False).eval(v, v)[0]
                assert abs(away / expected - 1.0) > PLANTED


@by_distribution
@by_combination
def test_a_narrow_lobe_is_the_smooth_interface(rng, polar, distribution, combination):
    v = polar(np.arccos(0.6), 0.4)
    u = rng.random((2000, 3))
    smooth = float(fresnel.dielectric(0.6, 1.5))
    reflection = v if COMBINATIONS[combination][0] else mirror(v)
    # Snell: the tangential part is divided by the index, and turned about for the retroreflective one.
    along = -v[:2] / 1.5 * (-1.0 if COMBINATIONS[combination][1] else 1.0)
    transmission = np.array([*along, -np.sqrt(1.0 - along @ along)])
    errors = []
    for alpha in (1e-1, 1e-2, 1e-3):
        reflected, refracted = (
            glass(combination, alpha=(alpha, alpha), distribution=distribution, scatter_mode=mode) for mode in "RT"
        )
        for lobe, target in ((reflected, reflection), (refracted, transmission)):
            off = np.linalg.norm(lobe.sample(v, u) - target, axis=-1)
            # A facet turned by delta turns light by at most 2 delta; half of all facets are within a width, or so.
            assert np.median(off) < 2.0 * alpha
            assert np.median(off) > 0.1 * alpha
        if combination == "full":  # the others have the same
            found = reflected.albedo(v)[0], refracted.albedo(v)[0]
            errors.append(np.abs(np.subtract(found, (smooth, 1.0 - smooth))))
    if errors:
        # The error falls as alpha^2; GGX's tails add a logarithm. The quadrature's own is 1e-4 at most.
        assert np.all(errors[2] < 2e-4)
        assert np.all(errors[2] < errors[0])


@pytest.mark.parametrize("btdf", [False, True], ids=["classic", "retroreflective"])
@by_masking
def test_an_interface_between_equal_media_reflects_nothing_and_transmits_straight(rng, polar, masking, btdf):
    v = polar(np.arccos(0.6), 0.4)
    target = -mirror(v) if btdf else -v
    for excess in (1e-2, 1e-4, 1e-6):
        lobe = Dielectric(1.0 + excess, alpha=(0.3, 0.3), scatter_mode="RT", retroreflective_btdf=btdf, masking=masking)
        l = lobe.sample(v, rng.random((2000, 3)))
        off = np.linalg.norm(l - target, axis=-1)
        # A facet seen under the angle theta turns light by (n - 1) tan(theta).
        assert np.median(off) < 2.0 * excess
        above = polar(np.arccos(rng.uniform(0.1, 1.0, 500)), rng.uniform(0.0, 6.0, 500))
        # Reflectance is at most that of the steepest facet here, of order ((n - 1) / (2 cos^2))^2.
        assert np.max(lobe.eval(v, above)) < 1e3 * excess**2
        assert np.min(lobe.albedo(v)) > 0.9


def test_at_an_index_of_one_there_is_no_density(rng, hemisphere):
    # A regression: v + l is a rounding there, which was taken for a facet, with densities of 1e32.
    v = hemisphere(rng, 2000) * rng.choice([-1.0, 1.0], (2000, 1))
    for combination, (_, btdf) in COMBINATIONS.items():
        lobe = glass(combination, ior=1.0)
        l = lobe.sample(v, rng.random((2000, 3)))
        np.testing.assert_allclose(l, -mirror(v) if btdf else -v, rtol=0.0, atol=8 * EPS)
        assert not np.any(lobe.pdf(v, l))
        assert not np.any(lobe.eval(v, l))
        assert not np.any(lobe.eval(v, mirror(l)))


U_ENDS = np.stack(np.meshgrid(*[[0.0, 2.0**-53, 0.5, 1.0 - 2.0**-53]] * 3), axis=-1).reshape(-1, 3)


@by_distribution
@by_masking
@by_combination
def test_at_the_ends_of_all_ranges_values_are_finite_and_weights_bounded(
    rng, polar, distribution, masking, combination
):
    u = np.concatenate([U_ENDS, rng.random((64, 3))])[:, None]
    v = polar(np.arccos([1.0, 0.5, 1e-3, 1e-6]), 0.7)
    v = np.concatenate([v, -v])
    for alpha in ((0.0025, 0.0025), (1.0, 1.0), (0.0025, 1.0)):
        for ior in (1.5, 0.75):
            for mode, sampling in (("R", "bounded"), ("RT", "visible")):
                lobe = glass(
                    combination, ior=ior, alpha=alpha, distribution=distribution, masking=masking,
                    scatter_mode=mode, sampling=sampling,
                )  # fmt: skip
                l = lobe.sample(v, u)
                f, pdf = lobe.eval(v, l), lobe.pdf(v, l)
                for a in (l, f, pdf):
                    assert np.all(np.isfinite(a))
                    assert np.min(a) >= 0.0 or a is l
                sampled = np.any(l != 0.0, axis=-1)
                np.testing.assert_allclose(np.linalg.norm(l, axis=-1)[sampled], 1.0, rtol=32 * EPS)
                # Of visible normals the weight is G2 / G1 times what the choice leaves: at most 1, but for rounding and
                # the factor of radiance. A sample has a density, but at the very ends of the random numbers.
                with np.errstate(invalid="ignore", divide="ignore"):
                    weight = f[..., 0] * np.abs(l[..., 2]) / pdf / index_ratio(v, l, ior)[..., 0]
                assert np.nanmax(weight) < 1.0 + 1e-4
                assert np.nanmax(weight[len(U_ENDS) :]) > MOST
                assert np.all((pdf > 0.0)[len(U_ENDS) :] == sampled[len(U_ENDS) :])


# Invariance -----------------------------------------------------------------------------------------------------------


@by_distribution
@by_masking
@by_combination
def test_equal_widths_make_a_lobe_the_same_from_all_azimuths(rng, scattered_pairs, distribution, masking, combination):
    c, s = np.cos(1.0), np.sin(1.0)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for alpha, misses in (((0.3, 0.3), 0.0), ((0.3, 0.3 * (1.0 + PLANTED)), MOST)):
        lobe = glass(combination, alpha=alpha, distribution=distribution, masking=masking)
        v, l = scattered_pairs(rng, lobe, 1000)
        allowed = rounding(lobe, v, l)
        for value in (lambda a, b, lobe=lobe: lobe.eval(a, b)[:, 0], lobe.pdf):
            there, turned = value(v, l), value(v @ turn.T, l @ turn.T)
            off = np.mean(np.abs(turned - there) > allowed * there)
            assert off == 0.0 if misses == 0.0 else off > misses


@by_distribution
@by_masking
@by_combination
def test_a_lobe_is_the_same_mirrored_at_either_axis(rng, scattered_pairs, distribution, masking, combination):
    lobe = glass(combination, alpha=(0.1, 0.6), distribution=distribution, masking=masking)
    v, l = scattered_pairs(rng, lobe, 1000)
    for sign in ([-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]):
        # Exactly: squares, and products of two changed signs; sums in the same order.
        assert np.array_equal(lobe.eval(v * sign, l * sign), lobe.eval(v, l))
        assert np.array_equal(lobe.pdf(v * sign, l * sign), lobe.pdf(v, l))
    assert np.mean(lobe.pdf(v[:, [1, 0, 2]], l[:, [1, 0, 2]]) == lobe.pdf(v, l)) < MOST
