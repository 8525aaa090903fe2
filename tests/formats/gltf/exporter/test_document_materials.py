"""Documents as assets: what is written is worth the same, or the difference is said."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.format import NothingToWriteError
from mrm_mtlx.formats.gltf import schema
from mrm_mtlx.formats.gltf.container import open_container
from mrm_mtlx.formats.gltf.exporter import texture_slots
from mrm_mtlx.formats.pbr import bsdf_surfaces, comparison
from mrm_mtlx.formats.registry import format_for, options_for
from mrm_mtlx.reference import UnsupportedError

GLTF = format_for(Path("a.gltf"))
TEXELS = np.array([[[230, 110, 60], [90, 140, 200]], [[40, 180, 100], [150, 70, 240]]])


@pytest.fixture
def written(library, tmp_path):
    """Function that writes what was read and returns the asset's JSON, with what glTF cannot say."""

    def run(imported, name="out/model.gltf", **options):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        findings = GLTF.write(imported, path, library, options_for(GLTF, options))
        return open_container(path, Reach.beside(path)).data, findings

    return run


@pytest.fixture
def imported(make_document, tmp_path):
    """Function from the elements of a document, as text, to the document as if it lay in the test's folder."""

    def make(elements, attributes='colorspace="lin_rec709"'):
        document = make_document(elements, attributes=attributes)
        assert document.validate() == (True, "")
        return Document(materialx=document, path=tmp_path / "a.mtlx", reach=Reach.only(tmp_path))

    return make


def shown(surface: str, name: str = "s") -> str:
    """Elements with a material of this shader."""
    return (
        f'{surface}<surfacematerial name="m" type="material">'
        f'<input name="surfaceshader" type="surfaceshader" nodename="{name}"/></surfacematerial>'
    )


def model(inputs: str, more: str = "") -> str:
    return shown(f'{more}<gltf_pbr name="s" type="surfaceshader">{inputs}</gltf_pbr>')


def number(name: str, value: float) -> str:
    return f'<input name="{name}" type="float" value="{value}"/>'


def color(name: str, *value: float) -> str:
    return f'<input name="{name}" type="color3" value="{", ".join(map(str, value))}"/>'


def closure(nodes: str, top: str = "bsdf") -> str:
    return shown(
        f'{nodes}<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="{top}"/></surface>'
    )


def full_material() -> dict:
    """A material with every property that is read, and textures."""
    mask = {
        "index": 1,
        "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": 0.5, "scale": [2.0, -3.0]}},
    }
    return {
        "name": "full",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.6, 0.7, 0.8],
            "baseColorTexture": {"index": 0},
            "metallicFactor": 0.3,
            "roughnessFactor": 0.7,
            "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 1, "scale": 0.5},
        "occlusionTexture": {"index": 1, "strength": 0.25},
        "emissiveFactor": [0.1, 0.2, 0.3],
        "emissiveTexture": {"index": 0},
        "alphaMode": "MASK",
        "alphaCutoff": 0.4,
        "extensions": {
            "KHR_materials_anisotropy": {
                "anisotropyStrength": 0.5,
                "anisotropyRotation": 0.25,
                "anisotropyTexture": {"index": 1},
            },
            "KHR_materials_clearcoat": {
                "clearcoatFactor": 0.5,
                "clearcoatNormalTexture": {"index": 1},
                "clearcoatRoughnessFactor": 0.3,
                "clearcoatRoughnessTexture": {"index": 1},
                "clearcoatTexture": {"index": 1},
            },
            "KHR_materials_dispersion": {"dispersion": 0.1},
            "KHR_materials_emissive_strength": {"emissiveStrength": 2.0},
            "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_iridescence": {
                "iridescenceFactor": 0.5,
                "iridescenceIor": 1.5,
                "iridescenceTexture": {"index": 1},
                "iridescenceThicknessMaximum": 600.0,
                "iridescenceThicknessMinimum": 200.0,
                "iridescenceThicknessTexture": {"index": 1},
            },
            "KHR_materials_retroreflection": {"retroreflectionFactor": 0.7, "retroreflectionTexture": mask},
            "KHR_materials_sheen": {
                "sheenColorFactor": [0.2, 0.3, 0.4],
                "sheenColorTexture": {"index": 0},
                "sheenRoughnessFactor": 0.5,
                "sheenRoughnessTexture": {"index": 0},
            },
            "KHR_materials_specular": {
                "specularColorFactor": [4.0, 3.0, 2.0],
                "specularColorTexture": {"index": 0},
                "specularFactor": 0.75,
                "specularTexture": {"index": 0},
            },
            "KHR_materials_transmission": {
                "transmissionFactor": 0.3,
                "transmissionTexture": {"index": 1, "texCoord": 1},
            },
            "KHR_materials_volume": {
                "attenuationColor": [0.5, 0.6, 0.7],
                "attenuationDistance": 2.0,
                "thicknessFactor": 0.5,
                "thicknessTexture": {"index": 1},
            },
        },
    }


