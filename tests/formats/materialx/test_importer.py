"""Untrusted documents: damaged, huge, deep, cyclic, or pointing where they should not."""

from __future__ import annotations

import json
import os
import struct
import time
import zlib
from pathlib import Path

import pytest

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.xml_scan import scan
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.system.limits import MAXIMUM_DOCUMENT_BYTES, MAXIMUM_INCLUDES, MAXIMUM_XML_DEPTH

HEAD = '<?xml version="1.0"?>\n<materialx version="1.39">\n'
METAL = '<conductor_bsdf name="metal" type="BSDF" />\n'
SHOWN = (
    '<surface name="surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="metal" /></surface>\n'
    '<surfacematerial name="material" type="material">'
    '<input name="surfaceshader" type="surfaceshader" nodename="surface" /></surfacematerial>\n'
)
WHOLE = HEAD + METAL + SHOWN + "</materialx>\n"

# A document may refer to what lies here, or try to.
INSIDE, OUTSIDE = "checked/parts", "elsewhere"


def document(elements: str, attributes: str = "") -> bytes:
    return (HEAD.replace(">\n<materialx", f">\n<materialx {attributes}") + elements + SHOWN + "</materialx>\n").encode()


def including(href: str) -> bytes:
    return document(f'<xi:include href="{href}" />\n')


def pictured(file: str, attributes: str = "") -> bytes:
    return document(
        f'<image name="picture" type="color3"><input name="file" type="filename" value="{file}" /></image>\n'
        '<conductor_bsdf name="metal" type="BSDF"><input name="ior" type="color3" nodename="picture" />'
        "</conductor_bsdf>\n",
        attributes,
    )


def nested(depth: int) -> bytes:
    """A document whose innermost element is at this depth; the root is at depth 1."""
    graphs = depth - 1
    return document('<nodegraph name="g">' * graphs + "</nodegraph>" * graphs + METAL)


BOMB = (
    '<?xml version="1.0"?>\n<!DOCTYPE materialx [<!ENTITY a0 "lol">'
    + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
    + ']>\n<materialx version="1.39"><backdrop name="b" doc="&a9;" /></materialx>'
)
THIEF = (
    '<?xml version="1.0"?>\n<!DOCTYPE materialx [<!ENTITY t SYSTEM "../elsewhere/metal.mtlx">]>\n'
    '<materialx version="1.39">&t;</materialx>'
)

