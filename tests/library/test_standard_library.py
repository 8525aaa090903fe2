"""The standard library of a host: found in its folder, told apart by version, read and never run."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import MaterialX as mx
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library import standard_library, wheel
from mrm_mtlx.library.hosts import Evidence, Host
from mrm_mtlx.library.standard_library import FIRST_DEFINED, StandardLibraryError, find, given, version_of_folder

LIBRARIES = Path(mx.__file__).parent / "libraries"
INSTALLED = mx.getVersionString()


@pytest.fixture
def older(tmp_path) -> Path:
    """A standard library that lacks what 1.39.5 has got: 1.39.4 by its definitions, in a host's folder."""
    folder = tmp_path / "host" / "share" / "materialx" / "libraries"
    for part in standard_library.PARTS:
        shutil.copytree(LIBRARIES / part, folder / part, ignore=shutil.ignore_patterns("gen*"))
    for path in folder.rglob("*.mtlx"):
        path.write_text(path.read_text(encoding="utf-8").replace(FIRST_DEFINED["1.39.5"], "ND_other"), encoding="utf-8")
    return folder


def test_the_installed_one_is_found_and_is_of_its_version():
    found = standard_library.installed(INSTALLED)
    assert found is not None
    assert (found.folder, found.version) == (LIBRARIES, INSTALLED)
    assert standard_library.installed("1.39.0") is None


def test_each_version_is_told_by_what_it_has_got_first(older):
    assert version_of_folder(older) == "1.39.4"
    for name in FIRST_DEFINED.values():
        for path in older.rglob("*.mtlx"):
            path.write_text(path.read_text(encoding="utf-8").replace(f'"{name}"', '"ND_other"'), encoding="utf-8")
    assert version_of_folder(older) == ""


@pytest.mark.versions
@pytest.mark.parametrize("version", [v for v in FIRST_DEFINED if v != "1.39.6"])
def test_versions_are_told_apart_as_they_are(with_materialx, version):
    python = with_materialx(version)
    assert given(python.parents[1], version).version == version


def test_the_folder_of_a_host_is_searched_and_the_topmost_counts(older, tmp_path):
    shutil.copytree(older, older / "again" / "libraries")
    assert find(tmp_path / "host") == older
    assert find(older) == older
    assert find(older / "pbrlib") is None


def test_a_folder_that_is_a_link_is_not_followed(older, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "link").symlink_to(tmp_path / "host")
    assert find(tmp_path / "elsewhere") is None


def test_a_search_ends(tmp_path, monkeypatch, older):
    monkeypatch.setattr(standard_library, "_MOST_FOLDERS", 2)
    assert find(tmp_path / "host") is None


def test_a_host_is_looked_for_where_it_commonly_is(older, tmp_path):
    host = Host("x", "X", "1.39.4", Evidence.ASSUMED, places=(str(tmp_path / "ho*"),))
    found = standard_library.of_hosts([host], "1.39.4")
    assert found is not None
    assert found.folder == older
    assert standard_library.of_hosts([host], INSTALLED) is None


# What a user may get wrong.


def refused(folder: Path, **keywords) -> str:
    with pytest.raises(mrm.ArgumentError) as caught:
        mrm.install_library(folder / "hosts", **keywords)
    assert not (folder / "hosts").exists()
    return str(caught.value)


def test_a_folder_without_pbrlib_is_refused(older, tmp_path):
    shutil.rmtree(older / "pbrlib")
    said = refused(tmp_path, stdlib=tmp_path / "host")
    assert said.startswith("stdlib: no standard library of MaterialX in ")
    assert "expected a folder that holds stdlib, pbrlib, bxdf" in said


def test_a_folder_that_is_none_is_refused(tmp_path):
    assert refused(tmp_path, stdlib=tmp_path / "nowhere").endswith("nowhere' is no folder")


def test_a_standard_library_of_another_version_is_refused(older, tmp_path):
    said = refused(tmp_path, stdlib=older, host="blender-5.0")
    assert "is of MaterialX 1.39.4, and 1.39.3 is needed" in said
    assert mrm.install_library(tmp_path / "hosts", stdlib=older, materialx="1.39.4", host="blender-5.0")