@pytest.fixture
def full(png, write_asset, tmp_path, rng):
    """An asset with that material, and a retroreflective one without textures."""
    png(tmp_path / "a.png", rng.integers(0, 256, (3, 4, 4)))
    png(tmp_path / "b.png", rng.integers(0, 256, (4, 3, 3)))
    samplers = [
        {"magFilter": 9728, "minFilter": 9728, "wrapS": 33071, "wrapT": 33648},
        {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497},
    ]
    return write_asset(
        materials=[
            full_material(),
            {
                "name": "plain",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.9, 0.8, 0.1, 1.0],
                    "metallicFactor": 1.0,
                    "roughnessFactor": 0.2,
                },
                "extensions": {"KHR_materials_retroreflection": {"retroreflectionFactor": 1.0}},
            },
        ],
        textures=[{"sampler": 0, "source": 0}, {"sampler": 1, "source": 1}],
        samplers=samplers,
        images=[{"uri": "a.png"}, {"uri": "b.png"}],
    )


@pytest.fixture(scope="module")
def ordered():
    """Function from an asset's JSON to its materials with textures in the place of indices, whose order is free."""

    def of(data):
        def info(index):
            texture = data["textures"][index]
            return {"sampler": data["samplers"][texture["sampler"]], "image": texture["source"]}

        def plain(value):
            if isinstance(value, dict):
                return {k: info(v) if k == "index" else plain(v) for k, v in value.items()}
            return [plain(v) for v in value] if isinstance(value, list) else value

        return plain(data["materials"])

    return of


def few(full) -> None:
    """Leave the factor and the texture of retroreflection, and little else."""
    data = json.loads(full.read_text())
    for material in data["materials"]:
        material["extensions"] = {key: value for key, value in material["extensions"].items() if "retro" in key}
        for name in ("normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor"):
            material.pop(name, None)
    full.write_text(json.dumps(data))


@pytest.mark.parametrize("name", ["out/few.gltf", "out/all.glb"])
def test_an_asset_comes_back_as_it_was(full, read, written, tmp_path, ordered, name):
    if "few" in name:
        few(full)
    imported = read(full)
    assert imported.findings == []
    data, findings = written(imported, name)
    assert findings == []
    assert ordered(data) == ordered(json.loads(full.read_text()))
    again = read(tmp_path / name)
    files = [e for e in again.materialx.traverseTree() if e.getName() == "file"]
    contents = {(again.reach.folder / e.getResolvedValueString()).read_bytes() for e in files}
    assert contents == {(tmp_path / "a.png").read_bytes(), (tmp_path / "b.png").read_bytes()}
    assert again.materialx.getMaterialNodes()[0].getName() == "full"
    if "all" in name:
        check_mesh(data, (tmp_path / name).read_bytes())


def test_two_runs_write_the_same_bytes_and_what_lies_beside_is_not_copied(full, library, read, tmp_path):
    few(full)
    imported = read(full)
    for name in ("one.glb", "two.glb", "one.gltf"):
        GLTF.write(imported, tmp_path / name, library)
    assert (tmp_path / "one.glb").read_bytes() == (tmp_path / "two.glb").read_bytes()
    text = (tmp_path / "one.gltf").read_text()
    assert [image["uri"] for image in json.loads(text)["images"]] == ["a.png", "b.png"]
    assert not (tmp_path / "one").exists()


def test_what_was_unpacked_is_copied_beside_the_asset(full, library, read, tmp_path):
    few(full)
    GLTF.write(read(full), tmp_path / "one.glb", library)
    unpacked = read(tmp_path / "one.glb")
    assert unpacked.reach.folder.is_relative_to(tmp_path)
    GLTF.write(unpacked, tmp_path / "again.gltf", library)
    images = json.loads((tmp_path / "again.gltf").read_text())["images"]
    assert len(images) == 2
    assert all((tmp_path / image["uri"]).parent == tmp_path / "again" for image in images)


def check_mesh(data, content) -> None:
    """That a .glb has spheres that a viewer shows, and says what it uses."""
    (length,) = struct.unpack_from("<I", content, 12)
    binary = content[20 + length + 8 :]

    def values(index):
        accessor = data["accessors"][index]
        view = data["bufferViews"][accessor["bufferView"]]
        kind, width = {5126: ("<f4", 4), 5123: ("<u2", 2)}[accessor["componentType"]]
        assert view["byteOffset"] % width == 0
        raw = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        found = np.frombuffer(raw, kind).reshape(accessor["count"], -1)
        return found.astype(float) if width == 4 else found[:, 0]

    primitive = data["meshes"][0]["primitives"][0]
    place, normal, tangent, uv = (
        values(primitive["attributes"][n]) for n in ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0")
    )
    triangles = values(primitive["indices"]).reshape(-1, 3)
    corners = place[triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.einsum("ij,ij->i", facing, corners.mean(axis=1)) > 0.0)  # anticlockwise from outside
    # float32: unit within its roundings.
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-6)
    np.testing.assert_allclose(np.einsum("ij,ij->i", normal, tangent[:, :3]), 0.0, atol=1e-6)
    bitangent = np.cross(normal, tangent[:, :3]) * tangent[:, 3:]
    inner = (uv[:, 1] > 0.01) & (uv[:, 1] < 0.99)
    assert np.all(bitangent[inner, 1] > 0.0)  # the image's upper edge is up
    assert place[np.argmin(uv[:, 1]), 1] == pytest.approx(1.0)
    assert {"TEXCOORD_0", "TEXCOORD_1"} <= primitive["attributes"].keys()  # a texture asks for the second set
    assert "TANGENT" not in data["meshes"][1]["primitives"][0]["attributes"]
    assert [node["mesh"] for node in data["nodes"]] == [0, 1]
    used = set(full_material()["extensions"]) | {"KHR_texture_transform"}
    assert data["extensionsUsed"] == sorted(used)
    assert "extensionsRequired" not in data
    for index, material in enumerate(data["materials"]):
        assert schema.problems("material", material, f"/materials/{index}") == []


