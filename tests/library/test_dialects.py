"""Versions of MaterialX: what each has, and how they are compared."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.library import dialects, materials_folder
from mrm_mtlx.system.arguments import ArgumentError


def test_the_flag_came_with_1_39_5():
    has = {version: dialects.dialect(version).has_retroreflective for version in ("1.36", "1.38", "1.39.4", "1.39.5")}
    assert has == {"1.36": False, "1.38": False, "1.39.4": False, "1.39.5": True}
    # Versions are numbers, not texts; and a document of 1.39 may use what any 1.39 has.
    assert dialects.dialect("1.39.10").has_retroreflective
    assert dialects.dialect("1.100").has_retroreflective
    assert dialects.dialect("1.39").has_retroreflective


def test_the_table_says_of_the_installed_library_what_it_has(upstream_library):
    flagged = upstream_library.document.getNodeDef("ND_conductor_bsdf").getActiveInput("retroreflective") is not None
    assert dialects.dialect(dialects.materialx_version()).has_retroreflective is flagged


def test_the_version_is_that_of_the_module():
    assert dialects.materialx_version() == mx.getVersionString()
    assert mx.getVersionString().startswith(f"{dialects.document_version()}.")


@pytest.mark.parametrize(
    ("version", "upgraded"),
    [("1.38", True), ("1.9", True), ("1.39", False), ("1.40", False), ("2.0", False), ("x", False), ("1.38.1", False)],
)
def test_documents_of_earlier_versions_are_upgraded(version, upgraded):
    assert dialects.is_upgraded(version) is upgraded


@pytest.mark.parametrize("stated", ["1.39", "1.38", ""])
def test_a_document_is_of_the_version_that_it_states(stated):
    document = mx.createDocument()
    document.setVersionString(stated) if stated else document.removeAttribute("version")
    assert dialects.version_of(document) == (stated or dialects.document_version())


@pytest.mark.parametrize(
    ("version", "lacks"),
    [
        ("1.39", False),
        ("1.38", True),
        ("1.4", True),
        ("0.9", True),
        ("1.40", False),
        ("2.0", False),
        ("new", False),
        ("", False),
    ],
)
def test_documents_before_1_39_lack_the_flag(version, lacks):
    assert dialects.lacks_retroreflective(version) is lacks


def test_data_libraries_of_another_version_than_the_module_are_named_by_a_variable(monkeypatch):
    monkeypatch.setenv(dialects.VARIABLE, "1.39.6")
    assert dialects.materialx_version() == dialects.versions()["materialx"] == "1.39.6"
    monkeypatch.setenv(dialects.VARIABLE, "")
    assert dialects.materialx_version() == mx.getVersionString()


@pytest.mark.parametrize("stated", ["1.39.0", "1.39.2"])
def test_what_classes_of_the_module_have_is_asked_of_the_module(monkeypatch, in_process, stated):
    monkeypatch.setenv(dialects.VARIABLE, stated)
    run = in_process("generate", materials_folder() / "cats_eye.mtlx", "--target", "glsl")
    assert (run.exit_code, run.stderr) == (0, "")


@pytest.mark.parametrize("stated", ["new", "1.", "1.39.6-dev", "1.39.6\x1b[2J", "\N{ARABIC-INDIC DIGIT ONE}.39"])
def test_a_variable_that_states_no_version_is_refused_in_one_line(monkeypatch, in_process, stated):
    monkeypatch.setenv(dialects.VARIABLE, stated)
    with pytest.raises(ArgumentError, match=f"variable {dialects.VARIABLE} is '.*', which is no version"):
        dialects.materialx_version()
    for command in (["doctor"], ["validate", materials_folder()]):
        run = in_process(*command)
        assert run.exit_code == 2
        assert run.stderr.count(dialects.VARIABLE) == 1
        assert "\x1b" not in run.stderr


@pytest.mark.parametrize("stated", ["1.38.10", "0.1"])
def test_data_libraries_that_are_not_served_are_refused_with_the_reason(monkeypatch, in_process, stated):
    monkeypatch.setenv(dialects.VARIABLE, stated)
    for command in (["doctor"], ["validate", materials_folder()]):
        run = in_process(*command)
        assert run.exit_code == 2
        assert f"MaterialX {stated} is not served: it refuses documents of version 1.39" in run.stderr


@pytest.mark.parametrize("version", ["", "1", "x", "1.39.x", "1.39.3.1", "-1.39"])
def test_what_is_no_version_is_refused(version):
    with pytest.raises(ValueError, match="is no version of MaterialX"):
        dialects.dialect(version)
