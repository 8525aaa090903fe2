"""`mrm convert`: writes OpenMATERIAL's block, merges it, compares with it, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer

from mrm_mtlx.cli.convert import convert

NOTHING = dict.fromkeys(("output", "to", "into", "at", "compare", "observation", "entrance", "element"))
TAPE = Path(__file__).parents[2] / "materials" / "conspicuity_tape_white.mtlx"


def test_a_document_is_written_merged_and_compared(mrm, tmp_path):
    (tmp_path / "sign.json").write_text('{"name": "sign", "optical": {}}')
    done = mrm("convert", TAPE, "-o", "sign.json", "--into", "sign.json", "--at", "/optical", "--observation", 0.5)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "wrote sign.json\n")
    data = json.loads((tmp_path / "sign.json").read_text())
    assert (data["name"], list(data), list(data["optical"])) == ("sign", ["name", "optical"], ["retroreflectivityData"])
    # DOT-C2 asks for 65 at 0.5/-4, and the document says that it is 1.06 to 3.8 times above its minima.
    assert 65.0 < data["optical"]["retroreflectivityData"]["coefficientOfRetroreflection"] < 250.0
    done = mrm("convert", TAPE, "--compare", "sign.json")
    assert done.returncode == 0
    assert "observation 0.5 deg, entrance -4 deg (as the file states)" in done.stdout
    assert done.stdout.splitlines()[-1].startswith("PASSED")
    done = mrm("convert", TAPE, "--compare", "sign.json", "--observation", "0.2")
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1].startswith("FAILED")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "expected a file to write"),
        ({"output": "a.usd"}, "ends in .json, or --to"),
        ({"output": "no/a.json"}, "the folder no does not exist"),
        ({"output": "a.json", "at": "/x"}, "only with --into"),
        ({"output": "a.json", "compare": "plain.json"}, "not with --compare"),
        ({"output": "a.json", "into": "absent.json"}, "does not exist"),
        ({"output": "a.json", "into": "plain.json", "at": "/x"}, "there is no object at '/x'"),
        ({"output": "a.json", "observation": -1.0}, "expected 0 to 90 degrees"),
        ({"output": "a.json", "observation": float("nan")}, "expected 0 to 90 degrees"),
        ({"output": "a.json", "entrance": 91.0}, "expected -90 to 90 degrees"),
        ({"compare": "plain.json"}, "has no retroreflectivityData"),
    ],
    ids=str,
)
def test_a_wrong_call_is_told_so(monkeypatch, tmp_path, metal, options, message):
    monkeypatch.chdir(tmp_path)
    Path("plain.json").write_text("{}")
    paths = {name: Path(value) for name, value in options.items() if name in ("output", "into", "compare")}
    with pytest.raises(typer.BadParameter) as caught:
        convert(**NOTHING | {"path": metal} | options | paths)
    assert message in str(caught.value)
    assert not Path("a.json").exists()


def test_a_wrong_format_is_a_usage_error(mrm, metal):
    done = mrm("convert", metal, "-o", "a.json", "--to", "gltf")
    assert (done.returncode, done.stdout) == (2, "")
    assert "'gltf'" in done.stderr
