"""Where the elements of documents stand: each is found where a search of the text finds it, or not at all."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import MaterialX as mx
import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.xml_scan import scan
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.reading import read_document

if TYPE_CHECKING:
    from mrm_mtlx.documents.document import Document


@pytest.fixture
def read(tmp_path, monkeypatch, library):
    """Function that writes files into the current folder, and reads the first of them."""
    monkeypatch.chdir(tmp_path)

    def reading(*contents: str | bytes, names: tuple[str, ...] = ("a.mtlx",)) -> Document:
        for name, content in zip(names, contents, strict=True):
            path = Path(name)
            path.parent.mkdir(exist_ok=True, parents=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_document(Path(names[0]), Reach.beside(Path(names[0])), library, tmp_path / "scratch")

    return reading


class Tag(NamedTuple):
    """Where a text has a tag."""

    line: int
    column: int


def tag_of(text: str, mark: str) -> Tag:
    """Where the tag begins that has a mark in it which the text has once."""
    assert text.count(mark) == 1
    before = text[: max(found.start() for found in re.finditer(r"<\w", text[: text.index(mark) + 1]))]
    lines = before.split("\n")
    return Tag(len(lines), len(lines[-1]) + 1)


def at(document: Document, path: str) -> Tag | None:
    """Line and column of an element by its path; None if they are not known."""
    found = document.locations.of(path)
    return None if found.line is None else Tag(found.line, found.column)


PLAIN = """\
<?xml version="1.0"?>
<!-- a comment
     of two lines -->
<materialx version="1.39">
  <nodegraph name="graph"><constant name="first" type="color3"><input name="value" type="color3" value="1, 0, 0"/>
    </constant>
\t<constant
      name="second" type="color3">
      <input type="color3" doc="ä€🚧" name="value" value="0, 1, 0" /><!-- ü -->  <!--
      --></constant>  <constant name="third" type="color3"/>
    <output name="out" type="color3" nodename="second"/>
  </nodegraph>
  <surface_unlit name="unlit" type="surfaceshader">
    <input name="emission_color" type="color3" nodegraph="graph" output="out"/>
  </surface_unlit>
  <surfacematerial name="material" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="unlit"/>
  </surfacematerial>
