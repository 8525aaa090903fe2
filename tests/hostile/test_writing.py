"""Full disks, planted links and neighbours: what writing destroyed, or called written."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import read_image, write_image
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.system.writing import FileSet, replacing
from mrm_mtlx.validation.checks.files import check_files

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Bytes after which a disk is full here, less than any file that is written in these tests.
ROOM = 300


@contextlib.contextmanager
def full_after(size: int) -> Iterator[None]:
    """No file of this process grows beyond so many bytes: as on a full disk, but for the words."""
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def good(tmp_path) -> Callable[[str], Path]:
    """Function from a name to a file of this name that is precious, alone in a folder."""

    def make(name: str) -> Path:
        folder = tmp_path / "precious"
        folder.mkdir()
        (folder / name).write_bytes(b"as it was")
        return folder / name

    return make


def assert_untouched(path: Path) -> None:
    assert path.read_bytes() == b"as it was"
    assert [each.name for each in path.parent.iterdir()] == [path.name]


PIXELS = np.random.default_rng(1).integers(0, 256, (64, 64, 3), dtype=np.uint8)


# Full disks -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("room", [0, ROOM, 5000])
@pytest.mark.parametrize(
    ("name", "pixels"), [("a.png", PIXELS), ("a.exr", (PIXELS / 255.0).astype(np.float16))], ids=["png", "exr"]
)
def test_a_picture_on_a_full_disk_was_a_stump_and_called_written(good, name, pixels, room):
    path = good(name)
    with full_after(room), pytest.raises(OSError):  # noqa: PT011  # which of its calls fails is the format's
        write_image(path, pixels, {})
    assert_untouched(path)
    write_image(path, pixels, {})
    stored = pixels / 255.0 if pixels.dtype == np.uint8 else pixels
    np.testing.assert_allclose(read_image(path), stored, rtol=2**-23)  # rounded to float32 once


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_rendering_to_a_full_disk_replaced_a_good_picture(gl, good, repository, monkeypatch, capsys, name):
    from mrm_mtlx.cli.main import command

    path, document = good(name), repository / "materials" / "licence_plate.mtlx"
    monkeypatch.setattr(sys, "argv", ["mrm", "render", str(document), "-o", str(path), "--size", "64"])
    with full_after(ROOM):
        assert command() == 2
    assert "wrote" not in capsys.readouterr().err
    assert_untouched(path)


@pytest.mark.parametrize("name", ["a.png", "a.svg", "a.pdf"])
def test_a_plot_on_a_full_disk_replaced_a_good_one(good, name):
    from matplotlib.figure import Figure

    from mrm_mtlx.plots import drawing

    figure, path = Figure(), good(name)
    figure.subplots().plot([0.0, 1.0])
    with full_after(ROOM), pytest.raises(ValueError, match="cannot be written"):
        drawing.save(figure, path)
    assert_untouched(path)


@pytest.mark.parametrize("name", ["a.mtlx", "a.usda", "a.usdc", "a.usdz", "a.gltf", "a.glb"])
def test_a_document_on_a_full_disk_replaced_a_good_one(good, surface_document, library, tmp_path, name):
    document = surface_document('<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"/>')
    path, source = good(name), Document(materialx=document, path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path))
    with full_after(ROOM), pytest.raises(OSError):  # noqa: PT011
        format_for(path).write(source, path, library)
    assert_untouched(path)
    format_for(path).write(source, path, library)
    assert path.stat().st_size > ROOM


def test_a_device_that_is_full_took_a_picture(full_disk, link, tmp_path):
    with pytest.raises(OSError, match="No space left"):
        write_image(link(tmp_path / "a.png", full_disk), PIXELS, {})


def test_a_picture_goes_through_a_pipe_whole(tmp_path):
    os.mkfifo(tmp_path / "a.png")
    reader = os.open(tmp_path / "a.png", os.O_RDONLY | os.O_NONBLOCK)
    write_image(tmp_path / "a.png", PIXELS[:8, :8], {})
    (tmp_path / "b.png").write_bytes(os.read(reader, 1 << 16))
    os.close(reader)
    assert read_image(tmp_path / "b.png").shape == (8, 8, 3)


# Links ----------------------------------------------------------------------------------------------------------------


def test_an_unfinished_file_had_a_name_that_could_be_foreseen(tmp_path, link):
    # Where others may write, as in /tmp, a link under that name leads what is written to a file of theirs to choose.
    victim = tmp_path / "victim"
    victim.write_text("as it was", encoding="utf-8")
    for name in (f".a.{os.getpid()}.png", f"a.{os.getpid()}.png"):
        link(tmp_path / name, victim)
    write_image(tmp_path / "a.png", PIXELS, {})
    assert victim.read_text(encoding="utf-8") == "as it was"


def test_a_link_under_the_very_name_is_not_followed(tmp_path, link, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("as it was", encoding="utf-8")
    monkeypatch.setattr(secrets, "token_hex", lambda _count: "known")
    link(tmp_path / ".mrm-known.txt", victim)
    with pytest.raises(FileExistsError), replacing(tmp_path / "a.txt") as unfinished:
        unfinished.write_text("new", encoding="utf-8")
    assert victim.read_text(encoding="utf-8") == "as it was"


@pytest.mark.skipif(os.name == "nt", reason="permissions of another kind")
def test_a_file_has_the_permissions_of_any_other(tmp_path):
    def mode(path: Path) -> int:
        return stat.S_IMODE(path.stat().st_mode)

    before = os.umask(0o027)
    try:
        with replacing(tmp_path / "a.txt") as unfinished:
            unfinished.write_text("new", encoding="utf-8")
        with FileSet(tmp_path) as files:
            files.named(tmp_path / "b.txt").write_text("new", encoding="utf-8")
    finally:
        os.umask(before)
    assert (mode(tmp_path / "a.txt"), mode(tmp_path / "b.txt")) == (0o640, 0o640)
    (tmp_path / "a.txt").chmod(0o604)
    with replacing(tmp_path / "a.txt") as unfinished:
        unfinished.write_text("newer", encoding="utf-8")
    assert mode(tmp_path / "a.txt") == 0o604


# Sets of files --------------------------------------------------------------------------------------------------------

IMAGES = """
  <image name="i" type="color3"><input name="file" type="filename" value="../tex/a.png"/></image>
  <image name="j" type="color3"><input name="file" type="filename" value="../tex/b.png"/></image>
  <add name="both" type="color3"><input name="in1" type="color3" nodename="i"/>
    <input name="in2" type="color3" nodename="j"/></add>"""
COLOR = '<input name="color" type="color3" nodename="both"/>'


@pytest.fixture
def project(surface_document, tmp_path) -> Document:
    """A document with two images, which are copied beside whatever is written elsewhere."""
    for name in ("a", "b"):
        (tmp_path / "project" / "tex").mkdir(parents=True, exist_ok=True)
        write_image(tmp_path / "project" / "tex" / f"{name}.png", PIXELS, {})
    (tmp_path / "project" / "mat").mkdir()
    (tmp_path / "out").mkdir()
    lobe = f'<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">{COLOR}</oren_nayar_diffuse_bsdf>'
    reach = Reach(tmp_path / "project" / "mat", tmp_path / "project")
    return Document(materialx=surface_document(IMAGES + lobe), path=reach.folder / "a.mtlx", reach=reach)


def contents(folder: Path) -> dict[str, bytes]:
    """Bytes of all files below a folder, by name; folders have none."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else b""
        for path in sorted(folder.rglob("*"))
    }


