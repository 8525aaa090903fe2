"""Each known deviation of MaterialX, in a small document: the shader deviates, and the reference can likewise."""

from __future__ import annotations

import pytest

from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.versions.combination import SPECIFIED
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.sampling import generator
from tests.fixtures.versions import deviating

LAYERED = """
  <nodedef name="ND_flaky" node="flaky">
    <input name="amount" type="float" value="0.5"/><output name="out" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_flaky" nodedef="ND_flaky">
    <conductor_bsdf name="metal" type="BSDF"/>
    <dielectric_bsdf name="glass" type="BSDF"/>
    <mix name="flakes" type="BSDF">
      <input name="fg" type="BSDF" nodename="metal"/><input name="bg" type="BSDF" nodename="glass"/>
      <input name="mix" type="float" interfacename="amount"/>
    </mix>
    <oren_nayar_diffuse_bsdf name="paint" type="BSDF"/>
    <layer name="both" type="BSDF">
      <input name="top" type="BSDF" nodename="flakes"/><input name="base" type="BSDF" nodename="paint"/>
    </layer>
    <surface name="shown" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="both"/></surface>
    <output name="out" type="surfaceshader" nodename="shown"/>
  </nodegraph>
  <flaky name="flakes" type="surfaceshader"/>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="flakes"/>
  </surfacematerial>
"""
# Opaque lobes alone, which lose no throughput, mixed by more than all.
BEYOND = """
  <nodegraph name="g">
    <input name="amount" type="float" value="1.5"/>
    <oren_nayar_diffuse_bsdf name="fg" type="BSDF"><input name="color" type="color3" value="0.8, 0.4, 0.2"/>
    </oren_nayar_diffuse_bsdf>
    <burley_diffuse_bsdf name="bg" type="BSDF"/>
    <mix name="mixed" type="BSDF">
      <input name="fg" type="BSDF" nodename="fg"/><input name="bg" type="BSDF" nodename="bg"/>
      <input name="mix" type="float" nodename="share"/>
    </mix>
    <clamp name="share" type="float">
      <input name="in" type="float" interfacename="amount"/><input name="high" type="float" value="2"/>
    </clamp>
    <surface name="shown" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="mixed"/></surface>
    <output name="out" type="surfaceshader" nodename="shown"/>
  </nodegraph>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodegraph="g" output="out"/>
  </surfacematerial>
"""
# The seventh decimal of a small number is a large share of it.
SMALL = """
  <nodedef name="ND_small" node="small"><output name="out" type="float"/></nodedef>
  <nodegraph name="NG_small" nodedef="ND_small">
    <divide name="d" type="float">
      <input name="in1" type="float" value="0.00012345678"/><input name="in2" type="float" value="0.0002"/>
    </divide>
    <output name="out" type="float" nodename="d"/>
  </nodegraph>
  <small name="share" type="float"/>
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">
    <input name="weight" type="float" nodename="share"/>
  </oren_nayar_diffuse_bsdf>
  SURFACE
"""
SURFACE = """
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
"""
# Those of the installed MaterialX.
DEVIATIONS = versions.installed().deviations
if versions.installed().throughputs.added == SPECIFIED.added:
    DEVIATIONS -= {Deviation.COMBINED_THROUGHPUT}  # over media alone, which are ignored besides

PAINT = """
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" type="float" nodename="{}"/>
  </oren_nayar_diffuse_bsdf>"""
