"""What a glTF material says is what its document is worth: values by formulas written here, at texels of images."""

from __future__ import annotations

import base64
import json
import math

import numpy as np
import pytest

from mrm_mtlx.formats.gltf import properties
from mrm_mtlx.formats.gltf.importer import asset_materials
from mrm_mtlx.reference import Environment, Illumination, ShadingPoints, Surface
from mrm_mtlx.shadergen import renderable_elements

# Factors are written with nine digits and pixels are float32: some roundings of 2^-24, which flanks of lobes multiply.
CLOSE = 1e-5

FACTORS = {
    "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.6, 0.7, 0.8], "metallicFactor": 0.7, "roughnessFactor": 0.9},
    "emissiveFactor": [0.2, 0.3, 0.4],
    "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 3.0},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.6, "clearcoatRoughnessFactor": 0.5},
        "KHR_materials_sheen": {"sheenColorFactor": [0.3, 0.2, 0.1], "sheenRoughnessFactor": 0.9},
        "KHR_materials_transmission": {"transmissionFactor": 0.4},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_specular": {"specularFactor": 0.9, "specularColorFactor": [3.0, 2.0, 1.0]},
        "KHR_materials_iridescence": {"iridescenceFactor": 0.5, "iridescenceIor": 1.6},
        "KHR_materials_retroreflection": {"retroreflectionFactor": 0.75},
    },
}


def with_textures(index: int) -> dict:
    """The same material with one texture in every slot."""
    material = json.loads(json.dumps(FACTORS))
    info = {"index": index}
    slots = dict.fromkeys(p.texture for p in properties.PROPERTIES if p.texture and p.input != "thickness")
    for path in slots:
        properties.found(material, path[:-1])[path[-1]] = info
    material["extensions"]["KHR_materials_iridescence"] |= {
        "iridescenceThicknessTexture": info,
        "iridescenceThicknessMinimum": 150.0,
        "iridescenceThicknessMaximum": 650.0,
    }
    return material | {"alphaMode": "BLEND"}


