"""The examples of docs/api.md: each is run, and gives what the page says."""

from __future__ import annotations

import doctest
import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import mrm_mtlx as mrm

if TYPE_CHECKING:
    import pytest

REPOSITORY = Path(__file__).parents[1]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL


def text() -> str:
    return (REPOSITORY / "docs" / "api.md").read_text(encoding="utf-8")


def failures(page: str) -> str:
    """What doctest says of the examples of a page; empty if they are true."""
    blocks = re.findall(r"^( *)```python\n(.*?)^ *```$", page, re.DOTALL | re.MULTILINE)
    examples = "\n".join(textwrap.dedent(block) for _, block in blocks)
    test = doctest.DocTestParser().get_doctest(examples, {}, "docs/api.md", None, 0)
    said: list[str] = []
    doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(test, out=said.append)
    return "".join(said)


def test_the_examples_of_the_page_are_true(gl: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    del gl  # validate and render need a driver
    (tmp_path / "materials").symlink_to(REPOSITORY / "materials")
    monkeypatch.chdir(tmp_path)
    assert failures(text()) == ""


def test_an_example_that_is_not_true_is_seen() -> None:
    assert "Expected:" in failures("```python\n>>> 1 + 1\n3\n```\n")


def test_the_page_names_every_public_function() -> None:
    functions = {name for name in mrm.__all__ if callable(getattr(mrm, name)) and name[0].islower()}
    assert {name for name in functions if f"`{name}(" not in text()} == set()
