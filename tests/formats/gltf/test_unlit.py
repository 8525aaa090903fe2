"""Materials that are the same in any light, and textures that have no image: read, checked and written back."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import srgb_decoded
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request

UNLIT = {"KHR_materials_unlit": {}}
TEXELS = np.array([[[230, 110, 60, 180], [90, 140, 200, 250]], [[40, 180, 100, 90], [150, 70, 240, 140]]])
FACTOR = (0.5, 0.75, 1.0, 0.5)
# The alphas of the image.
ALPHAS = TEXELS[..., 3].ravel() / 255.0
# Texture coordinates of the texels, v upward.
PLACES = [[(column + 0.5) / 2, 1 - (row + 0.5) / 2] for row in range(2) for column in range(2)]
COLORS = (srgb_decoded(TEXELS[..., :3] / 255.0) * FACTOR[:3]).reshape(-1, 3)
# Relative: pixels of an image are float32, and so are numbers.
CLOSE = 2.0**-22


@pytest.fixture
def asset(png, write_asset, tmp_path):
    """Function from an unlit material, its base colour apart, to the file of an asset."""

    def make(textured=True, **material):
        png(tmp_path / "texels.png", TEXELS)
        core = {"baseColorFactor": FACTOR} | ({"baseColorTexture": {"index": 0}} if textured else {})
        return write_asset(
            materials=[{"name": "sign", "extensions": UNLIT, "pbrMetallicRoughness": core, **material}],
            textures=[{"source": 0, "sampler": 0}],
            samplers=[{"magFilter": 9728}],
            images=[{"uri": "texels.png"}],
            extensionsUsed=list(UNLIT),
        )

    return make


MODES = {
    "opaque": ({}, np.ones(4)),
    "blended": ({"alphaMode": "BLEND"}, ALPHAS * FACTOR[3]),
    "masked": ({"alphaMode": "MASK", "alphaCutoff": 0.3}, (ALPHAS * FACTOR[3] >= 0.3).astype(float)),
    "masked at a half": ({"alphaMode": "MASK"}, (ALPHAS * FACTOR[3] >= 0.5).astype(float)),
}


@pytest.mark.parametrize("mode", MODES)
def test_an_unlit_material_shows_its_base_colour_whatever_the_light(asset, read, surface_of, points, mode):
    material, opacity = MODES[mode]
    imported = read(asset(**material))
    assert imported.findings == []
    assert imported.materialx.validate() == (True, "")
    (node,) = [node for node in imported.materialx.getNodes() if node.getType() == "surfaceshader"]
    assert node.getCategory() == "surface_unlit"
    assert imported.source_locations[f"{node.getName()}/emission_color"].startswith(
        "/materials/0/pbrMetallicRoughness/baseColor"
    )
    found = surface_of(imported).shade(points(PLACES))
    np.testing.assert_allclose(found, COLORS * opacity[:, None], rtol=CLOSE)


@pytest.mark.parametrize(
    ("material", "opacity"),
    [
        ({}, 1.0),
        ({"alphaMode": "BLEND"}, 0.5),
        ({"alphaMode": "MASK", "alphaCutoff": 0.5}, 1.0),
        ({"alphaMode": "MASK", "alphaCutoff": 0.6}, 0.0),
    ],
)
def test_an_unlit_material_of_numbers(asset, read, surface_of, points, material, opacity):
    found = surface_of(read(asset(textured=False, **material))).shade(points([[0.5, 0.5]]))
    np.testing.assert_allclose(found, [np.array(FACTOR[:3]) * opacity], rtol=CLOSE)


def test_the_check_of_an_unlit_asset_compares_it(gl, asset):
    path = asset(alphaMode="MASK", alphaCutoff=0.3)
    result = check_document(Request(path, Reach.beside(path), path.name, targets=("glsl",), samples=256))
    assert result.findings == []
    (renderable,) = result.renderables
    assert (renderable.name, renderable.targets["glsl"].status) == ("/materials/0", "pass")


@pytest.mark.parametrize("mode", MODES)
def test_an_unlit_material_is_written_back(asset, read, library, surface_of, points, tmp_path, mode):
    material, opacity = MODES[mode]
    out = tmp_path / "out" / "again.gltf"
    out.parent.mkdir()
    assert format_for(out).write(read(asset(**material)), out, library) == []
    data = json.loads(out.read_text(encoding="utf-8"))
    (written,) = data["materials"]
    assert (written["extensions"], data["extensionsUsed"]) == (UNLIT, list(UNLIT))
    assert written.get("alphaMode", "OPAQUE") == material.get("alphaMode", "OPAQUE")
    found = surface_of(read(out)).shade(points(PLACES))
    np.testing.assert_allclose(found, COLORS * opacity[:, None], rtol=CLOSE)


def test_what_is_written_of_an_unlit_material_is_its_colour_times_its_strength(make_document, library, tmp_path):
    inputs = '<input name="emission" type="float" value="0.5"/><input name="emission_color" type="color3" '
    document = make_document(unlit(inputs + 'value="1, 0.5, 0.25"/>'), attributes='colorspace="lin_rec709"')
    path = tmp_path / "a.gltf"
    assert (
        format_for(path).write(
            Document(materialx=document, path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path)), path, library
        )
        == []
    )
    (written,) = json.loads(path.read_text(encoding="utf-8"))["materials"]
    # What those are to show that do not know the extension, as it recommends.
    assert written["pbrMetallicRoughness"] == {
        "baseColorFactor": [0.5, 0.25, 0.125, 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": 0.9,
    }


def unlit(inputs: str, more: str = "") -> str:
    """Elements with an unlit material."""
    return (
        f'{more}<surface_unlit name="s" type="surfaceshader">{inputs}</surface_unlit>'
        '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>'
        "</surfacematerial>"
    )


VARYING = """
  <position name="q" type="vector3"/>
  <extract name="p" type="float"><input name="in" type="vector3" nodename="q"/></extract>
"""


@pytest.mark.parametrize(
    ("inputs", "reason"),
    [
        ('<input name="transmission" type="float" value="0.5"/>', "it is unlit and lets light through"),
        ('<input name="emission" type="float" nodename="p"/>', ""),
        ('<input name="opacity" type="float" nodename="p"/>', ""),
    ],
)
def test_an_unlit_surface_that_gltf_cannot_say_is_named(make_document, library, tmp_path, inputs, reason):
    path = tmp_path / "a.gltf"
    source = Document(
        materialx=make_document(unlit(inputs, VARYING)), path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path)
    )
    with pytest.raises(NothingToWriteError) as caught:
        format_for(path).write(source, path, library)
    (finding,) = caught.value.findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LEFT_OUT", "/m")
    assert reason in finding.message


TEXTURES = [
    {},
    {"sampler": 0},
    {"extensions": {"KHR_texture_basisu": {"source": 0}}},
    {"extensions": {"EXT_texture_webp": {}}},
]


@pytest.mark.parametrize("texture", TEXTURES, ids=str)
def test_a_texture_without_an_image_is_a_warning_and_its_material_is_checked(write_asset, texture):
    """What glTF calls undefined, and Khronos' validator accepts."""
    path = write_asset(
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0}}],
        textures=[texture],
        samplers=[{}],
        images=[{"uri": "a.ktx2"}],
        extensionsRequired=["KHR_texture_basisu"] if "KHR_texture_basisu" in str(texture) else [],
    )
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    assert {(found.code, found.severity) for found in result.findings} == {("INTERCHANGE_LOST", "warning")}
    assert "/textures/0" in [found.location for found in result.findings]
    assert [renderable.name for renderable in result.renderables] == ["/materials/0"]
