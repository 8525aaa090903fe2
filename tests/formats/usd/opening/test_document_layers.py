"""Documents of MaterialX that stages refer to: their materials are read as UsdMtlx gives them, and checked."""

from __future__ import annotations

import zipfile

import pytest
from pxr import Sdf

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request

DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39" {attributes}>
  {more}
  <nodegraph name="NG">
    <image name="im" type="color3">
      <input name="file" type="filename" value="tex/a.png" colorspace="srgb_texture" />
    </image>
    <output name="out" type="color3" nodename="im" />
  </nodegraph>
  <standard_surface name="ss" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="out" />
    <input name="coat" type="float" value="0.25" />
    <input name="specular_color" type="color3" value="1, 0.5, 0.25" />
  </standard_surface>
  <surfacematerial name="Red" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="ss" />
  </surfacematerial>
</materialx>
"""
BOUND = """
def Scope "Looks" (
    references = @./mats/m.mtlx@</MaterialX/Materials>
)
{{
    {over}
}}
def Xform "M"
{{
    def Mesh "ball" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        rel material:binding = </Looks/Red>
    }}
}}
"""


@pytest.fixture
def document(tmp_path):
    """Function from what is special to the document that stages refer to."""

    def make(more="", attributes="", text=DOCUMENT):
        (tmp_path / "mats" / "tex").mkdir(parents=True, exist_ok=True)
        (tmp_path / "mats" / "tex" / "a.png").write_bytes(b"picture")
        path = tmp_path / "mats" / "m.mtlx"
        path.write_text(text.format(more=more, attributes=attributes), encoding="utf-8")
        return path

    return make


def test_the_materials_of_a_document_are_those_of_the_stage(document, stage_of):
    document()
    read = stage_of(BOUND.format(over=""))
    assert read.findings == []  # also of the binding
    assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == ["/Looks/Red"]
    assert read.materialx.validate() == (True, "")
    node = read.materialx.getNode("ss")
    assert node.getInput("coat").getValue() == 0.25
    assert node.getInput("base_color").getNodeGraphString() == "NG"
    image = read.materialx.getNodeGraph("NG").getNode("im").getInput("file")
    assert (image.getValueString(), image.getColorSpace()) == ("mats/tex/a.png", "srgb_texture")


def test_values_that_a_stage_puts_over_a_document_count(document, stage_of):
    """UsdMtlx gives a material the inputs of its shader; whoever changes a look in a stage changes these."""
    document()
    read = stage_of(BOUND.format(over='over "Red"\n{\nfloat inputs:coat = 0.75\nfloat inputs:metalness = 1\n}\n'))
    node = read.materialx.getNode("ss")
    assert node.getInput("coat").getValue() == 0.75
    assert node.getInput("metalness").getValue() == 1.0
    assert node.getInput("sheen") is None


def test_a_colour_space_of_the_document_is_said_of_its_values(document, stage_of):
    document(attributes='colorspace="acescg"')
    read = stage_of(BOUND.format(over=""))
    node = read.materialx.getNode("ss")
    assert node.getInput("specular_color").getColorSpace() == "acescg"
    assert read.materialx.getNodeGraph("NG").getNode("im").getInput("file").getColorSpace() == "srgb_texture"


@pytest.mark.parametrize(
    "arc",
    ["references = @./mats/m.mtlx@</MaterialX/Materials/Red>", "payload = @./mats/m.mtlx@</MaterialX/Materials/Red>"],
)
def test_a_document_may_be_named_in_every_way(document, stage_of, usda, arc):
    document()
    read = stage_of(f'def "X" (\n {arc}\n) {{\n}}\n')
    assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == ["/X"]
    read = stage_of(usda("", head="#usda 1.0\n(\n subLayers = [@mats/m.mtlx@]\n)\n"))
    assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == [
        "/MaterialX/Materials/Red"
    ]


def test_a_document_in_a_package_is_read(document, stage_of, tmp_path):
    text = document().read_text(encoding="utf-8")
    with zipfile.ZipFile(tmp_path / "p.usdz", "w") as package:
        package.writestr("s.usda", '#usda 1.0\ndef "X" (\n references = @m.mtlx@</MaterialX/Materials/Red>\n) {\n}\n')
        package.writestr("m.mtlx", text)
        package.writestr("tex/a.png", b"picture")
    read = stage_of(tmp_path / "p.usdz")
    image = read.materialx.getNodeGraph("NG").getNode("im").getInput("file").getValueString()
    assert image == "tex/a.png"


def test_what_lies_beside_the_materials_is_named(document, stage_of):
    document()
    (finding,) = stage_of('def "M" (\n references = @./mats/m.mtlx@</MaterialX/Looks>\n) {\n}\n').findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LOST", "/M")
    assert "of 'm.mtlx', /MaterialX/Looks is not read" in finding.message


WRONG = {
    "no XML": ("<materialx", "line 1"),
    "an unknown node": (DOCUMENT.replace("standard_surface", "standard_surfce"), ""),
    "an include outside": (DOCUMENT.replace("{more}", '<xi:include href="../../x.mtlx" />'), "outside the folder"),
    "an endless definition": (DOCUMENT.replace('nodegraph="NG" output="out"', 'nodename="gone"'), ""),
}


@pytest.mark.parametrize("case", WRONG.values(), ids=WRONG.keys())
def test_a_document_that_is_wrong_is_told_without_errors_that_come_from_its_absence(document, usda, case):
    text, message = case
    document(text=text)
    other = (
        'def Material "N" {\n token outputs:mtlx:surface.connect = </N/s.outputs:out>\n def Shader "s" {\n'
        ' uniform token info:id = "ND_surface"\n token outputs:out\n }\n}\n'
    )
    path = usda(BOUND.format(over="") + other)
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    (found,) = [finding for finding in result.findings if finding.severity == "error"]
    assert (found.code, found.location) == ("USD_MISSING", "/Looks")
    assert "the document './mats/m.mtlx' is wrong: " in found.message
    assert message in found.message
    assert [renderable.name for renderable in result.renderables] == ["/N"]


def test_a_document_that_is_a_pipe_is_told(stage_of, tmp_path):
    import os

    if not hasattr(os, "mkfifo"):
        pytest.skip("there are no pipes")
    (tmp_path / "mats").mkdir()
    os.mkfifo(tmp_path / "mats" / "m.mtlx")
    findings = stage_of(BOUND.format(over="")).findings
    assert [(finding.code, finding.location) for finding in findings] == [("USD_MISSING", "/Looks")]


def test_a_document_outside_is_refused(usda, stage_of, tmp_path):
    from mrm_mtlx.documents.document import ReadError

    (tmp_path / "m.mtlx").write_text(DOCUMENT.format(more="", attributes=""))
    (tmp_path / "in").mkdir()
    path = tmp_path / "in" / "s.usda"
    Sdf.Layer.CreateNew(str(path)).Save()
    path.write_text('#usda 1.0\ndef "X" (\n references = @../m.mtlx@</MaterialX>\n) {\n}\n')
    with pytest.raises(ReadError) as caught:
        stage_of(path)
    assert caught.value.finding.code == "READ_OUTSIDE"