PLACE = (
    '<place2d name="p" type="vector2"><input name="texcoord" type="vector2" nodename="uv"/>'
    '<input name="pivot" type="vector2" value="0.5, 0.5"/><input name="scale" type="vector2" value="0.5, 2"/>'
    '<input name="rotate" type="float" value="30"/><input name="offset" type="vector2" value="0.1, 0.2"/>'
    "{order}</place2d>"
    '<texcoord name="uv" type="vector2"/>'
)
IMAGE = '<{node} name="i" type="{kind}"><input name="file" type="filename" value="{file}"{space}/>{more}</{node}>'
SRGB = ' colorspace="srgb_texture"'


def image(kind="color3", file="a.png", space=SRGB, node="image", more="") -> str:
    return IMAGE.format(node=node, kind=kind, file=file, space=space, more=more)


def connected(name: str, kind: str, node: str = "i", output: str = "") -> str:
    return f'<input name="{name}" type="{kind}" nodename="{node}"{output}/>'


# Between texels, encoded values are blended and then decoded: another image is the same at its texels alone.
CLOSEST = '<input name="filtertype" type="string" value="closest"/>'
GREEN = '<input name="index" type="integer" value="1"/>'
REPEATED = (
    '<input name="uvtiling" type="vector2" value="3, 2"/><input name="uvoffset" type="vector2" value="0.2, 0.1"/>'
)
OF_Z = ' output="outz"'
CLAMPED = '<input name="uaddressmode" type="string" value="clamp"/><input name="offset" type="vector2" value="0.3, 0"/>'
COLORS = '<input name="color" type="color4" value="0.9, 0.8, 0.7, 0.6"/>'
AT_P = '<input name="texcoord" type="vector2" nodename="p"/>'
TEXTURED = {
    "an image as it stands": (image(), connected("base_color", "color3")),
    "an image of numbers as a colour": (image(space="", more=CLOSEST), connected("base_color", "color3")),
    "an image in another format": (image(file="a.tif"), connected("base_color", "color3")),
    "an encoded image as a number": (
        image(more=CLOSEST) + f'<extract name="r" type="float">{connected("in", "color3")}{GREEN}</extract>',
        connected("retroreflectivity", "float", "r"),
    ),
    "place2d": (PLACE.format(order="") + image(more=AT_P), connected("emissive", "color3")),
    "place2d in the other order": (
        PLACE.format(order='<input name="operationorder" type="integer" value="1"/>').replace('"0.5, 2"', '"2, 2"')
        + image(more=AT_P),
        connected("emissive", "color3"),
    ),
    "a tiled image": (image(node="tiledimage", more=REPEATED), connected("base_color", "color3")),
    "numbers of two images in one texture": (
        image("float", "b.png", "") + image("float", "a.png", "").replace('"i"', '"j"'),
        connected("metallic", "float") + connected("roughness", "float", "j"),
    ),
    "a scaled channel beside a constant": (
        image("vector3", "a.png", "")
        + f'<separate3 name="r" type="multioutput">{connected("in", "vector3")}</separate3>'
        + f'<multiply name="t" type="float">{connected("in1", "float", "r", OF_Z)}{number("in2", 0.5)}</multiply>',
        connected("roughness", "float", "t") + number("metallic", 0.25),
    ),
    "a channel where it belongs, beside a constant": (
        image("vector3", "a.png", "")
        + f'<separate3 name="r" type="multioutput">{connected("in", "vector3")}</separate3>',
        connected("roughness", "float", "r", ' output="outy"') + number("metallic", 0.25),
    ),
    "an image with a factor of its own": (
        image("float", "b.png", "", "gltf_image", number("factor", 0.5)),
        connected("clearcoat", "float"),
    ),
    "a colour image, which repeats whatever it says": (
        image("multioutput", "a.png", "", "gltf_colorimage", CLAMPED + COLORS + CLOSEST),
        connected("base_color", "color3", output=' output="outcolor"')
        + connected("alpha", "float", output=' output="outa"')
        + '<input name="alpha_mode" type="integer" value="2"/>',
    ),
    "a thickness between two": (
        image(
            "float",
            "b.png",
            "",
            "gltf_iridescence_thickness",
            number("thicknessMin", 200) + number("thicknessMax", 600),
        ),
        connected("iridescence_thickness", "float") + number("iridescence", 1.0),
    ),
    "a mixture by a mask": (
        image("float", "b.png", "")
        + f'<mix name="t" type="float">{number("bg", 0.0)}{number("fg", 0.8)}{connected("mix", "float")}</mix>',
        connected("retroreflectivity", "float", "t"),
    ),
    "a second use of texture coordinates": (
        '<texcoord name="p" type="vector2"><input name="index" type="integer" value="2"/></texcoord>'
        + image("float", "b.png", "", more=AT_P),
        connected("clearcoat", "float"),
    ),
}


