"""The commands beside `validate`: what they print, where they write, and how they refuse."""

from __future__ import annotations

import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import MaterialX as mx
import pytest

from mrm_mtlx.engines.base import Availability
from mrm_mtlx.findings.catalogue import RULES
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.library.dialects import materialx_version
from mrm_mtlx.library.host_models import MODELS_FILE
from mrm_mtlx.library.surface_models import SURFACE_MODELS, Extension
from mrm_mtlx.shadergen import TARGETS

# `mrm rules` ----------------------------------------------------------------------------------------------------------


def test_rules_lists_every_rule_on_a_line(mrm):
    done = mrm("rules")
    assert (done.returncode, done.stderr) == (0, "")
    listed = [re.split(r"  +", line) for line in done.stdout.splitlines()]
    assert listed == [[rule.code, rule.severity.value, rule.title] for rule in RULES.values()]


@pytest.mark.parametrize("beginning", ["READ", "doc_cycle", "SHADER_"])
def test_rules_explains_those_that_begin_so(mrm_here, beginning):
    done = mrm_here("rules", beginning)
    assert (done.returncode, done.stderr) == (0, "")
    headings = re.findall(r"^([A-Z_]+) \((\w+)\): (.+)$", done.stdout, re.MULTILINE)
    expected = [rule for rule in RULES.values() if rule.code.startswith(beginning.upper())]
    assert headings == [(rule.code, rule.severity.value, rule.title) for rule in expected]
    flat = "".join(done.stdout.split())
    for rule in expected:
        assert "".join(rule.meaning.split()) in flat
        assert "".join(rule.remedy.split()) in flat


def test_rules_prints_the_page_of_the_documentation(mrm_here, repository):
    done = mrm_here("rules", "--markdown")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.findall(r"^## (\w+)$", done.stdout, re.MULTILINE) == list(RULES)
    assert done.stdout == (repository / "docs" / "rules.md").read_text(encoding="utf-8")


# `mrm doctor` ---------------------------------------------------------------------------------------------------------


def test_doctor_says_what_runs_here_and_how_to_add_the_rest(mrm, gl):
    text, report = mrm("doctor"), mrm("doctor", "--format", "json")
    assert (text.returncode, text.stderr, report.returncode, report.stderr) == (0, "", 0, "")
    found = json.loads(report.stdout)
    assert list(found) == ["schema", "versions", "targets", "surface_models", "engines"]
    assert [m["node"] for m in found["surface_models"]] == ["open_pbr_surface", "standard_surface", "gltf_pbr"]
    assert all(f"{m['node']} {m['input']}" in text.stdout and not m["reason"] for m in found["surface_models"])
    assert found["schema"] == "mrm.doctor/1"
    assert set(found["targets"]) <= set(TARGETS)
    assert list(found["engines"]) == ["gl", "vulkan", "slang", "osl", "cycles", "storm"]
    assert found["engines"]["gl"]["detail"] == gl.detail
    for name, engine in found["engines"].items():
        (line,) = [line for line in text.stdout.splitlines() if line.startswith(f"{name} ")]
        assert ("ok" if engine["available"] else "missing") in line.split()
        rest = text.stdout.partition(line)[2].splitlines()
        assert line.endswith(engine["detail"]) or " ".join(" ".join(rest[1:]).split()).startswith(engine["detail"])
        assert engine["remedy"] in text.stdout
        assert not (engine["available"] and engine["remedy"])
    assert "\x1b" not in text.stdout
    assert all(len(line) <= 80 for line in text.stdout.splitlines() if "to add it" not in line)


