"""`--root`: folders from which files may be read besides the document's own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

PICTURE = Path(__file__).parents[1] / "rules" / "USD_VALIDATOR_WARNING" / "parts" / "normal.png"
DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <image name="i" type="color3"><input name="file" type="filename" value="{}" /></image>
  <oren_nayar_diffuse_bsdf name="d" type="BSDF"><input name="color" type="color3" nodename="i" />
  </oren_nayar_diffuse_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="d" /></surface>
  <surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />
  </surfacematerial>
</materialx>
"""
# Each command that opens a document; "{}" is its place.
COMMANDS = {
    "validate": ("validate", "{}", "--target", "glsl", "--samples", "16"),
    "render": ("render", "{}", "-o", "a.png", "--size", "16"),
    "generate": ("generate", "{}"),
    "convert": ("convert", "{}", "a.usda"),
    "convert to OpenMATERIAL": ("convert", "{}", "a.json"),
    "plot": ("plot", "{}", "-o", "a.svg"),
    "photometry": ("photometry", "{}"),
}


@pytest.fixture
def show(tmp_path):
    """Folders as a project has them, `show/tex` beside `show/mat`, with a document; returns `show`."""
    for folder in ("show/tex", "show/mat", "tools/tex"):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(PICTURE, tmp_path / "show/tex/x.png")
    (tmp_path / "show/mat/a.mtlx").write_text(DOCUMENT.format("../tex/x.png"), encoding="utf-8")
    return tmp_path / "show"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_texture_beside_the_folder_is_read_where_a_root_holds_it(in_process, gl, show, command):
    arguments = [part.format(show / "mat/a.mtlx") for part in COMMANDS[command]]
    refused = in_process(*arguments)
    assert refused.exit_code == 1
    assert "READ_OUTSIDE" in refused.output
    assert "--root" in refused.output
    allowed = in_process(*arguments, "--root", show)
    assert (allowed.exit_code, "READ_OUTSIDE" in allowed.output) == (0, False), allowed.output


def test_roots_are_searched_in_order_for_what_is_not_beside_the_document(in_process, show, tmp_path):
    (show / "mat/a.mtlx").write_text(DOCUMENT.format("tex/x.png"), encoding="utf-8")
    (tmp_path / "tools/tex/x.png").write_bytes(b"no picture")
    quick = ("validate", show / "mat", "--target", "glsl", "--samples", "16")
    assert "DOC_FILE /i/file the image 'tex/x.png' does not exist" in " ".join(in_process(*quick).output.split())
    assert in_process(*quick, "--root", show).exit_code == 0
    assert in_process(*quick, "--root", show, "--root", tmp_path / "tools").exit_code == 0
    shadowed = in_process(*quick, "--root", tmp_path / "tools", "--root", show)
    assert (shadowed.exit_code, "DOC_FILE" in shadowed.output) == (1, True)


def test_includes_are_searched_in_the_roots_and_may_lie_there(in_process, show, tmp_path):
    (tmp_path / "tools/part.mtlx").write_bytes((show / "mat/a.mtlx").read_bytes())
    (show / "mat/a.mtlx").write_text(
        '<?xml version="1.0"?>\n<materialx version="1.39"><xi:include href="part.mtlx" /></materialx>', encoding="utf-8"
    )
    quick = ("validate", show / "mat/a.mtlx", "--target", "mdl", "--format", "json")
    (document,) = json.loads(in_process(*quick, "--root", tmp_path / "tools", "--root", show).stdout)["documents"]
    assert (document["findings"], [r["name"] for r in document["renderables"]]) == ([], ["m"])
    (document,) = json.loads(in_process(*quick).stdout)["documents"]
    assert [f["code"] for f in document["findings"]] == ["READ_INCLUDE"]


def test_a_link_in_the_folder_may_lead_into_a_root(in_process, show, tmp_path):
    (tmp_path / "tools/a.mtlx").write_bytes((show / "mat/a.mtlx").read_bytes())
    (show / "mat/a.mtlx").unlink()
    (show / "mat/a.mtlx").symlink_to(tmp_path / "tools/a.mtlx")
    quick = ("validate", show / "mat", "--target", "glsl", "--samples", "16")
    assert "READ_OUTSIDE" in in_process(*quick).output
    allowed = in_process(*quick, "--root", show, "--root", tmp_path / "tools")
    assert allowed.exit_code == 0, allowed.output


