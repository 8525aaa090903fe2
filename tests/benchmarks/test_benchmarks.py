"""The benchmarks run, at sizes that say nothing about speed, and keep their tables; no time decides anything here."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

import pytest

from benchmarks import gl as driver
from benchmarks import lobes, oracle, timing, tolerance, usd

if TYPE_CHECKING:
    from pathlib import Path
    from types import ModuleType

SUBJECTS = ("gl", "mitsuba", "oracle", "surface", "tolerance", "usd", "validate")


def test_every_subject_has_a_module_that_imports_and_a_kept_page(repository: Path) -> None:
    folder = repository / "benchmarks"
    assert {path.stem for path in folder.glob("*.md")} - {"README"} == set(SUBJECTS)
    for name in SUBJECTS:
        module = importlib.import_module(f"benchmarks.{name}")
        title = (folder / f"{name}.md").read_text(encoding="utf-8").splitlines()[1]
        assert title == f"# {module.__doc__.splitlines()[0].rstrip('.')}"
        assert module.measure


@pytest.mark.parametrize("module", [oracle, tolerance, usd], ids=lambda module: module.__name__)
def test_a_benchmark_gives_a_number_in_every_row(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    small(monkeypatch)
    table = module.measure()
    rows = list(table.rows)
    assert rows
    for row in rows:
        assert len(row) == len(table.columns)
        assert float(row[1]) >= 0.0


def test_the_benchmark_of_the_driver_gives_numbers(gl: object, monkeypatch: pytest.MonkeyPatch) -> None:
    small(monkeypatch)
    table = driver.measure()
    assert all(float(cell) >= 0.0 for row in table.rows for cell in row[1:])


def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sizes that take no time."""
    monkeypatch.setattr(timing, "REPEATS", 1)
    monkeypatch.setattr(lobes, "COUNT", 64)
    monkeypatch.setattr(oracle, "COUNT", 64)
    monkeypatch.setattr(tolerance, "LIT", 64)
    monkeypatch.setattr(tolerance, "FEW", 8)
    monkeypatch.setattr(driver, "COUNTS", (64,))
    monkeypatch.setattr(usd, "PRIMS", 20)


def test_a_page_says_what_was_measured_and_on_what_and_names_no_host(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "A subject.\n\nWhat there is to know.\n"
    monkeypatch.setattr(sys, "argv", ["subject", "--save"])
    timing.run(text, lambda: timing.Table(("what", "s"), [("one", "1.0")]), str(tmp_path / "subject.py"))
    printed = capsys.readouterr().out
    lines = (tmp_path / "subject.md").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "<!-- Made by: python -m benchmarks.subject --save -->"
    assert lines[1:] == printed.splitlines()
    assert (lines[1], lines[3], lines[-1]) == ("# A subject", "What there is to know.", "| one | 1.0 |")
    assert lines[5].startswith("On ")
    assert "numpy" in lines[5]