def test_doctor_says_what_the_reference_covers(mrm_here):
    text, report = mrm_here("doctor", "--coverage"), mrm_here("doctor", "--coverage", "--format", "json")
    assert (text.returncode, report.returncode) == (0, 0)
    found = json.loads(report.stdout)
    assert found["schema"] == "mrm.coverage/1"
    covered = [c for c in found["definitions"] if c["how"]]
    assert found["covered"] == len(covered)
    total = next(line for line in text.stdout.splitlines() if line.startswith("all"))
    assert f"{len(covered) / len(found['definitions']):.1%}" in total
    missing = [c["name"] for c in found["definitions"] if not c["how"]]
    assert [line.split()[2] for line in text.stdout.splitlines() if line.startswith("not covered: ")] == missing


def test_doctor_names_what_is_missing_and_the_command_that_adds_it(mrm, tmp_path):
    # No compiler on the PATH, and no driver that EGL would find.
    empty = tmp_path / "nothing"
    empty.mkdir()
    lacking = {"PATH": str(empty), "__EGL_VENDOR_LIBRARY_DIRS": str(empty), "__EGL_VENDOR_LIBRARY_FILENAMES": ""}
    told = mrm("doctor", **lacking)
    missing = [line.split()[0] for line in told.stdout.splitlines() if line.split()[1:2] == ["missing"]]
    assert "vulkan" in missing
    # Where Blender's module runs, all that Storm lacks is the driver.
    without_driver = ("gl" in missing) + ("storm" in missing and "cycles" not in missing)
    assert told.stdout.count("to add it: apt-get install") == 1 + without_driver
    if sys.platform.startswith("linux"):
        assert "gl" in missing
        assert told.returncode == 1


def test_without_a_driver_documents_are_generated_and_skipped_with_the_reason(mrm, metal, tmp_path):
    if not sys.platform.startswith("linux"):
        pytest.skip("how to hide the driver is known for EGL alone")
    empty = tmp_path / "nothing"
    empty.mkdir()
    lacking = {"__EGL_VENDOR_LIBRARY_DIRS": str(empty), "__EGL_VENDOR_LIBRARY_FILENAMES": ""}
    done = mrm("validate", metal, "--target", "glsl", "-j", "1", **lacking)
    assert done.returncode == 3
    assert "1 skipped (1 glsl: " in done.stdout
    assert "apt-get install" in done.stdout.splitlines()[-1]
    done = mrm("render", metal, "-o", "a.png", **lacking)
    assert done.returncode == 2
    assert "apt-get install" in done.stderr
    assert not (tmp_path / "a.png").exists()


# `mrm library` --------------------------------------------------------------------------------------------------------


def test_library_prints_its_folders(mrm):
    for options, file in (
        ((), "pbrlib/mrm_defs.mtlx"),
        (("--materials",), "licence_plate.mtlx"),
        (("--classes",), "dot_c2_red.mtlx"),
    ):
        done = mrm("library", *options)
        assert (done.returncode, done.stderr) == (0, "")
        assert (Path(done.stdout.strip()) / file).is_file()


def test_library_installs_its_files_and_says_how_to_load_them(mrm_here, tmp_path):
    done = mrm_here("library", "install", "hosts/one")
    assert done.returncode == 0
    written = sorted(path for path in (tmp_path / "hosts" / "one").rglob("*") if path.is_file())
    assert [tmp_path / line for line in done.stdout.splitlines()] == written
    expected = {*node_library_files(materialx_version()), MODELS_FILE}
    assert {path.relative_to(tmp_path / "hosts" / "one" / "mrm").as_posix() for path in written} == expected
    assert "--library mrm" in done.stderr
    assert "left out" not in done.stderr


