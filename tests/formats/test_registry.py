"""A format that another package registers: read, written, checked and rendered like ours; and formats told apart."""

from __future__ import annotations

import json
import re

import pytest

from mrm_mtlx.formats.format import Capability, Format
from mrm_mtlx.formats.registry import GROUP, format_for, format_of, formats, suffixes

# Names of materials and their roughness, a line each; without one, a comment.
TOY = '''
"""A format of a line per material: its name and its roughness."""

from dataclasses import dataclass
from typing import Annotated

import MaterialX as mx

from mrm_mtlx.documents.document import Document, ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.options import Option, Options
from mrm_mtlx.system.arguments import ArgumentError


@dataclass(frozen=True)
class ToyOptions(Options):
    digits: Annotated[int | None, Option("N", "Digits of the roughness. Default: 3.")] = None

    def __post_init__(self):
        if self.digits is not None and not 1 <= self.digits <= 9:
            raise ArgumentError(f"{self.digits}: expected 1 to 9", "digits")


def read(path, reach, library, scratch):
    materialx = mx.createDocument()
    document = Document(materialx=materialx, path=path, reach=reach)
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        name, _, roughness = line.partition(" ")
        if not name.isidentifier():
            raise ReadError(rules.READ_FORMAT.at(f"line {number}", f"{name!r} is no name"))
        if not roughness:
            document.findings.append(rules.INTERCHANGE_LOST.at(f"line {number}", f"{name} has no roughness"))
            continue
        lobe = materialx.addNode("conductor_bsdf", f"{name}_lobe", "BSDF")
        lobe.addInput("roughness", "vector2").setValueString(f"{roughness}, {roughness}")
        surface = materialx.addNode("surface", f"{name}_surface", "surfaceshader")
        surface.addInput("bsdf", "BSDF").setNodeName(lobe.getName())
        material = materialx.addNode("surfacematerial", name, "material")
        material.addInput("surfaceshader", "surfaceshader").setNodeName(surface.getName())
        for element in (material, surface, lobe):
            document.source_locations[element.getName()] = f"line {number}"
    materialx.setDataLibrary(library.document)
    return document


def write(document, path, library, files, options):
    lines, lost = [], []
    for material in document.materialx.getMaterialNodes():
        lobe = material.getConnectedNode("surfaceshader").getConnectedNode("bsdf")
        if lobe is None or lobe.getCategory() != "conductor_bsdf":
            lost.append(rules.INTERCHANGE_LEFT_OUT.at(f"/{material.getNamePath()}", "it is no metal"))
            continue
        roughness = float(lobe.getInput("roughness").getValueString().partition(",")[0])
        lines.append(f"{material.getName()} {roughness:.{options.digits or 3}g}\\n")
    if not lines:
        raise NothingToWriteError(lost)
    files.named(path).write_text("".join(lines), "utf-8")
    return lost
'''
# What is registered is light; the module above is imported when a file is read.
ENTRY = """
from mrm_mtlx.formats.format import Capability, Format

TOY = Format("toy", "Toy", (".toy",), "toy_translation", options="toy_translation:ToyOptions")
TOO = Format("toy", "Another", (".too",), "toy_translation")
USD = Format("usd2", "Another USD", (".usd",), "toy_translation")
JSON = Format("toyjson", "Toy in JSON", (".json",), "toy_json", frozenset((Capability.READ,)), ambiguous=True)
"""
TOY_JSON = """
import json

import toy_translation


def recognises(start):
    return b'"toy"' in start


def read(path, reach, library, scratch):
    lines = scratch / "lines.toy"
    lines.write_text(json.loads(path.read_text("utf-8"))["toy"], "utf-8")
    return toy_translation.read(lines, reach, library, scratch)
"""


@pytest.fixture
def toy(mrm, installed, tmp_path):
    """Function that runs a command in the test's folder where the format is installed; or others of its module."""
    (tmp_path / "site" / "toy_translation.py").write_text(TOY, encoding="utf-8")
    (tmp_path / "site" / "toy_json.py").write_text(TOY_JSON, encoding="utf-8")

    def run(*arguments, **entries):
        if not variables:
            variables.update(installed("toy_entry", ENTRY, GROUP, **(entries or {"toy": "toy_entry:TOY"})))
        return mrm(*arguments, **variables)

    variables: dict[str, str] = {}
    (tmp_path / "metals.toy").write_text("dull 0.4\nbright 0.1\n", encoding="utf-8")
    return run


def test_another_packages_format_is_read_and_written_and_its_losses_are_told(toy, tmp_path):
    done = toy("convert", tmp_path / "metals.toy", tmp_path / "metals.mtlx")
    assert (done.returncode, done.stderr) == (0, f"wrote {tmp_path / 'metals.mtlx'}\n")
    assert 'name="bright_lobe"' in (tmp_path / "metals.mtlx").read_text()
    done = toy("convert", tmp_path / "metals.mtlx", tmp_path / "back.toy")
    assert (done.returncode, (tmp_path / "back.toy").read_text()) == (0, "dull 0.4\nbright 0.1\n")
    # Through a format that is not MaterialX's, too.
    assert toy("convert", tmp_path / "metals.toy", tmp_path / "metals.usda").returncode == 0
    done = toy("convert", tmp_path / "metals.usda", tmp_path / "again.toy")
    assert (done.returncode, (tmp_path / "again.toy").read_text()) == (0, "dull 0.4\nbright 0.1\n")
    assert (
        toy("convert", tmp_path / "metals.toy", tmp_path / "b.toy").stderr.splitlines()[-1].endswith("is Toy already")
    )


