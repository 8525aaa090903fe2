"""The comparison of two checkouts sees what differs, and nothing else."""

from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

# A command with a report, a table and a file, each of which says what `said` does.
PROGRAM = """
import json, sys
from pathlib import Path

said = {"place": "", "places": {}}
said |= {"engines": {}, "message": "odd", "status": 1, "error": 0.5, "table": "0.1.0", "written": "curve"}
said.update(json.loads(Path(__file__).with_suffix(".json").read_text()))

def run():
    command, *arguments = sys.argv[1:]
    if command == "validate":
        finding = {"code": "DOC_ODD", "severity": "error", "message": said["message"], **said["places"]}
        documents = [{"path": "a.mtlx", "findings": [finding]}, {"path": "b.mtlx", "findings": []}]
        print(json.dumps({"versions": {"mrm": said["table"]}, "engines": said["engines"], "documents": documents}))
    if command == "conformance":
        print(json.dumps({"cases": [{"name": "c", "target": "glsl", "engine": "gl", "max_error": said["error"]}]}))
    if command == "vectors":
        print('# versions "mrm": "' + said["table"] + '"')
    if command == "plot":
        if said.get("option", "--light") not in arguments:
            sys.exit(2)
        Path(arguments[arguments.index("-o") + 1]).write_text(said["written"])
    print(f"{command}: {len(list(Path('materials').iterdir()))} materials", file=sys.stderr)
    print(f"{said['place']}warning DOC_ODD /a: {said['message']}", file=sys.stderr)
    sys.exit(said["status"])
"""
ALL = ("validate/materials", "conformance/gl", "vectors/csv", "plot/materials/cats_eye")


@pytest.fixture
def compare(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str]]:
    """Function from the arguments to the exit status and what is printed."""

    def run(*arguments: object, only: tuple[str, ...] = ALL) -> tuple[int, str]:
        from tools.compare_outputs.__main__ import main

        chosen = [text for name in only for text in ("--only", name)]
        status = main([*map(str, arguments), *chosen, "-j", "1"])
        return status, capsys.readouterr().out

    return run


@pytest.fixture
def checkout(tmp_path: Path) -> Callable[..., Path]:
    """Function from a name and what its command says to a small checkout."""

    def make(name: str, **said: object) -> Path:
        root = tmp_path / name
        for folder in ("materials", "materials_classes", "tests/rules", "tools/fuzz/seeds"):
            (root / folder).mkdir(parents=True)
        (root / "materials" / "cats_eye.mtlx").write_text("<materialx/>")
        (root / "pyproject.toml").write_text('[project.scripts]\nmrm = "program:run"\n')
        (root / "program.py").write_text(PROGRAM)
        (root / "program.json").write_text(json.dumps(said))
        return root

    return make


def test_the_same_output_passes(compare, checkout) -> None:
    status, printed = compare(checkout("old"), checkout("new"))
    assert status == 0
    # Of a run its two streams; of a report its items too, of a plot the picture.
    assert [line.split()[:4] for line in printed.splitlines()[:4]] == [
        ["validate", "8", "compared,", "8"],
        ["conformance", "3", "compared,", "3"],
        ["vectors", "2", "compared,", "2"],
        ["plot", "3", "compared,", "3"],
    ]
    assert printed.splitlines()[-1].split() == ["PASSED", "16", "compared,", "16", "equal,", "0", "different"]


@pytest.mark.parametrize(
    ("planted", "told"),
    [
        ({"message": "even"}, "validate/materials/1.stdout a.mtlx"),
        ({"places": {"hint": "mend it"}}, '+   "hint": "mend it"'),
        ({"engines": {"metal": {}}}, '+  "metal": {}'),
        ({"error": 0.5000000000000001}, "conformance/gl/1.stdout c glsl gl"),
        ({"status": 0}, "+exit status 0"),
        ({"written": "curved"}, "+curved"),
        ({"table": "1,5"}, '+# versions "mrm": "1,5"'),
    ],
)
def test_a_planted_difference_is_told(compare, checkout, planted: dict[str, object], told: str) -> None:
    status, printed = compare(checkout("old"), checkout("new", **planted))
    assert status == 1
    assert told in printed
    assert "FAILED" in printed


def test_places_of_findings_and_versions_are_no_differences(compare, checkout) -> None:
    places = {"file": "a.mtlx", "line": 2, "column": 3, "pointer": "/a", "layer": "a.usda", "prim": "/A"}
    new = checkout("new", places=places, place="parts/a.mtlx:2:3: ", table="0.2.0")
    assert compare(checkout("old"), new)[0] == 0


def test_an_entry_of_a_header_may_be_allowed(compare, checkout) -> None:
    new = checkout("new", engines={"metal": {}})
    assert compare(checkout("old"), new, "--allow", "engines.metal")[0] == 0


def test_an_argument_of_the_new_checkout_may_have_another_name(compare, checkout) -> None:
    old, new = checkout("old"), checkout("new", option="--lights")
    assert compare(old, new, only=ALL[3:])[0] == 1
    assert compare(old, new, "--argument", "plot:--light=--lights", only=ALL[3:])[0] == 0
    assert compare(old, new, "--argument", "plot:=--lights", only=ALL[3:])[0] == 0


def test_kept_output_is_not_computed_again(compare, checkout, tmp_path: Path) -> None:
    old, new = checkout("old"), checkout("new")
    assert compare(old, new, "--keep", tmp_path / "kept")[0] == 0
    (old / "program.json").write_text('{"written": "other"}')
    (new / "materials" / "added.mtlx").write_text("<materialx/>")
    assert compare(old, new, "--keep", tmp_path / "kept")[0] == 0
    assert compare(old, new)[0] == 1


def test_more_documents_may_be_given(compare, checkout, tmp_path: Path) -> None:
    (tmp_path / "corpus").mkdir()
    status, printed = compare(
        checkout("old"), checkout("new"), "--documents", tmp_path / "corpus", only=("validate/corpus",)
    )
    assert status == 0
    assert printed.split()[1] == "4"


def test_nothing_compared_is_no_pass(compare, checkout) -> None:
    assert compare(checkout("old"), checkout("new"), only=("nonsense",))[0] == 1


def test_another_package_than_the_checkouts_is_refused(compare, checkout) -> None:
    new = checkout("new")
    (new / "program.py").unlink()
    (new / "pyproject.toml").write_text('[project.scripts]\nmrm = "json:loads"\n')
    with pytest.raises(SystemExit, match="is not what is imported"):
        compare(checkout("old"), new)


def test_a_changed_figure_of_the_project_is_seen(compare, repository: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed"
    for name in ("mrm_mtlx", "libraries"):
        shutil.copytree(repository / name, changed / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(repository / "pyproject.toml", changed)
    with (changed / "mrm_mtlx" / "bsdf" / "ggx.py").open("a", encoding="utf-8") as module:
        module.write("\nright = distribution\ndistribution = lambda *a: right(*a) * (1 + 1e-12)\n")
    status, printed = compare(repository, changed, only=("vectors/csv",))
    assert status == 1
    assert printed.splitlines()[-1].split() == ["FAILED", "2", "compared,", "1", "equal,", "1", "different"]