def test_without_a_version_that_of_the_folder_counts_where_the_host_has_none(older, tmp_path):
    assert mrm.install_library(tmp_path / "hosts", stdlib=older).version == "1.39.4"


@pytest.mark.parametrize("version", ["1.38.10", "1.40.0", "1.39.77", "1.39", "newest"])
def test_a_version_that_is_not_served_is_refused(tmp_path, version):
    said = refused(tmp_path, materialx=version)
    assert said.startswith("materialx: ")
    assert version in said


def test_a_file_that_is_no_document_is_refused(older, tmp_path):
    (older / "bxdf" / "gltf_pbr.mtlx").write_text("<materialx", encoding="utf-8")
    assert "gltf_pbr.mtlx' is no MaterialX document" in refused(tmp_path, stdlib=older, materialx="1.39.4")


def test_a_file_is_not_read_to_no_end(older, tmp_path, monkeypatch):
    monkeypatch.setattr(standard_library, "_LARGEST_FILE", 1 << 10)
    assert "more than 0 MB" in refused(tmp_path, stdlib=older, materialx="1.39.4")


def test_a_pipe_is_not_waited_for(older, tmp_path):
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes here")
    (older / "bxdf" / "standard_surface.mtlx").unlink()
    os.mkfifo(older / "bxdf" / "standard_surface.mtlx")
    os.mkfifo(older / "pbrlib" / "more.mtlx")
    installed = mrm.install_library(tmp_path / "hosts", stdlib=older, materialx="1.39.4")
    assert installed.left_out == {"standard_surface": "this MaterialX has no 'standard_surface'"}


def test_what_a_file_would_include_is_not_read(older, tmp_path):
    (tmp_path / "secret.mtlx").write_text(
        '<materialx><nodedef name="ND_secret" node="x"/></materialx>', encoding="utf-8"
    )
    for path in (older / "bxdf").glob("*.mtlx"):
        text = path.read_text(encoding="utf-8").replace(
            "</materialx>", '<xi:include href="../../../../../secret.mtlx"/>'
        )
        path.write_text(
            text.replace("<materialx ", '<materialx xmlns:xi="http://www.w3.org/2001/XInclude" ') + "</materialx>"
        )
    installed = mrm.install_library(tmp_path / "hosts", stdlib=older, materialx="1.39.4")
    assert not any("secret" in path.read_text(encoding="utf-8", errors="replace") for path in installed.files)


# From a wheel.

OF_NO_HOST = "1.39.1"


def test_without_the_package_index_the_message_says_what_else_there_is(tmp_path, monkeypatch):
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    constraints = tmp_path / "constraints.txt"
    constraints.write_text("MaterialX==1.39.5\n", encoding="utf-8")
    monkeypatch.setenv("PIP_CONSTRAINT", str(constraints))  # of the environment here: not what the fetch is about
    said = refused(tmp_path, materialx=OF_NO_HOST, host="quiltix")
    assert "its wheel could not be fetched (ERROR: No matching distribution found" in said
    assert "`stdlib`" in said


def test_a_package_index_that_does_not_answer_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(wheel, "_LONGEST_S", 0.001)
    assert "(not finished within 0 s)" in refused(tmp_path, materialx=OF_NO_HOST, host="quiltix")


def test_without_pip_and_uv_the_message_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(wheel.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(wheel.shutil, "which", lambda _: None)
    with pytest.raises(StandardLibraryError, match="neither pip nor uv"):
        wheel.fetched("1.39.3", tmp_path)


@pytest.mark.versions
@pytest.mark.parametrize("tool", ["pip", "uv"])
def test_a_wheel_is_fetched_for_its_data(tmp_path, monkeypatch, tool):
    if tool == "uv":
        if shutil.which("uv") is None:
            pytest.skip("uv is not installed")
        monkeypatch.setattr(wheel.importlib.util, "find_spec", lambda _: None)
    found = wheel.fetched("1.39.2", tmp_path)
    assert (found.version, found.origin) == ("1.39.2", "the wheel of MaterialX 1.39.2")
