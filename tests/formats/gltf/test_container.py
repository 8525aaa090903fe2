"""Untrusted assets: each fault is a finding with its place, or an error that says why nothing is read."""

from __future__ import annotations

import base64
import json
import os
import struct

import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.formats import json_text
from mrm_mtlx.formats.gltf import container
from mrm_mtlx.formats.gltf.importer import textures

INVALID, LOST, OUTSIDE, MISSING = "INTERCHANGE_INVALID", "INTERCHANGE_LOST", "READ_OUTSIDE", "DOC_FILE"
BASE = "/materials/0/pbrMetallicRoughness"
RETRO = "/materials/0/extensions/KHR_materials_retroreflection"


def retro(**extension) -> dict:
    return {"extensions": {"KHR_materials_retroreflection": extension}}


MATERIALS = [
    (retro(retroreflectionFactor=1.5), f"{RETRO}/retroreflectionFactor", "at most 1, got 1.5"),
    (retro(retroreflectionFactor=-0.1), f"{RETRO}/retroreflectionFactor", "at least 0, got -0.1"),
    (retro(retroreflectionFactor="1"), f"{RETRO}/retroreflectionFactor", "a number, got a string"),
    (retro(retroreflectionFactor=True), f"{RETRO}/retroreflectionFactor", "a number, got a boolean"),
    (retro(retroreflectionFactor=None), f"{RETRO}/retroreflectionFactor", "a number, got null"),
    (retro(retroreflectionTexture=3), f"{RETRO}/retroreflectionTexture", "an object, got a number"),
    (retro(retroreflectionTexture={}), f"{RETRO}/retroreflectionTexture", "index is missing"),
    (retro(retroreflectionTexture={"index": -1}), f"{RETRO}/retroreflectionTexture/index", "at least 0, got -1"),
    (retro(retroreflectionTexture={"index": 0.5}), f"{RETRO}/retroreflectionTexture/index", "an integer, got a number"),
    ({"extensions": {"KHR_materials_retroreflection": []}}, RETRO, "an object, got an array"),
    ({"extensions": []}, "/materials/0/extensions", "an object, got an array"),
    ({"alphaMode": "GLASS"}, "/materials/0/alphaMode", "one of OPAQUE, MASK, BLEND, got 'GLASS'"),
    ({"name": 7}, "/materials/0/name", "a string, got a number"),
    ({"emissiveFactor": [1, 1]}, "/materials/0/emissiveFactor", "3 numbers, got 2"),
    ({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 2, 1]}}, f"{BASE}/baseColorFactor/2", "at most 1, got 2"),
    (
        {"extensions": {"KHR_materials_ior": {"ior": 0.5}}},
        "/materials/0/extensions/KHR_materials_ior/ior",
        "0, or at least 1",
    ),
    (
        {"extensions": {**retro(retroreflectionFactor=1)["extensions"], "KHR_materials_unlit": {}}},
        "/materials/0/extensions",
        "must not be used together with KHR_materials_unlit",
    ),
    (
        {"extensions": {**retro()["extensions"], "KHR_materials_pbrSpecularGlossiness": {}}},
        "/materials/0/extensions",
        "KHR_materials_pbrSpecularGlossiness",
    ),
]


@pytest.mark.parametrize(("material", "place", "words"), MATERIALS)
def test_a_material_that_breaks_the_rules_is_left_out_with_its_place(write_asset, read, material, place, words):
    imported = read(write_asset(materials=[material, {"name": "sound"}]))
    (finding,) = imported.findings
    assert (finding.code, finding.location) == (INVALID, place)
    assert words in finding.message
    assert [m.getName() for m in imported.materialx.getMaterialNodes()] == ["sound"]


