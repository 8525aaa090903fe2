"""The retroreflective flag in files that state a version without it: MaterialX upgrades these and says nothing."""

from __future__ import annotations

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.library import load_library

FLAG = '<input name="retroreflective" type="boolean" {} />'


def file_of(version: str, *elements: str) -> str:
    stated = f' version="{version}"' if version else ""
    return "\n".join([f"<materialx{stated}>", *elements, "</materialx>", ""])


def metal(name: str, flag: str = 'value="true"', category: str = "conductor_bsdf") -> str:
    return f'<{category} name="{name}" type="BSDF">{FLAG.format(flag)}</{category}>'


@pytest.fixture
def found(tmp_path):
    """Function from the text of a document to the places of the rule's findings in it."""

    def read(text: str) -> list[tuple[str, str, int]]:
        path = tmp_path / "a.mtlx"
        path.write_text(text, encoding="utf-8")
        findings = read_document(path, Reach.beside(path), load_library(), tmp_path / "scratch").findings
        rows = [f for f in findings if f.code == "RETRO_VERSION"]
        return [(f.location, f.source.file.rpartition("/")[2], f.source.line) for f in rows]

    return read


@pytest.mark.parametrize("flag", ['value="true"', 'value="false"', 'nodename="switch"', 'interfacename="switch"'])
def test_whatever_the_flag_is_set_to_an_earlier_host_does_not_know_it(found, flag):
    assert found(file_of("1.38", metal("a", flag))) == [("/a/retroreflective", "a.mtlx", 2)]


@pytest.mark.parametrize("category", ["conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf"])
def test_it_is_said_of_each_node_also_in_graphs(found, category):
    text = file_of(
        "1.37", metal("a", category=category), f'<nodegraph name="g">{metal("b", category=category)}</nodegraph>'
    )
    assert [place for place, _, _ in found(text)] == ["/a/retroreflective", "/g/b/retroreflective"]


@pytest.mark.parametrize("version", ["1.39", "1.40", "", "new"])
def test_other_versions_and_what_is_none_are_not_taken_for_earlier_ones(found, version):
    assert found(file_of(version, metal("a"))) == []


def test_nodes_without_the_flag_and_inputs_of_that_name_elsewhere_are_fine(found):
    other = f'<mix name="b" type="color3">{FLAG.format("")}</mix>'
    assert found(file_of("1.38", '<conductor_bsdf name="a" type="BSDF" />', other)) == []


@pytest.mark.parametrize(("own", "included"), [("1.38", "1.39"), ("1.39", "1.38")])
def test_of_what_is_included_the_version_of_its_own_file_counts(found, tmp_path, own, included):
    (tmp_path / "b.mtlx").write_text(file_of(included, metal("b")), encoding="utf-8")
    places = found(file_of(own, '<xi:include href="b.mtlx" />', metal("a")))
    assert places == ([("/a/retroreflective", "a.mtlx", 3)] if own == "1.38" else [("/b/retroreflective", "b.mtlx", 2)])
