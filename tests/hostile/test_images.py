"""Images that took memory without bound, passed though they end too early, or told where they lie."""

from __future__ import annotations

import os
import shutil
import struct
import sys
import threading
import zlib
from typing import TYPE_CHECKING

import numpy as np
import OpenImageIO as oiio
import pytest

from mrm_mtlx.documents import document_images, images
from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.document_images import DocumentImages, ImagesTooLargeError, refuse_excess
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import as_read, read_image, read_stored, stored_bytes, write_image
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from pathlib import Path

PIXELS = np.random.default_rng(2).integers(0, 256, (64, 64, 3), dtype=np.uint8)
# Bytes of one image of these tests, and what all of a surface may take.
ONE, ALLOWED = 64 * 64 * 3, 3 * 64 * 64 * 3


# Memory ---------------------------------------------------------------------------------------------------------------


@pytest.fixture
def four_images(place, document_text) -> Path:
    """A document with a surface that looks at four images, of which memory is meant for three."""
    for index in range(4):
        write_image(place.folder / f"{index}.png", PIXELS, {})
    nodes = "".join(
        f'<image name="i{k}" type="color3"><input name="file" type="filename" value="{k}.png"/></image>'
        f'<add name="a{k}" type="color3"><input name="in1" type="color3" nodename="i{k}"/>'
        + (f'<input name="in2" type="color3" nodename="a{k - 1}"/>' if k else "")
        + "</add>"
        for k in range(4)
    )
    return place.write("four.mtlx", document_text(nodes, '<input name="color" type="color3" nodename="a3"/>'))


@pytest.fixture
def little_memory(monkeypatch) -> None:
    monkeypatch.setattr(document_images, "MAXIMUM_HELD_BYTES", ALLOWED)


def test_many_images_took_more_memory_than_there_is(gl, four_images, little_memory, check):
    (result,) = check(four_images, targets=("glsl", "essl", "osl"))
    assert result.findings == []
    (surface,) = result.renderables
    for target in ("glsl", "essl"):
        found = surface.targets[target]
        assert (found.stage, found.status) == ("compile", "skip")
        assert found.reason.startswith("it has images that take 1 MiB of memory or more; ")
    assert surface.targets["osl"].status in ("pass", "skip")


def test_as_many_as_there_is_memory_for_are_compared(gl, four_images, monkeypatch, check):
    monkeypatch.setattr(document_images, "MAXIMUM_HELD_BYTES", 4 * ONE)
    (surface,) = check(four_images, targets=("glsl",))[0].renderables
    assert (surface.targets["glsl"].stage, surface.targets["glsl"].status) == ("compare", "pass")


def test_one_image_in_many_textures_took_more_memory_than_there_is(gl, four_images, monkeypatch, check):
    for index in range(1, 4):
        shutil.copy(four_images.with_name("0.png"), four_images.with_name(f"{index}.png"))
    monkeypatch.setattr("mrm_mtlx.engines.gl.program.MAXIMUM_TEXTURE_BYTES", 64 * 64 * 4 * 2 * 4 - 1)
    (surface,) = check(four_images, targets=("glsl",))[0].renderables
    found = surface.targets["glsl"]
    assert (found.stage, found.status) == ("compile", "skip")
    assert "images that take, as textures, 1 MiB" in found.reason


def test_sizes_are_known_before_anything_is_decoded(four_images, little_memory, monkeypatch):
    decoded = []
    monkeypatch.setattr(document_images, "read_stored", lambda path: decoded.append(path.name) or read_stored(path))
    held = DocumentImages(Reach.beside(four_images))
    for name in ("0.png", "1.png", "2.png"):
        assert held(name).nbytes == ONE
    for name in ("3.png", "0.png"):
        with pytest.raises(ImagesTooLargeError, match="images that take"):
            held(name)
    assert decoded == ["0.png", "1.png", "2.png"]
    held.start_surface()
    assert held("3.png").nbytes == ONE


