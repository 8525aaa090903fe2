"""The form in which documents are written as USD."""

from __future__ import annotations

import zipfile

import pytest
from pxr import Sdf, Usd, UsdShade

from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.formats.usd.exporter import stage_file
from mrm_mtlx.formats.usd.options import UsdOptions
from mrm_mtlx.shadergen.usd import material_prims

NETWORK_ALONE = UsdOptions(preview=False)
LEAF = '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">{}</oren_nayar_diffuse_bsdf>'
USE = (
    '<surfacematerial name="m" type="material">'
    '<input name="surfaceshader" type="surfaceshader" nodename="s" /></surfacematerial>'
)
COLOR = '<input name="color" type="color3" value="0.5, 0.25, 0.125"{} />'


def attribute(path, name):
    """An attribute of the stage at a path, of the first material; the stage lives as long as it does."""
    stage = Usd.Stage.Open(str(path))
    found = stage.GetAttributeAtPath(f"/Materials/m/{name}")
    assert found, f"{name} is missing"
    found.stage = stage
    return found


def test_a_material_has_the_form_that_usdmtlx_gives_it(surface_document, written):
    path = written(surface_document(LEAF.format(COLOR.format(""))))
    expected = """
    def Material "m" (
        prepend apiSchemas = ["MaterialXConfigAPI"]
    )
    {
        string config:mtlx:version = "1.39"
        token outputs:mtlx:surface.connect = </Materials/m/s.outputs:surface>

        def Shader "bsdf"
        {
            uniform token info:id = "ND_oren_nayar_diffuse_bsdf"
            color3f inputs:color = (0.5, 0.25, 0.125)
            token outputs:out (
                renderType = "BSDF"
            )
        }

        def Shader "s"
        {
            uniform token info:id = "ND_surface"
            token inputs:bsdf (
                renderType = "BSDF"
            )
            token inputs:bsdf.connect = </Materials/m/bsdf.outputs:out>
            token outputs:surface
        }
    }
"""
    assert expected in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["a.usda", "a.usdc", "a.usd", "a.usdz"])
def test_a_stage_is_complete_and_its_bytes_are_always_the_same(surface_document, written, stage_of, name):
    document = surface_document(LEAF.format(COLOR.format("")))
    path = written(document, name)
    first = path.read_bytes()
    assert written(document, name).read_bytes() == first
    assert first.startswith({"a.usda": b"#usda 1.0\n", "a.usdz": b"PK"}.get(name, b"PXR-USDC"))
    stage = Usd.Stage.Open(str(path))
    assert stage.GetDefaultPrim().GetPath() == "/Materials"
    material = UsdShade.Material(stage.GetPrimAtPath("/Materials/m"))
    surface, output, _ = material.ComputeSurfaceSource("mtlx")
    assert (surface.GetPath(), output) == ("/Materials/m/s", "surface")
    # USD's own validators have nothing to say but what is filtered.
    assert stage_of(path).findings == []


@pytest.mark.parametrize(
    ("document_space", "own_space", "expected"),
    [
        ("", "", ""),
        ("", "srgb_texture", "srgb_texture"),
        ("acescg", "", "acescg"),
        ("acescg", "srgb_texture", "srgb_texture"),
        ("srgb_texture", "lin_rec709", "lin_rec709"),
        ("lin_rec709", "", ""),  # linear without a word
    ],
)
def test_a_colour_has_its_space(surface_document, written, document_space, own_space, expected):
    own = f' colorspace="{own_space}"' if own_space else ""
    attributes = f'colorspace="{document_space}"' if document_space else ""
    document = surface_document(LEAF.format(COLOR.format(own)), attributes=attributes)
    assert attribute(written(document), "bsdf.inputs:color").GetColorSpace() == expected


def test_a_linear_graph_stays_so_in_a_document_of_another_space(make_document, written, stage_of):
    constant = '<constant name="c" type="color3"><input name="value" type="color3" value="0.5, 0.2, 0.1" /></constant>'
    document = make_document(
        f'<nodegraph name="g" colorspace="lin_rec709">{constant}<output name="o" type="color3" nodename="c" />'
        + "</nodegraph>"
        + LEAF.format('<input name="color" type="color3" nodegraph="g" output="o" />')
        + '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf" /></surface>'
        + USE,
        attributes='colorspace="acescg"',
    )
    back = stage_of(written(document)).materialx
    assert back.getDescendant("g/c/value").getActiveColorSpace() == "lin_rec709"


def test_a_length_is_in_the_unit_that_its_definition_expects(surface_document, written):
    film = '<input name="thinfilm_thickness" type="float" value="0.5" unit="micron" unittype="distance" />'
    document = surface_document(f'<dielectric_bsdf name="bsdf" type="BSDF">{film}</dielectric_bsdf>')
    assert attribute(written(document), "bsdf.inputs:thinfilm_thickness").Get() == 500.0