@pytest.fixture
def images(png, tmp_path):
    """Two images of one size in the test's folder, one of them also as TIFF."""
    png(tmp_path / "a.png", TEXELS)
    png(tmp_path / "a.tif", TEXELS)
    png(tmp_path / "b.png", TEXELS[::-1, :, :1])


@pytest.mark.parametrize("name", TEXTURED)
def test_a_pattern_that_gltf_can_say_is_written_without_loss(images, imported, written, name):
    nodes, inputs = TEXTURED[name]
    data, findings = written(imported(model(inputs + number("roughness", 0.5) * ('"roughness"' not in inputs), nodes)))
    assert findings == []
    assert len(data["textures"]) == 1


GRAPH = (
    '<nodegraph name="g"><input name="f" type="filename" value="a.png"/><gltf_normalmap name="n" type="vector3">'
    '<input name="file" type="filename" interfacename="f"/></gltf_normalmap>'
    '<output name="o" type="vector3" nodename="n"/></nodegraph>'
)
OF_GRAPH = '<input name="normal" type="vector3" nodegraph="g" output="o"/>'


def test_a_normal_map_in_a_graph_with_an_interface_is_written(images, imported, written):
    data, findings = written(imported(model(number("roughness", 0.5) + OF_GRAPH, GRAPH)))
    assert findings == []
    assert data["materials"][0]["normalTexture"] == {"index": 0}


# A graph whose one number comes through its interface, {given} there.
THROUGH = (
    '<nodegraph name="g"><input name="f" {given}/><multiply name="t" type="float">'
    '<input name="in1" type="float" interfacename="f"/><input name="in2" type="float" value="1"/></multiply>'
    '<output name="o" type="float" nodename="t"/></nodegraph>'
)
INTERFACES = {
    "a node": ('<constant name="c" type="float"><input name="value" type="float" value="0.75"/></constant>', 0.75),
    "one of several outputs": (
        '<separate2 name="c" type="multioutput"><input name="in" type="vector2" value="0.1, 0.75"/></separate2>', 0.75,
    ),
    "a number": ("", 0.75),
    "nothing": ("", 0.0),
}  # fmt: skip


