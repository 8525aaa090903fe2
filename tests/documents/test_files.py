"""Where the names of files in a document lead."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import pytest

from mrm_mtlx.documents.files import Reach, read_regular


@pytest.fixture
def reach(tmp_path):
    """A folder that is checked, with a file in it and a link that leads out, and two folders to search."""
    for name in ("checked/parts", "first/tex", "second/tex", "elsewhere"):
        (tmp_path / name).mkdir(parents=True)
    for name in ("checked/parts/a.png", "first/tex/b.png", "second/tex/b.png", "second/tex/c.png", "elsewhere/d.png"):
        (tmp_path / name).touch()
    (tmp_path / "checked" / "leads_out.png").symlink_to(tmp_path / "elsewhere" / "d.png")
    return Reach(tmp_path / "checked", tmp_path / "checked", (tmp_path / "first", tmp_path / "second"))


@pytest.mark.parametrize(
    ("name", "inside"),
    [
        ("a.png", True),
        ("parts/a.png", True),
        ("parts/../a.png", True),
        ("", True),
        ("..", False),
        ("../a.png", False),
        ("parts/../../a.png", False),
        ("../checked_too/a.png", False),  # a name that only begins like the folder's
        ("leads_out.png", False),
        ("nul\0.png", False),
        ("n" * 5000, False),
    ],
)
def test_a_name_is_resolved_inside_the_folder_or_not_at_all(reach, name, inside):
    resolved = Reach.only(reach.folder).resolve(name)
    assert (resolved is not None) is inside
    if resolved is not None:
        assert resolved.is_relative_to(reach.folder.resolve())


# A name; where it leads, from the folder that holds all of them.
FOUND = {
    "parts/a.png": "checked/parts/a.png",
    "tex/b.png": "first/tex/b.png",
    "tex/c.png": "second/tex/c.png",
    "../second/tex/b.png": "second/tex/b.png",
    "tex/nowhere.png": "checked/tex/nowhere.png",
    "parts\\a.png": "checked/parts/a.png",
    "parts\\/a.png": "checked/parts/a.png",
    "\\parts\\a.png": "checked/parts/a.png",
    "..\\first\\tex\\b.png": "first/tex/b.png",
}


@pytest.mark.parametrize("name", FOUND)
def test_a_name_leads_where_materialx_would_find_it(reach, tmp_path, name):
    assert reach.resolve(name) == (tmp_path / FOUND[name]).resolve()
    assert pickle.loads(pickle.dumps(reach)).resolve(name) == reach.resolve(name)


@pytest.mark.parametrize("name", ["../elsewhere/d.png", "..\\elsewhere\\d.png", "\\\\first\\tex\\b.png"])
def test_what_lies_in_no_folder_that_was_named_is_outside(reach, name):
    assert reach.resolve(name) is None


@pytest.mark.skipif(os.name == "nt", reason="a drive is no folder of this system")
def test_a_name_with_a_drive_is_absolute(reach):
    assert reach.resolve("C:\\tex\\b.png") is None


def test_names_of_an_included_file_are_relative_to_its_own_folder(reach, tmp_path):
    assert reach.at(tmp_path / "checked" / "parts").resolve("a.png") == (tmp_path / "checked/parts/a.png").resolve()
    assert reach.at(tmp_path / "checked" / "parts").resolve("../../elsewhere/d.png") is None


def test_only_regular_files_are_opened(reach):
    assert reach.regular("parts/a.png") is not None
    assert reach.regular("parts") is None
    assert reach.regular("nowhere.png") is None
    if hasattr(os, "mkfifo"):
        os.mkfifo(reach.folder / "pipe.png")
        assert reach.regular("pipe.png") is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_that_takes_the_place_of_a_file_while_it_is_opened_is_not_read(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "a.txt")
    monkeypatch.setattr(Path, "is_file", lambda _path: True)
    assert read_regular(tmp_path / "a.txt", 9) is None


def test_tiles_are_not_looked_for_in_folders_outside(reach):
    (reach.folder / "parts" / "a.1001.png").touch()
    (reach.folder / "leads_out").symlink_to(reach.folder.parent / "elsewhere")
    (reach.folder.parent / "elsewhere" / "a.1001.png").touch()
    assert reach.members("<part>/a.<UDIM>.png") == [reach.folder / "parts" / "a.1001.png"]


def test_a_file_has_its_place_in_the_folder_that_holds_it(reach):
    for name in ("parts/a.png", "tex/b.png", "tex/c.png"):
        target = reach.resolve(name)
        assert target is not None
        assert reach.within(target).as_posix() == name
    with pytest.raises(ValueError, match="outside"):
        Reach.only(reach.folder).within(reach.folder.parent)