</materialx>
"""
MARKS = {
    "/graph": '"graph">',
    "/graph/first": '"first"',
    "/graph/first/value": "1, 0, 0",
    "/graph/second": 'name="second" type',
    "/graph/second/value": "0, 1, 0",
    "/graph/third": '"third"',
    "/graph/out": 'name="out"',
    "/unlit": 'name="unlit" type',
    "/unlit/emission_color": "emission_color",
    "/material": 'name="material"',
    "/material/surfaceshader": 'name="surfaceshader"',
}


@pytest.mark.parametrize("path", MARKS)
def test_an_element_is_where_its_tag_begins(read, path):
    assert at(read(PLAIN), path) == tag_of(PLAIN, MARKS[path])


@pytest.mark.parametrize(
    "changed",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: "\ufeff" + text,
        lambda text: "\ufeff" + text.partition("\n")[2].partition("-->\n")[2].replace("\n", " "),
        lambda text: text.replace(' type="color3"', ' type="color3" uiname="a < b"'),
        lambda text: text.replace('"1.39"', '"1.38"'),
        lambda text: "\n" * 70_000 + text.partition("\n")[2],
    ],
    ids=["Windows", "old Mac", "byte order mark", "one line", "a < in values", "earlier version", "far down"],
)
def test_it_is_found_however_the_text_is_written(read, changed):
    content = changed(PLAIN)
    document = read(content)
    text = content.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    assert {path: at(document, path) for path in MARKS} == {path: tag_of(text, mark) for path, mark in MARKS.items()}


def test_every_element_of_a_document_is_found_once(read):
    document = read(PLAIN)
    paths = [f"/{element.getNamePath()}" for element in document.materialx.traverseTree() if element.getName()]
    found = [at(document, path) for path in paths]
    assert len(set(found)) == len(paths) == len(MARKS)
    assert found == sorted(found)


def test_what_a_document_has_not_is_where_its_parent_is(read):
    document = read(PLAIN)
    assert at(document, "/graph/second/absent") == at(document, "/graph/second")
    assert at(document, "/graph/absent/value") == at(document, "/graph")
    for path in ("", "/", "/absent", "/absent/value", "line 3"):
        assert document.locations.of(path) == SourceLocation("a.mtlx")


def lines(elements: str, version: str = "1.39") -> str:
    return f'<materialx version="{version}">\n{textwrap.dedent(elements).strip()}\n</materialx>\n'


def test_of_two_of_a_name_it_is_the_first_as_in_materialx(read):
    text = lines("""
        <constant name="c" type="float"><input name="value" type="float" value="1"/></constant>
        <constant name="c" type="float"><input name="value" type="float" value="2"/>
          <input name="other" type="float" value="3"/></constant>
        <constant name="d" type="float"/>
    """)
    document = read(text)
    assert at(document, "/c") == (2, 1)
    assert at(document, "/c/value") == tag_of(text, 'value="1"')
    assert at(document, "/c/other") == (2, 1)
    assert at(document, "/d") == (5, 1)
    (twice,) = document.findings
    assert (twice.code, twice.location, twice.source) == ("DOC_DUPLICATE_NAME", "/c", SourceLocation("a.mtlx", 3, 1))


def test_elements_without_names_have_those_that_materialx_gives(read):
    text = lines("""
        <constant type="float" doc="0"><input type="float" doc="1"/><input type="float" doc="2"/></constant>
        <constant name="constant2" type="float" doc="3"/>
        <constant type="float" doc="4"/>
        <constant name="constant1" type="float" doc="dropped"/>
        <rotate2d type="vector2" doc="5"/><rotate2d type="vector2" doc="6"/>
        <odd.tag doc="7"/>
    """)
    document = read(text)
    elements = [e for e in document.materialx.traverseTree() if e.getAttribute("doc")]
    assert [e.getAttribute("doc") for e in elements] == list("01234567")
    for element in elements:
        assert at(document, element.getNamePath()) == tag_of(text, f'doc="{element.getAttribute("doc")}"')


def test_names_are_those_that_are_meant_by_what_stands_in_the_file(read):
    text = lines("""
        <constant name="a&amp;b" type="float" doc="0"/>
        <constant name="&lt;&#252;&gt;" type="float" doc="1"/>
        <constant name='q"q' type="float" doc="2"/>
    """)
    document = read(text)
    found = {e.getName(): at(document, e.getNamePath()) for e in document.materialx.getNodes()}
    assert found == {"a&b": (2, 1), "<ü>": (3, 1), 'q"q': (4, 1)}


def test_a_path_that_two_elements_may_have_leads_to_neither(read):
    text = lines("""
        <nodegraph name="g"><constant name="a/b" type="float"/>
          <constant name="a" type="float"><input name="b" type="float" value="1"/></constant></nodegraph>
    """)
    document = read(text)
    assert at(document, "/g/a/b") == at(document, "/g/a") == at(document, "/g") == (2, 1)


def test_elements_of_an_included_file_are_there(read):
    parts = ("looks/a.mtlx", "looks/deep/b.mtlx", "looks/c.mtlx")
    document = read(
        '<materialx version="1.39">\n<xi:include href="deep/b.mtlx"/>\n<constant name="own" type="float"/></materialx>',
        '<materialx version="1.39">\n\n<xi:include href="../c.mtlx"/>\n <constant name="b" type="float"/></materialx>',
        lines('\n\n<constant name="c" type="float">\n<input name="value" type="float" value="1"/></constant>'),
        names=parts,
    )
    assert document.locations.of("/own") == SourceLocation("looks/a.mtlx", 3, 1)
    assert document.locations.of("/b") == SourceLocation("looks/deep/b.mtlx", 4, 2)
    assert document.locations.of("/c/value") == SourceLocation("looks/c.mtlx", 3, 1)


def test_a_name_in_an_included_namespace_is_found(read):
    text = lines("""
        <nodegraph name="g"><constant name="c" type="float"/></nodegraph>
        <nodegraph name="ns:h"/>
    """).replace("<materialx", '<materialx namespace="ns"')
    document = read(
        '<materialx version="1.39"><xi:include href="b.mtlx"/></materialx>', text, names=("a.mtlx", "b.mtlx")
    )
    names = [e.getNamePath() for e in document.materialx.traverseTree() if e.getName()]
    assert names == ["ns:g", "ns:g/c", "ns:h"]
    found = [document.locations.of(f"/{name}") for name in names]
    assert found == [SourceLocation("b.mtlx", line, column) for line, column in ((2, 1), (2, 21), (3, 1))]


def test_an_include_that_is_wrong_is_named_where_it_stands(read):
    with pytest.raises(ReadError) as raised:
        read(
            '<materialx version="1.39"><xi:include href="b.mtlx"/></materialx>',
            '<materialx version="1.39">\n  <xi:include href="absent.mtlx"/></materialx>',
            names=("sub/a.mtlx", "sub/b.mtlx"),
        )
    assert raised.value.finding.location == "b.mtlx line 2"
    assert raised.value.finding.source == SourceLocation("sub/b.mtlx", 2, 3)


@pytest.mark.parametrize(
    ("content", "line", "column"),
    [
        (b"", 1, 1),
        (b'<materialx version="1.39">\n  <a>\n </b></materialx>', 3, 4),
        ('<materialx version="1.39">\n <!-- ä€ --> <a b></materialx>'.encode(), 2, 18),
        ("\ufeff<a".encode(), 1, 1),
        (b'<materialx version="1.39">\n\xff', 2, 1),
        ("<materialx>\nä\n  ö \xff".encode() + b"\xff", 3, 6),
        (b"<!DOCTYPE x><materialx/>", 1, 12),
        (b"<materialx>" + b"\n<a>" * 70, 65, 1),
    ],
)
def test_what_is_no_document_is_named_with_line_and_column(read, content, line, column):
    with pytest.raises(ReadError) as raised:
        read(content)
    found = raised.value.finding.source
    assert (found.file, found.line) == ("a.mtlx", line)
    assert found.column == column
    assert raised.value.finding.location == f"line {line}"


@pytest.mark.parametrize("content", [b"\xff\xfe<\0a\0", b"<a/>"])
def test_where_there_is_no_line_there_is_the_file(read, content):
    with pytest.raises(ReadError) as raised:
        read(content)
    assert raised.value.finding.source == SourceLocation("a.mtlx")


# Documents of earlier versions, which MaterialX changes while it reads them -------------------------------------------


def test_inputs_that_change_names_with_each_other_are_where_their_node_is(read):
    text = lines(
        """
        <nodegraph name="g">
          <compare name="a" type="float">
            <input name="intest" type="float" value="0"/>
            <input name="in1" type="float" value="1"/>
            <input name="in2" type="float" value="2"/>
          </compare>
        </nodegraph>
    """,
        "1.36",
    )
    document = read(text)
    names = {str(e.getValueString()): e.getName() for e in document.materialx.getDescendant("g/a").getInputs()}
    assert names == {"0": "value1", "1": "in2", "2": "in1"}
    for name in ("", *names.values()):
        assert at(document, f"/g/a/{name}") == (3, 3)


def test_what_the_upgrade_makes_is_where_what_it_is_made_of_is(read):
    text = lines(
        """
        <nodegraph name="g">
          <input name="amount" type="float" value="1"/>
          <constant name="c" type="color3"/>
          <swizzle name="s" type="float">
            <input name="in" type="color3" nodename="c"/>
            <parameter name="channels" type="string" value="r"/>
          </swizzle>
          <output name="out" type="float" nodename="s"/>
        </nodegraph>
    """,
        "1.37",
    )
    document = read(text)
    for element in document.materialx.getChild("g").traverseTree():
        path = element.getNamePath()
        parent, _, name = path.rpartition("/")
        stands = re.search(rf'<\w+ name="{name}"', text)
        right = {tag_of(text, stands[0][1:])} if stands else set()
        assert at(document, path) in {*right, at(document, parent)}, path


def test_a_material_of_an_earlier_version_is_found_and_its_shader_is_not(read):
    text = lines(
        """
        <nodedef name="ND_x" node="x" type="surfaceshader"/>
        <material name="M">
          <shaderref name="S" node="standard_surface">
            <bindinput name="base" type="float" value="0.5"/>
          </shaderref>
        </material>
    """,
        "1.36",
    )
    document = read(text)
    assert document.materialx.getDescendant("S/base") is not None
    assert at(document, "/M") == (3, 1)
    assert document.locations.of("/S/base") == SourceLocation("a.mtlx")


def test_an_element_is_never_taken_for_one_of_another_kind(read):
    """Whatever stands under a name in the file: an input is one, with the same value, and a node is none."""
    text = lines("""
        <nodegraph name="g">
          <image name="x" type="color3"/>
          <constant name="y" type="float"><input name="value" type="float" value="1"/></constant>
        </nodegraph>
    """)
    document = read(text)
    graph = document.materialx.getChild("g")
    assert at(document, "/g/x") == (3, 3)
    graph.removeChild("x")
    graph.addInput("x", "color3")
    assert at(document, "/g/x") == (2, 1)
    assert at(document, "/g/y/value") == tag_of(text, 'value="1"')
    graph.getNode("y").getInput("value").setValueString("2")
    assert at(document, "/g/y/value") == at(document, "/g/y") == (4, 3)
    graph.getNode("y").removeChild("value")
    graph.getNode("y").addChildOfCategory("token", "value")
    assert at(document, "/g/y/value") == (4, 3)
    graph.getNode("y").removeChild("value")
    graph.getNode("y").addChildOfCategory("note", "value")
    assert at(document, "/g/y/value") == (4, 3)


# Hostile documents ----------------------------------------------------------------------------------------------------


def test_many_elements_of_one_name_or_none_take_no_time():
    """As MaterialX needs the square of their number, they are looked at without it."""
    text = lines("<a/>" * 20_000 + '<b name="b"/>' * 20_000)
    elements = scan(text.encode(), "a.mtlx", is_document=True).elements
    found = [elements.child(elements.ROOT, name) for name in ("a1", "a20000", "a20001", "b")]
    assert found == [1, 20_000, None, 20_001]
    assert elements.position(20_000) == (2, 4 * 19_999 + 1)
    assert elements.position(20_001) == (2, 80_001)


def test_deep_documents_with_long_names_are_not_written_out(read):
    name = "n" * 100_000
    text = lines(f'<a name="{name}">' * 60 + "".join(f'<b name="b{k}"/>' for k in range(1000)) + "</a>" * 60)
    document = read(text)
    path = "/".join([name] * 60 + ["b999"])
    found = at(document, path)
    assert found == tag_of(text, '"b999"')


def test_a_tag_that_is_longer_than_what_is_read_at_once_is_compared_whole(read):
    value = "0, " * 5000 + "0"
    text = lines(f'<c name="c" type="floatarray"><input name="value" type="floatarray" value="{value}"/></c>')
    document = read(text)
    assert at(document, "/c/value") == (2, text.split("\n")[1].index("<input") + 1)
    assert document.materialx.getDescendant("c/value").getValueString() == value


def test_the_versions_of_materialx_that_are_tested_are_earlier_ones():
    assert mx.getVersionString().startswith("1.39")


# Documents at hand ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("folder", ["materials", "materials_classes", "tests/rules"])
def test_every_element_of_every_document_at_hand_stands_where_its_name_does(repository, library, tmp_path, folder):
    own = others = 0
    for path in sorted((repository / folder).rglob("*.mtlx")):
        try:
            document = read_document(path, Reach(path.parent, repository), library, tmp_path)
        except ReadError:
            continue
        for element in document.materialx.traverseTree():
            source = document.locations.of(f"/{element.getNamePath()}")
            if source.line is None:
                assert not element.getNamePath()
                continue
            assert source.file.endswith(".mtlx")
            file = next(p for p in path.parent.rglob("*.mtlx") if p.as_posix().endswith(source.file.rpartition("/")[2]))
            line = file.read_text(encoding="utf-8").split("\n")[source.line - 1]
            tag = re.match(r"<([\w:]+)(?=\s)(?:[^>]*?\sname=\"([^\"]*)\")?", line[source.column - 1 :])
            if tag[2] is None or tag[2] == element.getName().rpartition(":")[2]:
                own += 1
            else:  # made by the upgrade of an earlier version
                assert tag[2] in element.getNamePath().split("/")
                others += 1
    assert own > 20
    assert others <= own / 10
