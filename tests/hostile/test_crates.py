"""Crates that claim more than they hold: each is refused before USD makes room for it, and none that is whole is."""

from __future__ import annotations

import contextlib
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.usd import read
from mrm_mtlx.formats.usd.opening import crate_packing, crate_values, layers
from mrm_mtlx.formats.usd.opening.crate_packing import summed, unpacked

TEXT = """#usda 1.0
(
    customLayerData = {
        dictionary d = {
            string s = "x"
        }
    }
)
def Xform "a" (
    prepend references = </b>
)
{
    int[] long = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20]
    int[] short = [7, 7, 7]
    double moving.timeSamples = { 0: 1, 1: 2 }
    def "c"
    {
    }
}
def "b"
{
}
"""
HEADER = struct.Struct("<8s3B5xq64x")
HUGE = 1 << 36


@pytest.fixture
def crate(tmp_path):
    """Function from a text of USD to the bytes of its crate."""

    def make(text=TEXT):
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        layer.ImportFromString(text)
        layer.Export(str(tmp_path / "whole.usdc"))
        return bytearray((tmp_path / "whole.usdc").read_bytes())

    return make


@pytest.fixture
def refused(tmp_path):
    """Function from a crate's bytes to what is said of it."""

    def read(data):
        path = tmp_path / "s.usdc"
        path.write_bytes(data)
        with pytest.raises(ReadError) as caught:
            layers.open_layer(path, "")
        assert caught.value.finding.code == "READ_FORMAT"
        return caught.value.finding.message

    return read


def contents(data):
    """Start, size and the place in the table of contents of each section."""
    (start,) = struct.unpack_from("<q", data, 16)
    (count,) = struct.unpack_from("<Q", data, start)
    found = {}
    for at in range(start + 8, start + 8 + 32 * count, 32):
        name, begin, size = struct.unpack_from("<16sqq", data, at)
        found[name.rstrip(b"\0").decode()] = (begin, size, at)
    return found


def put(data, at, *numbers):
    struct.pack_into(f"<{len(numbers)}Q", data, at, *numbers)


def packed(content):
    """Bytes as TfFastCompression stores them, without a repetition."""
    more, rest = divmod(len(content) - 15, 255)
    head = bytes([len(content) << 4]) if len(content) < 15 else b"\xf0" + b"\xff" * more + bytes([rest])
    return b"\0" + head + content