def test_what_was_read_from_a_root_is_copied_beside_what_is_written(in_process, show, tmp_path):
    (tmp_path / "out").mkdir()
    done = in_process("convert", show / "mat/a.mtlx", "out/a.usda", "--root", show)
    assert done.exit_code == 0, done.output
    (copy,) = (tmp_path / "out").rglob("x.png")
    assert copy.read_bytes() == PICTURE.read_bytes()
    assert f"{copy.relative_to(tmp_path / 'out').as_posix()}@" in (tmp_path / "out/a.usda").read_text(encoding="utf-8")


def test_sources_of_implementations_are_searched_in_the_roots(in_process, gl, tmp_path):
    (tmp_path / "tools/genglsl/lib").mkdir(parents=True)
    (tmp_path / "mat").mkdir()
    (tmp_path / "tools/genglsl/half.glsl").write_text(
        '#include "lib/half.glsl"\nvoid half_of(out float x) { x = HALF; }\n', encoding="utf-8"
    )
    (tmp_path / "tools/genglsl/lib/half.glsl").write_text("#define HALF 0.5\n", encoding="utf-8")
    (tmp_path / "mat/a.mtlx").write_text(
        '<?xml version="1.0"?>\n<materialx version="1.39">'
        '<nodedef name="ND_h" node="h"><output name="out" type="float"/></nodedef>'
        '<implementation name="IM_h" nodedef="ND_h" target="genglsl" function="half_of" '
        'file="genglsl/half.glsl"/><h name="n" type="float"/><surface_unlit name="s" type="surfaceshader">'
        '<input name="emission" type="float" nodename="n"/></surface_unlit><surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial></materialx>',
        encoding="utf-8",
    )
    assert "'genglsl/half.glsl' does not exist" in in_process("generate", "mat/a.mtlx").output
    done = in_process("generate", "mat/a.mtlx", "--root", "tools")
    assert (done.exit_code, "void half_of" in done.output, "#define HALF" in done.output) == (0, True, True)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_root_that_is_no_folder_is_a_wrong_call(in_process, show, command):
    arguments = [part.format(show / "mat/a.mtlx") for part in COMMANDS[command]]
    done = in_process(*arguments, "--root", "nowhere")
    assert (done.exit_code, "--root" in done.output, "nowhere" in done.output) == (2, True, True)


def test_a_root_is_for_documents_alone(in_process, tmp_path):
    done = in_process("plot", "-o", "a.svg", "--root", tmp_path)
    assert (done.exit_code, "only with a document" in done.output) == (2, True)


def test_a_set_of_tiles_is_copied_whole_from_a_root(in_process, show, tmp_path):
    (show / "mat/a.mtlx").write_text(DOCUMENT.format("tex/&lt;UDIM&gt;/x.&lt;UDIM&gt;.png"), encoding="utf-8")
    for tile in ("1001", "1002"):
        (show / "tex" / tile).mkdir()
        shutil.copy(PICTURE, show / "tex" / tile / f"x.{tile}.png")
    (tmp_path / "out").mkdir()
    done = in_process("convert", show / "mat/a.mtlx", "out/a.usda", "--root", show)
    assert done.exit_code == 0, done.output
    copies = sorted(path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.png"))
    assert copies == ["a/tex/1001/x.1001.png", "a/tex/1002/x.1002.png"]
    assert "a/tex/<UDIM>/x.<UDIM>.png@" in (tmp_path / "out/a.usda").read_text(encoding="utf-8")


GLTF = """{"asset": {"version": "2.0"}, "images": [{"uri": "../tex/x.png"}], "textures": [{"source": 0}],
"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]}"""
USDA = """#usda 1.0
def Material "M" {
    token outputs:mtlx:surface.connect = </M/s.outputs:out>
    def Shader "s" {
        uniform token info:id = "ND_surface_unlit"
        color3f inputs:emission_color.connect = </M/i.outputs:out>
        token outputs:out
    }
    def Shader "i" {
        uniform token info:id = "ND_image_color3"
        asset inputs:file = @../tex/x.png@
        color3f outputs:out
    }
}
"""


@pytest.mark.parametrize("name", ["a.gltf", "a.usda"])
def test_files_of_other_formats_may_lie_in_a_root_too(in_process, show, name):
    (show / "mat" / name).write_text(GLTF if name == "a.gltf" else USDA, encoding="utf-8")
    assert "READ_OUTSIDE" in in_process("convert", show / "mat" / name, "out.mtlx").output
    done = in_process("convert", show / "mat" / name, "out.mtlx", "--root", show)
    assert (done.exit_code, "READ_OUTSIDE" in done.output) == (0, False), done.output
    assert 'value="show/tex/x.png"' in Path("out.mtlx").read_text(encoding="utf-8")
