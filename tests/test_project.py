"""What keeps the project in order: one version, pinned tools and actions, a workflow that covers what is promised."""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING

from mrm_mtlx import __version__

if TYPE_CHECKING:
    from pathlib import Path


def test_actions_of_the_workflow_are_pinned_by_commit(repository: Path) -> None:
    text = (repository / ".github/workflows/ci.yml").read_text(encoding="utf-8")
    used = re.findall(r"uses: (\S+)(.*)", text)
    assert used
    assert [name for name, _ in used if not re.fullmatch(r"[\w.-]+/[\w.-]+@[0-9a-f]{40}", name)] == []
    assert all(re.fullmatch(r" # v\d+\.\d+\.\d+", version) for _, version in used)


def test_the_workflow_tries_every_python_of_the_classifiers(repository: Path) -> None:
    text = (repository / ".github/workflows/ci.yml").read_text(encoding="utf-8")
    (matrix,) = re.findall(r"python: \[(.*)\]", text)
    project = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    versions = [
        c.rpartition(" ")[2] for c in project["classifiers"] if c.startswith("Programming Language :: Python :: ")
    ]
    assert re.findall(r'"([\d.]+)"', matrix) == versions
    assert project["requires-python"] == f">={versions[0]}"


def test_the_linter_and_the_type_checker_are_pinned_to_what_continuous_integration_has(repository: Path) -> None:
    project = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    constraints = (repository / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pinned = project["optional-dependencies"]["lint"]
    assert {requirement.partition("==")[0] for requirement in pinned} == {"ruff", "mypy"}
    assert set(pinned) <= set(constraints)


def test_documents_that_name_the_version_name_the_one_that_there_is(repository: Path) -> None:
    paths = [*(repository / "materials_classes").glob("*.mtlx"), *(repository / "docs").rglob("*.md")]
    named = {
        path.name: set(re.findall(r"mrm-mtlx (\d+\.\d+\.\d+)", path.read_text(encoding="utf-8"))) for path in paths
    }
    assert {name: found for name, found in named.items() if found - {__version__}} == {}
    assert any(named.values())


def test_every_decision_is_listed_under_its_title(repository: Path) -> None:
    folder = repository / "docs/decisions"
    listed = re.findall(r"^(\d+)\. \[(.+)\]\((.+)\)$", (folder / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    pages = sorted(path for path in folder.glob("*.md") if path.name != "README.md")
    assert [name for _, _, name in listed] == [path.name for path in pages]
    for (number, title, _), path in zip(listed, pages, strict=True):
        text = path.read_text(encoding="utf-8")
        assert text.startswith(f"# {number}. {title}\n")
        assert path.name.startswith(f"{int(number):04}-")
        assert [f"**{part}.**" in text for part in ("Context", "Decision", "Consequence")] == [True] * 3


def test_places_that_the_page_of_development_names_are_there(repository: Path) -> None:
    text = (repository / "docs/development.md").read_text(encoding="utf-8")
    # Of names in backticks, those of files and folders: from the root of the checkout, of the package, or of a room.
    named = {name for name in re.findall(r"`([\w./]+)`", text) if "/" in name or name.endswith((".py", ".csv", ".txt"))}
    assert len(named) > 40
    package = repository / "mrm_mtlx"
    library, tests = repository / "libraries/pbrlib", repository / "tests/library"
    folders = (repository, package, library, tests, package / "standards/data")
    absent = {name for name in named if not any((folder / name).exists() for folder in folders)}
    assert absent - {"../shared"} == {"tests/rules/CODE/"}  # what lies beside a checkout, or does not
    modules = set(re.findall(r"`((?:validation|documents|formats)\.\w+)", text))
    assert len(modules) > 3
    assert [name for name in modules if not list(package.glob(f"{name.replace('.', '/')}*"))] == []