def integers(values):
    """Integers as a crate stores them: the differences, each of four bytes."""
    codes = bytearray(-(-2 * len(values) // 8))
    for k in range(len(values)):
        codes[k // 4] |= 3 << 2 * (k % 4)
    steps = np.diff(values, prepend=0).astype("<i4").tobytes()
    content = packed(b"\0\0\0\0" + bytes(codes) + steps)
    return struct.pack("<Q", len(content)) + content


def replaced(data, name, content):
    """The crate with another section, which stands at its end."""
    data = bytearray(data)
    put(data, contents(data)[name][2] + 16, len(data), len(content))
    return data + content


@pytest.mark.parametrize("name", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
def test_a_section_that_claims_a_huge_count_is_named(crate, refused, name):
    data = crate()
    put(data, contents(data)[name][0], HUGE)
    assert f"s.usdc: the crate is damaged: section {name} claims" in refused(data)


@pytest.mark.parametrize("name", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
def test_a_section_that_lies_beyond_the_file_is_named(crate, refused, name):
    data = crate()
    put(data, contents(data)[name][2] + 16, len(data) - 4)
    assert f"section {name} claims" in refused(data)


def test_tokens_that_claim_to_unpack_to_gigabytes_are_refused(crate, refused):
    data = crate()
    put(data, contents(data)["TOKENS"][0] + 8, HUGE)
    assert "section TOKENS claims" in refused(data)


def test_a_table_of_contents_that_claims_billions_of_sections_is_refused(crate, refused):
    data = crate()
    put(data, HEADER.unpack_from(data)[4], 1 << 33)
    assert "the table of contents claims 8589934592 sections" in refused(data)


def test_paths_that_meet_again_and_again_are_refused(crate, refused):
    """Each entry has the next as its child and as its sibling: USD would follow 2 to the power of 30 branches."""
    count = 30
    jumps = [1] * (count - 1) + [-2]
    tree = b"".join(integers(values) for values in (range(count), [0] * count, jumps))
    section = struct.pack("<QQ", count, count) + tree
    assert "section PATHS is no tree" in refused(replaced(crate(), "PATHS", section))


@pytest.mark.parametrize("jumps", [[-1, 0], [-2, -2], [2, -2], [5, -2], [-1, -7], [4, 3, -2, -2, -2]], ids=str)
def test_paths_that_lead_nowhere_are_refused(crate, refused, jumps):
    count = len(jumps)
    tree = b"".join(integers(values) for values in (range(count), [0] * count, jumps))
    assert "section PATHS is no tree" in refused(replaced(crate(), "PATHS", struct.pack("<QQ", count, count) + tree))


def test_a_path_that_stands_in_two_places_is_refused(crate, refused):
    tree = b"".join(integers(values) for values in ([0, 0], [0, 0], [-1, -2]))
    assert "names 2 paths, not each once, of 2" in refused(replaced(crate(), "PATHS", struct.pack("<QQ", 2, 2) + tree))


def test_more_entries_than_are_unpacked_at_once_are_refused(crate, refused, monkeypatch):
    monkeypatch.setattr(crate_packing, "MAXIMUM_ENTRIES", 1)
    assert "entries; 1 are read" in refused(crate())


def values_of(data):
    """The values of the fields."""
    start, _, _ = contents(data)["FIELDS"]
    (count,) = struct.unpack_from("<Q", data, start)
    (size,) = struct.unpack_from("<Q", data, start + 8)
    at = start + 16 + size
    (size,) = struct.unpack_from("<Q", data, at)
    return np.frombuffer(unpacked(memoryview(bytes(data))[at + 8 : at + 8 + size], 8 * count, ""), "<u8").tolist()


def stands_at(data, kind, array=False):
    """Where in the file the values of a type stand."""
    flags = (1 if array else 0) << 63
    return [
        v & (1 << 48) - 1
        for v in values_of(data)
        if v >> 48 & 0xFF == kind and v & 1 << 63 == flags and not v & 1 << 62
    ]


def test_an_array_that_claims_a_huge_number_of_elements_is_refused(crate, refused):
    for at in stands_at(crate(), 3, array=True):
        data = crate()
        put(data, at, HUGE)
        assert "an array claims 68719476736 elements" in refused(data)


def test_a_packed_array_beyond_the_bound_is_refused(crate, refused, monkeypatch):
    monkeypatch.setattr(crate_values, "MAXIMUM_ARRAY_BYTES", 79)
    assert "an array of 0 MiB" in refused(crate())
    monkeypatch.setattr(crate_values, "MAXIMUM_ARRAY_BYTES", 80)
    crate_values.refuse_oversized(memoryview(bytes(crate())), values_of(crate()), (0, 8, 0))


def with_values(data, values):
    """The crate with other values of its fields."""
    start, _, _ = contents(data)["FIELDS"]
    (size,) = struct.unpack_from("<Q", data, start + 8)
    names = bytes(data[start + 8 : start + 16 + size])
    content = packed(np.array(values, "<u8").tobytes())
    section = struct.pack("<Q", len(values)) + names + struct.pack("<Q", len(content)) + content
    return replaced(data, "FIELDS", section)


def test_an_array_whose_elements_are_not_in_its_table_is_refused(crate, refused):
    """USD reads whatever stands in memory behind the table."""
    data = crate('#usda 1.0\ndef "a" {\n float[] x = [' + ", ".join(["0.5", "0.25"] * 50) + "]\n}\n")
    (at,) = stands_at(data, 8, array=True)
    assert data[at + 8 : at + 13] == b"t\x02\0\0\0"
    where = len(data)
    values = [v & ~((1 << 48) - 1) | where if v >> 48 & 0xFF == 8 and v >> 63 else v for v in values_of(data)]
    # The count, the table, and other numbers of its entries.
    data += data[at : at + 21] + integers([0, 1] * 49 + [1, 2])
    assert "an array has elements beyond its table of 2" in refused(with_values(data, values))


def test_a_value_of_a_type_that_no_attribute_has_is_refused(crate, library, tmp_path):
    """Such as the samples of another attribute for its default: Python has no form for them."""
    data = crate()
    values = values_of(data)
    (samples,) = [value for value in values if value >> 48 & 0xFF == 46]
    data = with_values(data, [samples if v >> 48 & 0xFF == 3 and v >> 63 else v for v in values])
    path = tmp_path / "s.usdc"
    path.write_bytes(data)
    with pytest.raises(ReadError) as caught:
        read(path, Reach.beside(path), library, tmp_path)
    assert caught.value.finding.code == "READ_FORMAT"
    assert "a value of a type that none can have" in caught.value.finding.message


def test_a_list_of_references_that_claims_a_huge_count_is_refused(crate, refused):
    data = crate()
    (at,) = stands_at(data, 35)
    put(data, at + 1, HUGE)
    assert "a value claims 68719476736 items" in refused(data)


def test_a_dictionary_that_lies_in_itself_is_refused(crate, refused):
    """USD follows it until its stack ends."""
    data = crate()
    (outer,) = stands_at(data, 31)
    # Count, key, distance to the value: that becomes the outer dictionary again.
    (distance,) = struct.unpack_from("<q", data, outer + 12)
    put(data, outer + 12 + distance, 31 << 48 | outer)
    assert "a value lies in itself" in refused(data)


def test_dictionaries_that_lie_too_deep_in_each_other_are_refused(crate, refused, monkeypatch):
    monkeypatch.setattr(crate_values, "MAXIMUM_DEPTH", 0)
    assert "values lie more than 0 deep in each other" in refused(crate())


def test_values_that_multiply_are_refused(crate, refused, monkeypatch):
    monkeypatch.setattr(crate_values, "MAXIMUM_PARTS", 2)
    assert "a value consists of more than 2 others" in refused(crate())


def test_time_samples_that_claim_a_huge_number_are_refused(crate, refused):
    data = crate()
    (at,) = stands_at(data, 46)
    at += struct.unpack_from("<q", data, at)[0] + 8  # behind the times
    at += struct.unpack_from("<q", data, at)[0]
    put(data, at, HUGE)
    assert "a value claims 68719476736 items" in refused(data)


@pytest.mark.parametrize("cut", [0, 8, 87, 88, 200, -40])
def test_a_crate_that_is_cut_short_is_refused(crate, refused, cut):
    assert "s.usdc" in refused(crate()[: cut or 8])


def test_no_byte_of_a_crate_makes_more_than_a_finding(crate, tmp_path):
    """Bytes of a small crate, each set to others: it is refused or not, and nothing else is raised."""
    data = crate('#usda 1.0\ndef "a" {\n}\n')
    path = tmp_path / "s.usdc"
    for at in range(8, len(data), 3):
        for other in (0x00, 0x7F, 0xFF):
            damaged = bytearray(data)
            damaged[at] = other
            path.write_bytes(damaged)
            with contextlib.suppress(ReadError):
                layers.check_file(path, "")


def layer_of_everything(layer, rng):
    """Values of all types, single and many, also at times, and all that lists, variants and targets are stored in."""
    kinds = [getattr(Sdf.ValueTypeNames, name) for name in dir(Sdf.ValueTypeNames)]
    kinds = [kind for kind in kinds if isinstance(kind, Sdf.ValueTypeName) and str(kind) not in ("group", "opaque")]
    for number, kind in enumerate(kinds):
        prim = Sdf.CreatePrimInLayer(layer, f"/p{number % 7}/q{number}")
        attribute = Sdf.AttributeSpec(prim, "x", kind)
        one = kind.scalarType.defaultValue
        many = int(rng.choice([0, 1, 15, 16, 17, 300]))
        attribute.default = type(kind.defaultValue)([one] * many) if kind.isArray else one
        layer.SetTimeSample(attribute.path, 1.0, attribute.default)
    prim.referenceList.Prepend(Sdf.Reference("./x.usda", "/a", Sdf.LayerOffset(1, 2), {"k": "v"}))
    prim.payloadList.Append(Sdf.Payload("./y.usda"))
    prim.inheritPathList.Prepend("/p0")
    prim.specializesList.Append("/p1")
    prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(["A", "B"], ["C"], ["D"]))
    prim.customData = {"a": {"b": {"c": 1}}, "v": Vt.IntArray([1] * 50), "m": Gf.Matrix4d(1)}
    Sdf.VariantSpec(Sdf.VariantSetSpec(prim, "v"), "one")
    prim.variantSelections["v"] = "one"
    Sdf.RelationshipSpec(prim, "r").targetPathList.explicitItems = ["/p0", "/p1/q1.x"]
    attribute.connectionPathList.Prepend("/p0/q0.x")
    Sdf.AttributeSpec(prim, "noise", Sdf.ValueTypeNames.IntArray).default = Vt.IntArray.FromNumpy(
        rng.integers(-(2**31), 2**31, 2000).astype(np.int32)
    )


def test_crates_that_usd_writes_are_whole(tmp_path, rng):
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    layer_of_everything(layer, rng)
    layer.Export(str(tmp_path / "s.usdc"))
    assert layers.open_layer(tmp_path / "s.usdc", "").is_crate


@pytest.mark.parametrize("version", ["0.4.0", "0.5.0", "0.6.0", "0.7.0", "0.9.0", "0.12.0", "0.13.0"])
def test_crates_of_other_versions_are_whole(tmp_path, version):
    code = "import sys; from pxr import Sdf; layer = Sdf.Layer.CreateAnonymous('.usdc')\n"
    code += "layer.ImportFromString(sys.argv[1]); layer.Export(sys.argv[2])"
    path = tmp_path / "s.usdc"
    environment = os.environ | {"USD_WRITE_NEW_USDC_FILES_AS_VERSION": version}
    subprocess.run([sys.executable, "-c", code, TEXT, str(path)], env=environment, capture_output=True, check=True)
    assert ".".join(map(str, path.read_bytes()[8:11])) == version
    assert layers.check_file(path, "").startswith(b"PXR-USDC")


def test_integers_are_summed_as_usd_sums_them():
    values = [5, 5, -3, 2**31 - 1, -(2**31), 0, 70000, 7]
    content = integers(values)
    found = unpacked(memoryview(content)[8:], 100, "")
    assert summed(found, len(values), 2, "").tolist() == values


def test_what_is_packed_by_repetition_and_in_chunks_isunpacked():
    # Three bytes, then seven from three before, then a byte.
    block = bytes([0x33]) + b"abc" + b"\x03\x00" + bytes([0x10]) + b"z"
    whole = b"abc" + b"abcabca" + b"z"
    assert unpacked(memoryview(b"\0" + block), 99, "") == whole
    chunks = b"\x02" + 2 * (struct.pack("<i", len(block)) + block)
    assert unpacked(memoryview(chunks), 99, "") == whole * 2
