"""Images that a document names: by whatever way the name comes, it is looked at."""

from __future__ import annotations

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.documents.images import read_stored
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation import element as element_module
from mrm_mtlx.validation.checks.files import check_files
from mrm_mtlx.validation.element import ElementCheck
from mrm_mtlx.validation.options import Request
from mrm_mtlx.validation.results import RenderableResult, Stage, Status, TargetResult
from mrm_mtlx.validation.steps import Steps


def file(name: str, value: str, **attributes: str) -> str:
    more = "".join(f' {key}="{text}"' for key, text in attributes.items())
    return f'<input name="{name}" type="filename" value="{value}"{more}/>'


IMAGE = '<image name="i" type="color3"><input name="file" type="filename" interfacename="picture"/></image>'
LOOK = '<image name="i" type="color3"><input name="file" type="filename" value="{}"/></image>'
OUT = '<output name="out" type="color3" nodename="i"/>'
# A node of its own, defined by a graph, whose image's default is given.
DEFINED = (
    f'<nodedef name="ND_p" node="p">{file("picture", "{}")}<output name="out" type="color3"/></nodedef>'
    f'<nodegraph name="NG_p" nodedef="ND_p">{IMAGE}{OUT}</nodegraph>'
)
UNLIT = (
    '<surface_unlit name="s" type="surfaceshader"><input name="emission_color" type="color3" {}/></surface_unlit>'
    '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>'
    "</surfacematerial>"
)