# Documents by name: their bytes, the code of the one finding that they get, and words of its message or its place.
HOSTILE: dict[str, tuple[bytes, str, str]] = {
    "truncated": (WHOLE.encode()[: len(WHOLE) // 2], "READ_XML", "line"),
    "empty": (b"", "READ_XML", "the file is empty"),
    "blank": (b" \n\t\n", "READ_XML", "the file is empty"),
    "two_roots": (WHOLE.encode() + b"<materialx />", "READ_XML", "junk after document element"),
    "not_xml": (b"MaterialX, trust me", "READ_XML", "syntax error at column 1"),
    "other_root": (b"<html><body>not found</body></html>", "DOC_INVALID", "the root element is <html>"),
    "deep": (nested(100_000), "READ_TOO_DEEP", f"more than {MAXIMUM_XML_DEPTH} levels"),
    "latin_1": (WHOLE.replace("metal", "métal").encode("latin-1"), "READ_ENCODING", "byte 0xe9 is not UTF-8"),
    "utf_16": (WHOLE.encode("utf-16"), "READ_ENCODING", "UTF-16 or binary"),
    "utf_16_without_mark": (WHOLE.encode("utf-16-be"), "READ_ENCODING", "UTF-16 or binary"),
    "nul": (WHOLE.encode().replace(b"metal", b"me\0tal"), "READ_ENCODING", "UTF-16 or binary"),
    "late_nul": (WHOLE.encode() + b" " * 5000 + b"\0", "READ_XML", "column"),
    "entity_bomb": (BOMB.encode(), "READ_XML", "document type declarations are not read"),
    "external_entity": (THIEF.encode(), "READ_XML", "document type declarations are not read"),
    "circle_a": (including("circle_b.mtlx"), "READ_INCLUDE", "circle_a.mtlx -> circle_b.mtlx -> circle_a.mtlx"),
    "circle_b": (including("circle_a.mtlx"), "READ_INCLUDE", "circle_b.mtlx -> circle_a.mtlx -> circle_b.mtlx"),
    "self": (including("self.mtlx"), "READ_INCLUDE", "self.mtlx -> self.mtlx"),
    "self_by_detour": (including("parts/../self_by_detour.mtlx"), "READ_INCLUDE", "the document includes itself"),
    "includes_nothing": (including(""), "READ_INCLUDE", "the included document '' is not a regular file"),
    "includes_folder": (including("parts"), "READ_INCLUDE", "'parts' is not a regular file"),
    "includes_damaged": (including("truncated.mtlx"), "READ_XML", "line"),
    "includes_deep": (including("deep.mtlx"), "READ_TOO_DEEP", "line"),
    "include_bomb": (including("parts/bomb_0.txt") + b"", "READ_INCLUDE", f"more than {MAXIMUM_INCLUDES} inclusions"),
    "include_above": (including("../elsewhere/metal.mtlx"), "READ_OUTSIDE", "include '../elsewhere/metal.mtlx'"),
    "include_absolute": (including("{outside}/metal.mtlx"), "READ_OUTSIDE", "include '"),
    "include_by_link": (including("parts/leads_out.mtlx"), "READ_OUTSIDE", "include 'parts/leads_out.mtlx'"),
    "include_by_linked_folder": (including("parts/leads_out/metal.mtlx"), "READ_OUTSIDE", "include 'parts/leads_out/"),
    "image_above": (pictured("../elsewhere/picture.ppm"), "READ_OUTSIDE", "image '../elsewhere/picture.ppm'"),
    "image_absolute": (pictured("{outside}/picture.ppm"), "READ_OUTSIDE", "image '"),
    "image_by_link": (pictured("parts/leads_out.ppm"), "READ_OUTSIDE", "image 'parts/leads_out.ppm'"),
    "image_by_prefix": (pictured("picture.ppm", 'fileprefix="../elsewhere/"'), "READ_OUTSIDE", "image '../elsewhere/"),
    "image_missing": (pictured("parts/nothing.ppm"), "DOC_FILE", "'parts/nothing.ppm' does not exist"),
}

# As similar as can be, and in order: no finding.
HARMLESS: dict[str, bytes] = {
    "byte_order_mark": b"\xef\xbb\xbf" + WHOLE.encode(),
    "windows_line_ends": WHOLE.replace("\n", "\r\n").encode(),
    "accents": WHOLE.replace('"metal" type', '"metal" doc="métal" type').encode(),
    "not_so_deep": nested(MAXIMUM_XML_DEPTH - 4),
    "include_inside": including("parts/metal.mtlx"),
    "include_by_link_inside": including("parts/stays_in.mtlx"),
    "include_absolute_inside": including("{inside}/metal.mtlx"),
    "image_inside": pictured("parts/picture.ppm"),
    "image_by_link_inside": pictured("parts/stays_in.ppm"),
    "image_by_prefix_inside": pictured("picture.ppm", 'fileprefix="parts/"'),
}

PICTURE = b"P3 2 1 255  255 255 255  255 204 0\n"


def lay_out(root: Path, files: dict[str, bytes]) -> Path:
    """Folders with what documents refer to, and the documents; returns the folder to check."""
    inside, outside = root / INSIDE, root / OUTSIDE
    for folder in (inside, outside):
        folder.mkdir(parents=True)
        (folder / "metal.mtlx").write_text(HEAD + METAL + "</materialx>\n", encoding="utf-8")
        (folder / "picture.ppm").write_bytes(PICTURE)
    for suffix, name in ((".mtlx", "metal.mtlx"), (".ppm", "picture.ppm")):
        (inside / f"leads_out{suffix}").symlink_to(outside / name)
        (inside / f"stays_in{suffix}").symlink_to(inside / name)
    (inside / "leads_out").symlink_to(outside)
    # Each of these includes the next one twice: 2^40 documents, if nobody counts.
    for k in range(40):
        (inside / f"bomb_{k}.txt").write_bytes(
            f'{HEAD}<xi:include href="bomb_{k + 1}.txt" /><xi:include href="bomb_{k + 1}.txt" /></materialx>'.encode()
        )
    (inside / "bomb_40.txt").write_text(f"{HEAD}</materialx>", encoding="utf-8")
    for name, content in files.items():
        for place, folder in ((b"{inside}", inside), (b"{outside}", outside)):
            content = content.replace(place, folder.as_posix().encode())
        (inside.parent / f"{name}.mtlx").write_bytes(content)
    return inside.parent


@pytest.fixture(scope="module")
def findings(tmp_path_factory, bounded) -> dict[str, list[dict[str, str]]]:
    """Findings of all of these documents by name, from one run with bounded memory and time."""
    root = tmp_path_factory.mktemp("hostile")
    folder = lay_out(root, {**{name: content for name, (content, _, _) in HOSTILE.items()}, **HARMLESS})
    large = folder / "large.mtlx"
    large.write_text(WHOLE, encoding="utf-8")
    os.truncate(large, 100 * 2**20)  # sparse
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe.mtlx")
    (folder / "folder.mtlx").mkdir()
    (folder / "dangling.mtlx").symlink_to("nothing")
    (folder / "document_by_link.mtlx").symlink_to(root / OUTSIDE / "metal.mtlx")
    done = bounded("validate", folder, "--target", "mdl", "--format", "json", "-j", "1")
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    return {Path(d["path"]).stem: d["findings"] for d in json.loads(done.stdout)["documents"]}


def assert_only(findings: list[dict[str, str]], code: str, words: str) -> None:
    """One finding of this code, with these words."""
    assert [f["code"] for f in findings] == [code]
    assert words in f"{findings[0]['location']} {findings[0]['message']}"
    assert findings[0]["severity"] == "error"


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_document_gets_its_finding_in_bounded_time_and_memory(findings, name):
    assert_only(findings[name], *HOSTILE[name][1:])


@pytest.mark.parametrize("name", HARMLESS)
def test_a_harmless_one_beside_it_gets_none(findings, name):
    assert findings[name] == []


def test_a_large_file_is_not_read(findings):
    assert_only(findings["large"], "READ_TOO_LARGE", f"100 MiB, more than the {MAXIMUM_DOCUMENT_BYTES // 2**20} MiB")


@pytest.mark.parametrize("name", ["pipe", "folder", "dangling"])
def test_what_is_no_file_is_not_opened(findings, name):
    if name == "pipe" and not hasattr(os, "mkfifo"):
        pytest.skip("this system has no named pipes")
    assert_only(findings[name], "READ_FAILED", "it is not a regular file")


def test_a_document_that_is_a_link_out_of_the_folder_is_not_opened(findings):
    assert_only(findings["document_by_link"], "READ_OUTSIDE", "a link that leads out of the folder")


def test_a_document_that_is_a_link_to_itself_gets_a_finding(check, tmp_path):
    (tmp_path / "loop.mtlx").symlink_to("loop.mtlx")
    (found,) = check(tmp_path)
    assert [f.code for f in found.findings] == ["READ_FAILED"]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the administrator may read every file")
def test_a_file_without_permission_gets_a_finding(check, tmp_path):
    path = tmp_path / "locked.mtlx"
    path.write_text(WHOLE, encoding="utf-8")
    path.chmod(0)
    (found,) = check(path)
    assert [f.code for f in found.findings] == ["READ_FAILED"]


STOLEN = """
<nodedef name="ND_dust" node="dust"><output name="out" type="float" /></nodedef>
<implementation name="IM_dust" nodedef="ND_dust" target="genglsl" file="{}" function="dust" />
<dust name="cover" type="float" />
<conductor_bsdf name="metal" type="BSDF"><input name="weight" type="float" nodename="cover" /></conductor_bsdf>
"""


@pytest.mark.parametrize("way", ["directly", "by an include", "by two includes"])
def test_source_code_outside_the_folder_is_not_opened(gl, check, tmp_path, way):
    file = {
        "directly": "../elsewhere/secret.txt",
        "by an include": "parts/first.glsl",
        "by two includes": "parts/second.glsl",
    }
    folder = lay_out(tmp_path, {"stolen": document(STOLEN.format(file[way]))})
    (tmp_path / OUTSIDE / "secret.txt").write_text("the secret of the house\n", encoding="utf-8")
    for name, included in (("first", "../../elsewhere/secret.txt"), ("second", "first.glsl")):
        (tmp_path / INSIDE / f"{name}.glsl").write_text(f'#include "{included}"\n', encoding="utf-8")
    (found,) = check(folder / "stolen.mtlx")
    assert not any("secret of the house" in f.message for f in found.findings)
    assert [f.code for f in found.findings] == ["READ_OUTSIDE"]


def test_source_code_inside_the_folder_is_used(gl, check, tmp_path):
    folder = lay_out(tmp_path, {"own": document(STOLEN.format("parts/own.glsl"))})
    (tmp_path / INSIDE / "own.glsl").write_text('#include "half.glsl"\n', encoding="utf-8")
    (tmp_path / INSIDE / "half.glsl").write_text("void dust(out float x) { x = 0.5; }\n", encoding="utf-8")
    (found,) = check(folder / "own.mtlx")
    assert [f.code for f in found.findings] == []


# Images ---------------------------------------------------------------------------------------------------------------


def png(width: int, height: int, rows: bytes, row_count: int = 1) -> bytes:
    """A grey PNG whose header says this size, and whose data is what is given, so many times."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packer = zlib.compressobj(1)
    packed = b"".join(packer.compress(rows) for _ in range(row_count)) + packer.flush()
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


SIZE = 64
FINE = png(SIZE, SIZE, b"\0" * (SIZE + 1), SIZE)


def images() -> dict[str, bytes]:
    """Images that cannot be read, or not within reason."""
    # Honest, and small on disk: PNG packs black a thousandfold.
    large = 18_000
    return {
        "claims_60000_squared.png": png(60_000, 60_000, b"\0" * 1000),
        "is_18000_squared.png": png(large, large, b"\0" * (large + 1), large),
        "claims_50000_squared.ppm": b"P6\n50000 50000\n255\n",
        "is_text.png": b"not an image",
        "is_empty.png": b"",
        "is_cut.png": FINE[:60],
    }


def test_images_that_claim_more_than_memory_holds_get_a_finding(gl, tmp_path, bounded):
    bad = images()
    pictures = {**bad, "is_fine.png": FINE}
    folder = lay_out(tmp_path, {Path(name).stem: pictured(f"parts/{name}") for name in pictures})
    for name, content in pictures.items():
        (tmp_path / INSIDE / name).write_bytes(content)
    done = bounded("validate", folder, "--target", "glsl", "--samples", "64", "--format", "json", "-j", "1")
    assert "Traceback" not in done.stderr
    found = {Path(d["path"]).stem: d["findings"] for d in json.loads(done.stdout)["documents"]}
    for name in bad:
        assert_only(found[Path(name).stem], "DOC_FILE", name)
    assert found["is_fine"] == []


# Any driver takes at least 16384 (OpenGL 4.3, table 23.55), and none of today takes this.
WIDE = 200_000


def test_an_image_wider_than_the_driver_takes_gets_a_finding(gl, tmp_path, check):
    folder = lay_out(tmp_path, {"wide": pictured("parts/wide.png")})
    (tmp_path / INSIDE / "wide.png").write_bytes(png(WIDE, 1, b"\0" * (WIDE + 1)))
    (found,) = check(folder / "wide.mtlx")
    assert [f.code for f in found.findings] == ["DOC_FILE"]


# Parts ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("depth", "accepted"),
    [
        (MAXIMUM_XML_DEPTH, True),
        (MAXIMUM_XML_DEPTH - 1, True),
        (MAXIMUM_XML_DEPTH + 1, False),
    ],
)
def test_the_bound_on_the_depth_is_the_one_that_is_stated(library, tmp_path, depth, accepted):
    path = tmp_path / "nested.mtlx"
    path.write_bytes(nested(depth))
    if accepted:
        read_document(path, Reach.beside(path), library, tmp_path)
    else:
        with pytest.raises(ReadError, match="levels deep"):
            read_document(path, Reach.beside(path), library, tmp_path)


@pytest.mark.parametrize(("count", "accepted"), [(MAXIMUM_INCLUDES, True), (MAXIMUM_INCLUDES + 1, False)])
def test_the_bound_on_inclusions_is_the_one_that_is_stated(library, tmp_path, count, accepted):
    (tmp_path / "part.mtlx").write_text(HEAD + METAL + "</materialx>", encoding="utf-8")
    path = tmp_path / "many.mtlx"
    path.write_bytes(document('<xi:include href="part.mtlx" />\n' * count))
    if accepted:
        read_document(path, Reach.beside(path), library, tmp_path)
    else:
        with pytest.raises(ReadError, match=f"more than {MAXIMUM_INCLUDES} inclusions"):
            read_document(path, Reach.beside(path), library, tmp_path)


def test_a_document_and_its_inclusions_share_one_bound_on_their_size(library, tmp_path):
    padding = "<!--" + " " * (MAXIMUM_DOCUMENT_BYTES // 2) + "-->"
    (tmp_path / "part.mtlx").write_text(HEAD + METAL + padding + "</materialx>", encoding="utf-8")
    path = tmp_path / "whole.mtlx"
    path.write_bytes(including("part.mtlx"))
    read_document(path, Reach.beside(path), library, tmp_path)
    path.write_bytes(including("part.mtlx") + padding.encode())
    with pytest.raises(ReadError) as caught:
        read_document(path, Reach.beside(path), library, tmp_path)
    assert caught.value.finding.code == "READ_TOO_LARGE"


def test_what_is_included_is_there(library, tmp_path):
    (tmp_path / "part.mtlx").write_text(HEAD + METAL + "</materialx>", encoding="utf-8")
    path = tmp_path / "whole.mtlx"
    path.write_bytes(including("part.mtlx"))
    read = read_document(path, Reach.beside(path), library, tmp_path)
    assert read.findings == []
    assert [node.getName() for node in read.materialx.getNodes()] == ["metal", "surface", "material"]
    assert read.materialx.getNode("metal").getNodeDef() is not None


def test_a_second_element_of_a_name_is_reported_with_its_place(library, tmp_path):
    path = tmp_path / "twice.mtlx"
    inner = (
        '<nodegraph name="g">\n<constant name="c" type="float" />\n<constant name="c" type="color3" />\n</nodegraph>\n'
    )
    path.write_bytes(
        document(METAL + inner + inner.replace('"g"', '"h"').replace('c" type="color3', 'd" type="color3'))
    )
    found = read_document(path, Reach.beside(path), library, tmp_path).findings
    assert [(f.code, f.location) for f in found] == [("DOC_DUPLICATE_NAME", "/g/c")]
    assert "line 6 of twice.mtlx" in found[0].message


# Attributes' values with a "<", which XML forbids and MaterialX takes -------------------------------------------------


@pytest.fixture
def scanned():
    """Function from the text of a document to its scan."""
    return lambda text: scan(text.encode(), "a.mtlx", is_document=True)


def udim(file: str) -> str:
    return f'<image name="i" type="color3"><input name="file" type="filename" value="{file}" /></image>'


def test_the_example_of_the_specification_is_read_with_a_warning(library, tmp_path):
    path = tmp_path / "a.mtlx"
    path.write_text(f"{HEAD}{udim('txt/[effect].<UDIM>.tif')}</materialx>", encoding="utf-8")
    read = read_document(path, Reach.beside(path), library, tmp_path)
    (found,) = read.findings
    assert (found.code, found.severity.value, found.location) == ("READ_XML_LENIENT", "warning", "line 3")
    assert "txt/[effect].<UDIM>.tif" in found.message
    assert read.materialx.getNode("i").getInput("file").getValueString() == "txt/[effect].<UDIM>.tif"


AROUND = {
    "comment": '<!-- it\'s "<UDIM>" -->',
    "cdata": "<a><![CDATA[\"<UDIM>']]></a>",
    "instruction": "<?say \"<UDIM>' ?>",
    "quote in the text": "<a>it's</a>",
    "quote in quotes": """<a b="it's" c='"'/>""",
}


@pytest.mark.parametrize("around", AROUND)
def test_what_stands_around_does_not_mislead_the_search_for_such_values(scanned, around):
    others = udim("b.<UDIM>.png").replace('"i"', '"j"')
    found = scanned(f"{HEAD}{AROUND[around]}{udim('a.<UDIM>.png')}{AROUND[around]}{others}</materialx>").findings
    assert [f.code for f in found] == ["READ_XML_LENIENT", "READ_XML_LENIENT"]
    assert [name in f.message for f, name in zip(found, ("a.<UDIM>.png", "b.<UDIM>.png"), strict=True)] == [True, True]


def test_a_text_that_leaves_no_sign_for_a_mark_is_refused(scanned):
    every = "".join(map(chr, range(0xE000, 0xF900)))
    with pytest.raises(ReadError) as caught:
        scanned(f"{HEAD}<!--{every}-->{udim('a.<UDIM>.png')}</materialx>")
    assert caught.value.finding.code == "READ_XML"


WITH = udim("a.<UDIM>.png")
# Broken texts, the line that is named, and the column.
NOT_XML = {
    "a quote is missing": ('<a b="1>\n<c d="2"/>', "line 4", 1),
    "a quote is missing at the end": ('<a b="1>\n<c/>', "line 4", 1),
    "a tag is not closed": (f"{WITH}<a>", "line 3", len(WITH) + len("<a></") + 1),
    "a sign stands in the text": (f"{WITH}a < b", "line 3", len(WITH) + len("a <") + 1),
    "a value has no quotes": ("<a b=<UDIM> />", "line 3", len("<a b=") + 1),
    "a value after another has none": (f"{WITH}<a b=<UDIM> />", "line 3", len(WITH) + len("<a b=") + 1),
    "a comment has no end": (f"{WITH}<!-- ", "line 3", len(WITH) + 1),
    "an entity is not defined": (f"{WITH}<a b='&x;'/>", "line 3", len(WITH) + 1),
    "a tag after more than ASCII is not closed": (f"{WITH}<é>", "line 3", len(WITH) + len("<é></") + 1),
}


@pytest.mark.parametrize("name", NOT_XML)
def test_what_is_broken_stays_so_and_is_named_where_it_is(scanned, name):
    elements, line, column = NOT_XML[name]
    with pytest.raises(ReadError) as caught:
        scanned(f"{HEAD}{elements}</materialx>")
    found = caught.value.finding
    assert (found.code, found.location) == ("READ_XML", line)
    assert found.message.endswith(f"at column {column}")


def test_the_depth_of_a_document_with_such_values_is_bounded_too(scanned):
    text = f"{HEAD}{udim('a.<UDIM>.png')}" + "<a>" * MAXIMUM_XML_DEPTH + "</a>" * MAXIMUM_XML_DEPTH + "</materialx>"
    with pytest.raises(ReadError, match="levels deep"):
        scanned(text)


@pytest.mark.parametrize("unit", ["<a b='", '<a b="', "<!--", "<![CDATA[", "<?", "<a b='\"", "<a "])
def test_a_text_that_never_closes_what_it_opens_takes_no_time(scanned, unit):
    began = time.monotonic()
    with pytest.raises(ReadError):
        scanned(f"{HEAD}{udim('a.<UDIM>.png')}" + unit * 200_000)
    assert time.monotonic() - began < 5.0


def test_a_declared_encoding_that_is_not_the_files_is_told(scanned):
    """MaterialX would read the bytes as the declaration says."""
    latin = HEAD.replace("?>", ' encoding="ISO-8859-1"?>')
    with pytest.raises(ReadError, match="says that it is ISO-8859-1, and is UTF-8"):
        scanned(f'{latin}<a b="é"/></materialx>')
    assert scanned(f'{latin}<a b="e"/></materialx>').root == "materialx"
    utf8 = HEAD.replace("?>", ' encoding="UTF-8"?>')
    assert scanned(f'{utf8}<a b="é"/></materialx>').root == "materialx"
