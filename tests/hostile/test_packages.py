"""Packages (.usdz) that are damaged, odd, or made to unpack to more than they hold: each gives one clear finding."""

from __future__ import annotations

import contextlib
import random
import struct
import zipfile

import numpy as np
import pytest

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import write_image
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.formats.usd import read
from mrm_mtlx.formats.usd.opening import packages
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request

LAYER = "#usda 1.0\n"
# In a file's header: flags, method, packed size, size; in the directory's entry, the same with two bytes more before.
FLAGS, METHOD, PACKED, SIZE = 6, 8, 18, 22


@pytest.fixture
def package(place):
    """Function from files, and the method by which they are packed, to a package's path."""

    def make(method=zipfile.ZIP_STORED, **files):
        path = place.folder / "p.usdz"
        with zipfile.ZipFile(path, "w", method) as written:
            for name, content in ({"s.usda": LAYER} | files).items():
                written.writestr(name, content)
        return path

    return make


@pytest.fixture
def refused(library, tmp_path):
    """Function from a package to what is said of it."""

    def run(path):
        scratch = tmp_path / "unpacked"
        scratch.mkdir()
        with pytest.raises(ReadError) as caught:
            read(path, Reach.beside(path), library, scratch)
        assert caught.value.finding.code == "READ_FORMAT"
        assert str(path.parent) not in caught.value.finding.message
        return caught.value.finding.message

    return run


def entry(data, name):
    """Where the header of a file begins, and its entry in the directory."""
    header = data.index(b"PK\x03\x04" + data[4:26], 0) if name is None else data.index(name) - 30
    return header, data.rindex(name) - 46


def changed(path, name, at, form, value):
    """Change a field of a file's header and of its entry in the directory."""
    data = bytearray(path.read_bytes())
    header, listed = entry(bytes(data), name)
    struct.pack_into(form, data, header + at, value)
    struct.pack_into(form, data, listed + at + 2, value)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize(
    "method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA], ids=["zip", "bz2", "xz"]
)
def test_compressed_files_are_refused_and_not_unpacked(package, refused, method):
    assert "s.usda is compressed" in refused(package(method, **{"bomb.png": bytes(10_000_000)}))


@pytest.mark.parametrize(
    "method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA], ids=["zip", "bz2", "xz"]
)
def test_files_that_are_said_to_be_compressed_and_are_not_give_no_error_of_a_library(package, refused, method):
    path = package(**{"a.png": b"x" * 100})
    assert "a.png is compressed" in refused(changed(path, b"a.png", METHOD, "<H", method))


def test_encrypted_files_are_refused(package, refused):
    assert "a.png is encrypted" in refused(changed(package(**{"a.png": b"x" * 100}), b"a.png", FLAGS, "<H", 1))


def test_a_size_beyond_the_package_is_refused(package, refused):
    path = package(**{"a.png": b"x" * 100})
    changed(path, b"a.png", PACKED, "<I", 99_000)
    assert "cannot be unpacked" in refused(changed(path, b"a.png", SIZE, "<I", 99_000))


def test_a_size_that_header_and_directory_state_differently_is_refused(package, refused):
    path = package(**{"a.png": b"x" * 100})
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, entry(bytes(data), b"a.png")[0] + SIZE, 50)
    path.write_bytes(data)
    assert "it states several sizes of a.png" in refused(path)


def test_files_that_overlap_are_refused(package, refused):
    """Each entry of the directory has all of the others in it: a little package unpacks to any size."""
    path = package(**{"a.png": b"x" * 100, "b.png": b"y" * 100})
    data = bytearray(path.read_bytes())
    header, listed = entry(bytes(data), b"b.png")
    first, _ = entry(bytes(data), b"a.png")
    data[header + 30 : header + 35] = b"a.png"
    data[listed + 46 : listed + 51] = b"a.png"
    struct.pack_into("<I", data, listed + 42, first)
    path.write_bytes(data)
    assert "a.png overlaps the file before it" in refused(path)


def test_a_first_layer_that_the_directory_conceals_is_refused(package, refused):
    """USD reads the package from its beginning, and would open that layer; others read the directory."""
    path = package(**{"t.usda": LAYER})
    data = bytearray(path.read_bytes())
    _, listed = entry(bytes(data), b"s.usda")
    _, kept = entry(bytes(data), b"t.usda")
    end = data.rindex(b"PK\x05\x06")
    del data[listed:kept]
    end -= kept - listed
    struct.pack_into("<HHI", data, end + 8, 1, 1, end - listed)
    path.write_bytes(data)
    with zipfile.ZipFile(path) as found:
        assert found.namelist() == ["t.usda"]
    assert "before t.usda there is what its directory does not name" in refused(path)


