"""The node library in other MaterialX hosts: MaterialX's own script stands for them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import MaterialX as mx
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library import materials_folder, node_library_folder
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.library.host_models import FLAG_FILE, MODELS_FILE
from tests.fixtures.versions import own_flag

GENERATE = Path(mx.__file__).parent / "_scripts" / "generateshader.py"

TIME_LIMIT_S = 60

DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39">
  <conductor_bsdf name="metal" type="BSDF">
    <input name="retroreflective" type="boolean" value="true" />
  </conductor_bsdf>
  <surface name="shown" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="metal" /></surface>
  <surfacematerial name="tape" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="shown" />
  </surfacematerial>
</materialx>
"""


def contents(folder: Path) -> dict[str, bytes]:
    """Files of a folder by relative path."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_what_is_written_is_the_node_library_and_the_surface_models(tmp_path):
    installed = mrm.install_library(tmp_path)
    found = contents(tmp_path / "mrm")
    assert found.keys() == {*node_library_files(mx.getVersionString()), MODELS_FILE}
    assert {name: found[name] for name in node_library_files(mx.getVersionString())} == node_library_files(
        mx.getVersionString()
    )
    assert installed.files == tuple(sorted(p for p in tmp_path.rglob("*") if p.is_file()))


def test_installing_again_overwrites_its_own_files_and_nothing_else(tmp_path):
    mrm.install_library(tmp_path)
    before = contents(tmp_path / "mrm")
    (tmp_path / "mrm" / "mrm_defs.mtlx").write_text("old")
    (tmp_path / "mrm" / "note.txt").write_text("of the user")
    (tmp_path / "other.mtlx").write_text("of the user")
    mrm.install_library(tmp_path)
    assert contents(tmp_path / "mrm") == before | {"note.txt": b"of the user"}
    assert (tmp_path / "other.mtlx").read_text() == "of the user"


def test_what_another_host_had_there_and_this_one_has_not_is_removed(tmp_path):
    files = tmp_path / "mrm"
    (files / "genmsl").mkdir(parents=True)
    for left in (files / FLAG_FILE, files / "genmsl" / "mrm_genmsl_impl.mtlx", files / "genmsl" / "of_the_user.mtlx"):
        left.write_text("of MaterialX 1.39.0")
    mrm.install_library(tmp_path)
    assert not (files / FLAG_FILE).exists()
    assert [p.name for p in (files / "genmsl").iterdir()] == ["of_the_user.mtlx"]
    (files / "genmsl" / "of_the_user.mtlx").rename(files / "genmsl" / "mrm_genmsl_impl.mtlx")
    mrm.install_library(tmp_path)
    assert not (files / "genmsl").exists()


def test_a_destination_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(mrm.ArgumentError, match="taken cannot be written"):
        mrm.install_library(tmp_path / "taken")
    assert (tmp_path / "taken").read_text() == ""


def test_nothing_is_half_written(tmp_path):
    mrm.install_library(tmp_path)
    before = contents(tmp_path)
    (tmp_path / "mrm" / "mrm_ng.mtlx").unlink()
    (tmp_path / "mrm" / "mrm_ng.mtlx").mkdir()  # in the way of a file
    (tmp_path / "mrm" / "mrm_defs.mtlx").write_text("old")
    with pytest.raises(mrm.ArgumentError, match="cannot be written"):
        mrm.install_library(tmp_path)
    left = before | {"mrm/mrm_defs.mtlx": b"old"}
    del left["mrm/mrm_ng.mtlx"]
    assert contents(tmp_path) == left


def test_the_data_folders_exist():
    assert (node_library_folder() / "pbrlib" / "mrm_defs.mtlx").is_file()
    assert materials_folder().is_dir()


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """Function from further arguments of MaterialX's script to the pixel shader it writes."""

    def generate(*arguments: str) -> str:
        folder = tmp_path_factory.mktemp("generated")
        document = folder / "tape.mtlx"
        document.write_text(DOCUMENT)
        run = subprocess.run(
            [sys.executable, str(GENERATE), str(document), *arguments],
            capture_output=True, text=True, check=False, timeout=TIME_LIMIT_S,
        )  # fmt: skip
        assert run.returncode == 0, run.stderr
        return next(folder.glob("tape.*.frag")).read_text()

    return generate


@pytest.mark.parametrize("target", ["glsl", "essl", "msl"])
def test_materialx_finds_the_library_in_place(generated, target):
    source = generated("--target", target, "--path", str(node_library_folder()), "--library", "pbrlib")
    assert "void mrm_conductor_bsdf(" in source
    assert source.count("mrm_conductor_bsdf(") > 1  # defined and called


@pytest.mark.parametrize("target", ["glsl", "essl", "msl"])
def test_materialx_finds_the_installed_library(generated, tmp_path, target):
    mrm.install_library(tmp_path)
    source = generated("--target", target, "--path", str(tmp_path), "--library", "mrm")
    assert "void mrm_conductor_bsdf(" in source
    assert source.count("mrm_conductor_bsdf(") > 1


@own_flag
def test_without_the_library_materialx_uses_its_own(generated):
    source = generated("--target", "glsl")
    assert "mrm_" not in source
    assert "mx_conductor_bsdf(" in source