def test_a_surface_model_that_could_not_be_extended_is_named_with_the_reason(
    in_process, library, monkeypatch, tmp_path
):
    left_out = Extension(SURFACE_MODELS[2], "it is not defined by a graph")
    changed = replace(library, surface_models=(Extension(SURFACE_MODELS[0]), left_out))
    monkeypatch.setattr("mrm_mtlx.library.load_library", lambda: changed)
    monkeypatch.setattr("mrm_mtlx.api.doctor.survey", lambda: {"gl": ("compiles", Availability(True, "a driver"))})
    expected = "gltf_pbr is left out: it is not defined by a graph"
    own = tmp_path / "own"
    shutil.copytree(Path(mx.__file__).parent / "libraries", own)
    model = own / "bxdf" / "gltf_pbr.mtlx"
    model.write_text(re.sub(r"<nodegraph .*</nodegraph>", "", model.read_text("utf-8"), flags=re.DOTALL), "utf-8")
    assert expected in in_process("library", "install", "hosts", "--stdlib", own).stderr
    told = in_process("doctor").stdout
    assert expected in told
    assert "open_pbr_surface specular_retroreflectivity (partly" in told


@pytest.mark.parametrize("where", ["file", "file/below"])
def test_library_cannot_install_into_a_file(mrm, tmp_path, where):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    done = mrm("library", "install", where)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{where} cannot be written" in done.stderr.splitlines()[-1]


# `mrm generate` -------------------------------------------------------------------------------------------------------

# Words that only source code of the language has.
TELLING = {
    "glsl": "#version 400",
    "essl": "#version 300 es",
    "vulkan": "#version 450",
    "msl": "#include <metal_stdlib>",
    "slang": "SV_Target",
    "wgsl": "#version",
    "osl": "shader material",
    "mdl": "mdl 1.",
}


@pytest.mark.parametrize("target", TARGETS)
def test_generate_prints_the_source_and_writes_the_same_to_files(mrm_here, metal, tmp_path, target):
    printed = mrm_here("generate", metal, "--target", target)
    assert (printed.returncode, printed.stderr) == (0, "")
    assert TELLING[target] in printed.stdout
    written = mrm_here("generate", metal, "--target", target, "-o", "out")
    assert (written.returncode, written.stdout) == (0, "")
    files = [Path(line.removeprefix("wrote ")) for line in written.stderr.splitlines()]
    assert [file.name for file in files] == [f"material{suffix}" for suffix in TARGETS[target].suffixes.values()]
    assert "".join((tmp_path / file).read_text(encoding="utf-8") + "\n" for file in files) == printed.stdout


def test_generate_takes_the_library_that_is_asked_for(mrm, metal):
    ours, theirs = (mrm("generate", metal, "--library", name).stdout for name in ("mrm", "upstream"))
    assert "mrm_conductor_bsdf" in ours
    assert "mrm_conductor_bsdf" not in theirs
    assert "mx_conductor_bsdf" in theirs


def test_generate_takes_the_element_that_is_asked_for(mrm_here, metal):
    text = metal.read_text(encoding="utf-8")
    second = text[text.index("<surfacematerial") : text.index("</materialx>")].replace(
        '"material" type', '"other" type'
    )
    metal.write_text(text.replace("</materialx>", f"{second}</materialx>"), encoding="utf-8")
    assert mrm_here("generate", metal, "--target", "osl").stdout.count("\nshader ") == 2
    one = mrm_here("generate", metal, "--target", "osl", "--element", "other").stdout
    assert re.findall(r"^shader (\w+)", one, re.MULTILINE) == ["other"]
    done = mrm_here("generate", metal, "--element", "third")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].endswith("third: expected one of material, other")


def test_generate_writes_osl_that_needs_no_headers(mrm_here, metal):
    ordinary, alone = (mrm_here("generate", metal, "--target", "osl", *more) for more in ((), ("--self-contained",)))
    assert (alone.returncode, alone.stderr) == (0, "")
    assert "#include" in ordinary.stdout
    assert "#include" not in alone.stdout
    assert alone.stdout.endswith(ordinary.stdout.replace('#include "mx_funcs.h"\n', ""))


def test_generate_writes_osl_for_a_script_node(mrm_here, metal):
    done = mrm_here("generate", metal, "--target", "osl", "--script-node", "--osl-mode", "cycles")
    assert (done.returncode, done.stderr) == (0, "")
    assert "#include" not in done.stdout
    assert done.stdout.startswith("#define MRM_OSL_MODE 2\n")
    assert 'string label = "Tangent"' in done.stdout