def test_a_package_behind_other_bytes_is_refused(package, refused):
    path = package()
    path.write_bytes(b"PK\x03\x04" + bytes(60) + path.read_bytes())
    assert "before s.usda there is what its directory does not name" in refused(path)


@pytest.mark.parametrize("files", [{}, {"a.png": b"x"}], ids=["nothing", "an image"])
def test_a_package_that_does_not_begin_with_a_layer_is_refused(place, refused, files):
    path = place.folder / "p.usdz"
    with zipfile.ZipFile(path, "w") as written:
        for name, content in files.items():
            written.writestr(name, content)
    assert ("is no file of USD" if files else "a package") in refused(path)


def test_text_in_a_package_that_is_nested_too_deeply_is_refused(package, library, tmp_path):
    path = package(**{"s.usda": LAYER + 'def "a" {\n' * 100_000})
    with pytest.raises(ReadError) as caught:
        read(path, Reach.beside(path), library, tmp_path / "outside")
    assert caught.value.finding.code == "READ_TOO_DEEP"


def test_what_usds_validators_say_of_a_package_is_said(place):
    path = place.folder / "p.usdz"
    with zipfile.ZipFile(path, "w") as written:
        written.writestr(
            "s.usda", '#usda 1.0\n(\n defaultPrim = "a"\n metersPerUnit = 1\n upAxis = "Y"\n)\ndef "a" {\n}\n'
        )
        written.writestr("b.gif", b"x")
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    said = [finding.message for finding in result.findings if finding.code == "USD_VALIDATOR"]
    kinds = [message.split(":")[1].split(".")[1] for message in said]
    assert kinds == ["UnsupportedFileExtensionInPackage", "ByteMisalignment", "ByteMisalignment"]
    assert "File 'b.gif' in package 'p.usdz' has an unknown unsupported extension 'gif'." in said[0]


def test_damaged_packages_give_findings_and_no_error_of_a_library(place, library, tmp_path):
    path = place.folder / "p.usdz"
    with zipfile.ZipFile(path, "w") as written:
        written.writestr("s.usda", LAYER)
        written.writestr("a.png", b"x" * 50)
        written.writestr("b.png", b"y" * 50, zipfile.ZIP_DEFLATED)
    whole = path.read_bytes()
    rng = random.Random(2026)
    for number in range(300):
        data = bytearray(whole)
        for _ in range(rng.choice([1, 2, 8])):
            data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(data[: rng.choice([len(data), rng.randrange(4, len(data))])])
        folder = tmp_path / f"unpacked{number}"
        folder.mkdir()
        with contextlib.suppress(ReadError):
            packages.unpack(path, folder, "")


def test_names_beyond_ascii_were_read_as_those_of_another_code_page(library, tmp_path, surface_document):
    # The names in packages that USD makes are UTF-8, and do not say so.
    (tmp_path / "tex").mkdir()
    write_image(tmp_path / "tex" / "\u00e4.png", np.zeros((2, 2, 3), np.uint8), {})
    image = '<image name="i" type="color3"><input name="file" type="filename" value="tex/\u00e4.png"/></image>'
    color = '<input name="color" type="color3" nodename="i"/>'
    lobe = f'<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">{color}</oren_nayar_diffuse_bsdf>'
    source = Document(materialx=surface_document(image + lobe), path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path))
    path = tmp_path / "na\u00efve.usdz"
    format_for(path).write(source, path, library)
    (tmp_path / "tex" / "\u00e4.png").unlink()
    with zipfile.ZipFile(path) as found:
        assert found.namelist() == ["na\u00efve.usdc", "na\u00efve/tex/\u00e4.png"]
    unflagged = bytearray(path.read_bytes())
    for signature, at in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        start = -1
        while (start := unflagged.find(signature, start + 1)) >= 0:
            struct.pack_into("<H", unflagged, start + at, 0)
    path.write_bytes(unflagged)
    (tmp_path / "scratch").mkdir()
    again = read(path, Reach.beside(path), library, tmp_path / "scratch")
    assert again.reach.regular(again.materialx.getNode("i").getInput("file").getValueString()) is not None
