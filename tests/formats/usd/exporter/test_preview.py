"""The look for hosts without MaterialX: its prims, what USD and Blender make of it, and that readers pass over it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdShade, UsdValidation

from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines.osl.process import RUNTIME
from mrm_mtlx.formats.pbr import comparison, daylight
from mrm_mtlx.formats.pbr.placement import Placement
from mrm_mtlx.formats.registry import format_for
from mrm_mtlx.formats.usd.exporter import preview
from mrm_mtlx.formats.usd.importer.validators import NOISE
from mrm_mtlx.formats.usd.options import UsdOptions

REPOSITORY = Path(__file__).parents[4]
PROGRAM = REPOSITORY / "tests/formats/usd/blender_import_program.py"
COLLAR = REPOSITORY / "materials" / "traffic_cone_collar.mtlx"
# An image that is placed and scaled, a normal map, and a node that has the name of the look's.
TEXTURED = """<materialx version="1.39" colorspace="lin_rec709">
<texcoord name="uv" type="vector2" />
<place2d name="p" type="vector2"><input name="texcoord" type="vector2" nodename="uv" />
  <input name="scale" type="vector2" value="0.5, 0.25" /><input name="rotate" type="float" value="30" />
  <input name="offset" type="vector2" value="0.1, 0.2" /></place2d>
<image name="preview" type="color3"><input name="file" type="filename" value="a.png" colorspace="srgb_texture" />
  <input name="texcoord" type="vector2" nodename="p" /><input name="vaddressmode" type="string" value="clamp" /></image>
<image name="n" type="vector3"><input name="file" type="filename" value="a.png" /></image>
<normalmap name="bumps" type="vector3"><input name="in" type="vector3" nodename="n" /></normalmap>
<extract name="green" type="float"><input name="in" type="vector3" nodename="n" />
  <input name="index" type="integer" value="1" /></extract>
<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="preview" />
  <input name="metallic" type="float" value="0" /><input name="roughness" type="float" nodename="green" />
  <input name="normal" type="vector3" nodename="bumps" /></gltf_pbr>
<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />
</surfacematerial></materialx>"""


@pytest.fixture
def textured(tmp_path, write_image):
    """The file of a document with all of that."""
    write_image(tmp_path / "a.png", np.arange(40, 88, dtype=np.uint8).reshape(4, 4, 3) * np.uint8(2))
    path = tmp_path / "textured.mtlx"
    path.write_text(TEXTURED, encoding="utf-8")
    return path


@pytest.fixture
def looked(library, tmp_path, imported):
    """Function from a document's file to a stage with looks, and the findings."""

    def run(path, name="look.usda"):
        target = tmp_path / name
        return target, format_for(target).write(imported(path), target, library)

    return run


def shader(stage, name):
    """The values and sources of a shader's inputs in the first material, and its id."""
    (material,) = (prim for prim in stage.Traverse() if prim.IsA(UsdShade.Material))
    found = UsdShade.Shader(material.GetChild(name))
    given = {}
    for each in found.GetInputs():
        sources = UsdShade.Utils.GetValueProducingAttributes(each)
        is_connected = each.HasConnectedSource()
        given[each.GetBaseName()] = (
            f"{sources[0].GetPrim().GetName()}.{sources[0].GetBaseName()}" if is_connected else each.Get()
        )
    return found.GetIdAttr().Get(), given


def test_numbers_stand_at_the_surface(looked):
    path, _ = looked(COLLAR)
    stage = Usd.Stage.Open(str(path))
    identifier, given = shader(stage, "preview")
    assert identifier == "UsdPreviewSurface"
    assert given["metallic"] == 0.0
    assert tuple(given["diffuseColor"]) == pytest.approx((0.505, 0.505, 0.497), abs=6e-4)  # three digits of four
    material = UsdShade.Material(stage.GetPrimAtPath("/Materials/M_traffic_cone_collar"))
    universal, _, _ = material.ComputeSurfaceSource()
    ours, _, _ = material.ComputeSurfaceSource("mtlx")
    assert (universal.GetPrim().GetName(), ours.GetPrim().GetName()) == ("preview", "SR_traffic_cone_collar")


