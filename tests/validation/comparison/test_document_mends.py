"""Deviations that a document written in another way spares: they are told by name, and nothing else passes as one."""

from __future__ import annotations

from functools import partial

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison.document_mends import MENDS
from mrm_mtlx.validation.comparison.drawing import check_draws
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.mending import mended_shaders
from mrm_mtlx.validation.comparison.sampling import generator
from tests.fixtures.versions import since

MATERIAL = """
  <surface_unlit name="u" type="surfaceshader">
    <input name="emission_color" type="color3" {connection}/>
  </surface_unlit>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="u"/>
  </surfacematerial>
"""
GRAPH = MATERIAL.format(connection='nodegraph="g" output="out"')
NODE = MATERIAL.format(connection='nodename="sum"')

IMAGE_IN_A_GRAPH = """
  <nodegraph name="{graph}">
    <image name="picture" type="color3"><input name="file" type="filename" value="{file}"/></image>
    <output name="out" type="color3" nodename="picture"/>
  </nodegraph>
"""
TWO_GRAPHS = IMAGE_IN_A_GRAPH.format(graph="g", file="dark.exr") + IMAGE_IN_A_GRAPH.format(graph="h", file="light.exr")
SUM = """
  <multiply name="twice" type="color3">
    <input name="in1" type="color3" nodegraph="g" output="out"/><input name="in2" type="float" value="2"/>
  </multiply>
  <add name="sum" type="color3">
    <input name="in1" type="color3" nodename="twice"/><input name="in2" type="color3" nodegraph="h" output="out"/>
  </add>
"""
NUMBERS = "".join(
    f"""
  <nodegraph name="{graph}">
    <power name="curve" type="color3">
      <input name="in1" type="color3" value="0.2, 0.4, 0.6"/><input name="in2" type="float" value="{exponent}"/>
    </power>
    <output name="out" type="color3" nodename="curve"/>
  </nodegraph>
"""
    for graph, exponent in (("g", 2), ("h", 0.5))
)
# A graph that is shown and takes a value from another one, each with an input of one name.
INTERFACES = """
  <nodegraph name="h">
    <input name="share" type="float" value="0.7"/>
    <multiply name="double" type="float">
      <input name="in1" type="float" interfacename="share"/><input name="in2" type="float" value="2"/>
    </multiply>
    <output name="out" type="float" nodename="double"/>
  </nodegraph>
  <nodegraph name="g">
    <input name="share" type="float" value="0.2"/><input name="other" type="float" nodegraph="h" output="out"/>
    <add name="both" type="float">
      <input name="in1" type="float" interfacename="share"/><input name="in2" type="float" interfacename="other"/>
    </add>
    <output name="out" type="float" nodename="both"/>
  </nodegraph>
"""
# A colour in a graph whose file has the name of that of the graph around it.
NESTED = """
  <nodedef name="ND_decal" node="decal">
    <input name="file" type="filename" value=""/><output name="out" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_decal" nodedef="ND_decal">
    <tiledimage name="picture" type="color3"><input name="file" type="filename" interfacename="file"/></tiledimage>
    <surface_unlit name="shown" type="surfaceshader">
      <input name="emission_color" type="color3" nodename="picture"/>
    </surface_unlit>
    <output name="out" type="surfaceshader" nodename="shown"/>
  </nodegraph>
  <decal name="u" type="surfaceshader">
    <input name="file" type="filename" value="light.exr" colorspace="srgb_texture"/>
  </decal>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="u"/>
  </surfacematerial>
"""
HELD_FILE = """
  <nodegraph name="g">
    <input name="file" type="filename" value="light.exr" colorspace="srgb_texture"/>
    <image name="picture" type="color3"><input name="file" type="filename" interfacename="file"/></image>
    <output name="out" type="color3" nodename="picture"/>
  </nodegraph>
"""
HELD_COLOR = """
  <nodegraph name="g">
    <input name="tint" type="color3" value="0.2, 0.4, 0.6" colorspace="srgb_texture"/>
    <multiply name="half" type="color3">
      <input name="in1" type="color3" interfacename="tint"/><input name="in2" type="float" value="0.5"/>
    </multiply>
    <output name="out" type="color3" nodename="half"/>
  </nodegraph>
"""
TWO_OUTPUTS = """
  <nodedef name="ND_pair" node="pair"><output name="low" type="float"/><output name="high" type="float"/></nodedef>
  <nodegraph name="NG_pair" nodedef="ND_pair">
    <constant name="a" type="float"><input name="value" type="float" value="0.25"/></constant>
    <constant name="b" type="float"><input name="value" type="float" value="0.75"/></constant>
    <output name="high" type="float" nodename="b"/><output name="low" type="float" nodename="a"/>
  </nodegraph>
  <pair name="both" type="multioutput"/>
  <convert name="sum" type="color3"><input name="in" type="float" nodename="both" output="low"/></convert>
"""
NAMES, SPACE = Deviation.SHARED_NAMES, Deviation.INTERFACE_COLOR_SPACE
# A document, what it meets, and a change that has to be seen all the same.
CASES = {
    "images of one name": (TWO_GRAPHS + SUM + NODE, NAMES, ('value="2"', 'value="2.0001"')),
    "numbers of one name": (NUMBERS + SUM + NODE, NAMES, ("0.2, 0.4", "0.2, 0.4001")),
    "interfaces of one name": (INTERFACES, NAMES, ('value="0.2"', 'value="0.2001"')),
    "a file of one name in two graphs": (NESTED, NAMES, ("srgb_texture", "gamma22")),
    "outputs in another order": (TWO_OUTPUTS + NODE, Deviation.OUTPUT_ORDER, ("0.25", "0.2501")),
    "the space of a file": (HELD_FILE + GRAPH, SPACE, ("srgb_texture", "gamma22")),
    "the space of a color": (HELD_COLOR + GRAPH, SPACE, ("srgb_texture", "gamma22")),
    "the space in a graph that is shown": (HELD_COLOR, SPACE, ("0.2, 0.4", "0.2, 0.4001")),
}


