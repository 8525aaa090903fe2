"""glTF on the command line: converted, checked and rendered, as the draft of the extension describes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mrm_mtlx.documents.images import read_image


@pytest.fixture
def collar(tmp_path, write_image):
    """An asset in the test's folder with a white plate that is retroreflective on its left half; its name there."""
    mask = np.zeros((8, 8, 3), np.uint8)
    mask[:, :4, 0] = 255
    mask[:, :, 1] = 255  # in another channel, where it counts for nothing
    write_image(tmp_path / "mask.png", mask)
    material = {
        "name": "collar",
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.25},
        "extensions": {
            "KHR_materials_specular": {"specularColorFactor": [4.0, 4.0, 4.0]},
            "KHR_materials_retroreflection": {"retroreflectionFactor": 1.0, "retroreflectionTexture": {"index": 0}},
        },
    }
    asset = {
        "asset": {"version": "2.0"},
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9728}],
        "images": [{"uri": "mask.png"}],
    }
    (tmp_path / "model.gltf").write_text(json.dumps(asset))
    return asset


def halves(path) -> tuple[float, float]:
    """Mean radiance well inside of the plate's left and right half."""
    pixels = read_image(path)[..., 1]
    middle = pixels[len(pixels) // 3 : 2 * len(pixels) // 3]
    width = middle.shape[1]
    return float(middle[:, width // 4 : 2 * width // 5].mean()), float(
        middle[:, 3 * width // 5 : 3 * width // 4].mean()
    )


def test_a_plate_returns_the_headlight_where_the_mask_is_red_and_is_paint_from_aside(gl, in_process, collar, tmp_path):
    for picture, *options in (("eye.exr",), ("aside.exr", "--light", 30)):
        done = in_process("render", "model.gltf", "--shape", "plane", "--size", 32, *options, "-o", picture)
        assert done.exit_code == 0, done.output
    left, right = halves(tmp_path / "eye.exr")
    # alpha is 0.25^2 and F0 0.16, f = F0 / (4 pi alpha^2) = 3.3 at the peak, over 0.8 / pi of the paint.
    assert left > 4.0 * right
    left, right = halves(tmp_path / "aside.exr")
    assert left == pytest.approx(right, rel=0.1)  # neither lobe points there; the wider reaches it by some percent


# Without an engine, which takes ten seconds to compile this model: tests/validation compares it.
UNRUN = ("--target", "vulkan", "--samples", 16)


def test_assets_of_a_folder_are_checked_with_json_pointers_as_places(in_process, collar, tmp_path):
    (tmp_path / "empty.gltf").write_text('{"asset": {"version": "2.0"}}')
    collar["materials"][0]["extensions"]["KHR_materials_retroreflection"]["retroreflectionFactor"] = 2
    (tmp_path / "wrong.gltf").write_text(json.dumps(collar))
    done = in_process("validate", ".", *UNRUN, "--format", "json")
    assert done.exit_code == 1
    empty, sound, wrong = json.loads(done.stdout)["documents"]
    assert [f["code"] for f in empty["findings"]] == ["DOC_NO_RENDERABLE"]
    assert sound["findings"] == []
    (renderable,) = sound["renderables"]
    assert renderable["name"] == "/materials/0"
    assert renderable["targets"]["vulkan"]["stage"] in ("generate", "compile")
    place = "/materials/0/extensions/KHR_materials_retroreflection/retroreflectionFactor"
    assert (wrong["findings"][0]["code"], wrong["findings"][0]["location"]) == ("INTERCHANGE_INVALID", place)
    assert in_process("convert", "wrong.gltf", "out.mtlx").exit_code == 1
    done = in_process("convert", "empty.gltf", "out.mtlx")
    assert done.exit_code == 3
    assert "has nothing to render" in done.stderr
    assert not (tmp_path / "out.mtlx").exists()


def test_what_has_no_form_is_an_error_where_the_nearest_is_not_wanted_and_nothing_is_written(
    in_process, tmp_path, repository
):
    done = in_process("convert", repository / "materials" / "shoe_trim.mtlx", "shoe.glb", "--exact")
    assert done.exit_code == 1
    assert "error INTERCHANGE_LEFT_OUT /M_shoe_trim" in done.stderr
    assert "nothing was written" in done.stderr
    assert not (tmp_path / "shoe.glb").exists()


def test_the_commands_of_the_page_run(gl, in_process, collar, tmp_path, repository, page_commands):
    (tmp_path / "materials").symlink_to(repository / "materials")
    commands = page_commands("gltf.md")
    assert len(commands) == 7
    small, told = {"validate": UNRUN, "render": ("--size", 32)}, ""
    for name, *arguments in commands:
        done = in_process(name, *arguments, *small.get(name, ()))
        assert done.exit_code in ((0, 3) if name == "validate" else (0,)), (name, arguments, done.output)
        told = told + done.stderr
    for name in ("materials.mtlx", "model.png", "again.gltf", "again.bin", "collar.glb", "shoe.glb", "exact.glb"):
        assert (tmp_path / name).stat().st_size > 0
    again = json.loads((tmp_path / "again.gltf").read_text())["materials"]
    assert [m["extensions"] for m in again] == [m["extensions"] for m in collar["materials"]]
    assert "INTERCHANGE_LOST /M_traffic_cone_collar: as glTF, its values differ by up to" in told
    assert "warning INTERCHANGE_APPROXIMATED /M_shoe_trim: glTF has no form for it: its sides differ in" in told


def test_the_command_of_three_js_page_writes_what_its_class_reads(in_process, tmp_path, repository, page_commands):
    (tmp_path / "materials").symlink_to(repository / "materials")
    ((name, *arguments),) = page_commands("hosts/threejs.md")
    assert in_process(name, *arguments).exit_code == 0
    content = (tmp_path / "traffic_cone_collar.glb").read_bytes()
    data = json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])
    (material,) = data["materials"]
    assert material["extensions"]["KHR_materials_retroreflection"] == {"retroreflectionFactor": 1.0}
    # The page shows the class as the file beside it has it.
    folder = repository / "docs" / "hosts"
    code = (folder / "khr_materials_retroreflection.js").read_text(encoding="utf-8")
    assert f"```js\n{code}```" in (folder / "threejs.md").read_text(encoding="utf-8")
    assert "'KHR_materials_retroreflection'" in code
    assert "retroreflectionFactor" in code