def test_another_packages_options_are_the_commands(toy, tmp_path):
    (tmp_path / "fine.toy").write_text("fine 0.123456\n", encoding="utf-8")
    toy("convert", tmp_path / "fine.toy", tmp_path / "fine.mtlx")
    assert "Digits of the roughness" in toy("convert", "--help").stdout
    toy("convert", tmp_path / "fine.mtlx", tmp_path / "out.toy", "--digits", 5)
    assert (tmp_path / "out.toy").read_text() == "fine 0.12346\n"
    for options, message in (
        (("out.toy", "--digits", 10), "--digits: 10: expected 1 to 9"),
        (("out.usda", "--digits", 5), "--digits: only for .toy, Toy"),
        (("out.toy", "--observation", 5), "--observation: only for .json, OpenMATERIAL"),
        (("out.toy", "--force"), "--force: this format has no files beside OUTPUT"),
    ):
        done = toy("convert", tmp_path / "fine.mtlx", tmp_path / options[0], *options[1:])
        assert done.returncode == 2
        assert message in done.stderr.splitlines()[-1]


def test_another_packages_files_are_found_in_folders_and_checked_in_worker_processes(toy, tmp_path):
    (tmp_path / "wrong.toy").write_text("dull 0.4\nno-name 0.1\n", encoding="utf-8")
    (tmp_path / "lossy.toy").write_text("dull 0.4\nhollow\nthin -1\n", encoding="utf-8")
    done = toy("validate", tmp_path, "--target", "glsl", "--samples", "64", "--jobs", "2", "--format", "json")
    documents = {d["path"].rpartition("/")[2]: d for d in json.loads(done.stdout)["documents"]}
    assert set(documents) == {"metals.toy", "wrong.toy", "lossy.toy"}
    assert documents["metals.toy"]["findings"] == []
    assert [r["name"] for r in documents["metals.toy"]["renderables"]] == ["line 1", "line 2"]
    (found,) = documents["wrong.toy"]["findings"]
    assert (found["code"], found["location"], found["message"]) == ("READ_FORMAT", "line 2", "'no-name' is no name")
    # What is wrong with an element is told where the file has it.
    codes = {(f["code"], f["location"]) for f in documents["lossy.toy"]["findings"]}
    assert ("INTERCHANGE_LOST", "line 2") in codes
    assert ("DOC_VALUE_RANGE", "line 3/roughness") in codes


def test_another_packages_files_are_measured_and_rendered(gl, toy, tmp_path):
    done = toy("photometry", tmp_path / "metals.toy")
    assert done.returncode == 0
    assert "/bright" in done.stdout
    done = toy("render", tmp_path / "metals.toy", "--size", "16", "-o", tmp_path / "metals.png")
    assert (done.returncode, (tmp_path / "metals.png").exists()) == (0, True)


def test_formats_of_one_ending_are_told_apart_by_content(toy, tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"toy": "dull 0.4\n"}), encoding="utf-8")
    (tmp_path / "b.json").write_text('{"retroreflectivityData": {}}', encoding="utf-8")
    done = toy("convert", tmp_path / "a.json", tmp_path / "a.mtlx", json="toy_entry:JSON")
    assert (done.returncode, 'name="dull"' in (tmp_path / "a.mtlx").read_text()) == (0, True)
    done = toy("convert", tmp_path / "b.json", tmp_path / "b.mtlx")
    assert (done.returncode, "'coefficientOfRetroreflection' is missing" in done.stderr) == (1, True)
    # Folders are full of files of such an ending.
    done = toy("validate", tmp_path, "--target", "glsl", "--samples", "16", "--format", "json")
    assert [d["path"].rpartition("/")[2] for d in json.loads(done.stdout)["documents"]] == ["a.mtlx"]


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"usd": "toy_entry:USD"}, "two formats have the ending .usd: mrm_mtlx.formats.usd and toy_translation"),
        ({"toy": "toy_entry:TOY", "too": "toy_entry:TOO"}, "two formats have the name toy"),
        ({"toy": "toy_entry:ENTRY"}, "does not load"),
        ({"toy": "toy_entry:Capability"}, "expected a Format"),
    ],
    ids=["ending", "name", "absent", "kind"],
)
def test_a_format_that_cannot_be_registered_is_named(toy, tmp_path, entries, message):
    done = toy("convert", tmp_path / "metals.toy", tmp_path / "a.mtlx", **entries)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(r"mrm: .*\n", done.stderr)
    assert message in done.stderr
    assert toy("--help").returncode == 0


def test_our_formats_by_their_endings(tmp_path):
    assert [known.name for known in formats()] == ["materialx", "usd", "gltf", "openmaterial"]
    assert suffixes(Capability.READ) == (".mtlx", ".usda", ".usdc", ".usd", ".usdz", ".gltf", ".glb")
    assert suffixes(Capability.READ, of_folders=True) == suffixes(Capability.READ)
    assert suffixes(Capability.WRITE) == (*suffixes(Capability.READ), ".json")
    for known in formats():
        for suffix in known.suffixes:
            assert format_for(tmp_path / f"A{suffix.upper()}") is known
    assert format_for(tmp_path / "a.xyz") is None
    # A file of JSON is OpenMATERIAL's; one of the same name with XML in it is none of its.
    path = tmp_path / "a.json"
    for content, is_json in ((b' \n{"a": 1}', True), (b"\xef\xbb\xbf{", True), (b"<?xml", False), (b"", False)):
        path.write_bytes(content)
        assert getattr(format_of(path), "name", None) == ("openmaterial" if is_json else None)
    path.unlink()
    assert format_of(path) is None


def test_a_capability_is_a_function_of_the_formats_module():
    for known in formats():
        module = known._module
        assert {c for c in Capability if hasattr(module, c)} == known.capabilities
        assert hasattr(module, "recognises") == known.ambiguous
    assert isinstance(Format("a", "A", (), "json").options_class(), Format("b", "B", (), "json").options_class)