PAINT += SURFACE
DOCUMENTS = {
    Deviation.PREMULTIPLIED_MIX: LAYERED,
    Deviation.SIX_DECIMALS: SMALL.replace("SURFACE", SURFACE),
    Deviation.UNMIXED_ZERO: (
        '<burn name="b" type="color3"><input name="fg" type="color3" value="0, 0.5, 0.5"/>'
        '<input name="bg" type="color3" value="0.8, 0.8, 0.8"/><input name="mix" type="float" value="0.25"/></burn>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="b"/>'
        "</oren_nayar_diffuse_bsdf>" + SURFACE
    ),
    Deviation.HAIR_CONSTANTS: '<chiang_hair_bsdf name="bsdf" type="BSDF"/>' + SURFACE,
    Deviation.BLACK_MATERIALS: """
  <nodedef name="ND_paint" node="paint">
    <input name="color" type="color3" value="0.1, 0.2, 0.3"/><output name="out" type="material"/>
  </nodedef>
  <nodegraph name="NG_paint" nodedef="ND_paint">
    <surface_unlit name="shown" type="surfaceshader">
      <input name="emission_color" type="color3" interfacename="color"/>
    </surface_unlit>
    <surfacematerial name="inner" type="material">
      <input name="surfaceshader" type="surfaceshader" nodename="shown"/>
    </surfacematerial>
    <output name="out" type="material" nodename="inner"/>
  </nodegraph>
  <paint name="m" type="material"><input name="color" type="color3" value="0.4, 0.5, 0.6"/></paint>
""",
    Deviation.COMBINED_THROUGHPUT: """
  <dielectric_bsdf name="core" type="BSDF"/>
  <dielectric_bsdf name="skirt" type="BSDF"><input name="roughness" type="vector2" value="0.3, 0.3"/></dielectric_bsdf>
  <multiply name="half" type="BSDF">
    <input name="in1" type="BSDF" nodename="skirt"/><input name="in2" type="float" value="0.5"/>
  </multiply>
  <add name="both" type="BSDF">
    <input name="in1" type="BSDF" nodename="core"/><input name="in2" type="BSDF" nodename="half"/>
  </add>
  <conductor_bsdf name="metal" type="BSDF"/>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="both"/><input name="base" type="BSDF" nodename="metal"/>
  </layer>"""
    + SURFACE,
    Deviation.IGNORED_MEDIA: """
  <dielectric_bsdf name="glass" type="BSDF"><input name="scatter_mode" type="string" value="T"/></dielectric_bsdf>
  <anisotropic_vdf name="dye" type="VDF"><input name="absorption" type="vector3" value="1, 0.5, 0"/></anisotropic_vdf>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="glass"/><input name="base" type="VDF" nodename="dye"/>
  </layer>"""
    + SURFACE,
    Deviation.VERTICAL_RAMPS: """
  <ramptb name="grey" type="float"><input name="valuet" type="float" value="0.9"/></ramptb>
  <splittb name="half" type="float">
    <input name="valuet" type="float" value="0.9"/><input name="valueb" type="float" nodename="grey"/>
    <input name="center" type="float" value="0.7"/>
  </splittb>"""
    + PAINT.format("half"),
    Deviation.HSV_ALPHA: """
  <rgbtohsv name="turned" type="color4"><input name="in" type="color4" value="0.2, 0.4, 0.6, 0.5"/></rgbtohsv>
  <hsvtorgb name="back" type="color4"><input name="in" type="color4" nodename="turned"/></hsvtorgb>
  <extract name="alpha" type="float">
    <input name="in" type="color4" nodename="back"/><input name="index" type="integer" value="3"/>
  </extract>"""
    + PAINT.format("alpha"),
    Deviation.MATRIX_PRODUCTS: """
  <multiply name="both" type="matrix33">
    <input name="in1" type="matrix33" value="0,1,0, 1,0,0, 0,0,1"/>
    <input name="in2" type="matrix33" value="1,0,0, 0,0,1, 0,1,0"/>
  </multiply>
  <transformmatrix name="moved" type="vector3">
    <input name="in" type="vector3" value="0.2, 0.4, 0.8"/><input name="mat" type="matrix33" nodename="both"/>
  </transformmatrix>
  <extract name="x" type="float"><input name="in" type="vector3" nodename="moved"/></extract>"""
    + PAINT.format("x"),
    Deviation.DEFAULT_COLORS: '<LamaConductor name="bsdf" type="BSDF"/>' + SURFACE,
}


def verdict(document, library, target="glsl"):
    element = document.getNode("m")
    expectation = Expectation(element, generator(0, "deviation"), 512, lambda _name: None)
    with SurfaceProgram(generate(element, target, library)) as program:
        return expectation.compare(expectation.draw(program))


@pytest.mark.parametrize("deviation", sorted(DOCUMENTS.keys() & DEVIATIONS, key=str))
def test_a_shader_that_deviates_as_known_is_told_by_name(gl, make_document, library, deviation):
    found = verdict(make_document(DOCUMENTS[deviation]), library)
    assert found.deviations == {deviation}
    assert found.comparison.passed
    assert found.specified is not None
    assert not found.specified.passed
    assert found.specified.excess > 100.0
    assert found.specified.max_error > 100.0 * found.comparison.max_error


