"""A rule that another package registers: it is listed, explained, checked and reported like ours."""

from __future__ import annotations

import json

import pytest

GROUP = "mrm_mtlx.rules"
SQUARE = '''
"""A studio's own rule: names of materials are in capitals."""

from mrm_mtlx.documents.elements import location
from mrm_mtlx.findings.finding import Rule, Severity


def check(document):
    for material in document.getMaterialNodes():
        if material.getName().islower():
            yield SHOUT.at(location(material), f"'{material.getName()}' has no capital")


SHOUT = Rule(
    "STUDIO_NAME",
    Severity.WARNING,
    "material without a capital",
    "Our materials have capitals, so that artists find them.",
    "Write one.",
    check=check,
)
'''
DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39">
  <conductor_bsdf name="metal" type="BSDF"/>
  <surface name="lit" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="metal"/></surface>
  <surfacematerial name="NAME" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="lit"/>
  </surfacematerial>
</materialx>
"""


@pytest.fixture
def studio(mrm, installed):
    """Function that runs a command where the rule is installed."""
    variables = installed("studio_rules", SQUARE, GROUP, shout="studio_rules:SHOUT")
    return lambda *arguments: mrm(*arguments, **variables)


@pytest.fixture
def pair(tmp_path):
    """The documents that trigger the rule, and that pass."""
    for name in ("sign", "Sign"):
        (tmp_path / f"{name}.mtlx").write_text(DOCUMENT.replace("NAME", name), encoding="utf-8")
    return tmp_path / "sign.mtlx", tmp_path / "Sign.mtlx"


def test_another_packages_rule_is_listed_and_explained(studio):
    assert studio("rules").stdout.splitlines()[-1].split(maxsplit=2) == [
        "STUDIO_NAME",
        "warning",
        "material without a capital",
    ]
    assert "so that artists find them" in studio("rules", "STUDIO").stdout
    assert "STUDIO" not in studio("rules", "--markdown").stdout  # the page of this package's own


def test_a_rule_whose_check_fails_is_named(mrm, installed, pair):
    source = SQUARE.replace("material.getName().islower()", "material.islower()")
    variables = installed("studio_rules", source, GROUP, shout="studio_rules:SHOUT")
    said = "the check of STUDIO_NAME, which another package registers, failed (AttributeError: "
    done = mrm("generate", pair[0], **variables)
    assert (done.returncode, done.stderr.startswith(f"mrm: {said}")) == (2, True)
    done = mrm("validate", pair[0], "--target", "mdl", **variables)
    assert (done.returncode, said in done.stdout) == (1, True)


def test_another_packages_rule_is_checked_in_worker_processes(studio, pair):
    done = studio("validate", *pair, "--target", "glsl", "--samples", "64", "--format", "json", "--select", "STUDIO")
    found = {
        document["path"].rpartition("/")[2]: document["findings"] for document in json.loads(done.stdout)["documents"]
    }
    assert found["Sign.mtlx"] == []
    (finding,) = found["sign.mtlx"]
    assert (finding["code"], finding["severity"], finding["location"]) == ("STUDIO_NAME", "warning", "/sign")
    assert (finding["message"], finding["hint"]) == ("'sign' has no capital", "Write one.")
    assert studio("validate", pair[0], "--target", "glsl", "--samples", "64", "--strict").returncode == 1


def test_another_packages_rule_is_told_by_every_command(studio, pair):
    done = studio("generate", pair[0], "--target", "glsl")
    assert done.stderr.splitlines()[0] == "sign.mtlx:5:3: warning STUDIO_NAME /sign: 'sign' has no capital"


@pytest.mark.parametrize(
    ("source", "value", "words"),
    [
        ("import a_module_that_is_not_there", "studio_rules:SHOUT", "does not load (ModuleNotFoundError"),
        ("SHOUT = 1", "studio_rules:SHOUT", "is a int, expected a Rule"),
        (SQUARE.replace("STUDIO_NAME", "studio"), "studio_rules:SHOUT", "is no code of a rule"),
        (SQUARE.replace("STUDIO_NAME", "DOC_CYCLE"), "studio_rules:SHOUT", "two rules are called DOC_CYCLE"),
    ],
)
def test_a_rule_that_is_of_no_use_is_told_in_one_line(mrm, installed, tmp_path, source, value, words):
    variables = installed("studio_rules", source, GROUP, shout=value)
    (tmp_path / "sign.mtlx").write_text(DOCUMENT.replace("NAME", "sign"), encoding="utf-8")
    for command in (("rules",), ("validate", tmp_path / "sign.mtlx", "--target", "glsl")):
        done = mrm(*command, **variables)
        assert (done.returncode, done.stdout) == (2, "")
        (line,) = done.stderr.splitlines()
        assert line.startswith("mrm: ")
        assert words in line
