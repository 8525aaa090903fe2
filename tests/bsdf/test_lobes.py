"""The three lobes: reciprocity, albedo, the retroreflective substitution, and what a wrong call gets."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.bsdf import (
    EON,
    Conductor,
    Dielectric,
    GeneralizedSchlick,
    Lambert,
    PrismaticSheeting,
    back_vector,
    fresnel,
    ggx,
    mirror,
    partially_retroreflective,
)
from mrm_mtlx.bsdf.compensation import compensation
from mrm_mtlx.bsdf.vectors import dot, normalize
from mrm_mtlx.reference import versions

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf import Lobe
    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

# Of a white lobe, as MaterialX's shaders have it.
WHITE_ALBEDO = versions.installed().microfacet_albedo.white

# Share of the samples, or of the views, in which a planted error has to show.
MOST = 0.5

LOBES = {
    "metal": Conductor([0.183, 0.421, 1.373], [3.424, 2.346, 1.770], alpha=(0.3, 0.3)),
    "narrow metal": Conductor([0.183, 0.421, 1.373], [3.424, 2.346, 1.770], alpha=(0.0025, 0.0025)),
    "brushed metal": Conductor([0.183, 0.421, 1.373], [3.424, 2.346, 1.770], alpha=(0.1, 0.4)),
    "coated metal": Conductor(0.9, 2.5, alpha=(0.2, 0.1), thinfilm_thickness=450.0, thinfilm_ior=1.35),
    "dielectric": Dielectric(1.5, alpha=(0.2, 0.2), tint=[1.0, 0.5, 0.25]),
    "soap on glass": Dielectric(1.5, alpha=(0.1, 0.3), thinfilm_thickness=300.0, thinfilm_ior=1.33),
    "tape": GeneralizedSchlick(0.19, 0.0, 1.0, alpha=(0.0529, 0.0529)),
    "coloured curve": GeneralizedSchlick([0.9, 0.5, 0.1], [0.8, 1.0, 0.3], 1.0, 3.0, alpha=(0.5, 0.05)),
    "coated curve": GeneralizedSchlick([0.9, 0.5, 0.1], 0.7, 1.0, alpha=(0.4, 0.4), thinfilm_thickness=600.0),
}

by_lobe = pytest.mark.parametrize("lobe", LOBES.values(), ids=LOBES.keys())
by_flag = pytest.mark.parametrize("retroreflective", [False, True], ids=["ordinary", "retroreflective"])


def white(lobe: Lobe) -> GeneralizedSchlick:
    """The same facets, perfectly reflecting."""
    return GeneralizedSchlick(1.0, alpha=lobe.alpha, retroreflective=lobe.retroreflective)


@dataclass(frozen=True)
class LeftInFresnel:
    """A wrong retroreflective metal: v is mirrored in D and G2, but Fresnel is still taken at v.b."""

    base: Conductor

    def eval(self, v: Array, l: Array) -> Array:
        seen = fresnel.conductor(np.abs(dot(v, back_vector(v, l)))[..., None], self.base.ior, self.base.extinction)
        return white(self.base).eval(v, l) * seen


@dataclass(frozen=True)
class LightMirrored:
    """A wrong retroreflective lobe: v is mirrored about the normal, l about the tangent too."""

    base: Lobe

    def eval(self, v: Array, l: Array) -> Array:
        return self.base.eval(v, np.asarray(l) * [-1.0, 1.0, 1.0])


@dataclass(frozen=True)
class Tilted:
    """A wrong lobe: a percent more for views from above."""

    base: Lobe

    def eval(self, v: Array, l: Array) -> Array:
        return self.base.eval(v, l) * (1.0 + 0.01 * np.asarray(v)[..., 2:])


# Reciprocity --------------------------------------------------------------------------------------------------------

# Slope of a reflectance over the cosine: below 100 for films up to 600 nm (phase 4 pi n d / wavelength), which is more
# than any bare curve has.
STEEPEST = 100.0


def asymmetry(candidate: Lobe, facets: Lobe, v: Array, l: Array) -> float:
    """Share of the pairs for which f(v, l) is not f(l, v).

    Both have the same facet and so the same D; v.m and l.m are equal but for the rounding of m, which grows as v + l
    shrinks, and the reflectance follows them. A film's amplitudes are roots of reflectances, which vanish at Brewster's
    angles: a rounding there is the root of a rounding. Measured against the perfectly reflecting lobe.
    """
    seen = mirror(v) if facets.retroreflective else v
    cosine_error = 16 * EPS / np.linalg.norm(seen + l, axis=-1, keepdims=True)
    film_error = 4.0 * np.sqrt(EPS) if facets.thinfilm_thickness else 16 * EPS
    allowed = (film_error + STEEPEST * cosine_error) * white(facets).eval(v, l)
    difference = np.abs(candidate.eval(v, l) - candidate.eval(l, v))
    return float(np.mean(np.any(difference > allowed, axis=-1)))


@by_lobe
@by_flag
def test_lobes_are_reciprocal(rng, direction_pairs, lobe, retroreflective):
    lobe = replace(lobe, retroreflective=retroreflective)
    assert asymmetry(lobe, lobe, *direction_pairs(rng, 4000)) == 0.0


@by_flag
def test_a_lobe_that_prefers_one_direction_is_seen(rng, direction_pairs, retroreflective):
    lobe = replace(LOBES["metal"], retroreflective=retroreflective)
    assert asymmetry(Tilted(lobe), lobe, *direction_pairs(rng, 4000)) > MOST


def test_fresnel_at_the_unmirrored_view_is_not_reciprocal(rng, hemisphere):
    lobe = replace(LOBES["metal"], retroreflective=True)
    v, l = hemisphere(rng, 4000), hemisphere(rng, 4000)
    assert asymmetry(LeftInFresnel(lobe), lobe, v, l) > MOST


def test_compensated_lobes_are_not_reciprocal_and_not_claimed_to_be(rng, hemisphere):
    # Turquin's factor knows the view alone.
    lobe = replace(LOBES["metal"], energy_compensation=WHITE_ALBEDO)
    assert asymmetry(lobe, lobe, hemisphere(rng, 1000), hemisphere(rng, 1000)) > MOST


# The substitution ---------------------------------------------------------------------------------------------------


def substitution_misses(candidate: Lobe, base: Lobe, v: Array, l: Array) -> float:
    """Share of the pairs for which a lobe is not the base seen from v', exactly."""
    return float(np.mean(np.any(candidate.eval(v, l) != base.eval(mirror(v), l), axis=-1)))