def test_what_another_process_is_to_read_is_weighed_by_its_headers(four_images, little_memory):
    reach = Reach.beside(four_images)
    refuse_excess(("0.png", "1.png", "2.png", "0.png", "absent.png"), reach)
    with pytest.raises(ImagesTooLargeError, match="images that take"):
        refuse_excess(("0.png", "1.png", "2.png", "3.png"), reach)
    four_images.with_name("0.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"^0\.png: cannot be read as an image"):
        refuse_excess(("0.png",), reach)


def test_images_are_read_again_after_they_were_released(four_images, little_memory):
    held = DocumentImages(Reach.beside(four_images))
    four_images.with_name("3.png").write_bytes(b"no picture")
    for _ in range(2):
        assert (held("0.png").nbytes, held("3.png"), held("absent.png")) == (ONE, None, None)
        held.release()
    assert len(held.problems) == 1


def test_the_images_of_the_surface_before_make_room(four_images, little_memory):
    held = DocumentImages(Reach.beside(four_images))
    for names in (("0.png", "1.png", "2.png"), ("3.png", "0.png"), ("1.png", "2.png", "3.png")):
        held.start_surface()
        assert [held(name).nbytes for name in names] == [ONE] * len(names)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (("render", "four.mtlx", "-o", "a.png", "--size", "16"), 2),
        (("photometry", "four.mtlx"), 1),
        (("plot", "four.mtlx", "-o", "a.png"), 3),
        (("convert", "four.mtlx", "a.json"), 2),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_a_command_took_more_memory_than_there_is(
    gl, four_images, little_memory, monkeypatch, capsys, arguments, status
):
    from typer.testing import CliRunner

    from mrm_mtlx.cli.main import app

    monkeypatch.chdir(four_images.parent)
    monkeypatch.setenv("COLUMNS", "300")
    done = CliRunner().invoke(app, arguments, prog_name="mrm")
    assert done.exit_code == status, done.output
    assert "has images that take 1 MiB of memory or more" in done.output
    assert not four_images.with_name("a.png").exists()


def test_converting_to_gltf_took_more_memory_than_there_is(make_document, four_images, little_memory, library):
    uses = (("base_color", "color3"), ("metallic", "float"), ("roughness", "float"), ("emissive", "color3"))
    nodes = "".join(
        f'<image name="i{k}" type="{kind}"><input name="file" type="filename" value="{k}.png"/></image>'
        for k, (_, kind) in enumerate(uses)
    )
    inputs = "".join(f'<input name="{n}" type="{kind}" nodename="i{k}"/>' for k, (n, kind) in enumerate(uses))
    material = (
        f'{nodes}<gltf_pbr name="s" type="surfaceshader">{inputs}</gltf_pbr><surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )
    source = Document(materialx=make_document(material), path=four_images, reach=Reach.beside(four_images))
    path = four_images.with_name("a.glb")
    lost = {finding.location: finding.message for finding in format_for(path).write(source, path, library)}
    assert lost["/m/emissive"].startswith("it has images that take")
    assert lost["/m"].startswith("it was written and not compared: it has images that take")


def test_numbers_are_those_that_were_read_before(tmp_path):
    for kind, ending in ((np.uint8, "png"), (np.uint16, "png"), (np.float16, "exr"), (np.float32, "exr")):
        for channels in range(1, 5):
            values = np.random.default_rng(3).integers(0, 256, (5, 7, channels))
            stored = values.astype(kind) if ending == "png" else (values / 255.0).astype(kind)
            path = tmp_path / f"a.{ending}"
            write_image(path, stored, {})
            found = read_stored(path)
            assert found.dtype == kind
            assert np.array_equal(found, stored)
            assert stored_bytes(path) == stored.nbytes
            for components in range(1, 5):
                assert np.array_equal(as_read(found, components), as_read(read_image(path), components))


# Damage ---------------------------------------------------------------------------------------------------------------


def saved(path: Path, pixels: np.ndarray = PIXELS, **attributes: object) -> bytes:
    kind = oiio.FLOAT if path.suffix in (".exr", ".hdr") else oiio.UINT8
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    for name, value in attributes.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image((pixels / 255.0).astype(np.float32))
    assert output.close()
    return path.read_bytes()


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
@pytest.mark.parametrize(
    "ending", ["jpg", "png", "exr", "tif", "hdr", "tga", "bmp", "webp", "ppm", "sgi", "dpx", "iff"]
)
def test_a_picture_that_ends_too_early_passed_for_a_whole_one(tmp_path, capfd, ending, share):
    path = tmp_path / f"a.{ending}"
    content = saved(path)
    assert read_stored(path).shape == (64, 64, 3)
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ValueError, match=rf"^a\.{ending}: cannot be ") as caught:
        read_stored(path)
    assert str(tmp_path) not in str(caught.value)
    assert str(caught.value).isprintable()
    assert capfd.readouterr() == ("", "")


def test_a_jpeg_with_padding_in_it_is_whole(tmp_path):
    path = tmp_path / "a.jpg"
    content = saved(path)
    before = read_stored(path)
    # libjpeg calls this "extraneous bytes before marker", and has all pixels.
    path.write_bytes(content[:-2] + bytes(7) + content[-2:])
    assert np.array_equal(read_stored(path), before)


def test_a_jpeg_with_a_hole_passed_for_a_whole_one(tmp_path):
    path = tmp_path / "a.jpg"
    content = saved(path)
    path.write_bytes(content[:2000] + content[5000:])
    with pytest.raises(ValueError, match=r"^a\.jpg: cannot be decoded"):
        read_stored(path)


# Formats --------------------------------------------------------------------------------------------------------------


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


BOMBS = {
    "b.null": b"",
    "b.null?RES=16384x16384&CHANNELS=4": b"?",
    "b.svg": b'<svg xmlns="http://www.w3.org/2000/svg" width="99999" height="99999"/>',
    "b.ptx": b"Ptex" + bytes(200),
    "b.gif": b"GIF89a\xff\xff\xff\xff" + bytes(20),
    "b.zfile": b"\x2f\x08\x67\xab" + bytes(200),
    "b.pic": b"\x53\x80\xf6\x34" + bytes(200),
    "b.fits": b"SIMPLE  =                    T" + bytes(3000),
    "b.tga.txt": b"nothing",
    "b.png": b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2**31 - 1, 2**31 - 1, 8, 2, 0, 0, 0)),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_decoder_was_asked_that_no_texture_needs(tmp_path, name, capfd):
    (tmp_path / name).write_bytes(BOMBS[name])
    with pytest.raises(ValueError, match=r"cannot be read as an image|more than are read"):
        read_stored(tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_the_name_does_not_say_what_a_file_is(tmp_path):
    saved(tmp_path / "a.png")
    for name in ("a.exr", "a", "a.tga", "a.jpg?x=1"):
        shutil.copy(tmp_path / "a.png", tmp_path / name)
        assert np.array_equal(read_stored(tmp_path / name), PIXELS)


def test_a_tile_larger_than_its_image_took_memory(tmp_path):
    path = tmp_path / "a.exr"
    spec = oiio.ImageSpec(64, 64, 3, oiio.HALF)
    spec.tile_width = spec.tile_height = 64
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(PIXELS / np.float32(255.0))
    output.close()
    assert read_stored(path).shape == (64, 64, 3)
    content = path.read_bytes()
    at = content.index(b"tiledesc\0") + len(b"tiledesc\0") + 4
    path.write_bytes(content[:at] + struct.pack("<II", 1 << 24, 1 << 24) + content[at + 8 :])
    with pytest.raises(ValueError, match=r"^a\.exr: "):
        read_stored(path)


def test_a_deep_image_is_refused(tmp_path):
    path = tmp_path / "deep.exr"
    spec = oiio.ImageSpec(4, 4, 4, oiio.FLOAT)
    spec.channelnames = ("R", "G", "B", "A")
    spec.deep = True
    data = oiio.DeepData()
    data.init(16, 4, oiio.FLOAT, ("R", "G", "B", "A"))
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_deep_image(data)
    output.close()
    with pytest.raises(ValueError, match=r"it is deep"):
        read_stored(path)


def test_a_file_as_large_as_memory_is_not_begun(tmp_path, monkeypatch):
    saved(tmp_path / "a.png")
    monkeypatch.setattr(images, "MAXIMUM_FILE_BYTES", 1000)
    with pytest.raises(ValueError, match=r"^a\.png: a file of more than"):
        read_stored(tmp_path / "a.png")


def test_a_pipe_for_an_image_is_not_waited_for(tmp_path, pipe):
    pipe(tmp_path / "a.png")
    with pytest.raises(ValueError, match="it is no file"):
        read_stored(tmp_path / "a.png")


# What is printed ------------------------------------------------------------------------------------------------------


def test_threads_that_are_silent_together_gave_the_terminal_back_too_early(capfd):
    inside, ended = threading.Barrier(2), threading.Barrier(2)

    def first() -> None:
        with silenced():
            inside.wait()
            ended.wait()
            os.write(2, b"second half")

    thread = threading.Thread(target=first)
    thread.start()
    with silenced():
        inside.wait()
        os.write(2, b"first half")
    ended.wait()
    thread.join()
    os.write(2, b"after")
    sys.stderr.flush()
    assert capfd.readouterr().err == "after"