def write_to(project: Document, path: Path, library, **how: bool) -> None:
    format_for(path).write(project, path, library, **how)


def test_converting_overwrote_a_picture_of_the_user_without_a_word(project, library, tmp_path):
    out = tmp_path / "out"
    (out / "X" / "tex").mkdir(parents=True)
    (out / "X" / "tex" / "a.png").write_bytes(b"a week's work")
    before = contents(out)
    with pytest.raises(FileExistsError, match=r"already there, with other content: X/tex/a\.png; `force` replaces"):
        write_to(project, out / "X.usda", library)
    assert contents(out) == before
    write_to(project, out / "X.usda", library, force=True)
    assert contents(out)["X/tex/a.png"] == contents(tmp_path / "project")["tex/a.png"]


def test_converting_overwrote_an_unrelated_binary_without_a_word(surface_document, library, tmp_path):
    plain = surface_document('<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"/>')
    project = Document(materialx=plain, path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path))
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "X.bin").write_bytes(b"a firmware")
    (tmp_path / "out" / "X.gltf").write_bytes(b"named by the user")
    with pytest.raises(FileExistsError, match=r"X\.bin"):
        write_to(project, tmp_path / "out" / "X.gltf", library)
    assert contents(tmp_path / "out") == {"X.bin": b"a firmware", "X.gltf": b"named by the user"}
    write_to(project, tmp_path / "out" / "X.gltf", library, force=True)
    assert contents(tmp_path / "out")["X.bin"] != b"a firmware"