@pytest.fixture
def folder(tmp_path, picture):
    """A folder with an image, and one beside it with another."""
    for name in ("checked/tex/here.ppm", "elsewhere/secret.ppm", "checked/tex/a.1001.ppm", "checked/tex/u1_v2.ppm"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(picture)
    (tmp_path / "checked/tex/link.1001.ppm").symlink_to(tmp_path / "elsewhere/secret.ppm")
    return tmp_path / "checked"


@pytest.fixture(scope="module")
def picture():
    """The bytes of an image of one pixel, (1, 0.8, 0)."""
    return b"P6 1 1 255\n\xff\xcc\x00"


@pytest.fixture
def found(make_document, library, folder):
    """Function from elements, as text, to the code and place of what is wrong with the files they name."""

    def check(elements: str) -> list[tuple[str, str]]:
        return [(f.code, f.location) for f in check_files(make_document(elements), Reach.only(folder), library)]

    return check


def graph(value: str) -> str:
    return f'<nodegraph name="g">{file("picture", value)}{IMAGE}{OUT}</nodegraph>'


NODE = '<p name="n" type="color3">{}</p>'
# By the way a name comes: elements with "{}" for it, and the place of the finding.
WAYS = {
    "an interface's input": (graph("{}") + UNLIT.format('nodegraph="g" output="out"'), "/g/picture"),
    "a definition's default": (DEFINED + NODE.format("") + UNLIT.format('nodename="n"'), "/ND_p/picture"),
    "a node of a definition": (
        DEFINED.format("tex/here.ppm") + NODE.format(file("picture", "{}")) + UNLIT.format('nodename="n"'),
        "/n/picture",
    ),
    "a node within a graph": (
        f'<nodegraph name="g">{LOOK}{OUT}</nodegraph>' + UNLIT.format('nodegraph="g"'),
        "/g/i/file",
    ),
    "a value beside an interface's name": (
        f'<nodegraph name="g"><image name="i" type="color3">{file("file", "{}", interfacename="picture")}</image>{OUT}'
        "</nodegraph>" + UNLIT.format('nodegraph="g"'),
        "/g/i/file",
    ),
    "a prefix alone": (
        f'<nodegraph name="g" fileprefix="{{}}">{LOOK.format("")}{OUT}</nodegraph>' + UNLIT.format('nodegraph="g"'),
        "/g/i/file",
    ),
    "a token of the interface": (
        f'<nodegraph name="g"><token name="which" type="string" value="{{}}"/>{LOOK.format("[which]")}{OUT}</nodegraph>'
        + UNLIT.format('nodegraph="g"'),
        "/g/i/file",
    ),
}


def put(elements: str, name: str) -> str:
    return elements.replace("{}", name)


@pytest.mark.parametrize("way", WAYS)
def test_an_image_is_looked_for_by_whatever_way_its_name_comes(found, way):
    elements, place = WAYS[way]
    assert found(put(elements, "tex/here.ppm")) == []
    assert found(put(elements, "tex/nothing.ppm")) == [("DOC_FILE", place)]
    assert found(put(elements, "../elsewhere/secret.ppm")) == [("READ_OUTSIDE", place)]


def test_a_default_that_no_node_takes_need_not_be_there(found):
    missing = DEFINED.format("tex/nothing.ppm")
    assert found(missing) == []
    assert found(missing + NODE.format(file("picture", "tex/here.ppm"))) == []


def test_a_value_that_a_connection_replaces_need_not_be_there(found):
    source = f'<constant name="c" type="filename">{file("value", "tex/here.ppm")}</constant>'
    image = f'<image name="i" type="color3">{file("file", "tex/nothing.ppm", nodename="c")}</image>'
    assert found(source + image) == []


def test_a_prefix_without_a_name_is_no_image(found):
    assert found(f'<nodegraph name="g" fileprefix="tex/">{LOOK.format("")}</nodegraph>') == []


# Names of sets; the finding.
SETS = {
    "tex/a.&lt;UDIM&gt;.ppm": None,
    "tex\\a.&lt;UDIM&gt;.ppm": None,
    "tex/&lt;UVTILE&gt;.ppm": None,
    "&lt;kind&gt;/a.&lt;UDIM&gt;.ppm": None,
    "tex/b.&lt;UDIM&gt;.ppm": "DOC_FILE",
    "tex/a.&lt;UVTILE&gt;.ppm": "DOC_FILE",
    "tex/here.{frame}.ppm": "DOC_FILE",
    "tex/a.{frame}.ppm": None,
    "tex/a.{04frame}.ppm": None,
    "nowhere/a.&lt;UDIM&gt;.ppm": "DOC_FILE",
    "../elsewhere/&lt;UDIM&gt;.ppm": "READ_OUTSIDE",
    "../&lt;UDIM&gt;/a.ppm": "READ_OUTSIDE",
    "tex/link.&lt;UDIM&gt;.ppm": "READ_OUTSIDE",
    # What stands for a property of the geometry, or for what the host knows, may be anything.
    "tex/&lt;asset&gt;.ppm": None,
    "../elsewhere/&lt;asset&gt;.ppm": "READ_OUTSIDE",
    "nowhere/&lt;asset&gt;.ppm": None,
    "&lt;asset&gt;": None,
    "nowhere/{shot}.ppm": None,
    # No graph's interface has such a token: generators leave it as it is.
    "nowhere/[which].ppm": "DOC_FILE",
}


@pytest.mark.parametrize("name", SETS)
def test_a_set_has_one_file_at_least_and_none_outside(found, name):
    assert found(put(LOOK, name)) == ([] if SETS[name] is None else [(SETS[name], "/i/file")])


def test_the_files_of_a_set_are_those_whose_names_fit(folder, picture):
    for name in ("a.1002.ppm", "a.10020.ppm", "a.x.ppm", "a.1001.ppm.old"):
        (folder / "tex" / name).write_bytes(picture)
    assert [path.name for path in Reach.only(folder).members("tex/a.<UDIM>.ppm")] == ["a.1001.ppm", "a.1002.ppm"]
    assert [path.name for path in Reach.only(folder).members("tex/here.ppm")] == ["here.ppm"]
    assert Reach.only(folder).members("tex/nothing.ppm") == []
    searched = Reach(folder / "tex", folder / "tex", (folder,))
    assert [path.name for path in searched.members("tex/a.<UDIM>.ppm")] == ["a.1001.ppm", "a.1002.ppm"]
    assert searched.resolve("tex/a.<UDIM>.ppm") == folder.resolve() / "tex" / "a.<UDIM>.ppm"


@pytest.mark.parametrize("way", WAYS)
def test_what_a_shader_asks_for_is_looked_at_too(make_document, library, folder, way):
    elements, _ = WAYS[way]
    for name, code in (
        ("tex/here.ppm", None),
        ("tex/nothing.ppm", "DOC_FILE"),
        ("../elsewhere/secret.ppm", "READ_OUTSIDE"),
    ):
        document = make_document(put(elements, name))
        images = CheckedImages(Reach.only(folder), "/m")
        read = images.of(generate(document.getNode("m"), "glsl", library).files)
        assert [(f.code, f.location) for f in images.findings] == ([] if code is None else [(code, "/m")])
        assert len(read) == (1 if code is None else 0)


def test_a_set_is_drawn_with_its_first_tile(gl, check, tmp_path, picture):
    path = tmp_path / "m.mtlx"
    body = put(LOOK, "a.&lt;UDIM&gt;.ppm") + UNLIT.format('nodename="i"')
    path.write_text(f'<?xml version="1.0"?>\n<materialx version="1.39">{body}</materialx>', encoding="utf-8")
    (tmp_path / "a.1001.ppm").write_bytes(picture)
    (tmp_path / "a.1002.ppm").write_bytes(picture.replace(b"\xff\xcc\x00", b"\x00\x00\x00"))
    images = CheckedImages(Reach.beside(path), "/m")
    assert images("a.<UDIM>.ppm").tolist() == read_stored(tmp_path / "a.1001.ppm").tolist()
    (result,) = check(path)
    assert (result.findings, result.renderables[0].targets["glsl"].status) == ([], "pass")


def test_an_image_that_the_shader_alone_asks_for_is_told_beside_one_that_the_reference_could_not_read(
    make_document, folder, monkeypatch
):
    (folder / "damaged.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    document = make_document(LOOK.format("damaged.png") + UNLIT.format('nodename="i"'))

    def draws(_engine, _shader, images, *_: object):
        assert images("nowhere.png") is None
        return {"": (TargetResult(Stage.COMPARE, Status.PASS), [])}

    monkeypatch.setattr(element_module, "check_draws", draws)
    request = Request(folder / "x.mtlx", Reach.only(folder), "x.mtlx", targets=("glsl",), samples=16)
    (material,) = renderable_elements(document)
    told = ElementCheck(request, material, RenderableResult("m"), [], Steps()).run()
    for name in ("damaged.png", "nowhere.png"):
        assert [f.code for f in told if name in f.message] == ["DOC_FILE"]