@pytest.mark.parametrize("deviation", sorted(DOCUMENTS.keys() - DEVIATIONS, key=str))
def test_a_version_without_a_deviation_is_as_specified(gl, make_document, library, deviation):
    found = verdict(make_document(DOCUMENTS[deviation]), library)
    assert (found.comparison.passed, found.deviations, found.specified) == (True, frozenset(), None)


@deviating(Deviation.BLACK_MATERIALS)
def test_a_deviation_that_explains_nothing_is_not_named(gl, make_document, library):
    # The colour loses its seventh decimal, and all the same the material is black.
    lit = DOCUMENTS[Deviation.BLACK_MATERIALS].replace(
        'interfacename="color"/>', 'nodename="scaled"/>'
    ).replace(
        "<surface_unlit",
        '<multiply name="scaled" type="color3"><input name="in1" type="color3" interfacename="color"/>'
        '<input name="in2" type="float" value="0.00012345678"/></multiply><surface_unlit',
    )  # fmt: skip
    found = verdict(make_document(lit), library)
    assert found.comparison.passed
    assert found.deviations == {Deviation.BLACK_MATERIALS}


@deviating(Deviation.PREMULTIPLIED_MIX)
@pytest.mark.parametrize(("drawn", "is_known"), [("1.5", True), ("1.5001", False)])
def test_a_mixture_by_more_than_1_clamps_each_part(gl, make_document, library, drawn, is_known):
    document, shown = make_document(BEYOND), make_document(BEYOND.replace('value="1.5"', f'value="{drawn}"'))
    expectation = Expectation(document.getNode("m"), generator(0, "beyond"), 512, lambda _name: None)
    with SurfaceProgram(generate(shown.getNode("m"), "glsl", library)) as program:
        found = expectation.compare(expectation.draw(program))
    assert found.comparison.passed is is_known
    assert found.deviations == ({Deviation.PREMULTIPLIED_MIX} if is_known else set())


def test_another_error_is_no_known_deviation(gl, make_document, library):
    text = DOCUMENTS[Deviation.SIX_DECIMALS]
    true, wrong = make_document(text), make_document(text.replace('value="0.0002"', 'value="0.000201"'))
    expectation = Expectation(true.getNode("m"), generator(0, "deviation"), 512, lambda _name: None)
    with SurfaceProgram(generate(wrong.getNode("m"), "glsl", library)) as program:
        found = expectation.compare(expectation.draw(program))
    assert not found.comparison.passed
    assert found.deviations == frozenset()


# Black where the texture coordinate is beyond its edge, in a fraction of the samples.
RARE = """
  <texcoord name="uv" type="vector2"/>
  <extract name="u" type="float"><input name="in" type="vector2" nodename="uv"/></extract>
  <ifgreater name="fg" type="float">
    <input name="value1" type="float" nodename="u"/><input name="value2" type="float" value="1.9"/>
    <input name="in1" type="float" value="0"/><input name="in2" type="float" value="0.5"/>
  </ifgreater>
  <burn name="b" type="float">
    <input name="fg" type="float" nodename="fg"/><input name="bg" type="float" value="0.8"/>
    <input name="mix" type="float" value="0.25"/>
  </burn>
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" type="float" nodename="b"/>
  </oren_nayar_diffuse_bsdf>
"""


def test_a_deviation_that_few_samples_show_is_found(gl, make_document, library):
    found = verdict(make_document(RARE + SURFACE), library)
    assert found.deviations == {Deviation.UNMIXED_ZERO}
    assert found.comparison.passed


def test_a_mixture_by_a_number_is_as_specified(gl, surface_document, library):
    inner = LAYERED[LAYERED.index("<conductor_bsdf") : LAYERED.index('<surface name="shown"')]
    found = verdict(
        surface_document(inner.replace('name="both"', 'name="bsdf"').replace('interfacename="amount"', 'value="0.5"')),
        library,
    )
    assert found.comparison.passed
    assert found.specified is None