@by_lobe
def test_a_retroreflective_lobe_is_the_ordinary_one_seen_from_the_mirrored_view(rng, direction_pairs, lobe):
    for base in (lobe, replace(lobe, energy_compensation=WHITE_ALBEDO)):
        retro = replace(base, retroreflective=True)
        assert substitution_misses(retro, base, *direction_pairs(rng, 2000)) == 0.0


def test_a_wrong_substitution_is_seen(rng, hemisphere):
    base, v, l = LOBES["brushed metal"], hemisphere(rng, 2000), hemisphere(rng, 2000)
    retro = replace(base, retroreflective=True)
    for wrong in (base, LeftInFresnel(retro), LightMirrored(retro)):
        assert substitution_misses(wrong, base, v, l) > MOST


@by_lobe
def test_mirrored_twice_it_is_the_ordinary_lobe_again(rng, direction_pairs, lobe):
    v, l = direction_pairs(rng, 2000)
    assert np.array_equal(replace(lobe, retroreflective=True).eval(mirror(v), l), lobe.eval(v, l))


@pytest.mark.parametrize("degrees", [0.0, 20.0, 50.0])
def test_a_narrow_retroreflective_lobe_peaks_at_the_light(polar, degrees):
    v = polar(np.deg2rad(degrees), 0.4)
    lobe = replace(LOBES["narrow metal"], retroreflective=True)
    around = polar(np.deg2rad(np.linspace(0.0, 80.0, 161))[:, None], np.deg2rad(np.arange(0.0, 360.0, 5.0)) + 0.4)
    around = np.concatenate([around.reshape(-1, 3), v[None]])
    towards = lobe.eval(v, around)[:, 0]
    # The direction asked for is the last one; the grid also has it, up to rounding.
    assert dot(around[np.argmax(towards)], v) == pytest.approx(1.0, abs=4 * EPS)
    away = replace(lobe, retroreflective=False).eval(v, around)[:, 0]
    assert dot(around[np.argmax(away)], mirror(v)) == pytest.approx(1.0, abs=4 * EPS)


