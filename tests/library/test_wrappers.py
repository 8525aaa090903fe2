"""The GLSL wrappers: the view is mirrored in one place, and the standard function is told nothing of it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.library import node_library_folder

if TYPE_CHECKING:
    from pathlib import Path

NODES = ("dielectric_bsdf", "conductor_bsdf", "generalized_schlick_bsdf")
GENGLSL = node_library_folder() / "pbrlib" / "genglsl"


def code_of(path: Path) -> str:
    """Source without comments."""
    return re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))


def faults(node: str, source: str) -> list[str]:
    """What is wrong with a wrapper, by its text."""
    found = []
    head = re.search(rf"void mrm_{node}\(([^)]*)\)", source)
    call = re.search(rf"\bmx_{node}\(([^)]*)\);", source)
    parameters = [part.split()[-1] for part in head[1].split(",")]
    arguments = [part.strip() for part in call[1].split(",")]
    if len(arguments) != len(parameters):
        return ["the standard function gets another number of arguments"]
    for parameter, argument in zip(parameters, arguments, strict=True):
        expected = {"closureData": "mirrored", "retroreflective": "false"}.get(parameter, parameter)
        if argument != expected:
            found.append(f"{parameter}: {argument} instead of {expected}")
    if "mrm_mirror_view(closureData, N, retroreflective)" not in source:
        found.append("the view is not mirrored by mrm_mirror_view")
    if re.search(r"\breflect\(", source):
        found.append("the view is mirrored in the wrapper itself")
    return found


@pytest.mark.parametrize("node", NODES)
def test_a_wrapper_mirrors_the_view_and_hands_everything_else_on(node):
    assert faults(node, code_of(GENGLSL / f"mrm_{node}.glsl")) == []


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize(
    ("old", "new", "seen"),
    [
        ("roughness, false,", "roughness, retroreflective,", "retroreflective: retroreflective instead of false"),
        ("(mirrored,", "(closureData,", "closureData: closureData instead of mirrored"),
        ("thinfilm_thickness, thinfilm_ior, N, X, distribution", "thinfilm_ior, thinfilm_thickness, N, X, distribution",
         "thinfilm_thickness: thinfilm_ior instead of thinfilm_thickness"),
        ("mrm_mirror_view(closureData, N, retroreflective)", "closureData", "not mirrored by mrm_mirror_view"),
    ],
)  # fmt: skip
def test_a_wrong_wrapper_is_seen(node, old, new, seen):
    good = code_of(GENGLSL / f"mrm_{node}.glsl")
    # The call of the standard function is the last place where each of these stands.
    start = good.index("{")
    damaged = good[:start] + good[start:].replace(old, new)
    assert damaged != good
    assert any(seen in fault for fault in faults(node, damaged))


@pytest.mark.parametrize("node", NODES)
def test_a_wrappers_arguments_are_those_of_the_definition_in_its_order(library, node):
    # The generators pass the inputs in the order of the definition, behind the closure data.
    renamed = {"ior": "ior_n", "extinction": "ior_k", "normal": "N", "tangent": "X"}
    if node != "conductor_bsdf":
        del renamed["ior"]
    inputs = [port.getName() for port in library.document.getNodeDef(f"ND_{node}").getActiveInputs()]
    head = re.search(rf"void mrm_{node}\(([^)]*)\)", code_of(GENGLSL / f"mrm_{node}.glsl"))
    found = [part.split()[-1] for part in head[1].split(",")]
    assert found == ["closureData", *(renamed.get(name, name) for name in inputs), "bsdf"]


def test_the_view_is_mirrored_in_one_file_alone():
    mirroring = [path.name for path in sorted(GENGLSL.rglob("*.glsl")) if re.search(r"\breflect\(", code_of(path))]
    assert mirroring == ["mrm_retroreflection.glsl"]
