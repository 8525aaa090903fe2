"""Documents that had another file read than the one that was looked at, or more than that."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.reading import read_document


def part(elements: str) -> str:
    return f'<?xml version="1.0"?>\n<materialx version="1.39">{elements}</materialx>'


def include(href: str) -> str:
    return f'<xi:include href="{href}" />'


def constant(name: str) -> str:
    return f'<constant name="{name}" type="float" />'


@pytest.fixture
def read(library, tmp_path):
    """Function from a path to the names of the elements that the document has; the code instead, if it is refused."""

    def names(path: Path, **changes) -> list[str] | str:
        try:
            imported = read_document(path, Reach(path.parent, **{"root": path.parent, **changes}), library, tmp_path)
        except ReadError as error:
            return error.finding.code
        return [element.getName() for element in imported.materialx.getChildren()]

    return names


def codes(results) -> list[list[str]]:
    return [[f.code for f in result.findings] for result in results]


def test_a_broken_document_did_not_pass_for_one_in_a_folder_of_its_folders_name(
    check, place, document_text, monkeypatch
):
    place.write("mat/b.mtlx", document_text('<no_such_node name="n" type="float" />'))
    place.write("mat/mat/b.mtlx", document_text())
    monkeypatch.chdir(place.folder)
    assert codes(check(Path("mat/b.mtlx"))) == [["DOC_UNKNOWN_NODE"]]
    assert codes(check(Path("mat"))) == [["DOC_UNKNOWN_NODE"], []]


def test_what_was_looked_at_is_what_is_read(read, place, monkeypatch):
    place.write("mat/b.mtlx", part(constant("right")))
    place.write("mat/mat/b.mtlx", part(constant("wrong")))
    monkeypatch.chdir(place.folder)
    assert read(Path("mat/b.mtlx")) == ["right"]


def test_an_include_of_the_third_level_is_the_one_in_its_includers_folder(read, place):
    path = place.write("a.mtlx", part(include("one/b.mtlx")))
    place.write("one/b.mtlx", part(include("two/c.mtlx")))
    place.write("one/two/c.mtlx", part(include("d.mtlx")))
    place.write("one/two/d.mtlx", part(constant("right")))
    place.write("one/d.mtlx", part(constant("wrong")))
    assert read(path) == ["right"]


def test_a_pipe_where_materialx_looks_for_the_third_level_is_not_opened(check, place, pipe):
    path = place.write("a.mtlx", part(include("one/b.mtlx")))
    place.write("one/b.mtlx", part(include("two/c.mtlx")))
    place.write("one/two/c.mtlx", part(include("d.mtlx")))
    place.write("one/two/d.mtlx", part(constant("right")))
    pipe(place.folder / "one" / "d.mtlx")
    assert codes(check(path)) == [["DOC_NO_RENDERABLE"]]


def test_a_secret_where_materialx_looks_for_the_third_level_is_not_read(read, place, link):
    path = place.write("a.mtlx", part(include("one/b.mtlx")))
    place.write("one/b.mtlx", part(include("two/c.mtlx")))
    place.write("one/two/c.mtlx", part(include("d.mtlx")))
    place.write("one/two/d.mtlx", part(constant("right")))
    link(place.folder / "one" / "d.mtlx", place.secrets[".mtlx"])
    assert read(path) == ["right"]


def test_the_environments_search_path_is_not_read(read, place, monkeypatch):
    monkeypatch.setenv("MATERIALX_SEARCH_PATH", str(place.outside))
    assert read(place.write("a.mtlx", part(include("secret.mtlx")))) == "READ_INCLUDE"


def test_the_folder_of_the_command_is_not_read(read, place, monkeypatch):
    monkeypatch.chdir(place.outside)
    assert read(place.write("a.mtlx", part(include("secret.mtlx")))) == "READ_INCLUDE"


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_an_include_that_is_no_file_is_not_opened(read, place, pipe, link, kind):
    if kind == "pipe":
        pipe(place.folder / "b.mtlx")
    elif kind == "folder":
        (place.folder / "b.mtlx").mkdir()
    else:
        link(place.folder / "b.mtlx", Path(os.devnull))
    found = read(place.write("a.mtlx", part(include("b.mtlx"))), root=Path("/") if kind == "device" else place.folder)
    assert found == "READ_INCLUDE"


def test_an_include_is_found_in_the_folder_of_what_includes_its_includer(read, place):
    """MaterialX keeps the folders of all including files on its search path; documents rely on it."""
    path = place.write("a.mtlx", part(include("one/b.mtlx")))
    place.write("one/b.mtlx", part(include("one/c.mtlx")))
    place.write("one/c.mtlx", part(constant("found")))
    assert read(path) == ["found"]


def test_one_name_in_two_folders_is_no_circle(read, place):
    path = place.write("a.mtlx", part(include("d/i.mtlx")))
    place.write("d/i.mtlx", part(include("d/i.mtlx")))
    place.write("d/d/i.mtlx", part(constant("innermost")))
    assert read(path) == ["innermost"]


def test_a_circle_by_a_link_is_found(read, place, link):
    path = place.write("a.mtlx", part(include("b.mtlx")))
    link(place.folder / "b.mtlx", path)
    assert read(path) == "READ_INCLUDE"


def test_names_in_a_linked_file_are_relative_to_the_link(read, place, link):
    path = place.write("a.mtlx", part(include("store_of/b.mtlx")))
    place.write("store/1f3a", part(include("c.mtlx")))
    place.write("store_of/c.mtlx", part(constant("beside_the_link")))
    link(place.folder / "store_of" / "b.mtlx", place.folder / "store" / "1f3a")
    assert read(path) == ["beside_the_link"]


@pytest.mark.parametrize(
    "elements",
    [
        f'<nodegraph name="g">{include("part.mtlx")}</nodegraph>',
        '<x:include xmlns:x="http://www.w3.org/2001/XInclude" href="part.mtlx" />',
        '<include xmlns="http://www.w3.org/2001/XInclude" href="part.mtlx" />',
    ],
    ids=["below the root", "another prefix", "no prefix"],
)
def test_an_inclusion_that_materialx_drops_without_a_word_is_a_finding(read, place, elements):
    place.write("part.mtlx", part(constant("dropped")))
    assert read(place.write("a.mtlx", part(elements))) == "READ_INCLUDE"


def test_a_node_that_is_called_include_is_none(read, place):
    assert read(place.write("a.mtlx", part('<include name="i" type="float" />'))) == ["i"]


def test_prefix_and_colour_space_of_an_included_file_stay_with_its_elements(library, place, tmp_path):
    path = place.write("a.mtlx", part(include("p/b.mtlx") + '<image name="mine" type="color3" />'))
    attributes = 'version="1.39" fileprefix="tex/" colorspace="srgb_texture" namespace="n"'
    image = '<image name="i" type="color3"><input name="file" type="filename" value="x.png" /></image>'
    place.write("p/b.mtlx", f'<?xml version="1.0"?>\n<materialx {attributes}>{image}</materialx>')
    imported = read_document(path, Reach.beside(path), library, tmp_path)
    (included, own) = imported.materialx.getChildren()
    assert included.getName() == "n:i"
    assert included.getInput("file").getResolvedValueString() == "tex/x.png"
    assert (included.getActiveColorSpace(), own.getActiveColorSpace()) == ("srgb_texture", "")
    assert Path(included.getActiveSourceUri()) == place.folder / "p/b.mtlx"
    assert Path(own.getActiveSourceUri()) == place.folder / "a.mtlx"
