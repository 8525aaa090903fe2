"""A perturbed evaluation takes from the exact one what the perturbation does not touch, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.reference import Environment, Illumination, Surface
from mrm_mtlx.reference.float32.rounding import (
    EXACT,
    OUTPUT_ROUNDINGS,
    QUANTITIES,
    SMALLEST,
    UNIT,
    Direction,
    Model,
    Perturbation,
    Quantity,
    channel_perturbations,
    opposite_perturbations,
    perturbations,
    range_perturbations,
)
from mrm_mtlx.reference.sharing import Values

SAMPLES = 150
LIT = Illumination()
AROUND = Illumination(light=False, environment=Environment.constant((1.0, 0.75, 0.5), samples=4))

OPEN_PBR = """
  <open_pbr_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" value="0.7, 0.2, 0.4" colorspace="srgb_texture"/>
    <input name="base_metalness" type="float" value="0.3"/>
    <input name="specular_roughness_anisotropy" type="float" value="0.5"/>
    <input name="transmission_weight" type="float" value="0.2"/>
    <input name="subsurface_weight" type="float" value="0.3"/>
    <input name="coat_weight" type="float" value="0.7"/>
    <input name="fuzz_weight" type="float" value="0.4"/>
    <input name="thin_film_weight" type="float" value="0.5"/>
    <input name="emission_luminance" type="float" value="1"/>
  </open_pbr_surface>
"""
# Noise that a comparison steps in, and an image in a colour space.
PATTERNS = """
  <noise2d name="n" type="float"/>
  <ifgreater name="step" type="float">
    <input name="value1" type="float" nodename="n"/><input name="value2" type="float" value="0.1"/>
    <input name="in1" type="float" value="0.2"/><input name="in2" type="float" value="0.6"/>
  </ifgreater>
  <image name="i" type="color3"><input name="file" type="filename" value="i.png" colorspace="srgb_texture"/></image>
  <viewdirection name="v" type="vector3"/>
  <dotproduct name="steep" type="float">
    <input name="in1" type="vector3" nodename="v"/><input name="in2" type="vector3" value="0.6, 0, 0.8"/>
  </dotproduct>
  <absval name="shine" type="float"><input name="in" type="float" nodename="steep"/></absval>
  <standard_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" nodename="i"/>
    <input name="specular_roughness" type="float" nodename="step"/>
    <input name="sheen" type="float" nodename="shine"/>
  </standard_surface>
"""
HAIR = """
  <chiang_hair_bsdf name="h" type="BSDF"/>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="h"/></surface>
"""
METAL = """
  <conductor_bsdf name="c" type="BSDF">
    <input name="roughness" type="vector2" value="0.1, 0.3"/><input name="retroreflective" type="boolean" value="true"/>
    <input name="thinfilm_thickness" type="float" value="300"/>
  </conductor_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="c"/></surface>
