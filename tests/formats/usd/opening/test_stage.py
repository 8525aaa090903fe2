"""Untrusted stages: each gives a clear finding, and none is opened further than it may be."""

from __future__ import annotations

import os
import zipfile

import pytest
from pxr import Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.usd.opening import composition_size, layers, packages, stage_files

HEAD = "#usda 1.0\n"
EMPTY = HEAD + 'def "a" {\n}\n'


def layered(*names):
    return HEAD + "(\n subLayers = [" + ", ".join(f"@{name}@" for name in names) + "]\n)\n"


def referring(arc):
    return HEAD + f'def "a" (\n {arc}\n) {{\n}}\n'


def doubling(levels):
    """Prims that each have the next one twice: 2 to the power of `levels` at the end."""
    prims = "".join(
        f'def "p{k}" {{\n' + "".join(f'def "{x}" (\n references = </p{k + 1}>\n) {{\n}}\n' for x in "xy") + "}\n"
        for k in range(levels)
    )
    return HEAD + prims + f'def "p{levels}" {{\n}}\n'


CRATE = "crate"
BROKEN = {
    "text named .usdc": ({"s.usdc": "hello"}, "READ_FORMAT", "", "s.usdc is no file of USD; expected USD crate"),
    "USD text named .usdc": ({"s.usdc": EMPTY}, "READ_FORMAT", "", "s.usdc holds USD text; expected USD crate"),
    "empty file": ({"s.usd": ""}, "READ_FORMAT", "", "s.usd is empty; expected USD text or USD crate"),
    "empty crate": ({"s.usdc": ""}, "READ_FORMAT", "", "s.usdc is empty; expected USD crate"),
    "truncated crate": ({"s.usdc": CRATE}, "READ_FORMAT", "", "s.usdc: "),
    "wrong syntax": ({"s.usda": HEAD + "def {"}, "READ_FORMAT", "", "s.usda"),
    "no package": ({"s.usdz": "PK\x03\x04 and no more"}, "READ_FORMAT", "", "s.usdz"),
    "deep nesting": ({"s.usda": HEAD + 'def "a" {\n' * 100_000}, "READ_TOO_DEEP", "line", "more than 256 levels"),
    "deep nesting behind braces in strings": (
        {"s.usda": HEAD + 'def "a" (\n doc = "}"\n) {\n' * 100_000}, "READ_TOO_DEEP", "line", "more than 256 levels",
    ),
    "deep nesting behind signs of strings in comments": (
        {"s.usda": HEAD + '/* """ */\n// \'\'\'\n' + 'def "a" {\n' * 100_000 + '/* """ \'\'\' */'},
        "READ_TOO_DEEP", "line", "more than 256 levels",
    ),
    "deep nesting behind an asset path with signs of its own": (
        {"s.usda": HEAD + 'def "a" {\n asset x = @@@a\\@@@b@@@@\n}\n' + 'def "a" {\n' * 100_000},
        "READ_TOO_DEEP", "line", "more than 256 levels",
    ),
    "sublayer of itself": (
        {"s.usda": layered("./b.usda"), "b.usda": layered("./s.usda")},
        "READ_INCLUDE", "", "includes itself: s.usda -> b.usda -> s.usda",
    ),
    "broken reference": (
        {"s.usda": referring("references = @./b.usda@"), "b.usda": "x"},
        "READ_FORMAT", "/a", "b.usda is no file of USD",
    ),
    "reference outside": ({"s.usda": referring("references = @../b.usda@")}, "READ_OUTSIDE", "/a", "'../b.usda' lies"),
    "absolute reference": ({"s.usda": referring("references = @/etc/b.usda@")}, "READ_OUTSIDE", "/a", "lies outside"),
    "reference outside in a variant": (
        {"s.usda": HEAD + 'def "a" (\n prepend variantSets = "v"\n) {\n variantSet "v" = {\n "w" (\n '
                   'references = @../b.usda@\n ) {\n }\n }\n}\n'},
        "READ_OUTSIDE", "/a{v=w}", "'../b.usda' lies",
    ),
    "clip outside": (
        {"s.usda": referring("clips = {\n dictionary d = {\n asset[] assetPaths = [@../c.usda@]\n }\n }")},
        "READ_OUTSIDE", "/a", "'../c.usda' lies",
    ),
    "layer outside, named by an attribute": (
        {"s.usda": HEAD + 'def "a" {\n asset x = @../b.usda@\n}\n'}, "READ_OUTSIDE", "", "'../b.usda' lies",
    ),
    "expression for a name": (
        {"s.usda": referring('references = @`"${X}/b.usda"`@')}, "READ_INCLUDE", "/a", "is an expression",
    ),
    "references that double": ({"s.usda": doubling(30)}, "READ_TOO_LARGE", "", "multiply to more than 1000000"),
    "a chain of references": (
        {"s.usda": HEAD + "".join(f'def "p{k}" (\n references = </p{k + 1}>\n) {{\n}}\n' for k in range(150))},
        "READ_TOO_LARGE", "", "in a chain of more than 100",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN.values(), ids=BROKEN.keys())
def test_what_cannot_be_read_is_told(stage_of, tmp_path, case):
    files, code, place, message = case
    (tmp_path / "in").mkdir()
    for name, text in files.items():
        path = tmp_path / "in" / name
        if text == CRATE:
            layer = Sdf.Layer.CreateAnonymous(".usdc")
            layer.ImportFromString(EMPTY)
            layer.Export(str(path))
            path.write_bytes(path.read_bytes()[:-40])
        else:
            path.write_text(text, encoding="latin-1")
    first = tmp_path / "in" / next(iter(files))
    with pytest.raises(ReadError) as caught:
        stage_of(first)
    finding = caught.value.finding
    assert finding.code == code
    assert finding.location.startswith(place)
    assert message in finding.message
    assert str(tmp_path) not in finding.message
    assert "\n" not in finding.message


MISSING = {
    "a sublayer": (HEAD + "(\n subLayers = [@./gone.usda@]\n)\n", ""),
    "a reference": (HEAD + 'def "cam" (\n references = @./gone.usda@</C>\n) {\n}\n', "/cam"),
    "a reference by a name without a folder": (HEAD + 'def "cam" (\n references = @gone.usda@\n) {\n}\n', "/cam"),
    "a payload": (HEAD + 'def "cam" (\n payload = @./gone.usda@\n) {\n}\n', "/cam"),
    "a file in a package": (HEAD + 'def "cam" (\n payload = @./gone.usdz[a.usda]@\n) {\n}\n', "/cam"),
}
MATERIAL = """def Material "M" ({arcs}) {{
  token outputs:mtlx:surface.connect = </M/s.outputs:out>
  def Shader "s" {{
    uniform token info:id = "ND_surface"
    token outputs:out
  }}
}}
"""


@pytest.mark.parametrize("case", MISSING.values(), ids=MISSING.keys())
def test_a_missing_layer_is_told_and_leaves_the_materials_that_do_not_depend_on_it(stage_of, usda, case):
    text, place = case
    path = usda(text + MATERIAL.format(arcs=""), head="")
    read = stage_of(path)
    (finding,) = [finding for finding in read.findings if finding.code == "USD_MISSING"]
    name = "gone.usdz[a.usda]" if "usdz" in text else "gone.usda"
    assert finding.location == place
    assert finding.message.removeprefix("the file './").removeprefix("the file '").startswith(f"{name}' does not exist")
    assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == ["/M"]
    assert not any("gone" in finding.message for finding in read.findings if finding.code != "USD_MISSING")


@pytest.mark.parametrize(
    "prims",
    [
        MATERIAL.format(arcs="references = @./gone.usda@</M>"),
        'def "R" (payload = @./gone.usda@) {{\n{}}}\n'.format(MATERIAL.format(arcs="").replace("</M/", "</R/M/")),
        'class "B" (references = @./gone.usda@) {\n}\n' + MATERIAL.format(arcs="inherits = </B>"),
        MATERIAL.format(arcs="").replace('def Shader "s" {', 'def Shader "s" (references = @./gone.usda@) {'),
    ],
    ids=["itself", "what it lies in", "what it inherits", "a shader of it"],
)
def test_a_material_that_depends_on_a_missing_layer_is_left_out_by_name(stage_of, prims):
    other = MATERIAL.format(arcs="").replace('"M"', '"N"').replace("</M/", "</N/")
    read = stage_of(prims + other)
    assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == ["/N"]
    left = [
        finding for finding in read.findings if finding.code == "USD_MISSING" and "it is not checked" in finding.message
    ]
    assert [(finding.location, "'./gone.usda'" in finding.message) for finding in left] == [
        ("/R/M" if '"R"' in prims else "/M", True)
    ]


@pytest.mark.parametrize("opening_sign", [b'"""', b"'''", b"@@@", b"/*"])
def test_what_is_not_closed_is_scanned_once(opening_sign):
    """Else a text of many such signs, behind a backslash each, would take the square of its length."""
    text = b"{" + (opening_sign + b"x\n\\") * 3
    if opening_sign in (b"@@@", b"/*"):
        text = text.replace(b"\\" + opening_sign, b"\\x")
    assert [match.span() for match in layers._TOKENS.finditer(text)] == [(0, 1), (1, len(text))]


def test_a_circle_of_references_is_told_and_the_rest_is_read(stage_of, usda):
    usda('def "B" {\n def "C" (\n references = @./stage.usda@</A>\n ) {\n }\n}\n', "b.usda")
    (finding,) = stage_of('def "M" {\n}\ndef "A" (\n references = @./b.usda@</B>\n) {\n}\n').findings
    assert (finding.code, finding.location) == ("READ_INCLUDE", "/A/C")
    assert finding.message.startswith("Cycle detected: @stage.usda@</A/C> references: @b.usda@</B/C>")


def test_bounds_are_those_that_are_stated(usda, stage_of, monkeypatch):
    usda("", "b.usda", head=layered())
    path = usda("", head=layered("./b.usda"))
    size = path.stat().st_size + (path.parent / "b.usda").stat().st_size
    for name, enough in (("MAXIMUM_LAYERS", 1), ("MAXIMUM_STAGE_BYTES", size)):
        with monkeypatch.context() as patch:
            patch.setattr(stage_files, name, enough)
            stage_of(path)
            patch.setattr(stage_files, name, enough - 1)
            with pytest.raises(ReadError, match="the stage consists of more than"):
                stage_of(path)


def test_the_weight_of_a_stage_counts_what_is_shared_once(usda, stage_of, monkeypatch):
    # 1 + 10 in the prototype, three instances of it, the root: 3 more prims each time.
    shared = 'def "p" {\n' + "".join(f'def "c{k}" {{\n}}\n' for k in range(10)) + "}\n"
    instance = 'def "i{}" (\n instanceable = {}\n references = </p>\n) {{\n}}\n'
    for once, weight in (("true", 1 + 11 + 3 + 11), ("false", 1 + 11 + 3 + 3 * 11)):
        path = usda(shared + "".join(instance.format(k, once) for k in range(3)))
        monkeypatch.setattr(composition_size, "MAXIMUM_PRIMS", weight)
        stage_of(path)
        monkeypatch.setattr(composition_size, "MAXIMUM_PRIMS", weight - 1)
        with pytest.raises(ReadError, match="multiply to more than"):
            stage_of(path)


def test_other_formats_are_named_and_not_opened(stage_of, tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0")
    (finding,) = stage_of('def "M" (\n references = @./a.obj@\n) {\n}\n').findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LOST", "/M")
    assert "'./a.obj' is no file of USD" in finding.message


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_is_not_waited_for(stage_of, tmp_path):
    os.mkfifo(tmp_path / "p.usda")
    with pytest.raises(ReadError) as caught:
        stage_of(tmp_path / "p.usda")
    assert caught.value.finding.code == "READ_FAILED"


def test_a_link_that_leads_out_is_not_followed(stage_of, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "secret.usda").write_text(EMPTY)
    (tmp_path / "in" / "b.usda").symlink_to(tmp_path / "secret.usda")
    path = tmp_path / "in" / "s.usda"
    path.write_text(layered("./b.usda"))
    with pytest.raises(ReadError) as caught:
        stage_of(path)
    assert caught.value.finding.code == "READ_OUTSIDE"


def test_a_file_that_changed_while_another_holds_it_is_read_anew(usda, stage_of):
    held = Sdf.Layer.FindOrOpen(str(usda('def Material "M" {\n token outputs:mtlx:surface\n}\n').resolve()))
    assert [r.code for r in stage_of(usda('def "M" {\n}\n')).findings] == []
    assert held.GetPrimAtPath("/M").typeName == "Material"  # what another has open is left as it is


def package(path, **files):
    with zipfile.ZipFile(path, "w") as written:
        for name, content in files.items():
            written.writestr(name, content)
    return path


def test_a_package_is_unpacked_within_bounds(stage_of, tmp_path, monkeypatch):
    path = package(tmp_path / "p.usdz", **{"s.usda": EMPTY, "../out.png": b"x", "tex/a.png": b"y" * 100})
    read = stage_of(path)
    files = sorted(p.relative_to(read.reach.folder).as_posix() for p in read.reach.folder.rglob("*") if p.is_file())
    assert files == ["s.usda", "tex/a.png"]
    assert not (read.reach.folder.parent / "out.png").exists()
    for name, enough in (("MAXIMUM_FILES", 3), ("MAXIMUM_PACKAGE_BYTES", 101 + len(EMPTY))):
        with monkeypatch.context() as patch:
            patch.setattr(packages, name, enough)
            stage_of(path)
            patch.setattr(packages, name, enough - 1)
            with pytest.raises(ReadError, match="the package holds 3 files"):
                stage_of(path)


@pytest.mark.parametrize(("names", "reason"), [(["."], "Is a directory"), (["a", "a/b"], "File exists")])
def test_a_package_with_names_that_no_folder_holds_is_refused_without_a_path(stage_of, tmp_path, names, reason):
    path = package(tmp_path / "p.usdz", **{"s.usda": EMPTY}, **dict.fromkeys(names, b"x"))
    with pytest.raises(ReadError) as caught:
        stage_of(path)
    assert caught.value.finding.message == f"the package p.usdz cannot be unpacked: {reason}"


def test_an_image_of_a_package_that_a_stage_refers_to_is_read(stage_of, usda, tmp_path):
    material = MATERIAL.format(arcs="")[:-2] + '  def Shader "i" {\n    uniform token info:id = "ND_image_color3"\n'
    material += "    asset inputs:file = @tex/a.png@\n    color3f outputs:out\n  }\n}\n"
    package(tmp_path / "p.usdz", **{"s.usda": HEAD + material, "tex/a.png": b"picture"})
    read = stage_of('def "M" (\n references = @./p.usdz@</M>\n) {\n}\n')
    name = read.materialx.getNode("i").getInput("file").getValueString()
    assert name == "p.usdz.0/tex/a.png"
    assert read.reach.regular(name).read_bytes() == b"picture"
    assert not [finding for finding in read.findings if not finding.code.startswith("USD_")]


def test_layers_are_looked_for_in_further_folders_that_may_be_read(usda, library, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "shared").mkdir()
    (tmp_path / "empty").mkdir()
    (tmp_path / "shared" / "b.usda").write_text(HEAD + MATERIAL.format(arcs=""))
    path = tmp_path / "in" / "s.usda"
    for name in ("b.usda", "../shared/b.usda"):
        path.write_text(referring(f"references = @{name}@</M>"))
        reach = Reach.beside(path, (tmp_path / "shared",))
        read = read_document(path, reach, library, tmp_path / "empty")
        assert [read.source_locations[node.getName()] for node in read.materialx.getMaterialNodes()] == ["/a"]
