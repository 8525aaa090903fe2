"""Prismatic sheeting as a BRDF: reciprocity, energy, samples that follow their density, and its limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy import stats

from mrm_mtlx.bsdf import Lambert, fresnel, prismatic
from mrm_mtlx.bsdf.quadrature import albedo_by_sampling
from mrm_mtlx.bsdf.sheeting import PrismaticSheeting
from mrm_mtlx.bsdf.vectors import mirror

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

EPS = np.finfo(float).eps

SHEETS = {
    "acrylic": PrismaticSheeting(1.49, alpha=(0.05, 0.05), tint=[1.0, 0.8, 0.1], substrate=[0.6, 0.5, 0.1]),
    "brushed": PrismaticSheeting(1.586, alpha=(0.05, 0.2), rotation=0.3),
    "metallised": PrismaticSheeting(1.5, alpha=(0.2, 0.2), backing="metal", substrate=0.1),
    "rough": PrismaticSheeting(1.5, alpha=(0.7, 0.7), substrate=1.0),
}
by_sheet = pytest.mark.parametrize("sheet", SHEETS.values(), ids=list(SHEETS))

PLANTED = 0.03

# Shares of the samples and of the pairs that have to show something: a lobe is met by one pair in six.
MOST, SEEN = 0.5, 0.1


# Reciprocity ----------------------------------------------------------------------------------------------------------


def misses(sheet: PrismaticSheeting, v: Array, l: Array) -> float:
    """Share of the pairs for which f(v, l) is not f(l, v)."""
    there, back = sheet.eval(v, l), sheet.eval(l, v)
    # Relative. At a critical angle a root turns roundings of the cosines into 1e-8, which the tail of a narrow lobe
    # (exp(-100) at ten widths) multiplies by its exponent; values below the smallest that matter are left out.
    apart = np.abs(there - back) > 1e-6 * np.maximum(there, back) + 1e-12
    return float(np.mean(np.any(apart, axis=-1)))


@by_sheet
def test_light_that_travels_back_is_reflected_as_much(rng, direction_pairs, sheet):
    v, l = direction_pairs(rng, 2000)
    assert misses(sheet, v, l) == 0.0
    assert np.mean(sheet.eval(v, l) > 0.0) > 0.9


class WeightOfTheView(PrismaticSheeting):
    """With w(v) in the place of the root of w(v) w(l)."""

    def eval(self, v: Array, l: Array) -> Array:
        surface, returned, substrate = self._parts()
        w_v, w_l = self.share(v), self.share(l)
        ratio = np.sqrt(np.where(w_l > 0.0, w_v / np.where(w_l > 0.0, w_l, 1.0), 0.0))
        return surface.eval(v, l) + returned.eval(v, l) * ratio[..., None] + substrate.eval(v, l)


class EntryOnly(PrismaticSheeting):
    """With the Fresnel loss of one of the two passages."""

    def eval(self, v: Array, l: Array) -> Array:
        surface, returned, substrate = self._parts()
        inner = returned.eval(v, l) + substrate.eval(v, l)
        return surface.eval(v, l) + inner / self.transmittance(l)[..., None]


class ThreePercentTowardsX(PrismaticSheeting):
    """Brighter by three percent seen from one side."""

    def eval(self, v: Array, l: Array) -> Array:
        return super().eval(v, l) * (1.0 + PLANTED * (np.asarray(v)[..., :1] > 0.0))


@pytest.mark.parametrize("wrong", [WeightOfTheView, EntryOnly, ThreePercentTowardsX])
def test_a_sheet_that_is_not_reciprocal_is_seen(rng, hemisphere, wrong):
    v, l = hemisphere(rng, 1000), hemisphere(rng, 1000)
    assert misses(wrong(**vars(SHEETS["metallised"])), v, l) > SEEN


# Energy ---------------------------------------------------------------------------------------------------------------

# Absolute, of the albedos below.
ACCURACY = 2e-3
ANGLES_DEG = (0.0, 25.0, 50.0, 75.0, 88.0)


def white(sheet: PrismaticSheeting) -> PrismaticSheeting:
    """The same sheet without any colour: all that it loses it loses to geometry."""
    return replace(sheet, tint=1.0, substrate=1.0)


@by_sheet
def test_no_sheet_gives_more_light_than_it_gets(polar, sheet):
    albedo = white(sheet).albedo(polar(np.deg2rad(ANGLES_DEG), 0.4), accuracy=ACCURACY)
    assert np.max(albedo) < 1.0 + ACCURACY
    assert np.min(albedo[:3]) > 0.5  # nor does it lose what has nowhere to go but out, up to 50 degrees


@dataclass(frozen=True)
class CountedTwice(PrismaticSheeting):
    """Whose substrate gets also what the corners send back."""

    def _parts(self):
        surface, returned, _ = super()._parts()
        return surface, returned, Lambert(self.substrate)


def test_light_that_is_counted_twice_is_seen(polar):
    wrong = CountedTwice(**vars(white(SHEETS["metallised"])))
    assert np.max(wrong.albedo(polar(np.deg2rad(ANGLES_DEG), 0.4), accuracy=ACCURACY)) > 1.0 + ACCURACY


# Samples --------------------------------------------------------------------------------------------------------------

SAMPLES = 1 << 16
VIEW = (0.6, 0.4)  # polar angle and azimuth [rad]


def estimate(sheet: PrismaticSheeting, v: Array, u: Array, gain: float = 1.0) -> tuple[Array, Array]:
    """Albedo by importance sampling and its standard deviation, (3,) each."""
    l = sheet.sample(v, u)
    pdf = gain * sheet.pdf(v, l)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(pdf[:, None] > 0.0, sheet.eval(v, l) * l[:, 2:] / pdf[:, None], 0.0)
    return weight.mean(axis=0), weight.std(axis=0) / np.sqrt(len(weight))


@by_sheet
def test_samples_estimate_the_albedo(rng, polar, significance, sheet):
    v, u = polar(*VIEW), rng.random((SAMPLES, 3))
    albedo = sheet.albedo(v, accuracy=ACCURACY)
    mean, deviation = estimate(sheet, v, u)
    sigmas = significance.sigmas(3)  # channels
    assert np.all(np.abs(mean - albedo) < sigmas * deviation + ACCURACY)
    # A density that is three percent off moves the estimate by as much.
    mean, deviation = estimate(sheet, v, u, 1.0 - PLANTED)
    assert np.any(np.abs(mean - albedo) > sigmas * deviation + ACCURACY)


@by_sheet
def test_weights_of_samples_are_bounded(rng, polar, sheet):
    for theta in (0.1, 0.8, 1.4):
        v = polar(theta, 0.4)
        l = sheet.sample(v, rng.random((4096, 3)))
        pdf = sheet.pdf(v, l)
        found = pdf > 0.0
        assert np.mean(found) > MOST
        assert np.all(np.any(l[~found] == 0.0, axis=1) | (l[~found, 2] <= 0.0))  # only what is lost has none
        weight = sheet.eval(v, l)[found] * l[found, 2:] / pdf[found, None]
        # Within a few: the terms' samples are as good as the lobes' own. Measured: up to 6, at grazing incidence.
        assert np.max(weight) < 20.0


def chi_square(density: Callable[[Array], Array], l: Array, grid: tuple[Array, Array], bins: int) -> float:
    """Probability of a chi-square of the samples, over cells of cosine and azimuth, as large as theirs or larger."""
    directions, solid_angle = grid

    def cell(x: Array) -> Array:
        rows = np.clip((x[:, 2] * bins).astype(int), 0, bins - 1)
        columns = ((np.arctan2(x[:, 1], x[:, 0]) / (2.0 * np.pi) % 1.0) * bins).astype(int) % bins
        return rows * bins + columns

    count = len(l)
    up = l[:, 2] > 0.0
    found = np.bincount(cell(l[up]), minlength=bins * bins)
    share = np.bincount(cell(directions), weights=density(directions) * solid_angle, minlength=bins * bins)
    rest = np.array([count - up.sum()]), np.array([1.0 - share.sum()])
    found, share = (np.concatenate(pair) for pair in zip((found, share), rest, strict=True))
    kept = share * count > 20.0  # below, the statistic is not chi-square's
    expected = count * share[kept]
    return float(stats.chi2.sf(np.sum((found[kept] - expected) ** 2 / expected), np.count_nonzero(kept) - 1))


CELLS, NODES = 12, 504  # nodes a multiple of the cells, so that each has as many


def even_grid() -> tuple[Array, Array]:
    """Directions over the hemisphere, even in cosine and azimuth, and their solid angles."""
    z, turn = np.meshgrid(*[(np.arange(NODES) + 0.5) / NODES] * 2, indexing="ij")
    sine, phi = np.sqrt(1.0 - z * z), 2.0 * np.pi * turn
    directions = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1).reshape(-1, 3)
    return directions, np.full(len(directions), 2.0 * np.pi / len(directions))


@pytest.mark.parametrize("name", ["metallised", "rough"])
def test_samples_follow_their_density(rng, polar, significance, name):
    # Lobes broad enough for an even grid: 0.07 is the narrowest, 42 nodes to a cell of 0.08 in the cosine.
    sheet, v = SHEETS[name], polar(*VIEW)
    l = sheet.sample(v, rng.random((2 * SAMPLES, 3)))

    def tilted(x: Array) -> Array:
        return sheet.pdf(v, x) * (1.0 + PLANTED * np.sign(x[:, 1]))

    assert chi_square(lambda x: sheet.pdf(v, x), l, even_grid(), CELLS) > significance.level()
    assert chi_square(tilted, l, even_grid(), CELLS) < significance.level()


# Limits ---------------------------------------------------------------------------------------------------------------


def test_a_smooth_sheet_sends_back_what_enters_comes_back_and_leaves(polar):
    sheet = PrismaticSheeting(1.5, alpha=(0.01, 0.01), substrate=0.0)
    for degrees in (0.0, 20.0, 40.0):
        v = polar(np.deg2rad(degrees), 0.3)
        returned = sheet._parts()[1]
        found = albedo_by_sampling(returned, v, accuracy=1e-4)[0]
        f = fresnel.dielectric(v[2], 1.5)
        expected = (1.0 - f) ** 2 * prismatic.retroreflected_share(v, 1.5)
        # Relative: the lobe is some 0.5 degrees wide, over which the share changes by up to 1 % of it.
        assert found == pytest.approx(expected, rel=0.01)
        assert found != pytest.approx(expected * (1.0 + PLANTED), rel=0.01)
        assert found != pytest.approx(expected / (1.0 - f), rel=0.01)  # one passage left out, four percent


def test_the_sheet_is_brightest_towards_the_light(rng, hemisphere, polar):
    sheet = SHEETS["acrylic"]
    for degrees in (5.0, 25.0):
        v = polar(np.deg2rad(degrees), 0.4)
        around = hemisphere(rng, 4000)
        mirrored = np.sum(around * mirror(v), axis=1) > 0.9  # the surface's own highlight is not in question
        assert np.max(sheet.eval(v, around[~mirrored])[:, 0]) <= sheet.eval(v, v)[0]
        assert sheet.eval(v, v)[0] > 10.0 * sheet.eval(v, mirror(v))[2] or degrees > 20.0


def test_the_body_colours_what_comes_back_and_not_the_surface(polar):
    v = polar(0.3, 0.1)
    red = PrismaticSheeting(1.5, alpha=(0.05, 0.05), tint=[0.5, 0.0, 0.0], substrate=0.0)
    clear = replace(red, tint=1.0)
    surface = red._parts()[0].eval(v, v)
    np.testing.assert_allclose(red.eval(v, v) - surface, (clear.eval(v, v) - surface) * [0.5, 0.0, 0.0], rtol=64 * EPS)
    assert red.eval(v, mirror(v))[1] > 0.0


def test_where_nothing_comes_back_all_falls_on_the_substrate(polar):
    # Between two orientations of total reflection's loss: 0.00005 of the light comes back at 80 degrees.
    sheet = PrismaticSheeting(1.5, alpha=(0.05, 0.05), rotation=np.pi / 6, substrate=1.0)
    v, l = polar(np.deg2rad(80.0)), polar(np.deg2rad(60.0), 2.0)
    t = sheet.transmittance(v) * sheet.transmittance(l)
    substrate = float(sheet._parts()[2].eval(v, l)[0])
    assert substrate == pytest.approx(float(t) / np.pi, rel=0.01)


def test_an_average_over_rotations_has_no_direction(polar):
    sheet = PrismaticSheeting(1.5, alpha=(0.1, 0.1), rotation=None)
    around = sheet.eval(polar(0.5, np.arange(0.0, 1.0, 0.1)), polar(0.55, np.arange(0.0, 1.0, 0.1) + 0.05))
    np.testing.assert_allclose(around, np.broadcast_to(around[0], around.shape), rtol=2e-3)  # the average's 1e-4 of 0.2
    fixed = replace(sheet, rotation=0.0)
    turned = fixed.eval(polar(0.5, np.arange(0.0, 1.0, 0.1)), polar(0.55, np.arange(0.0, 1.0, 0.1) + 0.05))
    assert np.max(np.abs(turned / turned[0] - 1.0)) > 0.1


def test_nothing_is_seen_from_below(rng, hemisphere):
    sheet = SHEETS["acrylic"]
    v, l, u = hemisphere(rng, 100), hemisphere(rng, 100), rng.random((100, 3))
    down = np.array([1.0, 1.0, -1.0])
    for pair in ((v * down, l), (v, l * down), (v * down, l * down)):
        assert not np.any(sheet.eval(*pair))
        assert not np.any(sheet.pdf(*pair))
    assert not np.any(sheet.sample(v * down, u))


def test_shapes_broadcast(rng, hemisphere):
    v, l = hemisphere(rng, 4), hemisphere(rng, 3)[:, None]
    sheet = PrismaticSheeting(np.full(4, 1.5), alpha=(np.full((3, 1), 0.1), 0.2), rotation=np.zeros(4))
    assert sheet.eval(v, l).shape == (3, 4, 3)
    assert sheet.pdf(v, l).shape == (3, 4)
    assert sheet.sample(v, rng.random((3, 4, 3))).shape == (3, 4, 3)


def test_wrong_parameters_are_refused():
    v = np.array([0.0, 0.0, 1.0])
    with pytest.raises(ValueError, match=r"^ior must be > 1, got 1; a sheet of the index of air has no corners$"):
        PrismaticSheeting(1.0).eval(v, v)
    with pytest.raises(ValueError, match=r"^backing must be one of air, metal, got 'gold'$"):
        PrismaticSheeting(backing="gold").eval(v, v)
    with pytest.raises(ValueError, match=r"^alpha must be in \(0, 1\], got "):
        PrismaticSheeting(alpha=(0.0, 0.1)).eval(v, v)
