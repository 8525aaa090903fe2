"""What comes through the interface of a graph, as generators have it: colour spaces, and numbers passed over."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.samples import compare, draw
from mrm_mtlx.validation.comparison.sampling import generator, sample_local, shading_points

MATERIAL = """
  <surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" {connection}/>
  </surfacematerial>
"""
OF_A_GRAPH = MATERIAL.format(connection='nodegraph="g" output="out"')
OF_A_NODE = MATERIAL.format(connection='nodename="n"')

# A normal that a graph holds, and what else it may hold.
DIFFUSE = """
    <oren_nayar_diffuse_bsdf name="b" type="BSDF"><input name="normal" type="vector3" interfacename="up"/>
    </oren_nayar_diffuse_bsdf>
    <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>
    <output name="out" type="surfaceshader" nodename="s"/>
"""
NORMAL = f"""
  <nodegraph name="g">
    <input name="up" type="vector3" value="0.6, 0, 0.8"/>{DIFFUSE}
  </nodegraph>
"""
TANGENT = NORMAL.replace('value="0.6, 0, 0.8"', 'value="0.6, 0, 0.8" defaultgeomprop="Tworld"')
OF_A_DEFINITION = f"""
  <nodedef name="ND_n" node="tilted">
    <input name="up" type="vector3" value="0, 1, 0"/><output name="out" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_n" nodedef="ND_n">{DIFFUSE}
  </nodegraph>
  <tilted name="n" type="surfaceshader"><input name="up" type="vector3" value="0.6, 0, 0.8"/></tilted>
"""

UNLIT = """
    <surface_unlit name="s" type="surfaceshader"><input name="emission_color" type="color3" nodename="c"/>
    </surface_unlit>
    <output name="out" type="surfaceshader" nodename="s"/>
"""
# A colour whose space is said where it is read.
COLOR = f"""
  <nodegraph name="g">
    <input name="tint" type="color3" value="0.2, 0.4, 0.6"/>
    <multiply name="c" type="color3">
      <input name="in1" type="color3" interfacename="tint" colorspace="gamma22"/>
      <input name="in2" type="float" value="0.5"/>
    </multiply>{UNLIT}
  </nodegraph>
"""
# A file given to a node that is no colour itself, and reads it as colours inside.
DECAL = """
  <nodedef name="ND_decal" node="decal">
    <input name="picture" type="filename" value=""/><output name="out" type="{kind}"/>
  </nodedef>
  <nodegraph name="NG_decal" nodedef="ND_decal">
    <image name="c" type="color3"><input name="file" type="filename" interfacename="picture"/></image>{shown}
  </nodegraph>
  <decal name="n" type="{kind}">
    <input name="picture" type="filename" value="a.exr" colorspace="srgb_texture"/>
  </decal>
"""
FILE = DECAL.format(kind="surfaceshader", shown=UNLIT)
VECTOR = DECAL.format(
    kind="vector3",
    shown='<convert name="v" type="vector3"><input name="in" type="color3" nodename="c"/></convert>'
    '<output name="out" type="vector3" nodename="v"/>',
)
# Through two definitions: the inner one is of colours, and transforms what it gives.
TWICE = """
  <nodedef name="ND_tile" node="tile">
    <input name="texture" type="filename" value=""/><output name="out" type="color3"/>
  </nodedef>
  <nodegraph name="NG_tile" nodedef="ND_tile">
    <image name="i" type="color3"><input name="file" type="filename" interfacename="texture"/></image>
    <output name="out" type="color3" nodename="i"/>
  </nodegraph>
""" + FILE.replace("<image ", "<tile ").replace("</image>", "</tile>").replace('name="file"', 'name="texture"')

CASES = {
    "a number for a normal, in a graph of the document": (NORMAL + OF_A_GRAPH, "m"),
    "a number for a normal, in the graph that is shown": (NORMAL, "g/out"),
    "a geometric default of the graph's own": (TANGENT + OF_A_GRAPH, "m"),
    "a number for a normal, in a definition": (OF_A_DEFINITION + OF_A_NODE, "m"),
    "a color": (COLOR + OF_A_GRAPH, "m"),
    "a file": (FILE + OF_A_NODE, "m"),
    "a file of a vector": (VECTOR + '<output name="o" type="vector3" nodename="n"/>', "o"),
    "a file through two definitions": (TWICE + OF_A_NODE, "m"),
}
PIXELS = np.linspace(0.1, 0.9, 4 * 4 * 3, dtype=np.float32).reshape(4, 4, 3)


@pytest.mark.parametrize("name", CASES)
def test_what_comes_through_an_interface_is_as_generated(gl, make_document, library, name):
    text, path = CASES[name]
    document, rng = make_document(text), generator(0, "interfaces")
    element, points = document.getDescendant(path), shading_points(rng, *sample_local(rng, 256))
    tolerance = Surface(element, images=lambda _name: PIXELS).tolerance(points)
    shader = generate(element, "glsl", library)
    textures = {port.variable: PIXELS for port in shader.uniforms if port.type == "filename"}
    with SurfaceProgram(shader, textures) as program:
        assert compare(draw(program, points).colors, tolerance, points).passed


# What would be seen: the number that counts in one place and not in the other, and each colour space.
WRONG = {
    "the number counts": (NORMAL + OF_A_GRAPH, "m", NORMAL, "g/out"),
    "the number is passed over": (NORMAL, "g/out", NORMAL + OF_A_GRAPH, "m"),
    "another space of a color": (COLOR + OF_A_GRAPH, "m", COLOR.replace("gamma22", "srgb_texture") + OF_A_GRAPH, "m"),
    "another space of a file": (FILE + OF_A_NODE, "m", FILE.replace("srgb_texture", "gamma22") + OF_A_NODE, "m"),
}


@pytest.mark.parametrize("name", WRONG)
def test_the_wrong_one_is_seen(gl, make_document, library, name):
    text, path, other, other_path = WRONG[name]
    document, shown, rng = make_document(text), make_document(other), generator(0, "interfaces")
    points = shading_points(rng, *sample_local(rng, 256))
    tolerance = Surface(document.getDescendant(path), images=lambda _name: PIXELS).tolerance(points)
    shader = generate(shown.getDescendant(other_path), "glsl", library)
    textures = {port.variable: PIXELS for port in shader.uniforms if port.type == "filename"}
    with SurfaceProgram(shader, textures) as program:
        assert not compare(draw(program, points).colors, tolerance, points).passed
