"""Reports in all their forms: well-formed whatever is in them, and complete."""

from __future__ import annotations

import copy
import json
import re
import unicodedata
import xml.etree.ElementTree as ET
from dataclasses import replace

import jsonschema
import pytest

from mrm_mtlx.findings import rules
from mrm_mtlx.findings.catalogue import RULES
from mrm_mtlx.findings.finding import Finding, Severity
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen import HOST_TARGETS, TARGETS
from mrm_mtlx.validation import reports
from mrm_mtlx.validation.results import DocumentResult, RenderableResult, Stage, Status, TargetResult, ValidationResult
from mrm_mtlx.validation.runner import validate

WORST = {
    "v": [0.0, 0.6, 0.8],
    "l": [0.0, 0.0, 1.0],
    "found": [1.0, 2.0, 3.0],
    "expected": [1.0, 2.0, 2.5],
    "error": 0.2,
    "tolerance": 0.1,
}
PASS = TargetResult(Stage.COMPARE, Status.PASS, None, 64, 1e-6, 1e-7, 2e-6, WORST)
FAIL = TargetResult(Stage.COMPARE, Status.FAIL, None, 64, 0.2, 1e-7, 0.1, WORST)
SKIP = TargetResult(Stage.GENERATE, Status.SKIP, "no OSL engine")

VERSIONS = {"mrm": "0.1.0", "materialx": "1.39.5"}
ENGINES = {"gl": {"available": True, "renderer": "llvmpipe"}, "slang": {"available": False, "reason": "not found"}}


def run_of(*documents: DocumentResult) -> ValidationResult:
    return ValidationResult(VERSIONS, ENGINES, list(documents))


def document(path: str = "sign.mtlx", *findings: Finding, **targets: TargetResult) -> DocumentResult:
    return DocumentResult(path, list(findings), [RenderableResult("sheet", dict(targets))] if targets else [])


