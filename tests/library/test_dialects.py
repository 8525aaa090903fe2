"""Versions of MaterialX: what each has, and how they are compared."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.library import dialects


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