# Yellow retroreflective tape: peak of the published fit at l = v [1/sr], four digits (Portsmouth et al. 2026, Fig. 4).
TAPE = GeneralizedSchlick(0.19, 0.0, 1.0, alpha=(0.23**2, 0.23**2), retroreflective=True)
PEAKS = {15.0: 5.790, 30.0: 7.200, 60.0: 15.567}

# Half of the last digit given.
PEAK_TOL = 0.0005


@pytest.mark.parametrize("degrees", sorted(PEAKS))
def test_the_peak_of_the_yellow_tape_is_the_published_one(polar, degrees):
    v = polar(np.deg2rad(degrees))
    np.testing.assert_allclose(TAPE.eval(v, v), PEAKS[degrees], rtol=0.0, atol=PEAK_TOL)
    # The width taken for the roughness shows at every angle, a tint that is left out at the steepest.
    assert abs(replace(TAPE, alpha=(0.23, 0.23)).eval(v, v)[0] - PEAKS[degrees]) > PEAK_TOL
    if degrees == max(PEAKS):
        assert abs(replace(TAPE, color82=1.0).eval(v, v)[0] - PEAKS[degrees]) > PEAK_TOL


@pytest.mark.parametrize("degrees", sorted(PEAKS))
def test_the_peak_of_the_yellow_tape_follows_from_its_closed_form(polar, degrees):
    c, alpha = np.cos(np.deg2rad(degrees)), 0.23**2
    # b = n: D = 1 / (pi alpha^2); Lambda = (sqrt(1 + alpha^2 tan^2) - 1) / 2 for both; F at c.
    g2 = 1.0 / np.sqrt(1.0 + alpha**2 * (1.0 / c**2 - 1.0))
    f = fresnel.generalized_schlick(c, 0.19, 0.0, 1.0, 5.0)
    v = polar(np.deg2rad(degrees))
    # Relative; the tangent's square and the curve's difference cost a few digits.
    np.testing.assert_allclose(TAPE.eval(v, v), g2 * f / (np.pi * alpha**2 * 4.0 * c**2), rtol=64 * EPS)


# Energy -------------------------------------------------------------------------------------------------------------

VIEWS = (0.1, 0.4, 0.8, 1.0)

# Absolute, of the adapted quadrature, per unit of reflectance: the lobe ends in a kink at the horizon. Measured against
# four times as many directions: 1.9e-3 at n.v = 0.1.
QUADRATURE_TOL = 2e-3


def albedo_of(lobe: Lobe, v: Array, directions: tuple[Array, Array]) -> Array:
    """Integral of f cos over directions and their solid angles, per channel."""
    l, solid_angle = directions
    return np.asarray((l[:, 2] * solid_angle) @ lobe.eval(v, l))


def furnace_gain(candidate: Callable[[Lobe], Lobe], lobe: Lobe, lobe_directions: Callable, polar: Callable) -> Array:
    """Albedo minus 1 over the views of `VIEWS`, largest channel."""
    gains = []
    for cos_v in VIEWS:
        v = polar(np.arccos(cos_v), 0.5)
        seen = mirror(v) if lobe.retroreflective else v
        gains.append(np.max(albedo_of(candidate(lobe), v, lobe_directions(seen, *lobe.alpha))) - 1.0)
    return np.array(gains)


@by_lobe
@by_flag
def test_no_lobe_gives_more_light_than_it_gets(lobe_directions, polar, lobe, retroreflective):
    lobe = white(replace(lobe, retroreflective=retroreflective))
    gains = furnace_gain(lambda x: x, lobe, lobe_directions, polar)
    assert np.max(gains) < QUADRATURE_TOL
    # Nor is it black: perfectly reflecting facets give most of the light back, or lose it by masking alone.
    assert np.min(gains) > -MOST


