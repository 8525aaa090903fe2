"""What is said of an asset has a JSON pointer, and in a .gltf the line where that is."""

from __future__ import annotations

import json

import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.reading import read_document

RETRO = "KHR_materials_retroreflection"
ASSET = {
    "asset": {"version": "2.0"},
    "materials": [
        {
            "name": "plain",
            "pbrMetallicRoughness": {"roughnessFactor": 0.25, "metallicFactor": 1.0},
            "doubleSided": True,
        },
        {"name": "wrong", "extensions": {RETRO: {"retroreflectionFactor": 2.0}}},
        {"name": "textured", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
    ],
    "textures": [{"source": 0}],
    "images": [{"uri": "absent.png"}],
}


@pytest.fixture
def read(tmp_path, monkeypatch, library):
    """Function that reads an asset from bytes, which lies in a folder of the current one."""
    monkeypatch.chdir(tmp_path)

    def reading(content: bytes, name: str = "model.gltf"):
        folder = tmp_path / "parts"
        folder.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
        scratch = tmp_path / "scratch"
        scratch.mkdir(exist_ok=True)
        path = (folder / name).relative_to(tmp_path)
        return read_document(path, Reach.beside(path), library, scratch)

    return reading


def line_of(text: str, mark: str) -> tuple[int, int]:
    lines = text[: text.index(mark)].split("\n")
    return len(lines), len(lines[-1]) + 1


def test_findings_of_reading_have_pointer_and_line(read):
    text = json.dumps(ASSET, indent=2)
    found = {one.location: one.source for one in read(text.encode()).findings}
    marks = {
        "/materials/0/doubleSided": '"doubleSided"',
        f"/materials/1/extensions/{RETRO}/retroreflectionFactor": '"retroreflectionFactor"',
        "/images/0/uri": '"uri"',
    }
    assert found == {
        at: SourceLocation("parts/model.gltf", *line_of(text, mark), pointer=at) for at, mark in marks.items()
    }


def test_findings_of_the_document_that_is_made_of_it_are_where_the_asset_says_it(read):
    text = json.dumps(ASSET, indent=2)
    document = read(text.encode())
    shader = document.materialx.getMaterialNodes()[0].getInput("surfaceshader").getNodeName()
    found = document.in_source(rules.DOC_VALUE_RANGE.at(f"/{shader}/roughness", "too rough"))
    assert found.location == "/materials/0/pbrMetallicRoughness/roughnessFactor"
    line, column = line_of(text, '"roughnessFactor"')
    assert found.source == SourceLocation("parts/model.gltf", line, column, pointer=found.location)
    absent = document.in_source(rules.DOC_VALUE_RANGE.at(f"/{shader}/sheen_color", "too red")).source
    assert absent == SourceLocation("parts/model.gltf", 6, 5, pointer="/materials/0")


def test_in_a_glb_there_are_pointers_and_no_lines(read, glb):
    document = read(glb(ASSET), "model.glb")
    assert {one.source for one in document.findings} == {
        SourceLocation("parts/model.glb", pointer=one.location) for one in document.findings
    }
    assert len(document.findings) == 3


@pytest.mark.parametrize(
    ("content", "source"),
    [
        ('{\n "asset": {"version": "2.0"},\n "materials": [\n  {},\n  7]}', (5, 3, "/materials/1")),
        ('{\n "asset": {\n  "version": 2}}', (3, 3, "/asset/version")),
        ('{\n "asset": {}}', (2, 2, "/asset")),
        ("{}", (None, None, "")),
        ('{\n "asset" 2}', (2, 10, "")),
        ("[]", (None, None, "")),
    ],
)
def test_what_is_no_asset_is_named_with_its_line(read, content, source):
    line, column, pointer = source
    with pytest.raises(ReadError) as raised:
        read(content.encode())
    assert raised.value.finding.source == SourceLocation("parts/model.gltf", line, column, pointer=pointer)


def test_a_chunk_that_is_no_json_has_no_line(read, glb):
    with pytest.raises(ReadError) as raised:
        read(glb(ASSET).replace(b'"asset":', b'"asset" '), "model.glb")
    assert raised.value.finding.source == SourceLocation("parts/model.glb", pointer="")