@pytest.fixture(scope="module")
def schema(repository) -> dict:
    return json.loads((repository / "docs" / "report.schema.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def conforms(schema):
    """Function that says whether a report follows the schema."""
    validator = jsonschema.Draft202012Validator(schema)
    return lambda report: not list(validator.iter_errors(report))


ERROR, WARNING = rules.SHADER_DIFFERS.at("/sheet", "found 1"), rules.RETRO_INVISIBLE.at("/sheet/lobe", "weight 0")

# Names and messages that a format could trip over: what documents may contain, and what a file system allows.
NASTY = {
    "markup": '<b>&amp;"quoted"</b> ]]> <!-- -->',
    "rich": "[red]x[/red] [/]",
    "lines": "one\ntwo\r\nthree",
    "separators": "a:b,c%d::error::e",
    "controls": "\x00\x01\x08\x0b\x1b[31m\x7f",
    "beyond ASCII": "Würzburg \u2028 \U0001f6a7 \u202e",
    "not characters": "\ufffe\uffff",
    "undecodable": "\udcff",
}


# Verdict and exit status ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("documents", "status", "strict"),
    [
        ((document(glsl=PASS),), 0, 0),
        ((document(glsl=PASS, osl=SKIP),), 0, 1),
        ((document("a", WARNING, glsl=PASS),), 0, 1),
        ((document("a", ERROR, glsl=PASS),), 1, 1),
        ((document(glsl=FAIL),), 1, 1),  # also where the finding was ignored
        ((document(osl=SKIP),), 3, 1),
        ((document(),), 3, 3),
        ((), 3, 3),
        ((document("a", ERROR), document("b", glsl=PASS)), 1, 1),
        ((document("a", WARNING),), 3, 1),
    ],
)
def test_the_exit_status_follows_from_errors_warnings_and_skips(documents, status, strict):
    result = run_of(*documents)
    assert reports.exit_status(result, strict=False) == status
    assert reports.exit_status(result, strict=True) == strict
    words = {0: "PASSED", 1: "FAILED", 3: "NOTHING CHECKED"}
    assert reports.verdict(result, strict=False).startswith(f"{words[status]}  ")
    assert reports.verdict(result, strict=True).startswith(f"{words[strict]}  ")


def test_the_verdict_counts_everything_and_names_the_reasons_of_skips():
    result = run_of(document("a", ERROR, WARNING, glsl=PASS, osl=SKIP), document("b", ERROR, glsl=FAIL))
    expected = "FAILED  2 errors, 1 warning, 2 checked, 1 skipped (1 osl: no OSL engine)"
    assert reports.verdict(result, strict=False) == expected


def test_the_verdict_names_every_reason_with_its_number_the_commonest_first():
    skips = [document(str(k), glsl=TargetResult(Stage.COMPILE, Status.SKIP, f"reason {k % 6}")) for k in range(13)]
    verdict = reports.verdict(run_of(*skips), strict=False)
    assert verdict.endswith(
        "13 skipped (3 glsl: reason 0; 2 glsl: reason 1; 2 glsl: reason 2; 2 glsl: reason 3; 2 glsl: reason 4; "
        "2 glsl: reason 5)"
    )


# JSON -----------------------------------------------------------------------------------------------------------------


def test_the_schema_is_itself_valid_and_describes_every_key(schema):
    jsonschema.Draft202012Validator.check_schema(schema)
    described = [part for part in parts(schema) if part.get("properties")]
    assert len(described) >= 8
    for part in described:
        if part.get("additionalProperties") is not False:
            continue  # conditions repeat names to say more of them
        for name, child in part["properties"].items():
            assert child.get("description"), name


def parts(schema: object) -> list[dict]:
    """Every object in a schema."""
    if isinstance(schema, list):
        return [part for item in schema for part in parts(item)]
    if isinstance(schema, dict):
        return [schema, *(part for item in schema.values() for part in parts(item))]
    return []


def test_the_schema_knows_every_rule_target_and_severity(schema):
    pattern = re.compile(schema["$defs"]["finding"]["properties"]["code"]["pattern"])
    assert all(pattern.search(code) for code in RULES)
    assert schema["$defs"]["finding"]["properties"]["severity"]["enum"] == [s.value for s in Severity]
    assert schema["$defs"]["renderable"]["properties"]["targets"]["propertyNames"]["enum"] == [*TARGETS, *HOST_TARGETS]


def test_a_real_report_follows_the_schema(gl, documents, settings, conforms):
    chosen = ["SHADER_DIFFERS", "DOC_INPUT_VALUE", "READ_XML", "SHADER_NOT_FINITE", "SHADER_GENERATE"]
    if Deviation.MEDIUMP_FLOATS in versions.installed().deviations:
        chosen.remove("SHADER_DIFFERS")  # its document differs in ESSL alone, where a narrow lobe is no number there
    targets = ("glsl", "essl", "vulkan", "msl")
    result = validate([documents / code for code in chosen], settings(targets=targets, jobs=2))
    report = json.loads(reports.to_json(result))
    assert conforms(report)
    assert report["schema"] == "mrm.validate/1"
    assert {f["code"] for d in report["documents"] for f in d["findings"]} >= set(chosen)
    statuses = {
        (t["stage"], t["status"]) for d in report["documents"] for r in d["renderables"] for t in r["targets"].values()
    }
    assert statuses >= {
        ("compare", "pass"),
        ("compare", "fail"),
        ("generate", "fail"),
        ("generate", "skip"),
        ("read", "skip"),
    }


def test_a_report_with_every_kind_of_result_follows_the_schema_and_its_summary_counts(conforms):
    result = run_of(document("a.mtlx", ERROR, WARNING, glsl=PASS, essl=FAIL, osl=SKIP), document("b.mtlx"))
    report = json.loads(reports.to_json(result))
    assert conforms(report)
    assert report["summary"] == {"errors": 1, "warnings": 1, "documents": 2, "checked": 2, "skipped": 1}
    assert (report["versions"], report["engines"]) == (VERSIONS, ENGINES)
    assert report["documents"][0]["renderables"][0]["targets"]["glsl"]["worst"] == WORST


# One change each that a reader of reports would trip over.
BROKEN = {
    "another version": lambda r: r.update(schema="mrm.validate/2"),
    "a key left out": lambda r: r["summary"].pop("skipped"),
    "a key too many": lambda r: r["documents"][0].update(time="now"),
    "an absolute path": lambda r: r["documents"][0].update(path="/home/a.mtlx"),
    "an unknown code": lambda r: r["documents"][0]["findings"][0].update(code="OOPS"),
    "an unknown status": lambda r: target(r, "glsl").update(status="passed"),
    "a skip without a reason": lambda r: target(r, "osl").update(reason=None),
    "a verdict with a reason": lambda r: target(r, "glsl").update(reason="because"),
    "an unknown target": lambda r: r["documents"][0]["renderables"][0]["targets"].update(cobol=target(r, "glsl")),
    "a sample without directions": lambda r: target(r, "glsl")["worst"].pop("v"),
    "a vector of two": lambda r: target(r, "glsl")["worst"]["v"].pop(),
    "a finding in an absolute file": lambda r: r["documents"][0]["findings"][0].update(file="/home/a.mtlx"),
    "a line before the first": lambda r: r["documents"][0]["findings"][0].update(line=0),
    "a column left out": lambda r: r["documents"][0]["findings"][0].pop("column"),
    "a pointer that is a path": lambda r: r["documents"][0]["findings"][0].update(pointer="materials"),
    "a negative error": lambda r: target(r, "glsl").update(max_error=-1.0),
    "an engine without a name": lambda r: r["engines"]["gl"].pop("renderer"),
}


def target(report: dict, name: str) -> dict:
    return report["documents"][0]["renderables"][0]["targets"][name]


@pytest.mark.parametrize("change", BROKEN)
def test_a_broken_report_does_not_follow_the_schema(conforms, change):
    report = json.loads(reports.to_json(run_of(document("a.mtlx", ERROR, glsl=PASS, osl=SKIP))))
    assert conforms(report)
    damaged = copy.deepcopy(report)
    BROKEN[change](damaged)
    assert not conforms(damaged)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_numbers_that_are_not_finite_become_null(conforms, value):
    worst = {**WORST, "found": [value, 1.0, value], "error": value}
    bad = TargetResult(Stage.COMPARE, Status.FAIL, None, 64, value, value, 0.1, worst)
    text = reports.to_json(run_of(document("a.mtlx", glsl=bad)))
    report = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert conforms(report)
    assert target(report, "glsl")["max_error"] is None
    assert target(report, "glsl")["worst"]["found"] == [None, 1.0, None]
    assert target(report, "glsl")["tolerance"] == 0.1


@pytest.mark.parametrize("text", NASTY.values(), ids=list(NASTY))
def test_json_carries_any_text(conforms, text):
    result = run_of(document(f"x{text}.mtlx", rules.DOC_INVALID.at(text, text, text), glsl=PASS))
    result.documents[0].renderables[0].path = text
    report = json.loads(reports.to_json(result).encode("ascii"))
    assert conforms(report)
    assert report["documents"][0]["path"] == f"x{text}.mtlx"
    assert report["documents"][0]["findings"][0]["message"] == text


HERE = SourceLocation("parts/lobe.mtlx", 12, 5)
IN_ASSET = SourceLocation("a.gltf", 3, 7, pointer="/materials/0")
IN_STAGE = SourceLocation("a.usdz", layer="a.usdz[looks.usda]", prim="/Looks/M")


def test_json_says_where_each_finding_is(conforms):
    places = (HERE, IN_ASSET, IN_STAGE, None)
    findings = [replace(ERROR, source=place) for place in places]
    report = json.loads(reports.to_json(run_of(document("a.mtlx", *findings))))
    assert conforms(report)
    keys = ("file", "line", "column", "pointer", "layer", "prim")
    found = [[f.get(key, "absent") for key in keys] for f in report["documents"][0]["findings"]]
    assert found == [
        ["parts/lobe.mtlx", 12, 5, "absent", "absent", "absent"],
        ["a.gltf", 3, 7, "/materials/0", "absent", "absent"],
        ["a.usdz", None, None, "absent", "a.usdz[looks.usda]", "/Looks/M"],
        ["a.mtlx", None, None, "absent", "absent", "absent"],
    ]


# JUnit ----------------------------------------------------------------------------------------------------------------


def seen(text: str) -> str:
    """What a report shows: the lines as they are, and a space for all that is not seen (Unicode's classes C and Z)."""
    kept = text.replace("\r\n", "\n")
    return "".join(c if c == "\n" or unicodedata.category(c)[0] not in "CZ" else " " for c in kept)


@pytest.mark.parametrize("name", NASTY)
def test_junit_is_xml_whatever_is_in_it(name):
    text = NASTY[name]
    failed = rules.DOC_INVALID.at(text, text, text)
    result = run_of(document(f"x{text}.mtlx", failed, glsl=TargetResult(Stage.READ, Status.SKIP, text or None)))
    result.documents[0].renderables[0].path = text
    root = ET.fromstring(reports.to_junit(result).encode("utf-8"))
    kept = seen(text)
    # XML reads every line end as one \n in text, and as a space in attributes unless it is written as a reference.
    assert root.find("testsuite").get("name").split() == f"x{kept}.mtlx".split()
    assert root.find(".//failure").text.split() == f"{kept}\n{kept}".split()
    assert root.find(".//skipped").text.split() == kept.split()


def test_junit_counts_a_suite_per_document_and_a_case_per_finding_and_target():
    result = run_of(document("a.mtlx", ERROR, WARNING, glsl=PASS, essl=FAIL, osl=SKIP), document("b.mtlx", glsl=PASS))
    root = ET.fromstring(reports.to_junit(result))
    assert root.tag == "testsuites"
    first, second = root.findall("testsuite")
    assert (first.get("name"), first.get("tests"), first.get("failures"), first.get("skipped")) == (
        "a.mtlx",
        "6",
        "2",
        "1",
    )
    assert (second.get("name"), second.get("tests"), second.get("failures"), second.get("skipped")) == (
        "b.mtlx",
        "2",
        "0",
        "0",
    )
    for suite in (first, second):
        assert len(suite.findall("testcase")) == int(suite.get("tests"))
        assert len(suite.findall(".//failure")) == int(suite.get("failures"))
        assert len(suite.findall(".//skipped")) == int(suite.get("skipped"))
    names = [case.get("name") for case in first.findall("testcase")]
    assert names == [
        "findings",
        "SHADER_DIFFERS /sheet",
        "RETRO_INVISIBLE /sheet/lobe",
        "sheet [glsl]",
        "sheet [essl]",
        "sheet [osl]",
    ]
    assert first.find(".//skipped").get("message") == "no OSL engine"


def test_junit_says_where_each_finding_is():
    findings = [replace(ERROR, source=HERE), replace(WARNING, source=None)]
    root = ET.fromstring(reports.to_junit(run_of(document("a.mtlx", *findings, glsl=PASS))))
    places = [(case.get("file"), case.get("line")) for case in root.iter("testcase")]
    assert places == [(None, None), ("parts/lobe.mtlx", "12"), ("a.mtlx", None), (None, None)]


# GitHub ---------------------------------------------------------------------------------------------------------------


def parsed(line: str) -> tuple[str, dict[str, str], str]:
    """A workflow command as GitHub's runner reads it (actions/runner, ActionCommand.TryParseV2)."""
    command, _, message = line.removeprefix("::").partition("::")
    kind, _, properties = command.partition(" ")
    values = dict(item.split("=", 1) for item in properties.split(","))
    return kind, {key: unescaped(value, "%3A:", "%2C,") for key, value in values.items()}, unescaped(message)


def unescaped(text: str, *more: str) -> str:
    for code in ("%0D\r", "%0A\n", *more, "%25%"):
        text = text.replace(code[:3], code[3:])
    return text


@pytest.mark.parametrize("text", NASTY.values(), ids=list(NASTY))
def test_github_reads_back_what_was_written_whatever_is_in_it(text):
    failed = rules.DOC_INVALID.at("/a", text, "hint")
    lines = reports.to_github(run_of(document(f"x{text}.mtlx", failed)))
    assert "\n" not in lines
    assert "\r" not in lines
    kind, properties, message = parsed(lines)
    assert (kind, properties["title"]) == ("error", "DOC_INVALID")
    assert properties["file"].split() == f"x{seen(text)}.mtlx".split()
    assert message == f"/a: {seen(text)} hint"


def test_github_gets_a_line_per_finding_and_nothing_for_none():
    result = run_of(document("a.mtlx", ERROR, WARNING, glsl=PASS), document("b.mtlx"), document("c.mtlx", WARNING))
    found = [parsed(line) for line in reports.to_github(result).splitlines()]
    assert [(kind, properties["file"]) for kind, properties, _ in found] == [
        ("error", "a.mtlx"),
        ("warning", "a.mtlx"),
        ("warning", "c.mtlx"),
    ]
    assert reports.to_github(run_of(document("b.mtlx"))) == ""


def test_github_is_told_line_and_column_where_they_are_known():
    findings = [replace(ERROR, source=place) for place in (HERE, IN_STAGE, SourceLocation("a,b:c%.mtlx", 1, 1), None)]
    found = [parsed(line)[1] for line in reports.to_github(run_of(document("a.mtlx", *findings))).splitlines()]
    assert found == [
        {"file": "parts/lobe.mtlx", "line": "12", "col": "5", "title": "SHADER_DIFFERS"},
        {"file": "a.usdz", "title": "SHADER_DIFFERS"},
        {"file": "a,b:c%.mtlx", "line": "1", "col": "1", "title": "SHADER_DIFFERS"},
        {"file": "a.mtlx", "title": "SHADER_DIFFERS"},
    ]


def test_the_verdict_says_that_it_is_strict_and_whether_that_is_why_it_failed():
    result = run_of(document("a", WARNING, glsl=PASS))
    counts = "0 errors, 1 warning, 1 checked, 0 skipped"
    assert reports.verdict(result, strict=False) == f"PASSED  {counts}"
    assert reports.verdict(result, strict=True) == f"FAILED  {counts}; --strict: warnings and skips count as failures"
    broken, clean = run_of(document("a", ERROR, glsl=PASS)), run_of(document("a", glsl=PASS))
    assert reports.verdict(broken, strict=True) == "FAILED  1 error, 0 warnings, 1 checked, 0 skipped; --strict"
    assert reports.verdict(clean, strict=True) == "PASSED  0 errors, 0 warnings, 1 checked, 0 skipped; --strict"


# The page ------------------------------------------------------------------------------------------------------------


def test_the_examples_of_the_page_are_what_is_printed(repository, in_process, tmp_path):
    page = (repository / "docs" / "reports.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(\w+)\n(.*?)```", page, re.DOTALL)
    (document,) = [text for kind, text in blocks if kind == "xml"]
    report, line, annotation = [text for kind, text in blocks if kind == "text"]
    (finding,) = [json.loads(text) for kind, text in blocks if kind == "json"]
    (tmp_path / "signs").mkdir()
    (tmp_path / "signs" / "stop.mtlx").write_text(document, encoding="utf-8")
    command = ("validate", "signs", "--target", "mdl", "--format")
    assert in_process(*command, "text").stdout.startswith(report)
    assert line in in_process("generate", "signs/stop.mtlx").stderr
    assert annotation in in_process(*command, "github").stdout
    told = json.loads(in_process(*command, "json").stdout)
    assert finding in told["documents"][0]["findings"]