def test_an_image_is_named_as_seen_from_the_file(surface_document, library, tmp_path):
    for folder in ("documents/tex", "stages"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "documents/tex/a.ppm").write_bytes(b"P6\n1 1\n255\n\x80\x40\x20")
    image = (
        '<image name="i" type="color3"><input name="file" type="filename" value="a.ppm" fileprefix="tex/" /></image>'
    )
    document = surface_document(image + LEAF.format('<input name="color" type="color3" nodename="i" />'))
    source = Document(
        materialx=document, path=tmp_path / "documents" / "a.mtlx", reach=Reach(tmp_path / "documents", tmp_path)
    )
    # What lies elsewhere is copied, so that the stage's folder has all that it names.
    for name, expected in (("stages/a.usda", "./a/documents/tex/a.ppm"), ("documents/a.usda", "./tex/a.ppm")):
        assert format_for(tmp_path / name).write(source, tmp_path / name, library, NETWORK_ALONE) == []
        assert attribute(tmp_path / name, "i.inputs:file").Get().path == expected
        assert (tmp_path / name).parent.joinpath(expected).read_bytes()[-3:] == b"\x80\x40\x20"
    assert not (tmp_path / "documents" / "a").exists()
    assert format_for(tmp_path / "a.usdz").write(source, tmp_path / "a.usdz", library, NETWORK_ALONE) == []
    with zipfile.ZipFile(tmp_path / "a.usdz") as package:
        (layer, picture) = package.infolist()
        assert package.read(picture) == (tmp_path / "documents/tex/a.ppm").read_bytes()
        for entry in (layer, picture):
            data = entry.header_offset + 30 + len(entry.filename) + len(entry.extra)
            assert (data % stage_file.ALIGNMENT, entry.compress_type) == (0, zipfile.ZIP_STORED)
    # Within the package, and without it.
    (tmp_path / "documents/tex/a.ppm").unlink()
    back = read_document(tmp_path / "a.usdz", Reach.only(tmp_path), library, tmp_path / "stages")
    name = back.materialx.getNode("i").getInput("file").getValueString()
    assert (back.packed, (back.reach.folder / name).read_bytes()[-3:]) == (True, b"\x80\x40\x20")
    with pytest.raises(OSError, match="is an image missing"):
        format_for(tmp_path / "a.usdz").write(source, tmp_path / "a.usdz", library, NETWORK_ALONE)


def test_a_surface_without_a_material_gets_one(make_document, written, stage_of):
    document = make_document(
        '<nodegraph name="g"><surface name="s" type="surfaceshader" />'
        '<output name="out" type="surfaceshader" nodename="s" /></nodegraph>'
    )
    text = written(document).read_text(encoding="utf-8")
    assert "token outputs:mtlx:surface.connect = </Materials/g_out/g.outputs:out>" in text
    assert [m.getName() for m in stage_of(written(document)).materialx.getMaterialNodes()] == ["g_out"]


def test_each_material_holds_all_that_it_is_made_of(make_document, written):
    shared = (
        LEAF.format("") + '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf" />'
    )
    use = '<surfacematerial name="{}" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />'
    materials = "".join(use.format(name) + "</surfacematerial>" for name in ("a", "b"))
    text = written(make_document(shared + "</surface>" + materials)).read_text(encoding="utf-8")
    assert [text.count(f"</Materials/{name}/bsdf.outputs:out>") for name in ("a", "b")] == [1, 1]


def test_what_has_no_form_is_named_once_each(make_document, written):
    lost = []
    document = make_document(
        '<surface name="s" type="surfaceshader" /><surface name="t" type="surfaceshader" />'
        '<constant name="alone" type="float" />'
        '<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s" />'
        '<input name="backsurfaceshader" type="surfaceshader" nodename="t" /></surfacematerial>'
        '<look name="looks"><materialassign name="a" material="m" geom="/x" /></look>'
        '<nodedef name="ND_own" node="own"><output name="out" type="float" /></nodedef>'
    )
    written(document, lost=lost)
    assert {finding.code for finding in lost} == {"INTERCHANGE_LOST"}
    assert [finding.location for finding in lost] == ["/m/backsurfaceshader", "/t", "/alone", "/looks", "/ND_own"]


def test_a_definition_in_source_code_is_named(make_document, written):
    lost = []
    document = make_document(
        '<nodedef name="ND_own" node="own"><output name="out" type="BSDF" /></nodedef>'
        '<implementation name="IM_own" nodedef="ND_own" target="genglsl" sourcecode="x" /><own name="o" type="BSDF" />'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="o" /></surface>' + USE
    )
    text = written(document, lost=lost).read_text(encoding="utf-8")
    assert [finding.location for finding in lost] == ["/ND_own", "/IM_own"]
    assert 'info:id = "ND_own"' in text


def test_definitions_that_make_too_much_are_refused(monkeypatch, surface_document, written):
    monkeypatch.setattr(material_prims, "MAXIMUM_PRIMS", 2)
    with pytest.raises(ValueError, match="more than 2 prims"):
        written(surface_document(LEAF.format("")))


def test_a_file_is_whole_or_as_it_was(monkeypatch, surface_document, written, tmp_path):
    (tmp_path / "out.usda").write_text("before")

    def broken(*_):
        msg = "no"
        raise ValueError(msg)

    monkeypatch.setattr(stage_file, "write_materials", broken)
    with pytest.raises(ValueError, match="no"):
        written(surface_document(LEAF.format("")))
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("out.usda", "before")]


def test_names_that_usd_does_not_allow_are_changed(make_document, written, stage_of):
    document = make_document(
        '<oren_nayar_diffuse_bsdf name="a:b" type="BSDF" />'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="a:b" /></surface>' + USE
    )
    path = written(document)
    assert Sdf.Layer.FindOrOpen(str(path)).GetPrimAtPath("/Materials/m/a_b")
    assert stage_of(path).materialx.getNode("a_b") is not None
