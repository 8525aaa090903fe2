"""`python -m tools.make_docs`: it knows every generated file, and sees what is out of date."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

import pytest

from tools import make_docs
from tools.make_docs import PRODUCTS, Product, make_all, same_picture, verdict

if TYPE_CHECKING:
    from pathlib import Path


def test_every_figure_and_picture_of_the_documentation_is_made_by_the_command(repository: Path) -> None:
    docs = repository / "docs"
    drawn = {
        f"{path.parent.name}/{path.name}" for folder in ("figures", "images") for path in (docs / folder).iterdir()
    }
    assert drawn == {name for name in PRODUCTS if "/" in name}
    marked = {path.name for path in docs.glob("*.md") if path.read_text(encoding="utf-8").startswith("<!-- Made by")}
    assert marked == {name for name in PRODUCTS if "/" not in name}


def test_the_page_of_rules_is_what_the_command_prints() -> None:
    assert make_docs.main(["--check", "rules.md"]) == 0


def test_a_page_that_is_out_of_date_is_seen(tmp_path: Path) -> None:
    product = Product(("-c", "print('the page as it is now')"))
    kept = tmp_path / "kept.md"
    kept.write_text("the page as it is now\n", encoding="utf-8")
    assert verdict(product, kept, tmp_path / "again.md") == "up to date"
    kept.write_text("the page as it was\n", encoding="utf-8")
    assert verdict(product, kept, tmp_path / "again.md") == "out of date"
    assert verdict(product, tmp_path / "absent.md", tmp_path / "again.md") == "out of date"


def test_check_fails_where_one_file_is_out_of_date_and_names_what_it_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(make_docs, "DOCS", tmp_path)
    (tmp_path / "good.md").write_text("1\n", encoding="utf-8")
    (tmp_path / "bad.md").write_text("2\n", encoding="utf-8")
    one = Product(("-c", "print(1)"))
    products = {"good.md": one, "bad.md": one, "large.png": Product(("-c", "raise SystemExit(1)"), minutes=True)}
    monkeypatch.setattr(make_docs, "PRODUCTS", products)
    assert make_docs.main(["--check"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "up to date    good.md",
        "out of date   bad.md",
        "not compared  large.png",
    ]
    assert make_docs.main(["--check", "good.md"]) == 0
    assert make_docs.main(["large.png"]) == 2


def test_a_command_that_makes_several_files_runs_once(tmp_path: Path) -> None:
    code = "import pathlib, sys; pathlib.Path(sys.argv[1], 'runs').open('a').write('x')"
    both = Product(("-c", code, "{folder}"))
    assert make_all({"a.png": both, "b.png": both}, tmp_path) == 0
    assert (tmp_path / "runs").read_text(encoding="utf-8") == "x"


def test_a_command_that_fails_leaves_the_file_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(make_docs, "DOCS", tmp_path)
    code = "import sys; print('half a page'); sys.exit('no driver')"
    monkeypatch.setattr(make_docs, "PRODUCTS", {"page.md": Product(("-c", code))})
    (tmp_path / "page.md").write_text("kept\n", encoding="utf-8")
    assert make_docs.main([]) == 2
    assert "no driver" in capsys.readouterr().err
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == "kept\n"


def test_a_name_that_is_not_generated_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        make_docs.main(["usd.md"])
    assert refused.value.code == 2
    assert "usd.md is not generated" in capsys.readouterr().err


def test_pictures_that_differ_in_roundings_alone_are_the_same() -> None:
    assert same_picture('<path d="M 1.001 2"/>', '<path d="M 1.011 2"/>')
    assert not same_picture('<path d="M 1.001 2"/>', '<path d="M 1.061 2"/>')
    assert not same_picture('<path d="M 1.001 2"/>', '<path d="M 1.001 2 3"/>')


@pytest.mark.parametrize("name", ["osl_accuracy", "pictures"])
def test_programs_that_take_minutes_import(name: str) -> None:
    assert importlib.import_module(f"tools.{name}").main