def test_a_lobe_with_too_much_energy_is_seen(lobe_directions, polar):
    @dataclass(frozen=True)
    class Unmasked:
        base: Lobe

        def eval(self, v: Array, l: Array) -> Array:
            lambdas = [ggx.smith_lambda(*np.moveaxis(np.asarray(d), -1, 0), *self.base.alpha) for d in (v, l)]
            return self.base.eval(v, l) / ggx.masking_shadowing(*lambdas)[..., None]

    lobe = white(LOBES["metal"])
    assert np.mean(furnace_gain(Unmasked, lobe, lobe_directions, polar) > QUADRATURE_TOL) >= MOST


# The compensated lobe is as far from 1 as the fit of the albedo is off, relative: 0.035 of 0.76.
FURNACE_TOL = 0.05


@pytest.mark.parametrize("alpha", [0.05, 0.2, 0.5, 1.0])
@by_flag
def test_a_compensated_white_lobe_returns_all_light(lobe_directions, polar, alpha, retroreflective):
    lobe = GeneralizedSchlick(1.0, alpha=(alpha, alpha), retroreflective=retroreflective)
    gains = furnace_gain(lambda x: replace(x, energy_compensation=WHITE_ALBEDO), lobe, lobe_directions, polar)
    assert np.max(np.abs(gains)) < FURNACE_TOL
    if alpha > 0.2:
        assert np.min(furnace_gain(lambda x: x, lobe, lobe_directions, polar)) < -FURNACE_TOL


@by_lobe
@by_flag
def test_compensation_multiplies_the_lobe_by_its_factor(rng, direction_pairs, lobe, retroreflective):
    v, l = direction_pairs(rng, 2000)
    lobe = replace(lobe, retroreflective=retroreflective)
    tint = getattr(lobe, "tint", 1.0)
    plain, full = lobe.eval(v, l), white(lobe).eval(v, l)
    # The tint stands outside: light that bounces twice is not tinted twice.
    f = plain / full / np.asarray(tint)
    factor = compensation(f, WHITE_ALBEDO(v[:, 2], np.sqrt(np.prod(lobe.alpha)))[:, None])
    found = replace(lobe, energy_compensation=WHITE_ALBEDO).eval(v, l)
    # Relative to the white lobe; the quotients cost a few roundings.
    np.testing.assert_array_less(np.abs(found - plain * factor), 32 * EPS * full)
    assert np.mean(np.abs(found - plain) > 32 * EPS * full) > MOST


# Absolute. Even quadrature over the hemisphere, for lobes that are broad beside its spacing: measured against four
# times as many directions, below 1e-6 for the widths used.
GRID_TOL = 1e-5


@pytest.mark.parametrize("name", ["metal", "coated curve"])
@pytest.mark.parametrize("cos_v", [0.3, 0.7, 1.0])
def test_a_retroreflective_lobe_has_the_albedo_of_the_ordinary_one(hemisphere_grid, polar, name, cos_v):
    v = polar(np.arccos(cos_v), 0.5)
    lobe = replace(LOBES[name], alpha=(0.5, 0.3))
    ordinary, retro = (albedo_of(replace(lobe, retroreflective=flag), v, hemisphere_grid()) for flag in (False, True))
    np.testing.assert_allclose(retro, ordinary, rtol=0.0, atol=GRID_TOL)
    assert np.min(ordinary) > GRID_TOL


def test_a_mirrored_light_changes_the_albedo_of_a_brushed_lobe(hemisphere_grid, polar):
    # Fresnel at v.b is the error that the albedo shows: the lobe's directions are right, its strength is not.
    v, lobe = polar(np.arccos(0.3), 0.5), replace(LOBES["metal"], alpha=(0.5, 0.3), retroreflective=True)
    wrong = albedo_of(LeftInFresnel(lobe), v, hemisphere_grid())
    assert np.max(np.abs(wrong - albedo_of(lobe, v, hemisphere_grid()))) > GRID_TOL