def test_images_are_read_at_their_place_in_their_space_and_with_their_factors(looked, textured):
    path, _ = looked(textured)
    stage = Usd.Stage.Open(str(path))
    identifier, given = shader(stage, "preview_")  # the document has a node of that name
    assert identifier == "UsdPreviewSurface"
    assert (given["diffuseColor"], given["roughness"], given["normal"]) == (
        "preview_diffuseColor.rgb", "preview_roughness.g", "preview_normal.rgb",
    )  # fmt: skip
    identifier, color = shader(stage, "preview_diffuseColor")
    assert identifier == "UsdUVTexture"
    assert (color["file"].path, color["sourceColorSpace"]) == ("./a.png", "sRGB")
    assert (color["wrapS"], color["wrapT"]) == ("repeat", "clamp")
    identifier, place = shader(stage, "preview_diffuseColor_place")
    assert (identifier, place["in"]) == ("UsdTransform2d", "preview_st.result")
    _, normal = shader(stage, "preview_normal")
    assert normal["sourceColorSpace"] == "raw"
    assert tuple(normal["scale"])[:3] == (2.0, 2.0, 2.0)
    assert tuple(normal["bias"])[:3] == (-1.0, -1.0, -1.0)
    assert shader(stage, "preview_st") == ("UsdPrimvarReader_float2", {"varname": "st"})


def test_a_place_is_scaled_then_turned_then_moved(rng):
    """UsdTransform2d: in * scale, turned counter-clockwise by degrees, plus translation (UsdPreviewSurface 2.6)."""
    for _ in range(10):
        turn, (wide, high), moved = rng.uniform(-np.pi, np.pi), rng.uniform(0.2, 3.0, 2), rng.normal(size=2)
        linear = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ np.diag([wide, high])
        written = {name: value for name, _, value in preview._transform(Placement(*_rows(linear, moved)))}
        back = np.deg2rad(written["rotation"])
        turned = np.array([[np.cos(back), -np.sin(back)], [np.sin(back), np.cos(back)]]) @ np.diag(written["scale"])
        # Numbers of a stage are float32, of up to 3.
        np.testing.assert_allclose(turned, linear, atol=1e-5)
        np.testing.assert_allclose(written["translation"], moved, rtol=1e-6)


def _rows(linear, moved):
    return [float(x) for row, by in zip(linear, moved, strict=True) for x in (*row, by)]


@pytest.mark.parametrize("name", ["look.usda", "look.usdc", "look.usdz"])
def test_usds_checkers_have_nothing_to_say(looked, textured, stage_of, name):
    path, _ = looked(textured, name)
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    # What a USD without UsdMtlx says of every node of MaterialX, see `importer.validators`.
    told = [error.GetMessage() for error in errors if error.GetIdentifier() != NOISE]
    assert told == []
    assert stage_of(path).findings == []


@pytest.mark.parametrize("name", ["traffic_cone_collar", "embossed_foil"])
def test_readers_of_materialx_pass_over_it(imported, round_trip, shades, rng, name):
    source = imported(REPOSITORY / "materials" / f"{name}.mtlx")
    before = shades(source, rng)
    for network_alone in (True, False):
        after = shades(round_trip(source, network_alone=network_alone), rng)
        assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))  # to the last bit


def test_a_stage_with_nothing_but_such_a_look_has_no_material_of_materialx(looked, stage_of):
    path, _ = looked(COLLAR)
    layer = Sdf.Layer.FindOrOpen(str(path))
    material = layer.GetPrimAtPath("/Materials/M_traffic_cone_collar")
    assert stage_of(path).materialx.getMaterialNodes()
    del material.properties["outputs:mtlx:surface"]
    layer.Save()
    assert not stage_of(path).materialx.getMaterialNodes()


def test_what_the_look_lacks_is_measured_and_told(looked):
    _, (finding,) = looked(COLLAR)
    assert (finding.code, finding.location) == ("INTERCHANGE_PREVIEW", "/M_traffic_cone_collar")
    assert "by day (45:0) it reflects 0.484 instead of 0.484 of the light" in finding.message
    assert "its R_A (0.2, -4 degrees) is 0.232 instead of 261 cd/lx/m2" in finding.message