PIXEL = base64.b64encode(b"\x89PNG\r\n\x1a\n" + bytes(8)).decode()
TEXTURES = [
    ({}, INVALID, "/materials/0/emissiveTexture/index", "element 0 of textures, of which there are 0"),
    ({"textures": [{}]}, LOST, "/textures/0", "no image that is read"),
    ({"textures": [{"source": 10**30}]}, INVALID, "/textures/0/source", "of which there are 0"),
    ({"textures": [{"source": "0"}]}, INVALID, "/textures/0/source", "an integer, got a string"),
    (
        {"textures": [{"source": 0, "sampler": 4}], "images": [{"uri": "a.png"}]},
        INVALID,
        "/textures/0/sampler",
        "samplers",
    ),
    (
        {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 1}]},
        INVALID,
        "/samplers/0/wrapS",
        "one of 33071, 33648, 10497, got 1",
    ),
    ({"images": [{}]}, INVALID, "/images/0", "either uri, or bufferView"),
    ({"images": [{"uri": "a.png", "bufferView": 0, "mimeType": "image/png"}]}, INVALID, "/images/0", "either"),
    ({"images": [{"uri": "http://example.org/a.png"}]}, OUTSIDE, "/images/0/uri", "not relative"),
    ({"images": [{"uri": "file:///etc/passwd"}]}, OUTSIDE, "/images/0/uri", "not relative"),
    ({"images": [{"uri": "C:\\secret.png"}]}, OUTSIDE, "/images/0/uri", "not relative"),
    ({"images": [{"uri": "/etc/passwd"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "../outside.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "%2e%2e/outside.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "..%2Foutside.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "a%00.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "x" * 3000}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "link.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "loop.png"}]}, OUTSIDE, "/images/0/uri", "leads out"),
    ({"images": [{"uri": "pipe.png"}]}, MISSING, "/images/0/uri", "no file 'pipe.png'"),
    ({"images": [{"uri": "none.png"}]}, MISSING, "/images/0/uri", "no file 'none.png'"),
    ({"images": [{"uri": ""}]}, MISSING, "/images/0/uri", "no file ''"),
    ({"images": [{"uri": "text.png"}]}, MISSING, "/images/0/uri", "not those of a PNG"),
    ({"images": [{"uri": f"data:image/png,{PIXEL}"}]}, INVALID, "/images/0/uri", "base64,<bytes>"),
    ({"images": [{"uri": "data:image/png;base64"}]}, INVALID, "/images/0/uri", "base64,<bytes>"),
    ({"images": [{"uri": "data:image/png;base64,????"}]}, INVALID, "/images/0/uri", "no base64"),
    ({"images": [{"uri": f"data:image/jpeg;base64,{PIXEL}"}]}, INVALID, "/images/0/uri", "those of image/png"),
    ({"images": [{"uri": "data:image/png;base64,aGVsbG8="}]}, MISSING, "/images/0/uri", "not those of a PNG"),
    ({"views": {"buffer": 0, "byteLength": 4}}, INVALID, "/bufferViews/0/buffer", "of which there are 0"),
    (
        {"views": {"buffer": 0, "byteLength": 9}, "buffers": [{"byteLength": 8}]},
        INVALID,
        "/bufferViews/0",
        "beyond the 8",
    ),
    (
        {"views": {"buffer": 0, "byteOffset": 10**40, "byteLength": 1}, "buffers": [{"byteLength": 8}]},
        INVALID,
        "/bufferViews/0",
        "beyond the 8",
    ),
    ({"views": {"buffer": 0, "byteLength": 10**12}}, INVALID, "/bufferViews/0/buffer", "buffers"),
    (
        {"views": {"buffer": 0, "byteLength": 10**12}, "buffers": [{"byteLength": 10**12}]},
        "READ_TOO_LARGE",
        "/bufferViews/0",
        "more than 64 MiB",
    ),
    ({"views": {"buffer": 0, "byteLength": 8}, "buffers": [{"byteLength": 8}]}, INVALID, "/buffers/0", "it has no uri"),
    (
        {"views": {"buffer": 0, "byteLength": 99}, "buffers": [{"byteLength": 99, "uri": "text.png"}]},
        INVALID,
        "/buffers/0",
        "ends before the 99 bytes",
    ),
    (
        {"views": {"buffer": 0, "byteLength": 8}, "buffers": [{"byteLength": 8, "uri": "../outside.png"}]},
        OUTSIDE,
        "/buffers/0/uri",
        "leads out",
    ),
]


@pytest.fixture
def hostile_folder(tmp_path_factory):
    """A folder with links that lead out of it, a loop, a pipe and a text, beside a file that nothing may reach."""
    outer = tmp_path_factory.mktemp("outer")
    folder = outer / "inner"
    folder.mkdir()
    (outer / "outside.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(99))
    (folder / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(99))
    (folder / "text.png").write_text("no image")
    (folder / "link.png").symlink_to(outer / "outside.png")
    (folder / "loop.png").symlink_to("loop.png")
    os.mkfifo(folder / "pipe.png")
    return folder


@pytest.mark.parametrize(("arrays", "code", "place", "words"), TEXTURES)
def test_a_texture_that_cannot_be_had_is_a_remark_with_its_place(hostile_folder, read, arrays, code, place, words):
    arrays = dict(arrays)
    if "views" in arrays:
        arrays |= {"bufferViews": [arrays.pop("views")], "images": [{"bufferView": 0, "mimeType": "image/png"}]}
    material = {"emissiveTexture": {"index": 0}, "name": "m"}
    data = {"asset": {"version": "2.0"}, "materials": [material], "textures": [{"source": 0}], **arrays}
    if arrays == {}:
        del data["textures"]
    path = hostile_folder / "model.gltf"
    path.write_text(json.dumps(data))
    imported = read(path)
    (finding,) = imported.findings
    assert (finding.code, finding.location) == (code, place)
    assert words in finding.message
    assert len(imported.materialx.getMaterialNodes()) == 1


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the administrator may read every file")
def test_an_image_that_may_not_be_read_is_a_remark_with_its_place(write_asset, png, tmp_path, read):
    png(tmp_path / "a.png", [[[1, 2, 3]]])
    (tmp_path / "a.png").chmod(0)
    material = {"emissiveTexture": {"index": 0}}
    imported = read(write_asset(materials=[material], textures=[{"source": 0}], images=[{"uri": "a.png"}]))
    (finding,) = imported.findings
    assert (finding.code, finding.location) == ("READ_FAILED", "/images/0/uri")
    assert "a.png cannot be read" in finding.message


def nested(depth: int) -> str:
    return '{"asset": {"version": "2.0"}, "extras": ' + "[" * depth + "]" * depth + "}"


TEXTS = [
    ("", INVALID, "", "no JSON"),
    ("[]", INVALID, "", "it holds an array"),
    ("{", INVALID, "", "line 1, column 2"),
    ('{"asset": {"version": "2.0", "version": "2.0"}}', INVALID, "", "'version' stands twice"),
    ('{"asset": {"version": "2.0"}, "a": NaN}', INVALID, "", "NaN is no JSON number"),
    ('{"asset": {"version": "2.0"}, "a": 1e999}', INVALID, "", "too large"),
    ('{"asset": {"version": "2.0"}, "a": ' + "1" * 5000 + "}", INVALID, "", "digits"),
    ('{"asset": {"version": "2.0"}, "a": -' + "1" * 309 + "}", INVALID, "", "digits"),  # more than a double holds
    (nested(100_000), "READ_TOO_DEEP", "", "nested"),
    ("{}", INVALID, "/asset/version", "'2.0', got nothing"),
    ('{"asset": {"version": "1.0"}}', INVALID, "/asset/version", "got '1.0'"),
    ('{"asset": {"version": 2.0}}', INVALID, "/asset/version", "'2.0'"),
    ('{"asset": {"version": "2.0", "minVersion": "2.1"}}', INVALID, "/asset/minVersion", "'2.1'"),
    ('{"asset": {"version": "2.0"}, "materials": {}}', INVALID, "/materials", "an array, got an object"),
    ('{"asset": {"version": "2.0"}, "images": [{}, 3]}', INVALID, "/images/1", "an object, got a number"),
    ('{"asset": {"version": "2.0"}, "textures": [' + "{}," * 10_000 + "{}]}", "READ_TOO_LARGE", "/textures", "10001"),
    ("\ud800".encode("utf-16", "surrogatepass").decode("latin-1"), INVALID, "", "UTF-8"),
]


@pytest.mark.parametrize(("text", "code", "place", "words"), TEXTS, ids=range(len(TEXTS)))
def test_a_file_that_is_no_asset_is_refused_with_the_reason(tmp_path, read, text, code, place, words):
    path = tmp_path / "model.gltf"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ReadError) as caught:
        read(path)
    assert (caught.value.finding.code, caught.value.finding.location) == (code, place)
    assert words in caught.value.finding.message


def chunked(*chunks: tuple[bytes, bytes], magic=b"glTF", version=2, length=None) -> bytes:
    body = b"".join(struct.pack("<I4s", len(content), name) + content for name, content in chunks)
    return struct.pack("<4sII", magic, version, 12 + len(body) if length is None else length) + body


SOUND = (b"JSON", b'{"asset": {"version": "2.0"}}   ')
BINARIES = [
    (b"glTF", "within the 12 bytes of its header"),
    (chunked(SOUND, version=1), "version 1 of the container"),
    (chunked(SOUND)[:-4], "cut short"),
    (chunked(SOUND) + b"more", "header says"),
    (chunked(SOUND, length=10**9), "cut short"),
    (chunked(), "no JSON chunk"),
    (chunked((b"BIN\0", b"1234")), "first chunk is not JSON"),
    (struct.pack("<4sII", b"glTF", 2, 16) + b"1234", "within the head of a chunk, at byte 12"),
    (struct.pack("<4sIII4s", b"glTF", 2, 24, 2**32 - 1, b"JSON") + b"{}  ", "says 4294967295 bytes; 4 are left"),
    (b"PK\3\4" + bytes(40), "begins with the four bytes"),
    (chunked((b"JSON", b"\0\0\0\0")), "no JSON"),
]


@pytest.mark.parametrize(("content", "words"), BINARIES, ids=range(len(BINARIES)))
def test_a_broken_glb_is_refused_with_the_reason(tmp_path, read, content, words):
    path = tmp_path / "model.glb"
    path.write_bytes(content)
    with pytest.raises(ReadError) as caught:
        read(path)
    assert caught.value.finding.code == INVALID
    assert words in caught.value.finding.message


def test_the_largest_whole_numbers_are_read(write_asset, read):
    largest = int("9" * json_text._LONGEST_NUMBER)
    extensions = {"KHR_materials_ior": {"ior": largest}, **retro(retroreflectionFactor=1)["extensions"]}
    path = write_asset(materials=[{"alphaMode": "MASK", "alphaCutoff": largest, "extensions": extensions}])
    assert len(read(path).materialx.getMaterialNodes()) == 1


def test_large_files_are_refused_unread(tmp_path, read):
    path = tmp_path / "model.gltf"
    path.write_text("{")
    os.truncate(path, container.MAXIMUM_JSON_BYTES + 1)  # sparse: no disk is used
    with pytest.raises(ReadError, match="MiB that are read") as caught:
        read(path)
    assert caught.value.finding.code == "READ_TOO_LARGE"


def test_a_folder_and_a_pipe_are_refused(tmp_path, read):
    (tmp_path / "folder.gltf").mkdir()
    os.mkfifo(tmp_path / "pipe.gltf")
    for name in ("folder.gltf", "pipe.gltf", "none.gltf"):
        with pytest.raises(ReadError, match="not a regular file"):
            read(tmp_path / name)


def test_what_is_unpacked_is_bounded_and_one_image_is_unpacked_once(monkeypatch, glb, png, tmp_path, read):
    content = png(tmp_path / "a.png", [[[1, 2, 3]]])
    info = {"index": 0}
    data = {
        "asset": {"version": "2.0"},
        "materials": [{"emissiveTexture": info, "occlusionTexture": info}, {"emissiveTexture": {"index": 1}}],
        "textures": [{"source": 0}, {"source": 1}],
        "images": [{"bufferView": 0, "mimeType": "image/png"}] * 2,
        "bufferViews": [{"buffer": 0, "byteLength": len(content)}],
        "buffers": [{"byteLength": len(content)}],
    }
    path = tmp_path / "model.glb"
    path.write_bytes(glb(data, content))
    imported = read(path)
    assert imported.findings == []
    assert len(list(imported.reach.folder.iterdir())) == 2
    monkeypatch.setattr(textures, "MAXIMUM_UNPACKED_BYTES", len(content))
    (finding,) = read(path).findings
    assert (finding.code, finding.location) == ("READ_TOO_LARGE", "/images/1")


def test_many_materials_are_read_in_bounded_time_and_broken_ones_do_not_hide_the_others(write_asset, read):
    broken = {"pbrMetallicRoughness": {"metallicFactor": -1}}
    imported = read(write_asset(materials=[{}, broken] * 50))
    assert len(imported.findings) == 50
    assert len(imported.materialx.getMaterialNodes()) == 50
