"""Every rule has a document that triggers it and one, as similar as can be, that does not."""

from __future__ import annotations

import ast
import json
import multiprocessing
import os
import pickle
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import pages, rules
from mrm_mtlx.findings.catalogue import RULES
from mrm_mtlx.findings.finding import Severity
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.validation.runner import validate

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.findings.finding import Finding

# Where a rule needs another target than GLSL to show.
TARGETS = {"SHADER_DIFFERS": ("glsl", "essl"), "SHADER_IGNORES_RETRO": ("glsl", "mdl")}

# These show in what the driver does with the shader.
NEED_GL = {
    "SHADER_COMPILE",
    "SHADER_DIFFERS",
    "UPSTREAM_DEVIATION",
    "SHADER_NOT_FINITE",
    "CHECK_CRASHED",
    "CHECK_TIMEOUT",
}

# These end the process that checks the document.
FATAL = {"CHECK_CRASHED", "CHECK_TIMEOUT"}

# These show when a document is written in another format, which a file of that name is.
WRITTEN = {
    "INTERCHANGE_APPROXIMATED": "written.glb",
    "INTERCHANGE_LEFT_OUT": "written.glb",
    "INTERCHANGE_PREVIEW": "written.usda",
}

# Seconds that the endless document is given. The other one of its pair takes about two.
PATIENCE_S = 5.0

LARGE = 100 * 2**20  # bytes
TWENTY = 20  # definitions, whose number of nodes doubles with each


def no_file(folder: Path, _: Path) -> Path:
    return folder / "triggers.mtlx"


def folder_of_a_folder(folder: Path, _: Path) -> Path:
    (folder / "triggers.mtlx").mkdir()
    return folder


def large_file(folder: Path, passes: Path) -> Path:
    path = folder / "triggers.mtlx"
    path.write_bytes(passes.read_bytes())
    os.truncate(path, LARGE)  # sparse: no disk is used
    return path


def definitions_of_definitions(folder: Path, passes: Path) -> Path:
    """Twenty of them, each of which uses the one before it twice."""
    text = passes.read_text(encoding="utf-8")
    start, end = text.index('  <nodedef name="ND_whole"'), text.index("  <whole name=")
    last, more = "whole", ""
    for k in range(TWENTY):
        more += text[start:end].replace("half", last).replace("ND_whole", f"ND_w{k}").replace("NG_whole", f"NG_w{k}")
        more = more.replace('node="whole"', f'node="w{k}"')
        last = f"w{k}"
    path = folder / "triggers.mtlx"
    path.write_text(text[:end] + more + text[end:].replace("whole", last), encoding="utf-8")
    return path


def latin_1(folder: Path, passes: Path) -> Path:
    path = folder / "triggers.mtlx"
    path.write_text(passes.read_text(encoding="utf-8"), encoding="latin-1")
    return path


def gltf_with_a_share_of_two(folder: Path, _: Path) -> Path:
    extensions = {"KHR_materials_retroreflection": {"retroreflectionFactor": 2.0}}
    asset = {"asset": {"version": "2.0"}, "materials": [{"extensions": extensions}, {"name": "valid"}]}
    path = folder / "triggers.gltf"
    path.write_text(json.dumps(asset), encoding="utf-8")
    return path


# Documents that cannot be stored sensibly: a function from an empty folder and the document that passes to the path.
BUILT: dict[str, Callable[[Path, Path], Path]] = {
    "READ_MISSING": no_file,
    "READ_FAILED": folder_of_a_folder,
    "READ_TOO_LARGE": large_file,
    "READ_ENCODING": latin_1,
    "DOC_TOO_LARGE": definitions_of_definitions,
    "INTERCHANGE_INVALID": gltf_with_a_share_of_two,
}


def document(documents: Path, code: str, name: str) -> Path:
    """The document of a rule by its name, whatever its format."""
    (path,) = (documents / code).glob(f"{name}.*")
    return path


@pytest.fixture
def findings(request, check, settings, library, tmp_path) -> Callable[[str, Path], list[Finding]]:
    """Function from a rule's code and a path to the findings that the path's documents get."""

    def of(code: str, path: Path) -> list[Finding]:
        if code in WRITTEN:
            read = read_document(path, Reach.beside(path), library, tmp_path)
            target = tmp_path / WRITTEN[code]
            try:
                return [read.in_source(found) for found in format_for(target).write(read, target, library)]
            except NothingToWriteError as error:
                return [read.in_source(found) for found in error.findings]
        if code in NEED_GL:
            request.getfixturevalue("gl")
        if code in FATAL:
            found = validate([path], settings(timeout_s=PATIENCE_S if code == "CHECK_TIMEOUT" else 120.0)).documents
        else:
            found = check(path, targets=TARGETS.get(code, ("glsl",)))
        return [f for document in found for f in document.findings]

    return of


