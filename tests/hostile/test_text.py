"""Names and values in documents that would drive the terminal, turn a line around, or pass for several findings."""

from __future__ import annotations

import shutil
import sys
import unicodedata
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.cli.main import command
from mrm_mtlx.findings import rules
from mrm_mtlx.system.text import printable, text_lines
from mrm_mtlx.validation import reports
from mrm_mtlx.validation.checks.graph import check_graph
from mrm_mtlx.validation.results import DocumentResult, RenderableResult, Stage, Status, TargetResult, ValidationResult

if TYPE_CHECKING:
    from collections.abc import Callable

# Clears the screen on terminals that know the C1 controls; the three letters after it are shown from right to left.
CLEAR, OVERRIDE, NEXT_LINE, LINE_SEPARATOR = "\x9b2J", "\u202eabc", "\x85", "\u2028"
EVIL = f"a{CLEAR}b{OVERRIDE}c\u2066d{NEXT_LINE}e{LINE_SEPARATOR}f\x1b[31mg"


def unseen(text: str) -> set[str]:
    """The characters of a text that are not seen, line feeds aside."""
    return {c for c in text if c not in "\n " and unicodedata.category(c)[0] in "CZ"}


@pytest.fixture
def metal(repository, tmp_path):
    """A document without fault."""
    return shutil.copy(repository / "tests" / "rules" / "READ_XML" / "passes.mtlx", tmp_path / "metal.mtlx")


@pytest.fixture
def evil() -> ValidationResult:
    """A run whose every text is hostile."""
    skipped = TargetResult(Stage.GENERATE, Status.SKIP, EVIL)
    document = DocumentResult(
        f"{EVIL}.mtlx", [rules.DOC_FILE.at(EVIL, EVIL)], [RenderableResult(EVIL, {"glsl": skipped})]
    )
    return ValidationResult({}, {}, [document])


@pytest.mark.parametrize("form", [reports.to_junit, reports.to_github, reports.to_json])
def test_a_report_carried_controls_and_marks_of_direction(form: Callable[[ValidationResult], str], evil):
    assert unseen(EVIL) >= {"\x9b", "\u202e", "\u2066", "\x85", "\u2028", "\x1b"}
    assert unseen(form(evil)) == set()


def test_the_last_line_carried_the_reason_of_a_skip_as_it_was(evil):
    assert unseen(reports.verdict(evil, strict=False)) == set()


def test_a_value_made_three_findings_of_one(make_document):
    # MaterialX shows the element in its message, and ends each message by a line feed.
    value = f"one{NEXT_LINE}two{LINE_SEPARATOR}three"
    document = make_document(
        f'<constant name="c" type="float"><input name="value" type="float" value="{value}"/></constant>'
    )
    assert value in document.validate()[1]
    assert [f.code for f in check_graph(document)] == ["DOC_INPUT_VALUE"]


@pytest.mark.parametrize("argument", ["--target", "--element"])
def test_a_usage_error_carried_what_it_was_given(argument, metal, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["mrm", "generate", str(metal), argument, EVIL])
    assert command() == 2
    shown = capsys.readouterr().err
    assert "expected one of" in shown
    assert unseen(shown) == set()


def test_text_is_shown_on_one_line_and_read_in_lines():
    assert printable(EVIL) == "a 2Jb abcc d e f [31mg"
    assert printable("Würzburg \U0001f6a7\xa0\n") == "Würzburg \U0001f6a7  "
    assert text_lines(f"{EVIL}\r\nb\n") == [EVIL, "b"]
    assert text_lines("") == [""]