@pytest.fixture
def images(tmp_path, write_image):
    """The images of a document: a dark one and a light one."""
    for name, value in (("dark", 0.25), ("light", 0.75)):
        write_image(tmp_path / f"{name}.exr", np.full((2, 4, 3), value))
    return CheckedImages(Reach.only(tmp_path), "")


@pytest.fixture
def checked(gl, make_document, library, images):
    """Function from a document, and another one that is drawn in its place, to the result and the findings."""

    def check(text, drawn=""):
        documents = make_document(text), make_document(drawn or text)
        true, shown = (renderable_elements(d)[-1] for d in documents)
        expectation = Expectation(true, generator(0, "mends"), 256, images)
        shader = generate(shown, "glsl", library)
        mended = partial(mended_shaders, shown, library)
        return check_draws(ENGINE, shader, images, {"": (expectation, {})}, "", mended)[""]

    return check


# Before 1.39.5, generators end the process of a definition whose outputs are in another order.
ENDING = {"outputs in another order": since("1.39.5", "code for outputs in another order")}
SURVIVED = [pytest.param(name, marks=ENDING.get(name, ())) for name in CASES]


@pytest.mark.parametrize("name", SURVIVED)
def test_what_the_document_spares_is_told_by_name(checked, name):
    text, deviation, _ = CASES[name]
    result, findings = checked(text)
    assert result.status == "pass"
    assert [f.code for f in findings] == ["UPSTREAM_DEVIATION"]
    assert f"({deviation.value})" in findings[0].message


@pytest.mark.parametrize("name", SURVIVED)
def test_another_error_is_none_that_the_document_spares(checked, name):
    text, _, change = CASES[name]
    result, findings = checked(text, text.replace(*change))
    assert result.status == "fail"
    assert [f.code for f in findings] == ["SHADER_DIFFERS"]


@pytest.mark.parametrize("name", CASES)
def test_a_mended_document_means_the_same(make_document, name):
    before, document = (make_document(CASES[name][0]) for _ in range(2))
    for mend in MENDS.values():
        mend(document)
        assert document.validate() == before.validate()
        paths = ([e.getNamePath() for e in renderable_elements(d)] for d in (document, before))
        assert len(set(map(tuple, paths))) == 1


def test_the_data_library_stays_as_it_is(make_document, library):
    before = mx.writeToXmlString(library.document)
    document = make_document(NESTED + TWO_GRAPHS + HELD_COLOR.replace('"g"', '"k"'))
    for mend in MENDS.values():
        mend(document)
    assert mx.writeToXmlString(library.document) == before


SAME_NAMES_ELSEWHERE = TWO_GRAPHS.replace('name="picture"', 'name="other"', 1).replace(
    'nodename="picture"', 'nodename="other"', 1
)


def test_names_of_their_own_are_no_deviation(checked):
    result, findings = checked(SAME_NAMES_ELSEWHERE + SUM + NODE)
    assert (result.status, findings) == ("pass", [])


def test_a_document_with_nothing_to_mend_is_not_drawn_again(make_document, library):
    document = make_document('<noise2d name="n" type="float"/><output name="o" type="float" nodename="n"/>')
    element = document.getOutput("o")
    assert list(mended_shaders(element, library, generate(element, "glsl", library))) == []


def test_a_deviation_of_the_source_is_mended_in_a_mended_document_too(make_document, library):
    document = make_document(TWO_GRAPHS + SUM + NODE)
    (element,) = renderable_elements(document)
    tried = [names for names, _ in mended_shaders(element, library, generate(element, "essl", library))]
    stated = {Deviation.MEDIUMP_FLOATS} & versions.installed().deviations
    assert {NAMES, Deviation.LOWP_SAMPLERS, *stated} in tried