@pytest.mark.parametrize("name", INTERFACES)
def test_what_an_interface_is_connected_to_is_written(imported, written, name):
    nodes, roughness = INTERFACES[name]
    given = {"a number": 'value="0.75"', "nothing": ""}.get(name, 'nodename="c"')
    given += ' output="outy"' if "several" in name else ""
    graph = THROUGH.format(given=f'type="float" {given}')
    of_graph = '<input name="roughness" type="float" nodegraph="g" output="o"/>'
    source = imported(model(of_graph + number("metallic", 1.0), nodes + graph))
    data, findings = written(source)
    assert findings == []
    assert data["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] == roughness


@pytest.mark.parametrize(("outer", "inner"), [(SRGB, ""), ("", SRGB), (SRGB, ' colorspace="lin_rec709"')])
def test_an_image_through_an_interface_has_the_colour_space_that_is_said_there_or_where_it_is_read(
    images, imported, written, tmp_path, surface_of, points, emitted, read, outer, inner
):
    graph = (
        f'<nodegraph name="g"><input name="f" type="filename" value="a.png"{outer}/>'
        f'<image name="n" type="color3"><input name="file" type="filename" interfacename="f"{inner}/>{CLOSEST}</image>'
        '<output name="o" type="color3" nodename="n"/></nodegraph>'
    )
    source = imported(model('<input name="emissive" type="color3" nodegraph="g" output="o"/>', graph))
    _, findings = written(source)
    assert findings == []
    at = points([[0.25, 0.25], [0.75, 0.75]])
    before = emitted(surface_of(source), at)
    # What is not sRGB is written in 16 bits.
    np.testing.assert_allclose(emitted(surface_of(read(tmp_path / "out/model.gltf")), at), before, rtol=1e-3)


@pytest.mark.parametrize(
    ("outer", "inner", "is_encoded"),
    [("", "", False), ("", SRGB, True), (SRGB, "", True), (' colorspace="lin_rec709"', SRGB, False)],
)
def test_a_colour_through_an_interface_is_in_the_space_that_is_said_there_or_where_it_is_read(
    imported, written, tmp_path, surface_of, points, emitted, read, outer, inner, is_encoded
):
    graph = (
        f'<nodegraph name="g"><input name="f" type="color3" value="0.5, 0.25, 0.75"{outer}/>'
        f'<constant name="n" type="color3"><input name="value" type="color3" interfacename="f"{inner}/></constant>'
        '<output name="o" type="color3" nodename="n"/></nodegraph>'
    )
    source = imported(model('<input name="emissive" type="color3" nodegraph="g" output="o"/>', graph))
    data, findings = written(source)
    assert findings == []
    assert (data["materials"][0]["emissiveFactor"] == [0.5, 0.25, 0.75]) != is_encoded
    at = points([[0.5, 0.5]])
    again = read(tmp_path / "out/model.gltf")
    # A document's numbers are float32: half a unit in the last place.
    np.testing.assert_allclose(emitted(surface_of(again), at), emitted(surface_of(source), at), rtol=2.0**-24)


def test_a_graph_that_uses_each_node_many_times_is_followed_once_per_node(images, imported, written):
    nodes = image("color3", "a.png", "").replace('"i"', '"c0"')
    for k in range(14):  # five million ways through it
        parts = "".join(
            f'<extract name="e{k}{c}" type="float">{connected("in", "color3", f"c{k}")}'
            f'<input name="index" type="integer" value="{c}"/></extract>'
            for c in range(3)
        )
        joined = "".join(connected(f"in{c + 1}", "float", f"e{k}{c}") for c in range(3))
        nodes += f'{parts}<combine3 name="c{k + 1}" type="color3">{joined}</combine3>'
    data, _ = written(imported(model(connected("emissive", "color3", "c14"), nodes)))
    assert len(data["textures"]) == 1


COLORED = connected("base_color", "color3") + number("specular_roughness", 0.3)
MODELS = {
    "standard_surface": COLORED + number("retroreflectivity", 0.5),
    "open_pbr_surface": COLORED + number("specular_retroreflectivity", 0.5),
}


@pytest.mark.parametrize("name", MODELS)
def test_other_surface_models_are_translated_with_their_retroreflectivity_and_what_differs_is_said(
    images, imported, written, name
):
    nodes = image() + f'<{name} name="s" type="surfaceshader">{MODELS[name]}</{name}>'
    data, (finding,) = written(imported(shown(nodes)))
    assert "differ by up to" in finding.message
    (mean,) = re.findall(r"([\d.]+) % in the mean", finding.message)
    assert float(mean) < 5.0  # another diffuse and another Fresnel term
    (material,) = data["materials"]
    assert material["pbrMetallicRoughness"] == {
        "baseColorTexture": {"index": 0},
        "baseColorFactor": [1.0, 1.0, 1.0, 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": 0.3,
    }
    assert material["extensions"]["KHR_materials_retroreflection"] == {"retroreflectionFactor": 0.5}
    assert "KHR_materials_volume" not in material["extensions"]  # it transmits nothing


def test_the_normals_of_another_surface_model_are_written(images, imported, written):
    normals = "".join(f'<input name="{name}" type="vector3" nodename="n"/>' for name in ("normal", "coat_normal"))
    nodes = (
        image("vector3", "a.png", "") + f'<normalmap name="n" type="vector3">{connected("in", "vector3")}</normalmap>'
    )
    inputs = normals + number("coat", 0.5)
    data, _ = written(
        imported(shown(f'{nodes}<standard_surface name="s" type="surfaceshader">{inputs}</standard_surface>'))
    )
    (material,) = data["materials"]
    assert material["normalTexture"] == {"index": 0}
    assert material["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"] == {"index": 0}


def test_a_surface_model_without_a_translation_is_left_out_where_the_nearest_is_not_wanted(imported, written):
    source = imported(shown('<disney_principled name="s" type="surfaceshader"/>'))
    _, (finding,) = written(source)
    assert finding.code == "INTERCHANGE_APPROXIMATED"
    with pytest.raises(NothingToWriteError) as caught:
        written(source, exact=True)
    assert "disney_principled is another surface model" in caught.value.findings[0].message


LOST = {
    "sheared coordinates": (
        PLACE.format(order='<input name="operationorder" type="integer" value="1"/>') + image(more=AT_P),
        connected("base_color", "color3"),
        "/m/base_color",
        "sheared",
    ),
    "a border": (
        image(more='<input name="uaddressmode" type="string" value="constant"/>'),
        connected("base_color", "color3"),
        "/m/base_color",
        "border",
    ),
    "noise": (
        '<noise2d name="i" type="float"/>',
        connected("metallic", "float"),
        "/m/metallic",
        "noise2d, which has no form",
    ),
    "a sum": (
        image("float", "b.png", "")
        + f'<add name="t" type="float">{connected("in1", "float")}{number("in2", 0.1)}</add>',
        connected("clearcoat", "float", "t"),
        "/m/clearcoat",
        "a number is added",
    ),
    "a product of images": (
        image("float", "b.png", "")
        + f'<multiply name="t" type="float">{connected("in1", "float")}{connected("in2", "float")}</multiply>',
        connected("clearcoat", "float", "t"),
        "/m/clearcoat",
        "multiplies images",
    ),
    "a missing image": (
        image(file="none.png"),
        connected("base_color", "color3"),
        "/m/base_color",
        "none.png cannot be read",
    ),
    "another colour space": (
        image(space=' colorspace="acescg"'),
        connected("base_color", "color3"),
        "/m/base_color",
        "acescg",
    ),
    "two places in one texture": (
        PLACE.format(order="")
        + image("float", "b.png", "")
        + image("float", "a.png", "", more=AT_P).replace('"i"', '"j"'),
        connected("metallic", "float") + connected("roughness", "float", "j"),
        "/m/roughness",
        "another place",
    ),
    "an occlusion that is scaled": (
        image("float", "b.png", "")
        + f'<multiply name="t" type="float">{connected("in1", "float")}{number("in2", 0.5)}</multiply>',
        connected("occlusion", "float", "t"),
        "/m/occlusion",
        "1 + strength",
    ),
    "a constant occlusion": ("", number("occlusion", 0.5), "/m/occlusion", "1 + strength"),
    "a colour beyond one": ("", color("base_color", 1.5, 0.5, 0.5), "/m/base_color", "at most 1, got 1.5"),
    "a varying index": (
        image("float", "b.png", ""),
        connected("alpha_cutoff", "float"),
        "/m/alpha_cutoff",
        "one number",
    ),
}


@pytest.mark.parametrize("name", LOST)
def test_what_gltf_cannot_say_is_said_and_the_rest_is_written(images, imported, written, name):
    nodes, inputs, place, words = LOST[name]
    data, findings = written(imported(model(inputs + number("thickness", 0.5), nodes)))
    first = findings[0]
    assert (first.code, first.location) == ("INTERCHANGE_LOST", place)
    assert words in first.message
    assert data["materials"][0]["extensions"]["KHR_materials_volume"] == {"thicknessFactor": 0.5}


def test_what_is_seen_through_a_material_is_compared(imported, written):
    inputs = number("transmission", 1.0) + number("metallic", 0.0) + connected("base_color", "color3")
    _, findings = written(imported(model(inputs, '<noise2d name="i" type="color3"/>')))
    lost, below, apart = (finding.message for finding in findings)
    assert "noise2d, which has no form" in lost
    assert "expected at least 0" in below  # the mean of this noise, in one channel
    assert "its values differ by up to" in apart  # the base colour shows in what is transmitted alone


def test_a_material_that_the_reference_does_not_know_is_written_and_said_not_to_be_compared(
    imported, written, monkeypatch
):
    def unknown(*_, **__):
        raise UnsupportedError(["ND_thing"])

    monkeypatch.setattr(comparison, "difference", unknown)
    _, findings = written(imported(model(number("roughness", 0.5))))
    assert [r.message for r in findings] == ["it was written and not compared: the reference does not know ND_thing"]


def test_an_image_of_more_pixels_than_are_looked_into_is_said(images, imported, written, monkeypatch):
    monkeypatch.setattr(texture_slots, "MAXIMUM_PIXELS", 3)
    nodes, inputs = image("float", "b.png", ""), connected("metallic", "float")
    _, findings = written(imported(model(inputs, nodes)))
    assert (findings[0].code, findings[0].location) == ("INTERCHANGE_LOST", "/m/metallic")
    assert "b.png has" in findings[0].message
    assert "more than are converted" in findings[0].message


@pytest.mark.parametrize(("number_of", "mode"), [(0, None), (1, "MASK"), (2, "BLEND"), (7, "BLEND"), (-1, "BLEND")])
def test_an_alpha_mode_is_what_the_graph_of_gltf_pbr_makes_of_its_number(imported, written, number_of, mode):
    given = f'<input name="alpha_mode" type="integer" value="{number_of}"/>' + number("alpha", 0.25)
    data, findings = written(imported(model(given + number("alpha_cutoff", 0.5))))
    assert data["materials"][0].get("alphaMode") == mode
    assert findings == []


HUGE = color("emissive", 3e38, 1, 1) + number("emissive_strength", 1e10)
DIVIDED = f'<divide name="d" type="float">{number("in1", 0.5)}{number("in2", 0.0)}</divide>'


@pytest.mark.parametrize("parts", [(HUGE,), (connected("roughness", "float", "d"), DIVIDED)], ids=["huge", "infinite"])
def test_a_number_that_is_not_finite_leaves_the_material_out(imported, written, tmp_path, parts):
    with pytest.raises(NothingToWriteError) as caught:
        written(imported(model(*parts)))
    assert "one of its numbers is inf" in caught.value.findings[0].message
    assert list((tmp_path / "out").iterdir()) == []


def test_a_made_image_of_a_material_with_a_long_name_has_a_shorter_one(images, imported, written):
    nodes, inputs = TEXTURED["numbers of two images in one texture"]
    elements = model(inputs, nodes).replace('name="m"', f'name="{"m" * 500}"')
    data, findings = written(imported(elements))
    assert findings == []
    assert data["images"][0]["name"] == "m" * 100 + "_metallicRoughnessTexture.png"


def test_emission_beyond_one_is_a_matter_of_its_strength(imported, written):
    data, findings = written(imported(model(color("emissive", 4.0, 2.0, 1.0) + number("emissive_strength", 3.0))))
    assert findings == []
    assert data["materials"][0]["emissiveFactor"] == [1.0, 0.5, 0.25]
    assert data["materials"][0]["extensions"]["KHR_materials_emissive_strength"] == {"emissiveStrength": 12.0}


WIDTH = '<input name="roughness" type="vector2" value="0.09, 0.09"/>'
FLAG = '<input name="retroreflective" type="boolean" value="true"/>'


def bsdf(kind: str, name: str, inputs: str) -> str:
    return f'<{kind} name="{name}" type="BSDF">{inputs}</{kind}>'


def layer(name: str, top: str, base: str) -> str:
    return bsdf("layer", name, connected("top", "BSDF", top) + connected("base", "BSDF", base))


def mixture(name: str, low: str, high: str, share: float) -> str:
    return bsdf("mix", name, connected("bg", "BSDF", low) + connected("fg", "BSDF", high) + number("mix", share))


METAL = color("color0", 0.9, 0.7, 0.3) + color("color90", 1, 1, 1) + WIDTH
BEADS = color("color0", 0.2, 0.1, 0.1) + color("color90", 0.5, 0.5, 0.5) + WIDTH
PAINT = bsdf("oren_nayar_diffuse_bsdf", "paint", color("color", 0.6, 0.5, 0.1))
EXACT = {
    "a retroreflective metal": (
        bsdf("generalized_schlick_bsdf", "bsdf", METAL + FLAG),
        {"metallicFactor": 1.0, "roughnessFactor": 0.3, "retroreflectionFactor": 1.0},
    ),
    "a partly retroreflective metal": (
        bsdf("mrm_generalized_schlick_bsdf", "bsdf", METAL + number("retroreflectivity", 0.25)),
        {"retroreflectionFactor": 0.25, "metallicFactor": 1.0},
    ),
    "paint": (PAINT.replace('"paint"', '"bsdf"'), {"metallicFactor": 0.0, "specularFactor": 0.0}),
    "beads over paint": (
        PAINT + bsdf("generalized_schlick_bsdf", "beads", BEADS + FLAG) + layer("bsdf", "beads", "paint"),
        {"retroreflectionFactor": 1.0, "metallicFactor": 0.0, "specularFactor": 0.5, "roughnessFactor": 0.3},
    ),
    "a film over beads over paint": (
        PAINT
        + bsdf("generalized_schlick_bsdf", "beads", BEADS + FLAG)
        + layer("under", "beads", "paint")
        + bsdf("dielectric_bsdf", "film", number("ior", 1.5) + number("weight", 0.5) + WIDTH)
        + layer("bsdf", "film", "under"),
        {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.3, "retroreflectionFactor": 1.0},
    ),
    "twins": (
        bsdf("generalized_schlick_bsdf", "a", METAL)
        + bsdf("generalized_schlick_bsdf", "b", METAL + FLAG)
        + mixture("bsdf", "a", "b", 0.75),
        {"retroreflectionFactor": 0.75},
    ),
    "twins over paint": (
        PAINT
        + bsdf("generalized_schlick_bsdf", "a", BEADS)
        + bsdf("generalized_schlick_bsdf", "b", BEADS + FLAG)
        + mixture("top", "a", "b", 0.5)
        + layer("bsdf", "top", "paint"),
        {"retroreflectionFactor": 0.5, "metallicFactor": 0.0},
    ),
    "sheen over metal": (
        bsdf("generalized_schlick_bsdf", "metal", METAL)
        + bsdf("sheen_bsdf", "cloth", color("color", 0.4, 0.2, 0.1) + number("roughness", 0.25) + number("weight", 0.5))
        + layer("bsdf", "cloth", "metal"),
        {"sheenRoughnessFactor": 0.5, "sheenColorFactor": [0.2, 0.1, 0.05]},
    ),
}


def numbers_of(material: dict) -> dict:
    """All factors of a material, by their names alone."""
    found = {}
    for name, value in material.items():
        found |= numbers_of(value) if isinstance(value, dict) else {name: value}
    return found


@pytest.mark.parametrize("name", EXACT)
def test_surfaces_of_closures_that_gltf_has_are_written_exactly(imported, written, name):
    nodes, expected = EXACT[name]
    data, findings = written(imported(closure(nodes)))
    # Sheen of a colour is not a colour of sheen: gltf_pbr's weight is the largest component.
    assert [r.message for r in findings] == ([] if name != "sheen over metal" else [findings[0].message])
    numbers = numbers_of(data["materials"][0])
    assert {key: numbers[key] for key in expected} == expected


def test_a_complex_index_is_an_approximation_and_its_error_is_said(imported, written):
    gold = (
        '<input name="ior" type="color3" value="0.18, 0.42, 1.37"/>'
        '<input name="extinction" type="color3" value="3.42, 2.35, 1.77"/>'
    )
    data, findings = written(imported(closure(bsdf("conductor_bsdf", "bsdf", gold + WIDTH + FLAG))))
    (finding,) = findings
    assert finding.code == "INTERCHANGE_LOST"
    assert "differ by up to" in finding.message
    # Fresnel at normal incidence of red, ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2): 12.3688 / 13.0888.
    assert data["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0] == pytest.approx(0.944985, rel=1e-5)


IMPOSSIBLE = {
    "translucent_bsdf": (bsdf("translucent_bsdf", "bsdf", ""), "translucent_bsdf has no form"),
    "anisotropic": (bsdf("conductor_bsdf", "bsdf", WIDTH.replace("0.09, 0.09", "0.1, 0.2")), "anisotropic"),
    "retroreflective film": (
        bsdf("generalized_schlick_bsdf", "metal", METAL)
        + bsdf("dielectric_bsdf", "film", number("ior", 1.5) + FLAG + WIDTH)
        + layer("bsdf", "film", "metal"),
        "clear coat is ordinary",
    ),
    "coat under sheen under coat": (
        PAINT
        + bsdf("generalized_schlick_bsdf", "beads", BEADS)
        + bsdf("dielectric_bsdf", "film", number("ior", 1.5) + WIDTH)
        + layer("one", "beads", "paint")
        + layer("two", "film", "one")
        + layer("bsdf", "film", "two"),
        "no clearcoat over clearcoat",
    ),
    "different sides": (
        bsdf("generalized_schlick_bsdf", "a", METAL)
        + bsdf("generalized_schlick_bsdf", "b", METAL.replace("0.09", "0.04") + FLAG)
        + mixture("bsdf", "a", "b", 0.5),
        "differ in retroreflectivity, roughness",
    ),
    "transmission": (
        bsdf("dielectric_bsdf", "top", '<input name="scatter_mode" type="string" value="RT"/>')
        + PAINT
        + layer("bsdf", "top", "paint"),
        "scatter_mode RT",
    ),
}


# Light that comes through, which nothing that glTF's base has comes near to.
LIGHT_THROUGH = ("translucent_bsdf", "transmission")


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_material_without_a_form_is_left_out_where_the_nearest_is_not_wanted(imported, written, tmp_path, name):
    nodes, words = IMPOSSIBLE[name]
    with pytest.raises(NothingToWriteError) as caught:
        written(imported(closure(nodes)), exact=True)
    (finding,) = caught.value.findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LEFT_OUT", "/m")
    assert words in finding.message
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.parametrize("name", LIGHT_THROUGH)
def test_a_material_that_lets_light_through_is_left_out_and_nothing_is_written(imported, written, tmp_path, name):
    nodes, words = IMPOSSIBLE[name]
    with pytest.raises(NothingToWriteError) as caught:
        written(imported(closure(nodes)))
    (finding,) = caught.value.findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LEFT_OUT", "/m")
    assert words in finding.message
    assert "it lets light through" in finding.message
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.parametrize("name", sorted(IMPOSSIBLE.keys() - LIGHT_THROUGH))
def test_the_nearest_is_written_for_a_material_without_a_form_and_its_error_is_said(imported, written, name):
    nodes, words = IMPOSSIBLE[name]
    data, (finding,) = written(imported(closure(nodes)))
    assert (finding.code, finding.location) == ("INTERCHANGE_APPROXIMATED", "/m")
    assert words in finding.message
    (mean,) = re.findall(r"([\d.]+) % in the mean", finding.message)
    assert 0.01 < float(mean) < 50.0  # an anisotropic lobe by one that is round is the farthest
    is_retroreflective = "KHR_materials_retroreflection" in data["materials"][0].get("extensions", {})
    assert is_retroreflective == ("retroreflective" in nodes)


def test_of_two_materials_the_one_that_has_a_form_is_written(imported, written):
    other = model(number("metallic", 1.0)).replace('"s"', '"t"').replace('"m"', '"good"')
    data, findings = written(imported(closure(bsdf("translucent_bsdf", "bsdf", "")) + other))
    assert [material["name"] for material in data["materials"]] == ["good"]
    assert [finding.code for finding in findings] == ["INTERCHANGE_LEFT_OUT"]


@pytest.mark.parametrize("wrong", ["reflectance", "channel"])
def test_a_wrong_mapping_is_seen_by_its_values(monkeypatch, images, imported, written, wrong):
    # 1 percent of the reflectance, and the neighbouring channel.
    monkeypatch.setattr(bsdf_surfaces, "_REFLECTANCE", 0.0404)
    nodes, inputs = TEXTURED["an encoded image as a number"]
    if wrong == "channel":
        composed = "mrm_mtlx.formats.gltf.exporter.texture_slots._composed"
        monkeypatch.setattr(composed, lambda _, loaded: next(iter(loaded.values()))[..., :3])
        _, findings = written(imported(model(inputs + number("roughness", 0.5), nodes)))
    else:
        _, findings = written(imported(closure(EXACT["beads over paint"][0])))
    (finding,) = findings
    assert "its values differ by up to" in finding.message


def test_values_that_are_equal_are_not_apart_and_others_are(make_document):
    documents = [make_document(model(number("roughness", r) + number("metallic", 1.0))) for r in (0.5, 0.5, 0.5001)]
    one, same, other = ((d.getNode("m"), lambda _name: None) for d in documents)
    assert comparison.difference(one, same) == (0.0, 0.0)
    largest, mean = comparison.difference(one, other)
    assert comparison.ROUNDING < mean < largest < 0.01