@pytest.mark.parametrize("name", ["narrow metal", "tape", "brushed metal"])
def test_the_adapted_and_the_even_quadrature_see_one_lobe(hemisphere_grid, lobe_directions, polar, name):
    # The check of the checks: directions dense around v' integrate the retroreflective lobe, and only that.
    v, lobe = polar(0.9, 0.5), replace(LOBES[name], alpha=(0.5, 0.3), retroreflective=True)
    adapted = albedo_of(lobe, v, lobe_directions(mirror(v), *lobe.alpha))
    np.testing.assert_allclose(adapted, albedo_of(lobe, v, hemisphere_grid()), rtol=0.0, atol=QUADRATURE_TOL)


# Where there is nothing ---------------------------------------------------------------------------------------------


@by_lobe
@by_flag
def test_below_the_surface_there_is_nothing(rng, hemisphere, lobe, retroreflective):
    lobe = replace(lobe, retroreflective=retroreflective)
    v, l = hemisphere(rng, 500), hemisphere(rng, 500)
    down = np.array([1.0, 1.0, -1.0])
    for pair in ((v * down, l), (v, l * down), (normalize(v * [1.0, 1.0, 0.0]), l)):
        assert not np.any(lobe.eval(*pair))
    # From inside a metal nothing is seen; an interface reflects on both sides.
    assert np.any(lobe.eval(v * down, l * down)) == (not isinstance(lobe, Conductor))
    above = lobe.eval(v, l)
    assert np.mean(above > 0.0) > MOST
    # A curve with a black tint at 82 degrees falls below zero beside it; no other lobe is ever negative.
    assert lobe.eval(v, l).min() >= 0.0 or getattr(lobe, "color82", 1.0) == 0.0


def test_opposite_directions_give_zero():
    # Their half-vector has no length; there is no light either, and no warning.
    v = np.array([[1.0, 0.0, 0.0], [0.6, 0.0, 0.8]])
    assert np.all(LOBES["metal"].eval(v, -v) == 0.0)
    assert np.all(replace(LOBES["metal"], retroreflective=True).eval(v, -mirror(v)) == 0.0)


# Wrong calls --------------------------------------------------------------------------------------------------------

V = np.array([0.6, 0.0, 0.8])