def test_a_look_of_a_wrong_colour_is_told_by_its_numbers(looked, monkeypatch):
    """A planted error: the colour of the base in the place of that which is seen through the film."""
    monkeypatch.setattr(daylight, "_calibrated", lambda *args: args[-1]["diffuseColor"])
    _, (finding,) = looked(COLLAR)
    assert "by day (45:0) it reflects 0.575 instead of 0.484 of the light" in finding.message


def test_a_difference_that_is_not_measured_is_told_nowhere(looked, monkeypatch):
    """That the words come from the measurement: without it, as where losses were under-reported, there are none."""
    monkeypatch.setattr(comparison, "difference", lambda *_: (0.0, 0.0))
    assert looked(COLLAR)[1] == []


def test_a_material_that_nothing_comes_near_to_gets_none_and_that_is_said(looked, tmp_path):
    path = tmp_path / "through.mtlx"
    path.write_text(
        '<materialx version="1.39"><translucent_bsdf name="b" type="BSDF" /><surface name="s" type="surfaceshader">'
        '<input name="bsdf" type="BSDF" nodename="b" /></surface><surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s" /></surfacematerial></materialx>'
    )
    stage, (finding,) = looked(path)
    assert (finding.code, finding.location) == ("INTERCHANGE_PREVIEW", "/m")
    assert "it gets no look for hosts without MaterialX" in finding.message
    assert "UsdPreviewSurface" not in stage.read_text(encoding="utf-8")


def test_the_same_document_gives_the_same_bytes_and_none_where_it_is_not_wanted(looked, imported, library, tmp_path):
    first, second = (looked(COLLAR, name)[0].read_bytes() for name in ("one.usda", "two.usda"))
    assert first == second
    bare = tmp_path / "bare.usda"
    assert format_for(bare).write(imported(COLLAR), bare, library, UsdOptions(preview=False)) == []
    assert "UsdPreviewSurface" not in bare.read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def in_blender(cycles):
    """Function from a stage and an image to be written to what Blender makes of the first material."""

    def run(stage, picture):
        command = [RUNTIME.interpreter() or sys.executable, str(PROGRAM), str(stage), str(picture)]
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        return json.loads(done.stdout.splitlines()[-1])

    return run


# Relative: Blender's Principled node has an account of its own of the lobe over the diffuse base. In Blender 4.5, 5.0,
# 5.1 and 5.3 it comes to 0.3 %.
BLENDERS_OWN = 0.01


def test_blender_shows_the_daytime_material(looked, in_blender, tmp_path):
    """In Blender, the values arrive, and the picture is as bright as the material by day: 0.484 of a white diffuser."""
    stage, _ = looked(COLLAR)
    values = in_blender(stage, tmp_path / "picture.exr")
    assert values["Base Color"] == pytest.approx([0.505, 0.505, 0.497, 1.0], abs=6e-4)
    assert values["Roughness"] == pytest.approx(np.sqrt(0.03), rel=1e-6)  # float32
    assert (values["Metallic"], values["Coat Weight"], values["Alpha"]) == (0.0, 0.0, 1.0)
    assert 1.4 < values["IOR"] < 1.6
    radiance = read_image(tmp_path / "picture.exr")[..., :3].mean(axis=(0, 1))
    np.testing.assert_allclose(radiance, np.array([0.484, 0.484, 0.476]) * np.sqrt(0.5) / np.pi, rtol=BLENDERS_OWN)


def test_blender_shows_nothing_of_a_stage_without_a_look(imported, library, in_blender, tmp_path):
    """That the picture comes from the look: without one, Blender has a material of its own default grey, 0.8."""
    bare = tmp_path / "bare.usda"
    format_for(bare).write(imported(COLLAR), bare, library, UsdOptions(preview=False))
    values = in_blender(bare, tmp_path / "picture.exr")
    assert values is None or values["Base Color"] == pytest.approx([0.8, 0.8, 0.8, 1.0], abs=1e-3)


def test_blender_reads_the_images(looked, textured, in_blender, tmp_path):
    stage, _ = looked(textured)
    values = in_blender(stage, tmp_path / "picture.exr")
    assert values["Base Color"] == "a.png"
    assert values["Roughness"] != "a.png"  # through a node that takes the green apart