def decoded(value: float) -> float:
    """A component of an sRGB colour, IEC 61966-2-1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def expected_inputs(texel: np.ndarray) -> dict[str, object]:
    """Inputs of gltf_pbr at a texel: each factor times the channel that glTF 2.0 and its extensions name."""
    r, g, b, a = (float(x) for x in texel)
    color = np.array([decoded(r), decoded(g), decoded(b)])
    return {
        "base_color": color * [0.5, 0.6, 0.7],
        "alpha": 0.8 * a,
        "metallic": 0.7 * b,
        "roughness": 0.9 * g,
        "emissive": color * [0.2, 0.3, 0.4],
        "emissive_strength": 3.0,
        "clearcoat": 0.6 * r,
        "clearcoat_roughness": 0.5 * g,
        "sheen_color": color * [0.3, 0.2, 0.1],
        "sheen_roughness": 0.9 * a,
        "transmission": 0.4 * r,
        "ior": 1.4,
        "specular": 0.9 * a,
        "specular_color": color * [3.0, 2.0, 1.0],
        "iridescence": 0.5 * r,
        "iridescence_ior": 1.6,
        "iridescence_thickness": 150.0 + g * 500.0,
        "retroreflectivity": 0.75 * r,
        "alpha_mode": 2,
    }


@pytest.fixture
def constants(make_document):
    """Function from inputs of gltf_pbr to a surface that has them."""

    def make(inputs) -> Surface:
        def text(name, value) -> str:
            kind = "integer" if name == "alpha_mode" else "float" if np.ndim(value) == 0 else "color3"
            return f'<input name="{name}" type="{kind}" value="{", ".join(f"{x:.9g}" for x in np.atleast_1d(value))}"/>'

        given = "".join(text(name, value) for name, value in inputs.items())
        kept.append(document := make_document(f'<gltf_pbr name="s" type="surfaceshader">{given}</gltf_pbr>'))
        return Surface(document.getNode("s"))

    kept: list = []
    return make


TEXELS = np.array([[[230, 110, 60, 180], [90, 140, 200, 250]], [[40, 180, 100, 90], [150, 70, 240, 140]]])
NEAREST = [{"magFilter": 9728}]


@pytest.fixture
def textured(png, write_asset, tmp_path):
    """Function that writes an asset whose one texture has four texels."""

    def write(*materials, **arrays):
        png(tmp_path / "texels.png", TEXELS)
        images = {"textures": [{"source": 0, "sampler": 0}], "samplers": NEAREST, "images": [{"uri": "texels.png"}]}
        return write_asset(materials=list(materials), **images | arrays)

    return write


ALL = tuple(np.ndindex(2, 2))


def values_apart(surface_of, constants, points, imported, texels=((0, 0),)) -> float:
    """Largest relative difference of a textured material from constants, at these texels."""
    apart = 0.0
    around = Illumination(environment=Environment.constant((1.0, 1.0, 1.0), samples=4))
    for row, column in texels:
        # Row 0 is the upper one, v = 1 - v_gltf.
        at = points(np.tile([(column + 0.5) / 2.0, 1.0 - (row + 0.5) / 2.0], (8, 1)))
        found = surface_of(imported).shade(at, around)
        expected = constants(expected_inputs(TEXELS[row, column] / 255.0)).shade(at, around)
        apart = max(apart, float(np.max(np.abs(found - expected) / np.abs(expected))))
    return apart


def test_every_texture_is_its_channel_times_its_factor_in_its_transfer(textured, read, surface_of, constants, points):
    imported = read(textured(with_textures(0)))
    assert imported.findings == []
    assert imported.materialx.validate() == (True, "")
    assert values_apart(surface_of, constants, points, imported, ALL) < CLOSE


def test_a_wrong_transfer_is_seen(monkeypatch, textured, read, surface_of, constants, points):
    monkeypatch.setattr("mrm_mtlx.formats.gltf.importer.texture_graph.ENCODED", "lin_rec709")
    assert values_apart(surface_of, constants, points, read(textured(with_textures(0)))) > 1e-3


@pytest.mark.parametrize("name", ["metallic", "retroreflectivity", "specular", "sheen_roughness"])
def test_a_wrong_channel_is_seen(monkeypatch, textured, read, surface_of, constants, points, name):
    path = textured(with_textures(0))
    wrong = tuple(
        p._replace(channels=((p.channels[0] + 1) % 4,)) if p.input == name else p for p in properties.PROPERTIES
    )
    monkeypatch.setattr(properties, "PROPERTIES", wrong)
    assert values_apart(surface_of, constants, points, read(path)) > 1e-3


def test_a_material_without_anything_is_that_of_gltf(write_asset, read, surface_of, constants, points):
    imported = read(write_asset(materials=[{}]))
    at = points(np.zeros((8, 2)))
    white = constants({"base_color": (1.0, 1.0, 1.0), "metallic": 1.0, "roughness": 1.0})
    assert np.array_equal(surface_of(imported).shade(at), white.shade(at))
    assert [e.getName() for e in renderable_elements(imported.materialx)] == ["material_0"]


def test_retroreflection_blends_by_factor_times_red(textured, read, surface_of, points):
    info = {"index": 0}
    plain = {
        "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.6, 0.3, 1.0], "metallicFactor": 0.5, "roughnessFactor": 0.4}
    }

    def of(**extension):
        return plain | {"extensions": {"KHR_materials_retroreflection": extension}}

    path = textured(
        plain,
        of(retroreflectionFactor=1.0),
        of(retroreflectionFactor=0.6, retroreflectionTexture=info),
        of(retroreflectionTexture=info),
    )
    imported = read(path)
    at = points(np.tile([0.25, 0.75], (64, 1)))
    none, full, part, default = (surface_of(imported, k).response(at) for k in range(4))
    share = 0.6 * TEXELS[0, 0, 0] / 255.0
    np.testing.assert_allclose(part, (1.0 - share) * none + share * full, rtol=CLOSE)
    assert np.array_equal(default, none)  # the factor is 0 by default, whatever the texture
    back = points(np.tile([0.25, 0.75], (8, 1)))
    back = ShadingPoints(back.view, back.view, back.normal, back.tangent, back.position, back.texcoord)
    assert np.all(surface_of(imported, 1).response(back) > surface_of(imported, 0).response(back))


def test_clear_coat_sheen_and_transmission_stay_ordinary(write_asset, read, surface_of, points):
    # With a base that reflects nothing, what is left is what the draft's rules leave alone.
    over = {
        "KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.3},
        "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.4, 0.3], "sheenRoughnessFactor": 0.5},
        "KHR_materials_transmission": {"transmissionFactor": 0.8},
    }

    def material(share, specular, extensions):
        more = {
            "KHR_materials_specular": {"specularFactor": specular},
            "KHR_materials_retroreflection": {"retroreflectionFactor": share},
        }
        base = {"metallicFactor": 0.0, "roughnessFactor": 0.4}
        return {"pbrMetallicRoughness": base, "extensions": extensions | more}

    materials = [material(share, specular, over) for specular in (0.0, 1.0) for share in (0.0, 1.0)]
    imported = read(write_asset(materials=materials))
    around = Illumination(environment=Environment.constant((1.0, 0.8, 0.6), samples=8))
    at = points(np.zeros((32, 2)))
    ordinary, retroreflective, base, retroreflective_base = (
        surface_of(imported, k).shade(at, around) for k in range(4)
    )
    # The lobe of no weight is not there at all: the same numbers are added.
    np.testing.assert_allclose(retroreflective, ordinary, rtol=1e-14)
    assert np.max(np.abs(retroreflective_base - base)) > 1e-3


def transformed(uv, offset, rotation, scale):
    """KHR_texture_transform by its text: scale, then a rotation that is counter-clockwise on the image, then offset.

    v runs downward, so that counter-clockwise takes +u to -v.
    """
    u, v = uv[:, 0] * scale[0], uv[:, 1] * scale[1]
    cosine, sine = math.cos(rotation), math.sin(rotation)
    return np.stack([cosine * u + sine * v + offset[0], -sine * u + cosine * v + offset[1]], axis=1)


WRAPS = {
    10497: lambda x: x % 1.0,
    33071: lambda x: np.clip(x, 0.0, 1.0 - 1e-9),
    33648: lambda x: np.where(x % 2.0 < 1.0, x % 2.0, 2.0 - x % 2.0),
}


@pytest.mark.parametrize(("wrap_s", "wrap_t"), [(10497, 33648), (33071, 10497), (33648, 33071)])
def test_transforms_and_wrap_modes_take_the_texel_that_the_description_says(
    rng, png, write_asset, tmp_path, read, surface_of, points, emitted, wrap_s, wrap_t
):
    size = 8
    texels = rng.integers(0, 256, (size, size, 3))
    png(tmp_path / "a.png", texels)
    numbers = {"offset": [0.3, -0.2], "rotation": 0.7, "scale": [1.7, -0.6]}
    info = {"index": 0, "extensions": {"KHR_texture_transform": numbers}}
    imported = read(
        write_asset(
            materials=[{"pbrMetallicRoughness": {}, "emissiveFactor": [1, 1, 1], "emissiveTexture": info}],
            textures=[{"source": 0, "sampler": 0}],
            samplers=[{"magFilter": 9728, "wrapS": wrap_s, "wrapT": wrap_t}],
            images=[{"uri": "a.png"}],
        )
    )
    uv = rng.uniform(-1.0, 2.0, (200, 2))
    place = transformed(uv, **numbers)
    # A texel's edge is a step: what is within a thousandth of one is left out.
    clear = np.all(np.abs(place * size - np.round(place * size)) > 1e-3 * size, axis=1)
    column, row = (np.floor(WRAPS[w](p) * size).astype(int) for w, p in zip((wrap_s, wrap_t), place.T, strict=True))
    expected = np.vectorize(decoded)(texels[row, column] / 255.0)
    found = emitted(surface_of(imported), points(np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1)))
    assert np.count_nonzero(clear) > 150
    np.testing.assert_allclose(found[clear], expected[clear], rtol=CLOSE)
    # The other sense of rotation, as in the listing of the description, shows other texels.
    other = transformed(uv, numbers["offset"], -numbers["rotation"], numbers["scale"])
    assert np.mean(np.all(np.floor(other * size) == np.floor(place * size), axis=1)) < 0.5


def test_the_example_of_the_description_shows_the_lower_left_quadrant():
    numbers = {"offset": (0.0, 1.0), "rotation": math.pi / 2.0, "scale": (0.5, 0.5)}
    corners = transformed(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), **numbers)
    assert np.round(corners, 9).min(axis=0).tolist() == [0.0, 0.5]
    assert np.round(corners, 9).max(axis=0).tolist() == [0.5, 1.0]


@pytest.mark.parametrize("scale", [1.0, 0.4])
def test_a_normal_texture_turns_the_normal(png, write_asset, tmp_path, read, surface_of, points, scale):
    png(tmp_path / "n.png", [[[180, 90, 230]]])
    plain = {"metallicFactor": 1.0, "roughnessFactor": 0.5}
    imported = read(
        write_asset(
            materials=[
                {"pbrMetallicRoughness": plain, "normalTexture": {"index": 0, "scale": scale}},
                {"pbrMetallicRoughness": plain},
            ],
            textures=[{"source": 0}],
            images=[{"uri": "n.png"}],
        )
    )
    at = points(np.full((32, 2), 0.5))
    x, y, z = (2.0 * c / 255.0 - 1.0 for c in (180, 90, 230))
    normal = np.array([scale * x, scale * y, z]) / np.linalg.norm([scale * x, scale * y, z])
    # Green is up, which is MaterialX's +v: the bitangent n x t.
    turned = points(np.full((32, 2), 0.5), normal, np.cross([0.0, 1.0, 0.0], normal))
    turned = ShadingPoints(at.view, at.light, turned.normal, turned.tangent, at.position, at.texcoord)
    above = np.all(np.stack([at.view @ normal, at.light @ normal]) > 0.05, axis=0)
    found, expected = surface_of(imported).response(at), surface_of(imported, 1).response(turned)
    np.testing.assert_allclose(found[above], expected[above], rtol=1e-4)  # 8-bit pixels as float32, near a lobe's flank


def test_anisotropy_stretches_along_the_rotated_tangent(png, write_asset, tmp_path, read, surface_of, points):
    # Direction (0, 1) in the texture is a quarter turn counter-clockwise from the tangent: along the bitangent.
    png(tmp_path / "a.png", [[[128, 255, 255]]])
    metal = {"metallicFactor": 1.0, "roughnessFactor": 0.3}

    def of(**extension):
        return {"pbrMetallicRoughness": metal, "extensions": {"KHR_materials_anisotropy": extension}}

    materials = [
        of(anisotropyStrength=0.8, anisotropyTexture={"index": 0}),
        of(anisotropyStrength=0.8, anisotropyRotation=math.pi / 2.0),
        of(anisotropyStrength=0.8),
    ]
    imported = read(write_asset(materials=materials, textures=[{"source": 0}], images=[{"uri": "a.png"}]))
    at = points(np.full((2, 2), 0.5))
    view = np.tile([0.0, 0.0, 1.0], (2, 1))
    light = np.array([[0.5, 0.0, math.sqrt(0.75)], [0.0, 0.5, math.sqrt(0.75)]])
    at = ShadingPoints(view, light, at.normal, at.tangent, at.position, at.texcoord)
    texture, turned, straight = (surface_of(imported, k).response(at)[:, 0] for k in range(3))
    assert straight[0] > 2.0 * straight[1]  # wide along the tangent
    np.testing.assert_allclose(turned, straight[::-1], rtol=CLOSE)
    np.testing.assert_allclose(texture, turned, rtol=0.02)  # 128 / 255 is not quite a half


@pytest.mark.parametrize("kind", ["glb", "data", "buffer"])
def test_images_inside_of_an_asset_are_those_beside_it(glb, png, write_asset, tmp_path, read, kind):
    content = png(tmp_path / "in.png", TEXELS)
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    data = {"asset": {"version": "2.0"}, "materials": [material], "textures": [{"source": 0}]}
    view = {"images": [{"bufferView": 0, "mimeType": "image/png", "name": "a mask"}]}
    ranges = {"bufferViews": [{"buffer": 0, "byteOffset": 4, "byteLength": len(content)}]}
    padded = b"1234" + content
    size = {"byteLength": len(padded)}
    path = tmp_path / ("model.glb" if kind == "glb" else "model.gltf")
    if kind == "glb":
        path.write_bytes(glb(data | view | ranges | {"buffers": [size]}, padded))
    elif kind == "data":
        uri = "data:image/png;base64," + base64.b64encode(content).decode()
        path.write_text(json.dumps(data | {"images": [{"uri": uri, "name": "a mask"}]}))
    else:
        (tmp_path / "a b.bin").write_bytes(padded)
        path.write_text(json.dumps(data | view | ranges | {"buffers": [{"uri": "a%20b.bin", **size}]}))
    imported = read(path)
    (file,) = (e for e in imported.materialx.traverseTree() if e.getName() == "file")
    assert imported.findings == []
    assert imported.packed
    assert (imported.reach.folder / file.getValueString()).read_bytes() == content
    assert file.getValueString() == "a_mask_0.png"


def test_places_are_json_pointers(textured, read):
    imported = read(textured({"name": "first"}, with_textures(0)))
    shader = "/SR_material_1"
    assert imported.source_location("/first") == "/materials/0"
    assert imported.source_location("/SR_first/metallic") == "/materials/0/metallic"
    extension = "/materials/1/extensions/KHR_materials_retroreflection"
    assert imported.source_location(f"{shader}/retroreflectivity") == f"{extension}/retroreflectionTexture"
    assert imported.source_location(f"{shader}/ior") == "/materials/1/extensions/KHR_materials_ior/ior"
    files = [e for e in imported.materialx.traverseTree() if e.getName() == "file"]
    assert {imported.source_location(f"/{e.getNamePath()}") for e in files} == {"/images/0"}


LOSSES = [
    ({"doubleSided": True}, "/doubleSided", "which sides"),
    (
        {"extensions": {"EXT_materials_retroreflection": {}}},
        "/extensions/EXT_materials_retroreflection",
        "KHR_materials_",
    ),
    ({"extras": {"geometry_retroreflection": 1.0}}, "/extras/geometry_retroreflection", "probably meant"),
    ({"extensions": {"ACME_glow": {}}}, "/extensions/ACME_glow", "not read"),
    (
        {"extensions": {"KHR_materials_retroreflection": {"retroreflectiveFactor": 1.0}}},
        "/extensions/KHR_materials_retroreflection",
        "retroreflectionFactor is probably meant",
    ),
    ({"emissionFactor": [1, 1, 1]}, "", "emissiveFactor is probably meant"),
]


@pytest.mark.parametrize(("material", "place", "words"), LOSSES)
def test_what_materialx_cannot_say_is_said(write_asset, read, material, place, words):
    (finding,) = read(write_asset(materials=[material])).findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LOST", f"/materials/0{place}")
    assert words in finding.message


def test_vertex_colours_filters_and_required_extensions_are_said(png, write_asset, tmp_path, read):
    png(tmp_path / "a.png", TEXELS)
    path = write_asset(
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        textures=[{"source": 0, "sampler": 0, "extensions": {"KHR_texture_basisu": {"source": 0}}}],
        samplers=[{"magFilter": 9728, "minFilter": 9987}],
        images=[{"uri": "a.png"}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "material": 0}]}],
        extensionsRequired=[
            "KHR_draco_mesh_compression",
            "ACME_paint",
            "KHR_materials_retroreflection",
            "KHR_materials_ior",
        ],
    )
    found = {(finding.code, finding.location) for finding in read(path).findings}
    assert found == {
        ("INTERCHANGE_INVALID", "/extensionsRequired/1"),
        ("INTERCHANGE_LOST", "/extensionsRequired/2"),
        ("INTERCHANGE_LOST", "/materials/0"),
        ("INTERCHANGE_LOST", "/samplers/0"),
        ("INTERCHANGE_LOST", "/textures/0/extensions/KHR_texture_basisu"),
    }


@pytest.mark.parametrize(
    ("material", "is_faint"),
    [
        ({"pbrMetallicRoughness": {"metallicFactor": 0.0}}, True),
        ({}, False),
        ({"pbrMetallicRoughness": {"metallicFactor": 0.0}, "extensions": {"KHR_materials_ior": {"ior": 2.0}}}, False),
    ],
)
def test_retroreflection_that_is_hardly_seen_is_said(write_asset, read, material, is_faint):
    extensions = material.get("extensions", {}) | {"KHR_materials_retroreflection": {"retroreflectionFactor": 1.0}}
    findings = read(write_asset(materials=[material | {"extensions": extensions}])).findings
    assert [finding.code for finding in findings] == (["RETRO_INVISIBLE"] if is_faint else [])
    assert not is_faint or "specularColorFactor" in findings[0].hint


def test_names_become_names_of_elements_once(write_asset, read):
    names = ["Cone Mat", "Cone Mat", "", "7", "SR_7", "retro/stripe"]
    imported = read(write_asset(materials=[{"name": name} for name in names]))
    found = [e.getName() for e in renderable_elements(imported.materialx)]
    assert len(set(found)) == len(names)
    assert not any(name[0].isdigit() for name in found)  # shaders have variables of these names
    assert imported.materialx.validate() == (True, "")
    assert [imported.source_location(f"/{name}") for name in found] == [f"/materials/{k}" for k in range(len(names))]
    assert asset_materials.RETROREFLECTION == "KHR_materials_retroreflection"
