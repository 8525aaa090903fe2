"""A renderable element as a network of USD, for hosts that generate their shaders themselves."""

from __future__ import annotations

import pytest
from pxr import Usd, UsdShade

from mrm_mtlx.shadergen import HOST_TARGETS, MissingCodeError, generate, suffixes_of

LOBE = (
    '<image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>'
    '<generalized_schlick_bsdf name="bsdf" type="BSDF"><input name="color0" type="color3" nodename="i"/>'
    '<input name="retroreflective" type="boolean" value="true"/></generalized_schlick_bsdf>'
)


@pytest.fixture
def shader(surface_document, library):
    document = surface_document(LOBE)
    return generate(document.getNode("m"), "storm", library)


def opened(shader, tmp_path):
    path = tmp_path / "m.usda"
    path.write_text(shader.sources["pixel"], encoding="utf-8")
    return Usd.Stage.Open(str(path))


def test_the_source_is_a_layer_whose_default_prim_holds_the_material(shader, tmp_path):
    stage = opened(shader, tmp_path)
    (material,) = stage.GetDefaultPrim().GetChildren()
    assert material.GetName() == shader.name == "m"
    assert UsdShade.Material(material).GetOutput("mtlx:surface").HasConnectedSource()
    assert suffixes_of("storm") == HOST_TARGETS["storm"].suffixes == {"pixel": ".usda"}


def test_uniforms_are_what_is_not_connected_by_the_path_of_the_attribute(shader, tmp_path):
    ports = {port.path: port for port in shader.uniforms}
    assert "bsdf/color0" not in ports
    assert ports["bsdf/retroreflective"].value is True
    assert ports["bsdf/exponent"].value == 5.0  # what the definition says
    stage = opened(shader, tmp_path)
    assert stage.GetAttributeAtPath(ports["bsdf/retroreflective"].variable).Get() is True
    assert shader.files == {ports["i/file"].variable: "a.png"}


def test_a_definition_in_source_code_has_no_form(make_document, library):
    document = make_document(
        '<nodedef name="ND_own" node="own"><output name="out" type="color3"/></nodedef>'
        '<implementation name="IM_own" nodedef="ND_own" target="genglsl" sourcecode="vec3(1.0)"/>'
        '<own name="o" type="color3"/>'
        '<oren_nayar_diffuse_bsdf name="b" type="BSDF"><input name="color" type="color3" nodename="o"/>'
        "</oren_nayar_diffuse_bsdf>"
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>'
        '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>'
        "</surfacematerial>"
    )
    with pytest.raises(MissingCodeError, match="the node's definition in source code stays behind"):
        generate(document.getNode("m"), "storm", library)


def test_an_output_of_numbers_is_no_material(make_document, library):
    document = make_document('<constant name="c" type="float"/><output name="o" type="float" nodename="c"/>')
    with pytest.raises(MissingCodeError, match="it is no shader"):
        generate(document.getOutput("o"), "storm", library)