def tag_of(text: str, path: str) -> tuple[int, int]:
    """Line and column of the tag that has the last name of a path, behind the tags of its parents."""
    end = 0
    for name in path.split("/")[1:]:
        named = re.compile(rf'<\w+(?:\s+\w+="[^"]*")*?\s+name="{re.escape(name)}"').search(text, end)
        assert named is not None, path
        end = named.end()
    lines = text[: named.start()].split("\n")
    return len(lines), len(lines[-1]) + 1


def expected_place(found: Finding, path: Path) -> tuple[int | None, int | None]:
    """Line and column of what a finding in a .mtlx is about, by searching the text; None for a column that it says."""
    line = re.fullmatch(r"line (\d+)", found.location)
    if line:
        return int(line[1]), None
    if not found.location:
        return None, None
    text = path.read_text(encoding="utf-8")
    if found.code == "DOC_DUPLICATE_NAME":  # the second is meant
        first, _ = tag_of(text, found.location)
        text = "\n" * first + text.split("\n", first)[first]
    return tag_of(text, found.location)


@pytest.mark.parametrize("code", RULES)
def test_every_rule_is_triggered_by_its_document_alone_and_not_by_the_one_beside_it(
    findings, documents, tmp_path, code
):
    right = document(documents, code, "passes")
    wrong = BUILT[code](tmp_path, right) if code in BUILT else document(documents, code, "triggers")
    found = findings(code, wrong)
    assert {one.code for one in found} == {code}
    assert findings(code, right) == []
    for one in found if wrong.is_file() else ():
        assert one.source is not None
        assert Path(one.source.file).parts[-2:] == wrong.parts[-2:]
        if wrong.suffix == ".mtlx":
            line, column = expected_place(one, wrong)
            assert one.source == SourceLocation(one.source.file, line, column or one.source.column)
    assert multiprocessing.active_children() == []


def test_the_documents_are_those_of_the_catalogue_and_each_says_what_it_shows(documents):
    assert sorted(path.name for path in documents.iterdir()) == sorted(RULES)
    for code in RULES:
        assert any((documents / code).glob("triggers.*")) != (code in BUILT), code
        for path in (p for p in (documents / code).iterdir() if p.is_file()):
            assert re.search(r"<!-- \w.+\. -->|^# \w.+\.$", path.read_text(encoding="utf-8"), re.DOTALL | re.M), path


def test_a_pair_of_documents_differs_in_few_lines(documents):
    # More would leave open which of the differences is the one that counts: a comment, and the wrong lines.
    few = 8
    for code in sorted(set(RULES) - set(BUILT) - {"READ_TOO_DEEP"}):
        wrong, right = (
            document(documents, code, name).read_text(encoding="utf-8").splitlines() for name in ("triggers", "passes")
        )
        assert 0 < len([line for line in wrong if line not in right]) <= few, code


@pytest.mark.parametrize("code", RULES)
def test_every_rule_is_explained_on_the_command_line_and_in_the_page(code):
    rule = RULES[code]
    page, whole = pages.page(rule), pages.markdown_page(RULES.values())
    assert rule.code == code
    assert rule.severity in Severity
    for text in (rule.title, rule.meaning, rule.remedy):
        assert text == text.strip() != ""
        assert "  " not in text  # a seam between two halves of a string
    for text in (rule.meaning, rule.remedy):
        assert text.endswith(".")
        assert flat(text) in flat(page)
        assert flat(text) in flat(whole)
    assert page.startswith(f"{code} ({rule.severity}): {rule.title}\n")
    assert f"\n## {code}\n\n*{rule.severity}*: {rule.title}\n" in whole


def flat(text: str) -> str:
    """Text without white space: where lines are broken, at a space or a hyphen, does not count."""
    return "".join(text.split())


def test_a_finding_takes_severity_and_hint_from_its_rule():
    plain = rules.DOC_CYCLE.at("/a", "found")
    assert (plain.code, plain.severity, plain.hint) == ("DOC_CYCLE", Severity.ERROR, rules.DOC_CYCLE.remedy)
    assert rules.DOC_CYCLE.at("/a", "found", "do this").hint == "do this"
    with pytest.raises(AttributeError):
        rules.DOC_SQUARE.at("/a", "found")


def test_a_rule_is_called_by_its_code():
    assert {name: getattr(rules, name).code for name in rules.__all__} == {code: code for code in RULES}


def test_a_rule_is_the_same_object_in_another_process():
    found = rules.DOC_CYCLE.at("/a", "found")
    assert pickle.loads(pickle.dumps(found)) == found
    code = f"import pickle, sys; found = pickle.loads({pickle.dumps(found)!r})\n"
    code += "from mrm_mtlx.findings import rules; sys.exit(found.rule is not rules.DOC_CYCLE)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_each_rule_is_used_where_something_is_checked(repository):
    package = repository / "mrm_mtlx"
    used = {
        node.attr
        for path in package.rglob("*.py")
        if not path.is_relative_to(package / "findings")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "rules"
    }
    assert used >= RULES.keys()
