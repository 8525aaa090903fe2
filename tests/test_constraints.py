"""The versions that continuous integration installs: complete, within the project's bounds, and in force there."""

from __future__ import annotations

import os
import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

REPOSITORY = Path(__file__).parents[1]
PROJECT = "mrm-mtlx"


def pinned(*names: str) -> dict[str, str]:
    """Package, by its canonical name, to the version that the files name; a later file replaces an earlier one's."""
    lines = [line for name in names for line in (REPOSITORY / name).read_text(encoding="utf-8").splitlines()]
    found = [re.fullmatch(r"([\w.-]+)==([\w.]+)", line) for line in lines if not line.startswith("#")]
    assert all(found), lines
    return {canonicalize_name(match[1]): match[2] for match in found if match}


def project() -> dict[str, list[str]]:
    """Requirements of pyproject.toml by extra, "" for the package's own."""
    text = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return {"": text["dependencies"], **text["optional-dependencies"]}


def required(extra: str, python: str) -> list[Requirement]:
    """What an extra of the project asks for on a version of Python, with the extras that it names."""
    found = []
    for requirement in map(Requirement, project()[extra]):
        if canonicalize_name(requirement.name) == PROJECT:
            found += [other for name in sorted(requirement.extras) for other in required(name, python)]
        elif requirement.marker is None or requirement.marker.evaluate({"python_version": python}):
            found.append(requirement)
    return found


def brought(requirement: Requirement, known: dict[str, list[str]]) -> None:
    """Add to `known` the names of a requirement and of what it brings, each with the reasons, as far as installed."""
    name, because = canonicalize_name(requirement.name), str(requirement)
    if because in known.get(name, []):
        return
    known.setdefault(name, []).append(because)
    try:
        below = metadata.requires(requirement.name) or []
    except metadata.PackageNotFoundError:
        return
    for other in map(Requirement, below):
        if other.marker is None or any(other.marker.evaluate({"extra": e}) for e in ("", *requirement.extras)):
            brought(other, known)


@pytest.fixture(scope="module")
def needed() -> dict[str, list[str]]:
    """Every package that the extra `dev` brings on Python 3.11, with the requirements that ask for it."""
    known: dict[str, list[str]] = {}
    for requirement in [*required("", "3.11"), *required("dev", "3.11")]:
        brought(requirement, known)
    return known


@pytest.fixture(scope="module")
def in_force() -> dict[str, str]:
    """The versions that pip was held to here; elsewhere other ones may be installed, which ask for others in turn."""
    constraint = os.environ["PIP_CONSTRAINT"]  # else its tests are not collected: tests/fixtures/material.py
    return pinned("constraints.txt", *(["constraints-numpy2.txt"] if "numpy2" in constraint else []))


@pytest.mark.parametrize("files", [["constraints.txt"], ["constraints.txt", "constraints-numpy2.txt"]])
def test_every_direct_requirement_is_pinned_within_its_bounds(files: list[str]) -> None:
    versions = pinned(*files)
    newer = len(files) > 1
    asked = [*required("", "3.11"), *required("dev", "3.11")]
    if newer:  # the OSL runtime is what does not allow it
        asked = [r for r in asked if r.name != "bpy"] + [Requirement("numpy>=2")]
    wrong = [str(r) for r in asked if not r.specifier.contains(versions.get(canonicalize_name(r.name), "0"))]
    assert wrong == []
    assert versions["numpy"].startswith("2." if newer else "1.26.")


def test_what_the_requirements_bring_is_pinned_as_well(needed: dict[str, list[str]]) -> None:
    assert len(needed) > 30  # the walk did see what the direct ones bring
    assert sorted(needed.keys() - pinned("constraints.txt").keys()) == []


def test_versions_satisfy_what_the_packages_ask_of_each_other(
    in_force: dict[str, str], needed: dict[str, list[str]]
) -> None:
    wrong = [
        because
        for name, reasons in needed.items()
        for because in reasons
        if not Requirement(because).specifier.contains(in_force.get(name, "0"), prereleases=True)
    ]
    assert wrong == []


def test_continuous_integration_has_the_versions_installed(
    in_force: dict[str, str], needed: dict[str, list[str]]
) -> None:
    installed = {canonicalize_name(d.metadata["Name"]): d.version for d in metadata.distributions()}
    both = sorted(needed.keys() & installed.keys())
    assert {name: installed[name] for name in both} == {name: in_force[name] for name in both}


def test_the_files_name_packages_and_versions_alone() -> None:
    for name in ("constraints.txt", "constraints-numpy2.txt"):
        text = (REPOSITORY / name).read_text(encoding="utf-8")
        assert re.search(r"https?:|file:|@|--", text) is None