def test_what_was_written_before_is_written_again_without_force(project, library, tmp_path):
    for name in ("X.usda", "X.mtlx"):
        write_to(project, tmp_path / "out" / name, library)
        before = contents(tmp_path / "out")
        write_to(project, tmp_path / "out" / name, library)
        assert contents(tmp_path / "out") == before
    assert "X/tex/b.png" in before


@pytest.mark.parametrize("name", ["X.usda", "X.usdc", "X.mtlx", "X.gltf"])
def test_a_set_that_changed_needed_force_to_replace_itself(library, tmp_path, name):
    # What the file that is replaced names is replaced with it, and nothing else.
    (tmp_path / "project").mkdir()
    (tmp_path / "out" / "X").mkdir(parents=True)
    image = '<image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>'
    surface = (
        '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>'
        '<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )
    document = mx.createDocument()
    mx.readFromXmlString(document, f'<?xml version="1.0"?><materialx version="1.39">{image}{surface}</materialx>')
    document.setDataLibrary(library.document)
    source = Document(materialx=document, path=tmp_path / "project" / "a.mtlx", reach=Reach.only(tmp_path / "project"))
    write_image(tmp_path / "project" / "a.png", PIXELS, {})
    write_to(source, tmp_path / "out" / name, library)
    before = contents(tmp_path / "out")
    write_image(tmp_path / "project" / "a.png", 255 - PIXELS, {})
    write_to(source, tmp_path / "out" / name, library)
    after = contents(tmp_path / "out")
    assert after.keys() == before.keys()
    assert [key for key in after if key.endswith(".png") and after[key] != before[key]]
    (tmp_path / "out" / name).write_bytes(b"@X/a.png@ <materialx> X/a.png" * 99)
    write_image(tmp_path / "project" / "a.png", PIXELS, {})
    with pytest.raises(FileExistsError, match="`force` replaces such"):
        write_to(source, tmp_path / "out" / name, library)


@pytest.mark.parametrize("name", ["X.usda", "X.usdc", "X.mtlx"])
def test_a_failure_in_the_middle_left_half_a_set(project, library, tmp_path, monkeypatch, name):
    out = tmp_path / "out"
    (out / name).write_bytes(b"as it was")
    (out / "X" / "tex").mkdir(parents=True)
    (out / "X" / "tex" / "a.png").write_bytes(b"a week's work")
    before, replace, moved = contents(out), type(out).replace, []

    def fails_at_the_third(path: Path, target: Path) -> Path:
        moved.append(target)
        if len(moved) == 3:
            raise OSError(5, "Input/output error")
        return replace(path, target)

    with monkeypatch.context() as broken:
        broken.setattr(type(out), "replace", fails_at_the_third)
        with pytest.raises(OSError, match="Input/output error"):
            write_to(project, out / name, library, force=True)
    assert len(moved) == 3
    assert contents(out) == before


def test_a_failure_takes_folders_away_that_were_made(project, library, tmp_path):
    out = tmp_path / "out"
    (out / "X.usda").mkdir()
    with pytest.raises(OSError, match="not a regular file"):
        write_to(project, out / "X.usda", library)
    (out / "X.usda").rmdir()
    with full_after(5000), pytest.raises(OSError, match="File too large"):
        write_to(project, out / "X.usda", library)
    assert contents(out) == {}


def test_a_failure_at_the_last_file_takes_folders_away_that_were_made(tmp_path, monkeypatch):
    sync, calls = os.fsync, []

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", full)

    def write() -> None:
        with FileSet(tmp_path) as files:
            files.beside(tmp_path / "made" / "inside" / "a").write_text("new", encoding="utf-8")
            files.named(tmp_path / "b").write_text("new", encoding="utf-8")

    with pytest.raises(OSError, match="No space left"):
        write()
    assert contents(tmp_path) == {}


def test_what_names_the_other_files_is_written_last(tmp_path, monkeypatch):
    moved, replace = [], type(tmp_path).replace

    def noted(path: Path, target: Path) -> Path:
        moved.append(target.name)
        return replace(path, target)

    monkeypatch.setattr(type(tmp_path), "replace", noted)
    with FileSet(tmp_path) as files:
        files.named(tmp_path / "a.gltf").write_text("new", encoding="utf-8")
        files.beside(tmp_path / "a.bin").write_text("new", encoding="utf-8")
    assert moved == ["a.bin", "a.gltf"]


def test_a_writer_that_writes_nothing_does_not_replace_a_file_by_an_empty_one(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("as it was", encoding="utf-8")
    with pytest.raises(FileNotFoundError, match="nothing was written"), replacing(path):
        pass
    assert contents(tmp_path) == {"a.txt": b"as it was"}


def test_an_interrupt_between_two_files_loses_neither(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / name).write_text("as it was", encoding="utf-8")
    sync, calls = os.fsync, []

    def interrupted(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 2:
            raise KeyboardInterrupt
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", interrupted)

    def write() -> None:
        with FileSet(tmp_path) as files:
            for name in ("a", "b"):
                files.named(tmp_path / name).write_text("new", encoding="utf-8")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert contents(tmp_path) == {"a": b"as it was", "b": b"as it was"}


def test_a_folder_that_is_a_link_led_copies_elsewhere(project, library, tmp_path, link):
    (tmp_path / "elsewhere").mkdir()
    link(tmp_path / "out" / "X", tmp_path / "elsewhere")
    with pytest.raises(OSError, match="a folder on the way is a link"):
        write_to(project, tmp_path / "out" / "X.usda", library, force=True)
    assert contents(tmp_path / "elsewhere") == {}


def test_a_relative_path_had_no_place_for_a_copy(tmp_path, monkeypatch):
    # The folder of the copies was looked for beside the unfinished files only if the path was absolute.
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    with FileSet(Path("out")) as files:
        files.named(Path("out", "X.gltf")).write_text("main", encoding="utf-8")
        files.beside(Path("out", "X", "tex", "a.png")).write_text("copy", encoding="utf-8")
    assert contents(tmp_path / "out") == {"X": b"", "X/tex": b"", "X/tex/a.png": b"copy", "X.gltf": b"main"}


def test_a_link_at_the_place_of_a_copy_was_written_through(project, library, tmp_path, link):
    victim = tmp_path / "victim"
    victim.write_bytes(b"as it was")
    link(tmp_path / "out" / "X" / "tex" / "a.png", victim)
    with pytest.raises(FileExistsError, match=r"X/tex/a\.png"):
        write_to(project, tmp_path / "out" / "X.usda", library)
    write_to(project, tmp_path / "out" / "X.usda", library, force=True)
    assert victim.read_bytes() == b"as it was"


def test_the_named_file_may_be_a_link_that_keeps_leading_where_it_led(project, library, tmp_path, link):
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "real.usda").write_bytes(b"older")
    link(tmp_path / "out" / "X.usda", tmp_path / "store" / "real.usda")
    write_to(project, tmp_path / "out" / "X.usda", library)
    assert (tmp_path / "out" / "X.usda").is_symlink()
    assert (tmp_path / "store" / "real.usda").read_bytes().startswith(b"#usda")
    assert sorted(contents(tmp_path / "store")) == ["real.usda"]


def test_sources_of_several_stages_are_written_all_or_none(repository, tmp_path, monkeypatch, capsys):
    from mrm_mtlx.cli.main import command

    document = repository / "materials" / "licence_plate.mtlx"
    monkeypatch.setattr(sys, "argv", ["mrm", "generate", str(document), "-o", str(tmp_path / "out")])
    with full_after(3000):
        assert command() == 2
    assert "wrote" not in capsys.readouterr().err
    assert contents(tmp_path / "out") == {}
    assert command() == 0
    assert len(contents(tmp_path / "out")) == 2


# Sets of tiles --------------------------------------------------------------------------------------------------------


@pytest.fixture
def tiled(surface_document, tmp_path) -> Document:
    """A document with a set of tiles, of which the first is a picture."""
    (tmp_path / "project").mkdir()
    (tmp_path / "out").mkdir()
    write_image(tmp_path / "project" / "t.1001.png", PIXELS, {})
    image = '<image name="both" type="color3"><input name="file" type="filename" value="t.&lt;UDIM&gt;.png"/></image>'
    lobe = f'<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">{COLOR}</oren_nayar_diffuse_bsdf>'
    return Document(
        materialx=surface_document(image + lobe),
        path=tmp_path / "project" / "a.mtlx",
        reach=Reach.only(tmp_path / "project"),
    )


@pytest.mark.parametrize("name", ["X.usda", "X.usdz", "X.mtlx"])
def test_a_tile_that_is_a_link_was_copied_from_outside(tiled, library, place, link, tmp_path, name):
    link(tmp_path / "project" / "t.1002.png", place.secrets[".bin"])
    with pytest.raises(ReadError, match=r"'t\.1002\.png' is a link that leads outside") as caught:
        write_to(tiled, tmp_path / "out" / name, library)
    assert caught.value.finding.code == "READ_OUTSIDE"
    assert contents(tmp_path / "out") == {}


def test_a_tile_that_is_a_pipe_is_not_waited_for(tiled, library, pipe, tmp_path):
    pipe(tmp_path / "project" / "t.1002.png")
    with pytest.raises(ReadError, match="not a regular file"):
        write_to(tiled, tmp_path / "out" / "X.usda", library)


def test_tiles_alone_are_copied(tiled, library, link, tmp_path):
    write_image(tmp_path / "project" / "own.png", PIXELS, {})
    (tmp_path / "project" / "t.secret.png").write_bytes(b"no tile")
    link(tmp_path / "project" / "t.1011.png", tmp_path / "project" / "own.png")
    write_to(tiled, tmp_path / "out" / "X.usda", library)
    assert sorted(contents(tmp_path / "out" / "X")) == ["t.1001.png", "t.1011.png"]


def test_a_link_among_tiles_is_a_finding(tiled, library, link, place, tmp_path):
    link(tmp_path / "project" / "t.1002.png", place.secrets[".png"])
    found = check_files(tiled.materialx, tiled.reach, library)
    assert [(f.code, f.location) for f in found] == [("READ_OUTSIDE", "/both/file")]
