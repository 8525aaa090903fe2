"""OpenMATERIAL's block of retroreflection: what is written, what is read back, and what is refused."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from mrm_mtlx.bsdf import Lambert
from mrm_mtlx.formats.openmaterial import block as block_module
from mrm_mtlx.formats.openmaterial.block import (
    BLOCK,
    COEFFICIENT,
    SOURCES,
    Geometry,
    RetroreflectivityData,
    as_json,
    load,
    merged,
)
from mrm_mtlx.formats.openmaterial.translation import of_brdf

MATERIAL = {"name": "sign", "parts": [{"layer/1": {BLOCK: {COEFFICIENT: 70.5, SOURCES: "lab A, 2024"}}}], "more": None}
PLACE = f"/parts/0/layer~11/{BLOCK}"


def sheeting(r_a):
    """A BRDF with the same R_A everywhere."""
    return lambda v, l: np.broadcast_to(r_a / (v[..., 2:] * l[..., 2:]), np.broadcast_shapes(v.shape, l.shape))


@pytest.fixture
def saved(tmp_path):
    """Function that writes a JSON text, or data, to a file."""

    def save(content):
        path = tmp_path / "material.json"
        path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
        return path

    return save


def test_the_block_has_the_documents_coefficient_and_says_where_it_was_taken():
    block = of_brdf(Lambert(1.0).eval, "a, b\n.mtlx", Geometry(0.0, 0.0))
    assert block.coefficient == 0.31831  # 1 / pi, to the six digits that are written
    assert block.geometry == Geometry(0.0, 0.0)
    parts = block.sources.split(", ")
    assert parts[0] == "computed from the MaterialX document a; b .mtlx"
    assert parts[1].startswith("by mrm-mtlx ")
    assert parts[2:4] == ["observation angle 0 deg", "entrance angle 0 deg"]
    assert "coplanar" in parts[4]
    assert parts[5].startswith("CIE illuminant A")
    assert len(parts) == 6


@pytest.mark.parametrize("r_a", [5000.01, 1e9])
def test_a_coefficient_beyond_the_standards_range_is_not_written(r_a):
    assert of_brdf(sheeting(4999.9), "a").coefficient == pytest.approx(4999.9)
    with pytest.raises(ValueError, match=r"may hold 0 to 5000"):
        of_brdf(sheeting(r_a), "a")


def test_what_is_written_is_read_back(tmp_path):
    block = of_brdf(sheeting(123.4567), "sign.mtlx", Geometry(0.33, 5.0))
    (tmp_path / "new.json").write_bytes(as_json(merged(None, block)))
    found = load(tmp_path / "new.json")
    assert (found.block, found.pointer, list(found.data)) == (block, f"/{BLOCK}", [BLOCK])
    assert found.block.geometry == Geometry(0.33, 5.0)


def test_a_block_is_found_and_replaced_where_it_stands_and_all_else_stays(saved):
    file = load(saved(MATERIAL))
    assert (file.pointer, file.block) == (PLACE, RetroreflectivityData(70.5, "lab A, 2024"))
    assert file.block.geometry is None
    data = merged(file, RetroreflectivityData(80.0, "ours"))
    expected = json.loads(json.dumps(MATERIAL).replace("70.5", "80.0").replace("lab A, 2024", "ours"))
    assert json.dumps(data) == json.dumps(expected)  # the order as well
    assert file.data == MATERIAL


def test_what_a_block_holds_besides_is_kept(saved):
    content = {BLOCK: {"note": [1, 2], COEFFICIENT: 1, SOURCES: ""}}
    data = merged(load(saved(content)), RetroreflectivityData(2.0, "ours"))
    assert data == {BLOCK: {"note": [1, 2], COEFFICIENT: 2.0, SOURCES: "ours"}}


def test_a_new_block_goes_where_it_is_told(saved):
    block = RetroreflectivityData(2.0, "ours")
    file = load(saved({"a": [{"~": {}}], "é": 1.5}))
    assert merged(file, block) == {"a": [{"~": {}}], "é": 1.5, BLOCK: {COEFFICIENT: 2.0, SOURCES: "ours"}}
    assert merged(file, block, "/a/0/~0")["a"][0]["~"] == {BLOCK: {COEFFICIENT: 2.0, SOURCES: "ours"}}
    for pointer in ("/b", "/a", "/a/1", "/a/0/x", "a", "/é", "/a/-1", "/a/" + "9" * 5000):
        with pytest.raises(ValueError, match="there is no object at"):
            merged(file, block, pointer)


@pytest.mark.parametrize(
    ("stated", "geometry"),
    [
        ("observation angle 0.2 deg, entrance angle -4 deg", Geometry(0.2, -4.0)),
        ("x, entrance angle +5 deg at observation angle 1 deg", Geometry(1.0, 5.0)),
        ("observation angle 0.2 deg", None),
        ("observation angle 0.2 deg, observation angle 0.5 deg, entrance angle 5 deg", None),
        ("observation angle 0.2.1 deg, entrance angle 5 deg", None),
        ("", None),
    ],
)
def test_angles_are_read_from_sources_that_state_them_once(stated, geometry):
    assert RetroreflectivityData(1.0, stated).geometry == geometry


def nested(depth):
    return b'{"a":' * depth + b"1" + b"}" * depth


def block(coefficient="1", sources='"lab"'):
    return f'{{"m": {{"{BLOCK}": {{"{COEFFICIENT}": {coefficient}, "{SOURCES}": {sources}}}}}}}'.encode()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no JSON"),
        (b"{", "line 1, column 2: no JSON"),
        (b"\xff{}", "byte 0 is not UTF-8"),
        (b"[]", "holds an array; expected a JSON object"),
        (b"3", "holds a number; expected a JSON object"),
        (nested(101), "nested more than 100 deep"),
        (nested(200_000), "nested more than 100 deep"),
        (b'{"a": ' + b"[" * 200_000, "nested more than 100 deep"),
        (b'{"a": 1, "b": {"c": 1, "c": 2}}', "the name 'c' stands twice in one object"),
        (b'{"a": 1e999}', "the number '1e999' is too large"),
        (b'{"a": ' + b"9" * 5000 + b"}", "a number has more than"),
        (block("NaN"), "NaN is no JSON number"),
        (block("-Infinity"), "-Infinity is no JSON number"),
        (block("-0.001"), f"/m/{BLOCK}/{COEFFICIENT}: expected 0 to 5000 cd/"),
        (block("5000.1"), "got 5000.1"),
        (block("9" * 300), "expected 0 to 5000"),
        (block('"250"'), f"/{COEFFICIENT}: expected a number, got a string"),
        (block("true"), "expected a number, got a boolean"),
        (block("null"), "expected a number, got null"),
        (block(sources="[]"), f"/m/{BLOCK}/{SOURCES}: expected a string, got an array"),
        (f'{{"{BLOCK}": []}}'.encode(), f"/{BLOCK}: expected an object, got an array"),
        (f'{{"{BLOCK}": {{"{SOURCES}": ""}}}}'.encode(), f"/{BLOCK}: '{COEFFICIENT}' is missing"),
        (f'{{"{BLOCK}": {{"{COEFFICIENT}": 1}}}}'.encode(), f"/{BLOCK}: '{SOURCES}' is missing"),
        (f'{{"a": {{"{BLOCK}": {{}}}}, "{BLOCK}": {{}}}}'.encode(), "stands there twice"),
    ],
    ids=range(24),
)
def test_a_broken_file_gives_one_line_with_its_place(saved, content, message):
    with pytest.raises(ValueError, match=r"^material\.json: ") as caught:
        load(saved(content))
    text = str(caught.value)
    assert message in text
    assert text.isprintable()
    assert len(text) < 300


def test_names_of_a_file_cannot_drive_the_terminal_nor_fill_it(saved):
    name = "\x1b[31m" + "x" * 10_000
    with pytest.raises(ValueError, match="expected an object") as caught:
        load(saved({name: {BLOCK: 1}}))
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


def test_only_regular_files_of_bounded_size_are_read(tmp_path, monkeypatch, saved):
    os.mkfifo(tmp_path / "pipe.json")
    for path in (tmp_path, tmp_path / "absent.json", tmp_path / "pipe.json"):
        with pytest.raises(ValueError, match="does not exist, or is not a regular file"):
            load(path)
    path = saved(MATERIAL)
    monkeypatch.setattr(block_module, "MAXIMUM_BYTES", path.stat().st_size)
    load(path)
    monkeypatch.setattr(block_module, "MAXIMUM_BYTES", path.stat().st_size - 1)
    with pytest.raises(ValueError, match="larger than"):
        load(path)


def test_half_of_a_surrogate_pair_survives(saved, tmp_path):
    file = load(saved(b'{"a": "\\ud800", "b": "\xc3\xa9"}'))
    (tmp_path / "new.json").write_bytes(as_json(merged(file, RetroreflectivityData(1.0, ""))))
    assert load(tmp_path / "new.json").data | {BLOCK: 0} == {"a": "\ud800", "b": "é", BLOCK: 0}


def test_a_name_that_stands_twice_among_many_is_found_at_once(tmp_path):
    # Counting each name anew would take minutes.
    names = ", ".join(f'"n{i}": 0' for i in range(100_000))
    path = tmp_path / "material.json"
    path.write_text(f'{{{names}, "twice": 1, "twice": 2}}', encoding="utf-8")
    with pytest.raises(ValueError, match="twice"):
        load(path)
