"""The GLSL wrappers of each dialect: the view is mirrored in one place, and the standard one is told nothing of it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import MaterialX as mx
import pytest

from mrm_mtlx.library import materialx_version
from mrm_mtlx.library.assembly import served, source_files
from mrm_mtlx.library.dialects import DIALECTS

NODES = ("dielectric_bsdf", "conductor_bsdf", "generalized_schlick_bsdf")
# A version of each dialect that the library has, by the folder of its closures.
VERSIONS = {spoken.closures: version for version, spoken in DIALECTS.items() if not spoken.unserved}
MIRRORED = "mrm_mirror_view(V, N, retroreflective)"


def code_of(path: Path) -> str:
    """Source without comments."""
    return re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))


def wrapper(version: str, node: str) -> str:
    return code_of(source_files(served(version))[f"genglsl/mrm_{node}.glsl"])


@dataclass(frozen=True)
class Function:
    """A function of a source: its parameters as they are written, and its body."""

    parameters: tuple[str, ...]
    body: str = ""

    @property
    def names(self) -> list[str]:
        return [parameter.split()[-1] for parameter in self.parameters]


def functions(prefix: str, node: str, source: str) -> dict[str, Function]:
    """The functions for a node, by what their names have after that of the node."""
    found = re.findall(rf"^void {prefix}_{node}(\w*)\(([^)]*)\)\s*{{(.*?)^}}", source, re.MULTILINE | re.DOTALL)
    return {kind: Function(tuple(p.strip() for p in given.split(",")), body) for kind, given, body in found}


def arguments(call: str) -> list[str]:
    """Arguments of a call, which may be calls themselves."""
    return [part.strip() for part in re.split(r",(?![^()]*\))", call)]


def faults(node: str, source: str, has_flag: bool) -> list[str]:
    """What is wrong with a wrapper, by its text; `has_flag`: the standard function has the flag too."""
    found = []
    for kind, function in functions("mrm", node, source).items():
        call = re.search(rf"\bmx_{node}{kind}\((.*)\);", function.body)
        if call is None:
            found.append(f"{kind}: does not call its standard function")
            continue
        handed_on = {"closureData": "mirrored", "retroreflective": "false"}
        if kind in ("_reflection", "_indirect"):
            handed_on["V"] = MIRRORED
        names = [name for name in function.names if has_flag or name != "retroreflective"]
        given = arguments(call[1])
        if len(given) != len(names):
            found.append(f"{kind}: the standard function gets another number of arguments")
            continue
        expected = [handed_on.get(name, name) for name in names]
        found += [f"{n}: {g} instead of {e}" for n, g, e in zip(names, given, expected, strict=True) if g != e]
        if "closureData" in names and "mrm_mirror_view(closureData, N, retroreflective)" not in function.body:
            found.append("the view is not mirrored by mrm_mirror_view")
    if re.search(r"\breflect\(", source):
        found.append("the view is mirrored in the wrapper itself")
    return found


def mismatches(node: str, source: str, standard: str, has_flag: bool) -> list[str]:
    """How the functions of a wrapper differ from the standard ones, but for the flag."""
    ours, theirs = functions("mrm", node, source), functions("mx", node, standard)
    if ours.keys() != theirs.keys():
        return [f"functions {sorted(ours)} instead of {sorted(theirs)}"]
    found = []
    for kind, function in ours.items():
        same = [p for p in function.parameters if has_flag or p != "bool retroreflective"]
        if "bool retroreflective" not in function.parameters or same != list(theirs[kind].parameters):
            found.append(f"{kind}: {', '.join(function.parameters)} instead of {', '.join(theirs[kind].parameters)}")
    return found


def standard_source(node: str, libraries: Path) -> str:
    """The source of the standard function in the data libraries of a version."""
    return code_of(libraries / "pbrlib" / "genglsl" / f"mx_{node}.glsl")


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("closures", VERSIONS)
def test_a_wrapper_mirrors_the_view_and_hands_everything_else_on(closures, node):
    version = VERSIONS[closures]
    source = wrapper(version, node)
    assert functions("mrm", node, source)
    assert faults(node, source, served(version).has_retroreflective) == []


# By dialect: what is changed where a standard function is called, and what of it is seen.
DAMAGES = [
    ("", "roughness, false,", "roughness, retroreflective,", "retroreflective: retroreflective instead of false"),
    ("", "(mirrored,", "(closureData,", "closureData: closureData instead of mirrored"),
    ("", "mrm_mirror_view(closureData, N, retroreflective)", "closureData", "not mirrored by mrm_mirror_view"),
    ("1.39.3", "(mirrored,", "(closureData,", "closureData: closureData instead of mirrored"),
    ("1.39.3", "roughness,", "roughness, false,", "another number of arguments"),
    ("1.39.3", "mrm_mirror_view(closureData, N, retroreflective)", "closureData", "not mirrored by mrm_mirror_view"),
    ("1.39.0", f"L, {MIRRORED}", "L, V", f"V: V instead of {MIRRORED}"),
    ("1.39.0", f"indirect({MIRRORED}", "indirect(V", f"V: V instead of {MIRRORED}"),
    ("1.39.0", "bsdf_indirect(mrm", "bsdf_reflection(mrm", "_indirect: does not call its standard function"),
    *((closures, "thinfilm_thickness, thinfilm_ior, N, X, distribution",
       "thinfilm_ior, thinfilm_thickness, N, X, distribution",
       "thinfilm_thickness: thinfilm_ior instead of thinfilm_thickness") for closures in VERSIONS),
]  # fmt: skip


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize(("closures", "old", "new", "seen"), DAMAGES)
def test_a_wrong_wrapper_is_seen(closures, node, old, new, seen):
    version = VERSIONS[closures]
    good = wrapper(version, node)
    # Not in the first line of a function, which has types.
    damaged = "\n".join(line if line.startswith("void") else line.replace(old, new) for line in good.split("\n"))
    assert damaged != good
    assert any(seen in fault for fault in faults(node, damaged, served(version).has_retroreflective))


def test_transmission_that_is_mirrored_is_seen():
    good = wrapper("1.39.0", NODES[0])
    damaged = good.replace("mx_dielectric_bsdf_transmission(V", f"mx_dielectric_bsdf_transmission({MIRRORED}")
    assert faults(NODES[0], damaged, has_flag=False) == [f"V: {MIRRORED} instead of V"]


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("closures", VERSIONS)
def test_a_wrappers_arguments_are_those_of_the_definition_in_its_order(library, closures, node):
    # The generators pass the inputs in the order of the definition, behind the data of the closure.
    renamed = {"ior": "ior_n", "extinction": "ior_k", "normal": "N", "tangent": "X"}
    if node != "conductor_bsdf":
        del renamed["ior"]
    inputs = [port.getName() for port in library.document.getNodeDef(f"ND_{node}").getActiveInputs()]
    expected = [*(renamed.get(name, name) for name in inputs), "bsdf"]
    for function in functions("mrm", node, wrapper(VERSIONS[closures], node)).values():
        assert function.names[-len(expected) :] == expected
        assert set(function.names[: -len(expected)]) <= {"closureData", "L", "V", "P", "occlusion"}


@pytest.mark.parametrize("node", NODES)
def test_a_wrapper_has_the_functions_of_the_installed_materialx(node):
    version, libraries = materialx_version(), Path(mx.getDefaultDataSearchPath().find("libraries").asString())
    has_flag = served(version).has_retroreflective
    standard = standard_source(node, libraries)
    assert mismatches(node, wrapper(version, node), standard, has_flag) == []
    # One of another dialect would be seen, be it by the number of its functions or by the flag.
    others = [other for closures, other in VERSIONS.items() if closures != served(version).closures]
    assert len(others) == len(VERSIONS) - 1
    assert all(mismatches(node, wrapper(other, node), standard, not has_flag) for other in others)


@pytest.mark.parametrize("closures", VERSIONS)
def test_the_view_is_mirrored_in_one_file_alone(closures):
    files = source_files(served(VERSIONS[closures]))
    glsl = {name: path for name, path in files.items() if name.endswith(".glsl")}
    assert len(glsl) == len(NODES) + 1
    mirroring = [name for name, path in glsl.items() if re.search(r"\breflect\(", code_of(path))]
    assert mirroring == ["genglsl/lib/mrm_retroreflection.glsl"]
