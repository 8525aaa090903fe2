"""The documents of a folder: what is searched, what is passed over, and what may be left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from mrm_mtlx.validation.collecting import documents_of

PATHS = (
    "a.mtlx", "b.usda", "notes.txt", "signs/a.mtlx", "signs/old/b.GLTF", ".hidden.mtlx", ".git/a.mtlx",
    "node_modules/pack/a.mtlx", "signs/.cache/a.mtlx", "signs/node_modules/a.mtlx", "node_modules_of_ours/a.mtlx",
)  # fmt: skip
FOUND = [".hidden.mtlx", "a.mtlx", "b.usda", "node_modules_of_ours/a.mtlx", "signs/a.mtlx", "signs/old/b.GLTF"]


@pytest.fixture
def folder(tmp_path):
    for name in PATHS:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def names(folder: Path, *exclude: str) -> list[str]:
    return [path.relative_to(folder).as_posix() for path in documents_of(folder, exclude)]


def test_hidden_folders_and_those_of_packages_are_passed_over(folder):
    assert names(folder) == FOUND


@pytest.mark.parametrize("name", [".git", "node_modules", "signs/.cache"])
def test_a_folder_that_is_named_is_searched_whatever_its_name(folder, name):
    assert documents_of(folder / name) != []


@pytest.mark.parametrize(
    ("pattern", "left_out"),
    [
        ("a.mtlx", {"a.mtlx", "signs/a.mtlx", "node_modules_of_ours/a.mtlx"}),
        ("*.usd?", {"b.usda"}),
        ("signs", {"signs/a.mtlx", "signs/old/b.GLTF"}),
        ("signs/", {"signs/a.mtlx", "signs/old/b.GLTF"}),
        ("signs/*.mtlx", {"signs/a.mtlx"}),
        ("signs/old", {"signs/old/b.GLTF"}),
        ("old", {"signs/old/b.GLTF"}),
        ("*/old", {"signs/old/b.GLTF"}),
        ("sign", set()),
        ("A.MTLX", set()),
    ],
)
def test_a_pattern_leaves_out_names_anywhere_or_paths_from_the_folder(folder, pattern, left_out):
    assert names(folder, pattern) == [name for name in FOUND if name not in left_out]


def test_several_patterns_leave_out_what_any_of_them_is_for(folder):
    assert names(folder, "signs", "*.usda", "n*") == [".hidden.mtlx", "a.mtlx"]


def test_the_current_folder_is_searched_like_any_other(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert documents_of(Path()) == [Path(name) for name in FOUND]
    assert documents_of(Path("signs"), ["old"]) == [Path("signs/a.mtlx")]


def test_links_to_folders_are_not_followed_and_a_folder_called_as_a_document_is_found(folder):
    (folder / "here").symlink_to(folder, target_is_directory=True)
    (folder / "folder.mtlx").mkdir()
    assert names(folder) == sorted([*FOUND, "folder.mtlx"])
