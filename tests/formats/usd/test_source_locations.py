"""What is said of a stage has the layer that says it, and the path of the prim or property."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf, UsdUtils

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.reading import read_document

ROOT = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Y"
    subLayers = [@./parts/over.usda@]
)
def Xform "World" {
    def "Looks" (
        references = @./parts/looks.usda@</Source>
    ) {
    }
}
"""
OVER = """#usda 1.0
over "World" {
    over "Looks" {
        over "M" {
            over "s" {
                float inputs:metalness.timeSamples = { 0: 0.5 }
            }
        }
    }
}
"""
LOOKS = """#usda 1.0
def "Source" (
    variantSets = "paint"
    variants = { string paint = "red" }
) {
    def Material "M" {
        token outputs:mtlx:surface.connect = </Source/M/s.outputs:out>
        def Shader "s" {
            uniform token info:id = "ND_standard_surface_surfaceshader"
            float inputs:base = 0.25
            float inputs:metalness = 0.25
            float inputs:unknown = 1
            token outputs:out
        }
    }
    variantSet "paint" = {
        "red" {
        }
        "blue" {
            over "M" {
                over "s" {
                    float inputs:blue_is_unknown = 1
                }
            }
        }
    }
}
"""


@pytest.fixture
def read(tmp_path, monkeypatch, library):
    """Function that writes files below the current folder, and reads the first of them."""
    monkeypatch.chdir(tmp_path)

    def reading(files: dict[str, str]):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(exist_ok=True, parents=True)
            if text:
                path.write_text(text, encoding="utf-8")
        path = Path(next(iter(files)))
        scratch = tmp_path.parent / f"{tmp_path.name} scratch"
        scratch.mkdir(exist_ok=True)
        return read_document(path, Reach.beside(path), library, scratch)

    return reading


def layered(root: str = ROOT, over: str = OVER, looks: str = LOOKS) -> dict[str, str]:
    return {"scene/root.usda": root, "scene/parts/over.usda": over, "scene/parts/looks.usda": looks}


def source(name: str, prim: str) -> SourceLocation:
    return SourceLocation(f"scene/{name}", layer=f"scene/{name}", prim=prim)


def test_each_thing_is_in_the_strongest_layer_that_says_it(read):
    document = read(layered())
    shader = "/World/Looks/M/s"
    found = {one.location: one.source for one in document.findings if one.code.startswith(("DOC", "INTERCHANGE"))}
    changed = "/World/Looks{paint=blue}M/s.inputs:blue_is_unknown"
    assert found == {
        f"{shader}.inputs:unknown": source("parts/looks.usda", f"{shader}.inputs:unknown"),
        f"{shader}.inputs:metalness": source("parts/over.usda", f"{shader}.inputs:metalness"),
        "/World/Looks{paint=blue}M/s.inputs:metalness": source(
            "parts/over.usda", "/World/Looks{paint=blue}M/s.inputs:metalness"
        ),
        "/World/Looks{paint=blue}M/s.inputs:unknown": source(
            "parts/looks.usda", "/World/Looks{paint=blue}M/s.inputs:unknown"
        ),
        changed: source("parts/looks.usda", changed),
    }


def test_findings_of_the_document_that_is_made_of_it_are_in_the_layer_too(read):
    document = read(layered())
    found = document.in_source(rules.DOC_VALUE_RANGE.at("/s/base", "too large"))
    assert found.location == "/World/Looks/M/s.inputs:base"
    assert found.source == source("parts/looks.usda", found.location)
    assert document.in_source(rules.DOC_VALUE_RANGE.at("/s/absent", "gone")).source == source(
        "parts/over.usda", "/World/Looks/M/s"
    )
    assert document.in_source(rules.DOC_INVALID.at("", "all of it")).source == SourceLocation("scene/root.usda")


def test_what_a_layer_names_and_is_not_there_is_told_of_that_layer(read):
    looks = LOOKS.replace('def "Source" (', 'def "Gone" (\n    references = @./absent.usda@\n) {\n}\ndef "Source" (', 1)
    over = OVER.replace("#usda 1.0\n", "#usda 1.0\n(\n    subLayers = [@./nowhere.usda@]\n)\n")
    found = {one.source for one in read(layered(over=over, looks=looks)).findings if one.code == "USD_MISSING"}
    assert source("parts/looks.usda", "/Gone") in found
    assert source("parts/over.usda", "") in found


def test_a_file_that_cannot_be_had_is_told_of_the_layer_that_names_it(read):
    with pytest.raises(ReadError) as raised:
        read(layered(looks=LOOKS.replace('def "Source" (', 'def "Source" (\n references = @../../out.usda@\n')))
    assert raised.value.finding.code == "READ_OUTSIDE"
    assert raised.value.finding.source == source("parts/looks.usda", "/Source")
    with pytest.raises(ReadError) as raised:
        read(layered(over="no USD"))
    assert raised.value.finding.source == source("root.usda", "")
    with pytest.raises(ReadError) as raised:
        read({"scene/root.usda": "no USD"})
    assert raised.value.finding.source == SourceLocation("scene/root.usda", prim="")


def test_an_image_that_is_not_there_is_in_the_layer_that_names_it(read):
    looks = LOOKS.replace(
        "            token outputs:out\n",
        "            token outputs:out\n            asset inputs:file = @./absent.png@\n",
    )
    found = [one for one in read(layered(looks=looks)).findings if "absent.png" in one.message]
    assert [one.source for one in found] == [source("parts/looks.usda", "/Source/M/s.inputs:file")]


def test_a_layer_of_a_package_has_the_name_that_usd_gives_it(read, tmp_path):
    text = LOOKS.partition(" (")[0] + " {\n" + LOOKS.partition(") {\n")[2].partition("    variantSet ")[0] + "}\n"
    Path(tmp_path / "looks.usda").write_text(text, encoding="utf-8")
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "looks.usda")), str(tmp_path / "box.usdz"))
    place = "/Source/M/s.inputs:unknown"
    found = [one.source for one in read({"box.usdz": ""}).findings if one.location == place]
    assert found == [SourceLocation("box.usdz", layer="box.usdz[looks.usda]", prim=place)]
    stage = '#usda 1.0\ndef "A" (\n    references = @./box.usdz@</Source>\n) {\n}\n'
    found = [one.source for one in read({"a.usda": stage}).findings if one.code == "DOC_UNKNOWN_INPUT"]
    assert found == [SourceLocation("box.usdz", layer="box.usdz[looks.usda]", prim="/A/M/s.inputs:unknown")]


def test_a_document_that_a_stage_refers_to_is_a_layer(read):
    document = """<materialx version="1.39">
      <standard_surface name="s" type="surfaceshader"><input name="base" type="float" value="0.5"/></standard_surface>
      <surfacematerial name="M" type="material">
        <input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial></materialx>"""
    stage = '#usda 1.0\ndef "L" (\n    references = @./parts/m.mtlx@</MaterialX/Materials>\n) {\n}\n'
    made = read({"scene/a.usda": stage, "scene/parts/m.mtlx": document})
    found = made.in_source(rules.DOC_VALUE_RANGE.at("/M", "of the material"))
    assert found.source == source("parts/m.mtlx", "/L/M")