def test_generate_reports_what_cannot_be_generated_as_a_finding(mrm_here, documents):
    done = mrm_here("generate", documents / "SHADER_GENERATE" / "triggers.mtlx")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("SHADER_GENERATE/triggers.mtlx:16:3: error SHADER_GENERATE /material: ")


def test_generate_into_a_file_is_a_usage_error(mrm, metal, tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    done = mrm("generate", metal, "-o", "file")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith("Error: ")


# Documents that `generate` and `render` cannot use --------------------------------------------------------------------

BROKEN = {
    "READ_MISSING": 1,
    "READ_XML": 1,
    "READ_TOO_DEEP": 1,
    "READ_INCLUDE": 1,
    "READ_OUTSIDE": 1,
    "DOC_INVALID": 1,
    "DOC_CYCLE": 1,
    "DOC_FILE": 1,
    "RETRO_UNDEFINED": 1,
    "DOC_NO_RENDERABLE": 3,
}


@pytest.mark.parametrize("code", BROKEN)
def test_a_broken_document_is_refused_with_its_finding(mrm_here, documents, code):
    done = mrm_here("generate", documents / code / "triggers.mtlx")
    assert (done.returncode, done.stdout) == (BROKEN[code], "")
    if code == "DOC_NO_RENDERABLE":
        assert done.stderr.strip().endswith("has nothing to render")
    else:
        place = "" if code == "READ_MISSING" else rf"{code}/triggers\.mtlx:\d+:\d+: "
        assert re.match(f"{place}error {code}", done.stderr)


@pytest.mark.parametrize("code", ["READ_MISSING", "READ_XML", "DOC_CYCLE", "DOC_NO_RENDERABLE"])
def test_a_broken_document_is_not_rendered(mrm_here, documents, tmp_path, code, gl):
    done = mrm_here("render", documents / code / "triggers.mtlx", "-o", "a.png", "--size", "24")
    assert (done.returncode, done.stdout) == (BROKEN[code], "")
    assert list(tmp_path.iterdir()) == []


def test_a_shader_that_does_not_compile_is_not_rendered(mrm, documents, tmp_path, gl):
    done = mrm("render", documents / "SHADER_COMPILE" / "triggers.mtlx", "-o", "a.png", "--size", "24")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("SHADER_COMPILE/triggers.mtlx:16:3: error SHADER_COMPILE /material: ")
    assert list(tmp_path.iterdir()) == []


def test_a_shader_that_cannot_be_generated_is_not_rendered(mrm_here, documents, gl):
    done = mrm_here("render", documents / "SHADER_GENERATE" / "triggers.mtlx", "-o", "a.png", "--size", "24")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("SHADER_GENERATE/triggers.mtlx:16:3: error SHADER_GENERATE /material: ")


def test_a_folder_is_no_document(mrm_here, tmp_path, gl):
    for arguments in (("generate", tmp_path), ("render", tmp_path, "-o", "a.png")):
        done = mrm_here(*arguments)
        assert (done.returncode, done.stdout) == (2, "")
        assert "is a folder; name one document" in done.stderr.splitlines()[-1]


def test_a_warning_is_shown_and_does_not_keep_from_generating(mrm_here, documents):
    done = mrm_here("generate", documents / "DOC_VALUE_RANGE" / "triggers.mtlx", "--target", "osl")
    assert done.returncode == 0
    place = "DOC_VALUE_RANGE/triggers.mtlx:5:5"
    assert done.stderr.startswith(f"{place}: warning DOC_VALUE_RANGE /metal/roughness: ")
    assert "shader material" in done.stdout


# `mrm conformance` ----------------------------------------------------------------------------------------------------

# 24 of MaterialX's nodes, 8 of those that it has not.
CASES = 32
CASE_KEYS = {
    "name",
    "node",
    "target",
    "engine",
    "retroreflective",
    "status",
    "samples",
    "max_error",
    "median_error",
    "reason",
}


def test_conformance_as_json_and_as_text_has_the_same_cases_with_what_is_promised(mrm, mrm_here, gl):
    arguments = ("conformance", "--samples", "256", "--target", "glsl")
    done, printed = mrm_here(*arguments, "--format", "json"), mrm(*arguments)
    assert (done.returncode, printed.returncode, printed.stderr) == (0, 0, "")
    assert done.stderr == f"PASSED  {CASES} passed, 0 failed, 0 skipped\n"
    report = json.loads(done.stdout)
    assert report["schema"] == "mrm.conformance/1"
    assert {"versions", "engines", "library", "cases"} <= set(report)
    assert len(report["cases"]) == CASES
    for case in report["cases"]:
        assert set(case) >= CASE_KEYS
        assert (case["target"], case["engine"], case["status"]) == ("glsl", "gl", "pass")
        assert case["samples"] == 256
        assert 0.0 < case["median_error"] < case["max_error"]
        assert case["reason"] is None
    assert len({case["name"] for case in report["cases"]}) == CASES
    assert {case["retroreflective"] for case in report["cases"]} == {True, False}
    lines = printed.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert [*lines[:1], *lines[1].split()] == [
        "case", "target", "status", "samples", "largest", "median", "of", "allowed"
    ]  # fmt: skip
    assert lines[-1] == done.stderr.strip()
    assert len(lines) == 2 * CASES + 5  # with a header and a note, of two lines each
    # The seed fixes the numbers: those of another process are the same.
    for name, line, case in zip(lines[2::2], lines[3::2], report["cases"], strict=False):
        assert name == case["name"]
        assert line.split()[-3:-1] == [f"{case['max_error']:.2e}", f"{case['median_error']:.2e}"]


@pytest.fixture
def damaged(repository, tmp_path):
    """Function from a change of a file of the node library to a folder with a copy of the package that has it."""

    def copy(file: str, old: str, new: str) -> Path:
        ignored = shutil.ignore_patterns("__pycache__")
        for name in ("mrm_mtlx", "libraries", "materials"):
            shutil.copytree(repository / name, tmp_path / "copy" / name, ignore=ignored)
        path = tmp_path / "copy" / "libraries" / "pbrlib" / "genglsl" / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
        return tmp_path / "copy"

    return copy


# Every shader anew, twenty seconds; the exit status is tried below as well, and wrong libraries in tests/conformance.
@pytest.mark.large
def test_1_a_node_library_that_is_wrong_fails_conformance(mrm, damaged, gl):
    folder = damaged("lib/mrm_retroreflection.glsl", "reflect(-closureData.V, N)", "-closureData.V")
    done = mrm("conformance", "--samples", "256", "--target", "glsl", "--format", "json", cwd=folder)
    assert done.returncode == 1
    assert done.stderr == "FAILED  14 passed, 18 failed, 0 skipped\n"
    for case in json.loads(done.stdout)["cases"]:
        assert case["status"] == ("fail" if case["retroreflective"] else "pass")


def test_a_node_library_that_gives_nan_is_reported_as_json(mrm, damaged, gl):
    folder = damaged("mrm_conductor_bsdf.glsl", "mirrored, weight", "mirrored, weight * sqrt(-1.0 - weight)")
    done = mrm("conformance", "--samples", "64", "--target", "glsl", "--format", "json", cwd=folder)
    assert done.returncode == 1
    json.loads(done.stdout, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_2_a_table_that_cannot_be_written(mrm, gl):
    done = mrm("conformance", "--samples", "16", "--target", "glsl", "-o", "no/folder/table.txt")
    assert (done.returncode, done.stdout) == (2, "")
    assert "cannot be written" in done.stderr.splitlines()[-1]
