"""What a renderable element shows: which node of the document, and which of its outputs."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.samples import compare, draw
from mrm_mtlx.validation.comparison.sampling import generator, sample_local, shading_points

TWO_SHADERS = """
  <nodedef name="ND_two" node="two">
    <output name="first" type="surfaceshader"/><output name="second" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_two" nodedef="ND_two">
    <surface_unlit name="red" type="surfaceshader">
      <input name="emission_color" type="color3" value="0.9, 0.2, 0.1"/>
    </surface_unlit>
    <surface_unlit name="green" type="surfaceshader">
      <input name="emission_color" type="color3" value="0.1, 0.8, 0.3"/>
    </surface_unlit>
    <output name="first" type="surfaceshader" nodename="red"/>
    <output name="second" type="surfaceshader" nodename="green"/>
  </nodegraph>
"""
PLAIN = '<two name="t" type="multioutput"/>'
# As MaterialX writes nodes of several outputs: with the outputs as children.
WRITTEN_OUT = """
  <two name="t" type="multioutput">
    <output name="first" type="surfaceshader"/><output name="second" type="surfaceshader"/>
  </two>
"""
MATERIAL = """
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" {connection}/>
  </surfacematerial>
"""
ONE = MATERIAL.format(connection='nodename="t" output="second"')
THROUGH_A_GRAPH = (
    '<nodegraph name="g">{node}<output name="o" type="surfaceshader" nodename="t" output="second"/></nodegraph>'
)


@pytest.mark.parametrize(
    ("text", "path"),
    [
        (PLAIN + ONE, "m"),
        (WRITTEN_OUT + ONE, "m"),
        (PLAIN + '<output name="o" type="surfaceshader" nodename="t" output="second"/>', "o"),
        (THROUGH_A_GRAPH.format(node=PLAIN) + MATERIAL.format(connection='nodegraph="g" output="o"'), "m"),
        (THROUGH_A_GRAPH.format(node=WRITTEN_OUT) + MATERIAL.format(connection='nodegraph="g" output="o"'), "m"),
        (THROUGH_A_GRAPH.format(node=PLAIN), "g/o"),
    ],
)
def test_the_output_that_is_named_is_shown(gl, make_document, library, text, path):
    document = make_document(TWO_SHADERS + text)
    element, rng = document.getDescendant(path), generator(0, "shown")
    points = shading_points(rng, *sample_local(rng, 64))
    tolerance = Surface(element).tolerance(points)
    with SurfaceProgram(generate(element, "glsl", library)) as program:
        found = draw(program, points).colors
    assert np.allclose(found[0, :3], [0.1, 0.8, 0.3])
    assert compare(found, tolerance, points).passed