@pytest.mark.parametrize("alpha", [0.0, -0.1, 1.5, np.nan, [0.1, 0.0]])
def test_a_width_out_of_range_is_refused(alpha):
    for pair in ((alpha, 0.1), (0.1, alpha)):
        with pytest.raises(ValueError, match=r"alpha must be in \(0, 1\], got .* it is the square of a roughness"):
            Conductor(0.2, 3.4, alpha=pair)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Dielectric(-1.5), "ior must be > 0, got -1.5"),
        (lambda: Dielectric(0.0), "ior must be > 0, got 0"),
        (lambda: Dielectric([1.5, np.nan]), "ior must be > 0, got nan"),
        (lambda: Dielectric([1.5, -1.0, 2.0]), "ior must be > 0, got -1 to 2"),
        (lambda: Dielectric(np.inf), "ior must be > 0, got inf"),
        (lambda: Dielectric(tint=-0.1), "tint must be >= 0, got -0.1"),
        (lambda: Conductor(-0.2, 3.4), "ior must be >= 0, got -0.2"),
        (lambda: Conductor(0.2, [3.4, -1.0, 2.0]), "extinction must be >= 0, got -1 to 3.4"),
        (lambda: Conductor(0.2, 3.4, thinfilm_thickness=-1.0), "thinfilm_thickness must be >= 0, got -1"),
        (lambda: Conductor(0.2, 3.4, thinfilm_ior=0.9), "thinfilm_ior must be >= 1, got 0.9"),
        (lambda: GeneralizedSchlick(color0=-0.1), "color0 must be >= 0, got -0.1"),
        (lambda: GeneralizedSchlick(exponent=-5.0), "exponent must be >= 0, got -5"),
        (lambda: EON(color=1.1), "color must be in [0, 1], got 1.1"),
        (lambda: EON(roughness=[0.5, 2.0]), "roughness must be in [0, 1], got 0.5 to 2"),
        (lambda: Lambert([-1.0, 0.0, 0.0]), "color must be >= 0, got -1 to 0"),
    ],
)
def test_a_parameter_out_of_its_range_is_refused_with_its_value(make, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        make()


UNIT_TESTED = {
    "metal": Conductor(0.2, 3.4), "interface": Dielectric(scatter_mode="RT"), "curve": GeneralizedSchlick(0.2),
    "Lambert": Lambert(), "EON": EON(), "sheet": PrismaticSheeting(),
    "blend": partially_retroreflective(Conductor(0.2, 3.4), 0.5),
}  # fmt: skip


@pytest.mark.parametrize("length", [2.0, 0.99, 1.003, np.nan])
@pytest.mark.parametrize("name", UNIT_TESTED)
def test_a_direction_that_is_not_unit_is_refused_with_its_length(name, length):
    lobe, pairs = UNIT_TESTED[name], np.tile(V, (5, 1))
    wrong = pairs.copy()
    wrong[3] *= length
    calls = {
        "v": (lambda: lobe.eval(wrong, pairs), lambda: lobe.pdf(wrong, pairs), lambda: lobe.sample(wrong, pairs)),
        "l": (lambda: lobe.eval(pairs, wrong), lambda: lobe.pdf(pairs, wrong)),
    }
    for vector, each in calls.items():
        for call in each:
            with pytest.raises(ValueError, match=f"^{vector} must be a unit vector, got one of length {length:g}; "):
                call()
    with pytest.raises(ValueError, match=r"^v must be a unit vector"):
        lobe.albedo(wrong, accuracy=0.1)


@pytest.mark.parametrize("name", UNIT_TESTED)
def test_three_digits_are_a_unit_vector_and_a_lost_sample_is_none(name):
    lobe, v = UNIT_TESTED[name], np.array([0.301, 0.0, 0.954])
    assert np.all(lobe.eval(v, [0.0, 0.5, 0.866]) > 0.0)
    lost = np.zeros(3)
    assert not np.any(lobe.eval(v, lost))
    assert not np.any(lobe.pdf(v, lost))


@pytest.mark.parametrize("name", ["v", "l"])
def test_directions_without_three_components_are_refused(name):
    pair = {"v": V, "l": V, name: np.ones((3, 2))}
    with pytest.raises(ValueError, match=rf"^{name} must have shape \(\.\.\., 3\), got \(3, 2\)$"):
        Dielectric().eval(**pair)
    with pytest.raises(ValueError, match=rf"^{name} must have shape \(\.\.\., 3\), got \(\)$"):
        Dielectric().eval(**{**pair, name: 1.0})


def test_colours_without_three_channels_are_refused():
    with pytest.raises(ValueError, match=r"^extinction must be a scalar or have shape \(\.\.\., 3\), got \(2,\)$"):
        Conductor(0.2, [1.0, 2.0]).eval(V, V)
    with pytest.raises(ValueError, match=r"^tint must be a scalar or have shape"):
        Dielectric(tint=np.ones((3, 1))).eval(V, V)


@pytest.mark.parametrize(
    ("name", "value", "choices"),
    [
        ("scatter_mode", "r", "'R', 'T', 'RT'"),
        ("distribution", "GGX", "'ggx', 'beckmann', 'phong'"),
        ("masking", "v-cavity", "'smith', 'smith_separable', 'v_cavity'"),
        ("sampling", "", "'bounded', 'visible'"),
    ],
)
def test_names_that_are_none_are_refused(name, value, choices):
    with pytest.raises(ValueError, match=rf"^{name} must be one of {choices}, got '{value}'$"):
        Dielectric(**{name: value})


@pytest.mark.parametrize("parts", [{"distribution": "beckmann"}, {"masking": "v_cavity"}])
def test_compensation_without_a_fitted_albedo_is_refused(parts):
    with pytest.raises(ValueError, match=r"^energy_compensation is known for distribution 'ggx' with masking 'smith'"):
        Dielectric(energy_compensation=WHITE_ALBEDO, **parts).eval(V, V)


@pytest.mark.parametrize("given", [True, False, 0.5])
def test_compensation_that_is_no_function_is_refused(given):
    with pytest.raises(ValueError, match=rf"^energy_compensation must be a function of n\.v and alpha, got {given}$"):
        Conductor(0.2, 3.4, energy_compensation=given).eval(V, V)
