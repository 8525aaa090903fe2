"""Closures: lobes times cosine, and the arithmetic of combining them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.bsdf import Conductor, Dielectric, GeneralizedSchlick, diffuse, fresnel
from mrm_mtlx.bsdf.compensation import compensation
from mrm_mtlx.bsdf.vectors import mirror
from mrm_mtlx.reference import Surface, closures, versions
from mrm_mtlx.reference.closures import Closure

EPS = np.finfo(float).eps

# Albedos of MaterialX's shaders.
ALBEDO_FACTORS = versions.installed().microfacet_albedo.factors
WHITE_ALBEDO = versions.installed().microfacet_albedo.white

# Share of the samples in which a planted error has to show.
MOST = 0.5


def single(x: float | list[float]) -> np.ndarray:
    """What a number of the document is in the shader."""
    return np.asarray(x, dtype=np.float32).astype(float)


# Document and lobe; both hold the numbers as float32.
GOLD_N, GOLD_K = single([0.183, 0.421, 1.373]), single([3.424, 2.346, 1.770])
ALPHA = single(0.3)
WIDTH = '<input name="roughness" type="vector2" value="0.3, 0.3"/>'
FILM = (
    '<input name="thinfilm_thickness" type="float" value="400"/><input name="thinfilm_ior" type="float" value="1.25"/>'
)
PAIRS = {
    "metal": (f'<conductor_bsdf name="bsdf" type="BSDF">{WIDTH}{{}}</conductor_bsdf>', Conductor(GOLD_N, GOLD_K)),
    "coated metal": (
        f'<conductor_bsdf name="bsdf" type="BSDF">{WIDTH}{FILM}{{}}</conductor_bsdf>',
        Conductor(GOLD_N, GOLD_K, thinfilm_thickness=400.0, thinfilm_ior=1.25),
    ),
    "dielectric": (
        f'<dielectric_bsdf name="bsdf" type="BSDF">{WIDTH}'
        '<input name="tint" type="color3" value="1, 0.5, 0.25"/>{}</dielectric_bsdf>',
        Dielectric(1.5, tint=[1.0, 0.5, 0.25]),
    ),
    "coated dielectric": (
        f'<dielectric_bsdf name="bsdf" type="BSDF">{WIDTH}{FILM}{{}}</dielectric_bsdf>',
        Dielectric(1.5, thinfilm_thickness=400.0, thinfilm_ior=1.25),
    ),
    "curve": (
        f'<generalized_schlick_bsdf name="bsdf" type="BSDF">{WIDTH}'
        '<input name="color0" type="color3" value="0.5, 0.25, 0.125"/>'
        '<input name="color82" type="color3" value="0.75, 1, 0.5"/>'
        '<input name="exponent" type="float" value="4"/>{}</generalized_schlick_bsdf>',
        GeneralizedSchlick([0.5, 0.25, 0.125], [0.75, 1.0, 0.5], 1.0, 4.0),
    ),
}
FLAG = '<input name="retroreflective" type="boolean" value="{}"/>'


def lobe_misses(surface: Surface, lobe, points) -> float:
    """Share of the samples for which a surface's response is not the lobe times the cosine of l.

    The closure normalises v and cancels n.l: the same numbers but for roundings. Those of v' + l grow as it shrinks and
    move D by 4 / alpha times as much; films follow the cosine with a slope of up to 100 and, at Brewster's angles,
    where a reflectance vanishes, are wrong by the root of a rounding.
    """
    v, l = points.view, points.light
    seen = mirror(v) if lobe.retroreflective else v
    expected = lobe.eval(v, l) * l[:, 2:]
    white = GeneralizedSchlick(
        1.0, alpha=lobe.alpha, retroreflective=lobe.retroreflective, energy_compensation=WHITE_ALBEDO
    )
    direction_error = 16 * EPS / np.linalg.norm(seen + l, axis=-1, keepdims=True)
    grazing = 16 * EPS / np.minimum(v[:, 2:], l[:, 2:])
    film_error = 4.0 * np.sqrt(EPS) if lobe.thinfilm_thickness else 0.0
    tolerance = (grazing + film_error + direction_error * (4.0 / ALPHA + 100.0)) * white.eval(v, l) * l[:, 2:]
    return float(np.mean(np.any(np.abs(surface.response(points) - expected) > tolerance, axis=-1)))


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("flag", ["false", "true"])
def test_a_response_is_the_compensated_lobe_times_the_cosine(
    surface_document, flat_points, rng, direction_pairs, name, flag
):
    text, lobe = PAIRS[name]
    document = surface_document(text.format(FLAG.format(flag)))
    surface = Surface(document.getNode("m"))
    points = flat_points(*direction_pairs(rng, 4000))
    lobe = replace(lobe, alpha=(ALPHA, ALPHA), retroreflective=flag == "true", energy_compensation=WHITE_ALBEDO)
    assert lobe_misses(surface, lobe, points) == 0.0
    for wrong in (
        replace(lobe, retroreflective=not lobe.retroreflective),
        replace(lobe, energy_compensation=None),
        replace(lobe, alpha=(1.001 * ALPHA, ALPHA)),
    ):
        assert lobe_misses(surface, wrong, points) > MOST


def test_masking_of_an_anisotropic_surface_uses_the_mean_width(surface_document, flat_points, polar):
    document = surface_document(
        '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.5, 0.125"/>'
        "</conductor_bsdf>"
    )
    v, l = polar(np.array([0.8, 0.8]), np.array([0.0, 1.0])), polar(np.array([0.9, 0.9]), np.array([2.5, 3.5]))
    true_widths = Conductor(GOLD_N, GOLD_K, alpha=(0.5, 0.125), energy_compensation=WHITE_ALBEDO).eval(v, l) * l[:, 2:]
    ratio = Surface(document.getNode("m")).response(flat_points(v, l)) / true_widths
    # Not the lobe of the papers, but near it; all channels alike, since D and F are the same.
    np.testing.assert_allclose(ratio, ratio[:, :1] * np.ones(3), rtol=64 * EPS)
    assert np.all(np.abs(ratio - 1.0) > 1e-3)
    assert np.all(np.abs(ratio - 1.0) < 0.5)


def test_fibres_are_no_narrower_than_those_of_the_least_roughness(surface_document, flat_points, polar):
    points = flat_points(polar(np.array([0.9, 1.2])), polar(np.array([1.3, 1.1]), np.array([0.2, 0.1])))

    def response(roughness: float):
        given = f'<input name="roughness" type="float" value="{roughness}"/>'
        document = surface_document(f'<sheen_bsdf name="bsdf" type="BSDF">{given}</sheen_bsdf>')
        return Surface(document.getNode("m")).response(points)

    # 0.005 as a float32 is not the shader's to the last digit, and is the exponent of the sine.
    least = response(0.005)
    assert np.all(least > 0.0)
    for roughness in (0.0, 0.001, 0.004):
        np.testing.assert_allclose(response(roughness), least, rtol=1e-4)
    assert np.all(np.abs(response(0.006) / least - 1.0) > 0.05)


def test_light_from_below_is_clamped_and_not_cut_off(surface_document, flat_points, polar):
    document = surface_document('<generalized_schlick_bsdf name="bsdf" type="BSDF"/>')
    surface = Surface(document.getNode("m"))
    v = polar(0.5)
    below = surface.response(flat_points(v, polar(np.pi / 2 + 0.1, np.pi)))
    assert np.all(below > 0.0)
    assert np.all(below < surface.response(flat_points(v, polar(np.pi / 2 - 0.1, np.pi))))


def test_a_surface_seen_from_behind_turns_its_normal(surface_document, flat_points, polar):
    for flag in ("true", "false"):
        text = PAIRS["metal"][0].format(FLAG.format(flag))
        document = surface_document(text)
        surface = Surface(document.getNode("m"))
        down = np.array([1.0, 1.0, -1.0])
        v, l = polar(0.7, 0.3), polar(0.6, 0.5)
        np.testing.assert_allclose(
            surface.response(flat_points(v * down, l * down)), surface.response(flat_points(v, l)), rtol=16 * EPS
        )


# Combination --------------------------------------------------------------------------------------------------------

FIRST = Closure(np.array([[1.0], [2.0], [3.0]]), np.array([[0.5], [0.25], [1.0]]))
SECOND = Closure(np.array([[10.0], [20.0], [40.0]]), np.array([[0.75], [0.5], [0.0]]))


def test_a_layer_weakens_its_base_by_its_throughput():
    found = closures.layer(FIRST, SECOND)
    assert found.response.ravel().tolist() == [1 + 5, 2 + 5, 3 + 40]
    assert found.throughput.ravel().tolist() == [0.375, 0.125, 0.0]
    # The other order is another material.
    assert closures.layer(SECOND, FIRST).response.ravel().tolist() == [10.75, 21.0, 40.0]


def test_a_mix_is_linear_in_response_and_throughput():
    found = closures.mix(FIRST, SECOND, np.asarray(0.25))
    assert found.response.ravel().tolist() == [0.25 + 7.5, 0.5 + 15.0, 0.75 + 30.0]
    assert found.throughput.ravel().tolist() == [0.125 + 0.5625, 0.0625 + 0.375, 0.25]
    # The amount belongs to the foreground, the first argument.
    assert np.array_equal(closures.mix(FIRST, SECOND, np.asarray(1.0)).response, FIRST.response)
    assert np.array_equal(closures.mix(FIRST, SECOND, np.asarray(0.0)).response, SECOND.response)


def test_a_sum_adds_responses_and_albedos():
    found = closures.add(FIRST, SECOND)
    assert found.response.ravel().tolist() == [11, 22, 43]
    # Throughput is 1 - albedo: t1 + t2 - 1, and nothing below 0.
    assert found.throughput.ravel().tolist() == [0.25, 0.0, 0.0]


def test_a_factor_multiplies_the_response_alone_and_is_clamped():
    found = closures.multiply(FIRST, np.array([[0.5], [-1.0], [7.0]]))
    assert found.response.ravel().tolist() == [0.5, 0.0, 3.0]
    assert np.array_equal(found.throughput, FIRST.throughput)


def test_nothing_reflects_nothing_and_hides_nothing():
    layered = closures.layer(closures.nothing(), SECOND)
    assert np.array_equal(layered.response, SECOND.response)
    assert np.array_equal(layered.throughput, SECOND.throughput)


# The same, in documents ---------------------------------------------------------------------------------------------

COAT = (
    f'<dielectric_bsdf name="coat" type="BSDF">{WIDTH}<input name="weight" type="float" value="0.5"/></dielectric_bsdf>'
)
PAINT = (
    '<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value="0.5, 0.25, 0.125"/>'
    "</oren_nayar_diffuse_bsdf>"
)
SPARKS = f'<conductor_bsdf name="sparks" type="BSDF">{WIDTH}</conductor_bsdf>'
GLAZE = (
    f'<generalized_schlick_bsdf name="glaze" type="BSDF">{WIDTH}<input name="weight" type="float" value="0.5"/>'
    '<input name="color0" type="color3" value="0.5, 0.25, 0.125"/></generalized_schlick_bsdf>'
)
PARTS = COAT + PAINT + SPARKS + GLAZE

V, L = np.array([[0.6, 0.0, 0.8], [0.0, 0.28, 0.96]]), np.array([[0.0, 0.6, 0.8], [0.48, 0.36, 0.8]])


def coat_response() -> np.ndarray:
    lobe = Dielectric(1.5, alpha=(ALPHA, ALPHA), energy_compensation=WHITE_ALBEDO)
    return 0.5 * lobe.eval(V, L) * L[:, 2:]


def coat_throughput() -> np.ndarray:
    """1 - weight * albedo * compensation, with Fresnel at the half-vector, as MaterialX has it."""
    a, b = ALBEDO_FACTORS(V[:, 2], ALPHA)
    f0 = fresnel.reflectance_at_normal(1.5)
    m = V + L
    cos_m = np.sum(V * m, axis=-1) / np.linalg.norm(m, axis=-1)
    gain = compensation(fresnel.dielectric(cos_m, 1.5), a + b)
    return (1.0 - 0.5 * (a * f0 + b) * gain)[:, None]


def paint_response() -> np.ndarray:
    lambert = diffuse.oren_nayar(V[:, 2], L[:, 2], np.sum(V * L, axis=-1), 0.0) * L[:, 2]
    return lambert[:, None] * np.array([0.5, 0.25, 0.125])


def glaze_response() -> np.ndarray:
    lobe = GeneralizedSchlick([0.5, 0.25, 0.125], alpha=(ALPHA, ALPHA), energy_compensation=WHITE_ALBEDO)
    return 0.5 * lobe.eval(V, L) * L[:, 2:]


def glaze_throughput() -> np.ndarray:
    """Grey: the mean of the channels of 1 - weight * albedo * compensation."""
    a, b = (factor[:, None] for factor in ALBEDO_FACTORS(V[:, 2], ALPHA))
    f0 = np.array([0.5, 0.25, 0.125])
    m = V + L
    cos_m = (np.sum(V * m, axis=-1) / np.linalg.norm(m, axis=-1))[:, None]
    gain = compensation(fresnel.generalized_schlick(cos_m, f0, 1.0, 1.0, 5.0), a + b)
    return np.mean(1.0 - 0.5 * (a * f0 + b) * gain, axis=-1, keepdims=True)


def sparks_response() -> np.ndarray:
    return Conductor(GOLD_N, GOLD_K, alpha=(ALPHA, ALPHA), energy_compensation=WHITE_ALBEDO).eval(V, L) * L[:, 2:]


COMBINATIONS = {
    "a coat over paint": (
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="coat"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>',
        lambda: coat_response() + coat_throughput() * paint_response(),
    ),
    "a coloured glaze over paint": (
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="glaze"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>',
        lambda: glaze_response() + glaze_throughput() * paint_response(),
    ),
    "paint over a coat": (
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="paint"/>'
        '<input name="base" type="BSDF" nodename="coat"/></layer>',
        paint_response,
    ),
    "two coats over paint": (
        '<layer name="under" type="BSDF"><input name="top" type="BSDF" nodename="coat"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>'
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="coat"/>'
        '<input name="base" type="BSDF" nodename="under"/></layer>',
        lambda: coat_response() + coat_throughput() * (coat_response() + coat_throughput() * paint_response()),
    ),
    "sparks mixed into paint": (
        '<mix name="bsdf" type="BSDF"><input name="fg" type="BSDF" nodename="sparks"/>'
        '<input name="bg" type="BSDF" nodename="paint"/><input name="mix" type="float" value="0.25"/></mix>',
        lambda: 0.25 * sparks_response() + 0.75 * paint_response(),
    ),
    "a half coat over paint": (
        '<mix name="top" type="BSDF"><input name="fg" type="BSDF" nodename="coat"/>'
        '<input name="mix" type="float" value="0.5"/></mix>'
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="top"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>',
        lambda: 0.5 * coat_response() + (0.5 + 0.5 * coat_throughput()) * paint_response(),
    ),
    "sparks added to paint": (
        '<add name="bsdf" type="BSDF"><input name="in1" type="BSDF" nodename="sparks"/>'
        '<input name="in2" type="BSDF" nodename="paint"/></add>',
        lambda: sparks_response() + paint_response(),
    ),
    "two coats side by side over paint": (
        '<add name="top" type="BSDF"><input name="in1" type="BSDF" nodename="coat"/>'
        '<input name="in2" type="BSDF" nodename="coat"/></add>'
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="top"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>',
        lambda: 2.0 * coat_response() + (2.0 * coat_throughput() - 1.0) * paint_response(),
    ),
    "a dimmed coat over paint": (
        '<multiply name="top" type="BSDF"><input name="in1" type="BSDF" nodename="coat"/>'
        '<input name="in2" type="float" value="0.5"/></multiply>'
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="top"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>',
        lambda: 0.5 * coat_response() + coat_throughput() * paint_response(),
    ),
    "tinted sparks": (
        '<multiply name="bsdf" type="BSDF"><input name="in1" type="BSDF" nodename="sparks"/>'
        '<input name="in2" type="color3" value="0.5, 2.0, -1.0"/></multiply>',
        lambda: sparks_response() * [0.5, 1.0, 0.0],
    ),
}

# Relative. Some thirty operations on well-conditioned directions.
COMBINATION_TOL = 128 * EPS


@pytest.mark.parametrize("name", COMBINATIONS)
def test_combined_nodes_follow_the_arithmetic_of_their_closures(surface_document, flat_points, name):
    text, expected = COMBINATIONS[name]
    document = surface_document(PARTS + text)
    found = Surface(document.getNode("m")).response(flat_points(V, L))
    np.testing.assert_allclose(found, expected(), rtol=COMBINATION_TOL)


def test_each_combination_differs_from_every_other(surface_document, flat_points):
    # What the test above could not tell apart, it would not check.
    found = []
    for text, _ in COMBINATIONS.values():
        document = surface_document(PARTS + text)
        found.append(Surface(document.getNode("m")).response(flat_points(V, L)))
    for k, one in enumerate(found):
        for other in found[:k]:
            assert np.max(np.abs(one - other)) > COMBINATION_TOL * np.max(one)


def test_a_weight_of_zero_shows_what_is_below_and_a_metal_hides_it(surface_document, flat_points):
    layered = (
        '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="{}"/>'
        '<input name="base" type="BSDF" nodename="paint"/></layer>'
    )
    off = '<input name="weight" type="float" value="0"/></'
    coat, metal = COAT.replace("0.5", "0"), SPARKS.replace("</", off)
    seen = {}
    for name, top in (("coat", coat), ("sparks", metal)):
        document = surface_document(top + PAINT + layered.format(name))
        seen[name] = Surface(document.getNode("m")).response(flat_points(V, L))
    np.testing.assert_allclose(seen["coat"], paint_response(), rtol=COMBINATION_TOL)
    assert not np.any(seen["sparks"])