"""
SURFACES = {"open_pbr": OPEN_PBR, "patterns": PATTERNS, "hair": HAIR, "metal": METAL}

IMAGE = np.random.default_rng(1).random((4, 4, 3)).astype(np.float32)


@pytest.fixture
def surface(make_document):
    """Function from a name of `SURFACES` to the surface."""

    def make(name: str, model: Model = Model.HARDWARE) -> Surface:
        document = make_document(SURFACES[name])
        assert document.validate()[0]
        return Surface(document.getNode("s"), model, images=lambda _: IMAGE)

    return make


@pytest.fixture
def points(turned_points, rng, direction_pairs):
    points = turned_points(rng, *direction_pairs(rng, SAMPLES))
    return replace(points, texcoord=rng.uniform(-2.0, 2.0, (SAMPLES, 2)))


def evaluated_anew(surface, points, illumination, model=Model.HARDWARE):
    """What a tolerance is, every perturbation evaluating the whole graph."""
    exact = surface._evaluation(points, illumination, EXACT)
    expected = surface._result(exact)
    exact.values = Values()
    chosen = [m for m in perturbations(model) if illumination.light or not np.any(m.light)]
    allowed = OUTPUT_ROUNDINGS * UNIT * np.abs(expected) + SMALLEST
    for perturbation in [*chosen, *(opposite_perturbations() if exact.discrete.varying else ())]:
        together = [perturbation, *(channel_perturbations() if perturbation.quantity is Quantity.FUNCTIONS else ())]
        allowed = allowed + perturbation.factor * np.max(
            [np.abs(surface._color(points, illumination, m, exact) - expected) for m in together], axis=0
        )
    ends = (
        np.abs(surface._color(points, illumination, perturbation, exact) - expected)
        for perturbation in range_perturbations()
    )
    return expected, allowed + np.maximum(*ends)


@pytest.mark.parametrize("illumination", [LIT, AROUND], ids=["lit", "around"])
@pytest.mark.parametrize("name", SURFACES)
def test_a_tolerance_is_digit_by_digit_that_of_perturbations_evaluated_anew(surface, points, name, illumination):
    found = surface(name).tolerance(points, illumination)
    expected, allowed = evaluated_anew(surface(name), points, illumination)
    assert np.array_equal(found.expected, expected)
    assert np.array_equal(found.allowed, allowed)


def test_so_it_is_in_the_model_of_oslclosures(surface, points):
    found = surface("metal", Model.CLOSURES).tolerance(points)
    _, allowed = evaluated_anew(surface("metal", Model.CLOSURES), points, LIT, Model.CLOSURES)
    assert np.array_equal(found.allowed, allowed)


@pytest.mark.parametrize("need", [Direction.VIEW, Direction.LIGHT, Quantity.MOST, *QUANTITIES[Model.HARDWARE]])
def test_what_is_not_noted_is_missing_from_some_tolerance(surface, points, monkeypatch, need):
    right = {name: evaluated_anew(surface(name), points, LIT)[1] for name in SURFACES}
    note = Values.note
    monkeypatch.setattr(Values, "note", lambda self, needs: note(self, set(needs) - {need}))
    wrong = {name: surface(name).tolerance(points).allowed for name in SURFACES}
    assert any(not np.array_equal(right[name], wrong[name]) for name in SURFACES)


def test_what_a_perturbation_does_not_touch_is_not_evaluated(surface, points, monkeypatch):
    """Pattern nodes do not depend on directions: of 20 perturbations and the exact evaluation, few meet noise."""
    from mrm_mtlx.reference.textures import noise as noise_functions

    count = 0
    noise = noise_functions.fractal_noise

    def counted(*args, **options):
        nonlocal count
        count += 1
        return noise(*args, **options)

    monkeypatch.setattr(noise_functions, "fractal_noise", counted)
    surface("patterns").tolerance(points)
    assert count == 1 + 1 + 4 + 4  # exactly, functions, the numbers, and these with the opposite signs


def test_a_value_is_what_it_takes():
    values = Values()
    inner = values.make(("inner",), lambda: values.note({Direction.VIEW}))
    outer = values.make(("outer",), lambda: values.take(inner))
    assert outer.needs == {Direction.VIEW}
    moved = Values(Perturbation(view=UNIT * np.eye(3)[0]), values)
    assert moved.find(("outer",)) is None
    assert Values(Perturbation(light=UNIT * np.eye(3)[0]), values).find(("outer",)) is outer
    assert Values(Perturbation(values=1), values).find(("outer",)) is None


def test_an_intermediate_result_is_made_of_what_was_asked_for_before():
    values = Values()

    def node() -> int:
        values.note({Direction.VIEW})
        return values.kept("square", lambda: 2) + values.input("in", lambda: 1)

    values.make(("node",), node)
    known = {key[-1]: value.needs for key, value in values._known.items()}
    assert known == {"square": {Direction.VIEW}, "in": frozenset(), "node": {Direction.VIEW}}
