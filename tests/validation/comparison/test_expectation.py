"""What a surface is expected to show: under a light and in an environment, and what only one of the two can see."""

from __future__ import annotations

import re
from dataclasses import replace

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.samples import compare, worse
from mrm_mtlx.validation.comparison.sampling import generator
from tests.fixtures.versions import planted

# Glass over a diffuse base: it reflects, refracts its environment, and dims what is below.
GLASS = """
  <dielectric_bsdf name="glass" type="BSDF">
    <input name="scatter_mode" type="string" value="RT"/>
    <input name="tint" type="color3" value="0.9, 0.6, 0.3"/>
    <input name="roughness" type="vector2" value="0.2, 0.3"/>
  </dielectric_bsdf>
  <oren_nayar_diffuse_bsdf name="diffuse" type="BSDF"/>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="glass"/><input name="base" type="BSDF" nodename="diffuse"/>
  </layer>
"""
SAMPLES = 512


@pytest.fixture
def glass(surface_document, library):
    """The document, the expectation of its surface and its shader; together, so that the document stays alive."""
    document = surface_document(GLASS)
    expectation = Expectation(document.getNode("m"), generator(0, "glass"), SAMPLES, lambda _name: None)
    return document, expectation, generate(document.getNode("m"), "glsl", library)


def drawn(expectation, shader, old="", new=""):
    pixel = shader.sources["pixel"]
    changed = replace(shader, sources={**shader.sources, "pixel": planted(pixel, old, new) if old else pixel})
    with SurfaceProgram(changed) as program:
        return expectation.draw(program)


def test_light_and_surroundings_are_drawn_and_compared(gl, glass):
    _, expectation, shader = glass
    found = drawn(expectation, shader)
    assert [len(drawing.colors) for drawing in found] == [SAMPLES, SAMPLES // 16]
    comparison = expectation.compare(found).comparison
    assert comparison.passed
    assert comparison.samples == SAMPLES + SAMPLES // 16


@pytest.mark.parametrize(
    ("old", "new", "seen_in"),
    [
        pytest.param(
            "bsdf.response = Li * safeTint * comp * weight",
            "bsdf.response = Li * safeTint * weight",
            [1],
            id="indirect",
        ),
        pytest.param("fd.refraction = true;", "fd.refraction = false;", [1], id="refraction"),
        pytest.param("D * F * G * comp * safeTint", "D * F * G * safeTint", [0], id="direct"),
        pytest.param("base.response * top.throughput", "base.response", [0, 1], id="throughput"),
    ],
)
def test_an_error_is_seen_where_it_is(gl, glass, old, new, seen_in):
    _, expectation, shader = glass
    true, wrong = drawn(expectation, shader), drawn(expectation, shader, old, new)
    for number in (0, 1):
        mixed = [*true]
        mixed[number] = wrong[number]
        assert expectation.compare(tuple(mixed)).comparison.passed is (number not in seen_in)


def test_a_surface_without_a_reference_is_drawn_and_says_what_is_unknown(gl, surface_document, library):
    document = surface_document(
        '<no_such_bsdf name="bsdf" type="BSDF"/>'.replace("no_such_bsdf", "oren_nayar_diffuse_bsdf")
    )
    document.getNode("bsdf").setNodeDefString("ND_unknown")
    expectation = Expectation(document.getNode("m"), generator(0, "x"), SAMPLES, lambda _name: None)
    assert re.search(r"the reference does not know \w+", expectation.reason)
    assert expectation.surface is None


def test_two_comparisons_as_one_are_as_bad_as_the_worse(rng, glass):
    _, expectation, _ = glass
    points = expectation._points[1]
    tolerance = expectation.surface.tolerance(points)
    good = compare(tolerance.expected, tolerance, points)
    bad = compare(tolerance.expected + 2.0 * tolerance.allowed, tolerance, points)
    for both in (worse(good, bad), worse(bad, good)):
        assert both.samples == 2 * len(points)
        assert (both.differing, both.excess, both.worst) == (len(points), bad.excess, bad.worst)
        assert (both.max_error, both.tolerance) == (bad.max_error, bad.tolerance)
    assert np.isclose(bad.excess, 2.0)


def test_a_shader_that_is_not_finite_is_told_with_the_node_that_makes_it_so(gl, surface_document, check, tmp_path):
    document = surface_document(
        '<normalize name="zero" type="vector3"><input name="in" type="vector3" value="0, 0, 0"/></normalize>'
        '<conductor_bsdf name="bsdf" type="BSDF"><input name="normal" type="vector3" nodename="zero"/></conductor_bsdf>'
    )
    mx.writeToXmlFile(document, str(tmp_path / "zero.mtlx"))
    (result,) = check(tmp_path / "zero.mtlx")
    assert [f.code for f in result.findings] == ["SHADER_NOT_FINITE"]
    assert "the node 'zero' is the first that is" in result.findings[0].message
