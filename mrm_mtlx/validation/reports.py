"""A validation result as JSON, JUnit XML and GitHub annotations; the terminal's form is in `screen`."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree as ET

from mrm_mtlx.findings.finding import Severity
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.system.json_data import finite
from mrm_mtlx.system.text import plural, printable, text_lines
from mrm_mtlx.validation.results import Status

if TYPE_CHECKING:
    from mrm_mtlx.validation.results import DocumentResult, ValidationResult

SCHEMA = "mrm.validate/1"


def exit_status(result: ValidationResult, *, strict: bool) -> int:
    """0 clean; 1 errors (and, with `strict`, warnings or skips); 3 nothing was checked."""
    if result.count(Severity.ERROR) or any(r.status is Status.FAIL for _, r in result.results()):
        return 1
    if strict and (result.count(Severity.WARNING) or result.skipped):
        return 1
    return 0 if result.checked else 3


def verdict(result: ValidationResult, *, strict: bool) -> str:
    """The last line of a text report: counts, the reasons of skips, --strict if it counts, and if nothing was found."""
    status = exit_status(result, strict=strict)
    word = {0: "PASSED", 1: "FAILED", 3: "NOTHING CHECKED"}[status]
    reasons = Counter(f"{target}: {r.reason}" for target, r in result.results() if r.status is Status.SKIP)
    skipped = f"{result.skipped} skipped"
    if reasons:
        ordered = sorted(reasons.items(), key=lambda item: (-item[1], item[0]))
        skipped += f" ({'; '.join(f'{count} {reason}' for reason, count in ordered)})"
    counts = [
        plural(result.count(Severity.ERROR), "error"),
        plural(result.count(Severity.WARNING), "warning"),
        f"{result.checked} checked",
        skipped,
    ]
    by_strict = "; --strict" if strict else ""
    if status != exit_status(result, strict=False):
        by_strict += ": warnings and skips count as failures"
    nothing = "" if result.documents else "; no document was found"
    return printable(f"{word}  {', '.join(counts)}{by_strict}{nothing}")


def to_json(result: ValidationResult) -> str:
    """The report by docs/report.schema.json; two runs with one seed give the same bytes."""
    report = {
        "schema": SCHEMA,
        "versions": result.versions,
        "engines": result.engines,
        "documents": [
            {
                "path": document.path,
                "findings": [f.in_file(document.path).to_json() for f in document.findings],
                "renderables": [r.to_json() for r in document.renderables],
            }
            for document in result.documents
        ],
        "summary": {
            "errors": result.count(Severity.ERROR),
            "warnings": result.count(Severity.WARNING),
            "documents": len(result.documents),
            "checked": result.checked,
            "skipped": result.skipped,
        },
    }
    return json.dumps(finite(report), indent=2, allow_nan=False)


def to_junit(result: ValidationResult) -> str:
    """JUnit XML: a suite per document, a case for its findings and one per renderable element and target."""
    suites = ET.Element("testsuites", name="mrm validate")
    for document in result.documents:
        _junit_suite(suites, document)
    ET.indent(suites)
    return ET.tostring(suites, encoding="unicode", xml_declaration=True)


def to_github(result: ValidationResult) -> str:
    """Workflow commands of GitHub Actions, one per finding."""
    lines = []
    for document in result.documents:
        for found in document.findings:
            place = f"{found.location}: " if found.location else ""
            source = found.source or SourceLocation(document.path)
            named = {"file": source.file, "line": source.line, "col": source.column, "title": found.code}
            said = {key: _escape(printable(str(value)), ":,") for key, value in named.items() if value is not None}
            properties = ",".join(f"{key}={value}" for key, value in said.items())
            message = _escape(_printable_lines(f"{place}{found.message} {found.hint}"))
            lines.append(f"::{found.severity} {properties}::{message}")
    return "\n".join(lines)


class _Case(NamedTuple):
    """A case of a suite, and what it is, if it did not pass: an element of the case, with a text."""

    name: str
    kind: str = ""
    text: str = ""
    source: SourceLocation | None = None


def _junit_suite(suites: ET.Element, document: DocumentResult) -> None:
    cases = [_Case("findings")]
    for found in document.findings:
        kind = "failure" if found.severity is Severity.ERROR else "system-out"
        name, text = f"{found.code} {found.location}".strip(), f"{found.message}\n{found.hint}"
        cases.append(_Case(name, kind, text, found.source or SourceLocation(document.path)))
    for renderable in document.renderables:
        for target, r in renderable.targets.items():
            kind = {Status.PASS: "", Status.FAIL: "failure", Status.SKIP: "skipped"}[r.status]
            cases.append(_Case(f"{renderable.name} [{target}]", kind, r.reason or (r.stage if kind else "")))
    kinds = [case.kind for case in cases]
    suite = ET.SubElement(
        suites,
        "testsuite",
        name=printable(document.path),
        tests=str(len(cases)),
        failures=str(kinds.count("failure")),
        skipped=str(kinds.count("skipped")),
        errors="0",
    )
    for case in cases:
        source = {"file": case.source.file, "line": case.source.line} if case.source else {}
        said = {"classname": document.path, "name": case.name, **source}
        element = ET.SubElement(suite, "testcase", {k: printable(str(v)) for k, v in said.items() if v is not None})
        shown = _printable_lines(case.text)
        if case.kind == "system-out":
            ET.SubElement(element, case.kind).text = shown
        elif case.kind:
            ET.SubElement(element, case.kind, message=text_lines(shown)[0]).text = shown


def _printable_lines(text: str) -> str:
    """Text whose quoted source keeps its lines; what is printable is what XML 1.0 can hold, too (section 2.2)."""
    return "\n".join(map(printable, text_lines(text)))


def _escape(text: str, also: str = "") -> str:
    for character in "%\r\n" + also:
        text = text.replace(character, f"%{ord(character):02X}")
    return text
