"""Outputs that are no shader: each shows its value, under any light, and single errors in it are seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import Surface, UnsupportedError, versions
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.sampling import generator

SAMPLES = 512
NUMBERS = """
  <nodegraph name="g">
    <input name="share" type="float" value="0.3"/>
    <texcoord name="uv" type="vector2"/>
    <position name="place" type="vector3"/>
    <geompropvalue name="property" type="float"><input name="geomprop" type="string" value="wear"/></geompropvalue>
    <dotproduct name="grey" type="float">
      <input name="in1" type="vector2" nodename="uv"/><input name="in2" type="vector2" value="0.25, 0.5"/>
    </dotproduct>
    <floor name="whole" type="integer"><input name="in" type="float" nodename="grey"/></floor>
    <ifgreater name="beyond" type="boolean">
      <input name="value1" type="float" nodename="grey"/><input name="value2" type="float" interfacename="share"/>
    </ifgreater>
    <convert name="color" type="color3"><input name="in" type="vector3" nodename="place"/></convert>
    <combine2 name="covered" type="color4">
      <input name="in1" type="color3" nodename="color"/><input name="in2" type="float" nodename="property"/>
    </combine2>
    <combine4 name="four" type="vector4">
      <input name="in1" type="float" nodename="grey"/><input name="in2" type="float" interfacename="share"/>
      <input name="in3" type="float" nodename="property"/><input name="in4" type="float" nodename="grey"/>
    </combine4>
    <separate2 name="parts" type="multioutput"><input name="in" type="vector2" nodename="uv"/></separate2>
    <output name="as_float" type="float" nodename="grey"/>
    <output name="as_vector2" type="vector2" nodename="uv"/>
    <output name="as_vector3" type="vector3" nodename="place"/>
    <output name="as_vector4" type="vector4" nodename="four"/>
    <output name="as_color3" type="color3" nodename="color" colorspace="srgb_texture" width="64" bitdepth="8"/>
    <output name="as_color4" type="color4" nodename="covered"/>
    <output name="as_integer" type="integer" nodename="whole"/>
    <output name="as_boolean" type="boolean" nodename="beyond"/>
    <output name="second" type="float" nodename="parts" output="outy"/>
  </nodegraph>
  <randomcolor name="free" type="color3"><input name="in" type="float" value="0.3"/></randomcolor>
  <output name="of_document" type="color3" nodename="free"/>
"""
# A change of the document, and the outputs that show it.
ERRORS = {
    "a wrong number": ('"0.25, 0.5"', '"0.25, 0.50002"', {"as_float", "as_vector4"}),
    "a wrong interface": (
        'name="share" type="float" value="0.3"',
        'name="share" type="float" value="0.30001"',
        {"as_vector4"},
    ),
    "a wrong alpha": ('name="in4" type="float" nodename="grey"', 'name="in4" type="float" value="1"', {"as_vector4"}),
    "a property for another": ('"wear"', '"rust"', {"as_vector4", "as_color4"}),
    "the opposite comparison": (
        'name="value1" type="float" nodename="grey"/><input name="value2"',
        'name="value2" type="float" nodename="grey"/><input name="value1"',
        {"as_boolean"},
    ),
    "another rounding": ("floor", "ceil", {"as_integer"}),
    "another output of the node": ('"outy"', '"outx"', {"second"}),
    "another color": ('name="in" type="float" value="0.3"', 'name="in" type="float" value="0.4"', {"of_document"}),
}


def elements(document):
    return {e.getName(): e for e in renderable_elements(document)}


def drawn(element, library, expectation, change=lambda pixel: pixel):
    shader = generate(element, "glsl", library)
    changed = replace(shader, sources={**shader.sources, "pixel": change(shader.sources["pixel"])})
    with SurfaceProgram(changed) as program:
        return expectation.draw(program)


def expected(element):
    return Expectation(element, generator(0, element.getName()), SAMPLES, lambda _name: None)


def test_every_output_shows_its_value(gl, make_document, library):
    document = make_document(NUMBERS)
    for name, element in elements(document).items():
        expectation = expected(element)
        found = drawn(element, library, expectation)
        verdict = expectation.compare(found)
        assert verdict.comparison.passed, name
        assert np.max(np.abs(found[0].colors[:, :3])) > 0.1 or verdict.deviations == {Deviation.BLACK_BOOLEANS}, name


@pytest.mark.parametrize("error", ERRORS)
def test_an_error_in_a_pattern_is_seen_in_the_outputs_that_depend_on_it(gl, make_document, library, error):
    old, new, seen = ERRORS[error]
    true, wrong = make_document(NUMBERS), make_document(NUMBERS.replace(old, new))
    shown = elements(wrong)
    failed = set()
    for name, element in elements(true).items():
        expectation = expected(element)
        if not expectation.compare(drawn(shown[name], library, expectation)).comparison.passed:
            failed.add(name)
    if Deviation.BLACK_BOOLEANS in versions.installed().deviations:
        seen = seen - {"as_boolean"}  # black whatever it is
    assert failed == seen


@pytest.mark.parametrize("which", [0, 1])
def test_a_pattern_that_depends_on_the_light_is_seen(gl, make_document, library, which):
    document = make_document(NUMBERS)
    element = document.getDescendant("g/as_vector3")
    expectation = expected(element)
    found = list(drawn(element, library, expectation))
    found[which] = replace(found[which], colors=0.999 * found[which].colors)  # under the light, or in the environment
    assert not expectation.compare(tuple(found)).comparison.passed


@pytest.mark.parametrize("kind", ["matrix33", "string"])
def test_what_shaders_show_as_black_is_no_comparison(make_document, kind):
    value = {"matrix33": "1,2,3,4,5,6,7,8,9", "string": "text"}[kind]
    document = make_document(
        f'<constant name="c" type="{kind}"><input name="value" type="{kind}" value="{value}"/></constant>'
        f'<output name="o" type="{kind}" nodename="c"/>'
    )
    with pytest.raises(UnsupportedError, match=f"outputs of type {kind}, which shaders show as black"):
        Surface(document.getOutput("o"))


def test_patterns_pass_a_check_of_the_document(gl, check, tmp_path):
    path = tmp_path / "numbers.mtlx"
    path.write_text(f'<?xml version="1.0"?><materialx version="1.39">{NUMBERS}</materialx>', encoding="utf-8")
    (result,) = check(path, targets=("glsl", "osl"))
    known = Deviation.BLACK_BOOLEANS in versions.installed().deviations
    assert [f.code for f in result.findings] == ["UPSTREAM_DEVIATION"] * known
    assert {r.targets["glsl"].status for r in result.renderables} == {"pass"}
    assert all(r.targets["osl"].stage == "compile" for r in result.renderables)
