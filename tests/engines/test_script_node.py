"""The Script node in Blender itself: OSL from a text, with its sockets, gives the picture of the ordinary form."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.engines.osl import process
from mrm_mtlx.library import materials_folder
from mrm_mtlx.shadergen import (
    OslMode,
    ScriptNode,
    Shader,
    generate,
    header_folder,
    script_node,
    with_mesh_inputs,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

PROGRAM = Path(__file__).with_name("blender_script_node.py")
TIME_LIMIT_S = 240

# Two retroreflective lobes; and a surface model with a pattern.
MATERIALS = ("hi_vis_tape_silver", "segmented_trim")

# Of the brightest pixel. Cycles builds its tree of triangles by threads, so that two renders of one scene differ by
# roundings of 2^-24, here by 4e-6; from a portal on paths differ, and the picture's mean does, here by 2e-4.
SAME_PICTURE, SAME_MEAN = 2e-5, 2e-3

KINDS = {"float": "NodeSocketFloat", "color": "NodeSocketColor", "boolean": "NodeSocketInt"}


@dataclass(frozen=True)
class Seen:
    """What Blender has made of sources, by their names: the nodes, the pictures, and all that it printed."""

    nodes: Mapping[str, Any]
    pictures: Mapping[str, NDArray[np.float32]]
    log: str


@pytest.fixture(scope="module")
def blender(cycles, tmp_path_factory) -> Callable[[Mapping[str, str]], Seen]:
    """Function from sources by name to what Blender makes of them; those named `*.external` lie beside the headers."""

    def show(sources: Mapping[str, str]) -> Seen:
        folder = tmp_path_factory.mktemp("blender")
        for header in header_folder().glob("*.h"):
            (folder / header.name).write_bytes(header.read_bytes())
        files = [folder / f"{name}.osl" for name in sources]
        for file, source in zip(files, sources.values(), strict=True):
            file.write_text(source, encoding="utf-8")
        request = {"sources": list(map(str, files)), "pictures": str(folder / "pictures.npz")}
        interpreter = process.RUNTIME.interpreter()
        assert interpreter is not None
        done = subprocess.run(
            [interpreter, "-I", str(PROGRAM), json.dumps(request)],
            capture_output=True,
            text=True,
            check=True,
            timeout=TIME_LIMIT_S,
        )
        with np.load(folder / "pictures.npz") as archive:
            pictures = {name: archive[str(number)] for number, name in enumerate(sources)}
        return Seen(dict(zip(sources, json.loads(done.stdout), strict=True)), pictures, done.stderr)

    return show


@pytest.fixture(scope="module")
def made() -> Callable[[str, OslMode], tuple[Shader, ScriptNode]]:
    """Function from a ready material to its ordinary OSL and its Script node."""

    def make(name: str, mode: OslMode) -> tuple[Shader, ScriptNode]:
        opened = mrm.open_document(materials_folder() / f"{name}.mtlx")
        (element,) = map(opened.element, opened.elements)
        shader = generate(element, "osl", opened.library, mode)
        return shader, script_node(element, shader)

    return make


@pytest.fixture(scope="module")
def printed(surface_document, library, write_image, tmp_path_factory) -> tuple[Shader, ScriptNode]:
    """A diffuse surface with an image, red on the left, green on the right, brighter above: both forms."""
    pixels = np.zeros((32, 32, 3), np.float32)
    pixels[:, :16, 0], pixels[:, 16:, 1] = 0.2, 0.2
    pixels[:8] *= 4.0
    image = write_image(tmp_path_factory.mktemp("image") / "print.exr", pixels)
    document = surface_document(
        f'<image name="print" type="color3"><input name="file" type="filename" value="{image}"/></image>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="print"/>'
        "</oren_nayar_diffuse_bsdf>"
    )
    shader = generate(document.getNode("m"), "osl", library)
    return shader, script_node(document.getNode("m"), shader)


@pytest.fixture(scope="module")
def seen(blender, made, printed) -> Seen:
    """Each material in two modes, in both forms; and damaged ones."""
    sources = {
        "print.external": with_mesh_inputs(printed[0].sources["pixel"]),
        "print": printed[1].shader.sources["pixel"],
    }
    for name in MATERIALS:
        for mode in (OslMode.ALIGNED, OslMode.CYCLES):
            ordinary, node = made(name, mode)
            sources[f"{name}.{mode}.external"] = with_mesh_inputs(ordinary.sources["pixel"])
            sources[f"{name}.{mode}"] = node.shader.sources["pixel"]
    sources["wider"] = sources["segmented_trim.aligned"].replace("roughness = 0.100000", "roughness = 0.100010")
    assert sources["wider"] != sources["segmented_trim.aligned"]
    return blender(sources)


@pytest.mark.parametrize("name", MATERIALS)
def test_blender_shows_the_sockets_that_are_told_and_no_others(seen, made, name):
    node = made(name, OslMode.ALIGNED)[1]
    shown = seen.nodes[f"{name}.aligned"]
    told = [(s.title, s.name, KINDS[s.type], s.default) for s in node.sockets]
    extra = [
        (label, each, "NodeSocketVector", (0.0,) * 3)
        for label, each in (("UV", node.uv), ("Tangent", node.tangent))
        if each
    ]
    assert [(s["name"], s["identifier"], s["kind"]) for s in shown["inputs"]] == [each[:3] for each in told + extra]
    for socket, (*_, default) in zip(shown["inputs"], told + extra, strict=True):
        values = socket["default"][:3] if isinstance(socket["default"], list) else socket["default"]
        np.testing.assert_array_equal(np.float32(values), np.float32(default))
    assert shown["outputs"] == ["Surface"]
    assert len(seen.nodes[f"{name}.aligned.external"]["inputs"]) > 40


def test_an_image_is_no_socket_and_lies_as_in_the_ordinary_form(seen):
    assert [socket["name"] for socket in seen.nodes["print"]["inputs"]] == ["UV"]
    picture = seen.pictures["print"]
    np.testing.assert_allclose(picture, seen.pictures["print.external"], rtol=0, atol=SAME_PICTURE * np.max(picture))
    # The sphere is seen from above: the image's upper quarter in the middle; a half of it is red, a half green.
    for channel, other in ((0, 1), (1, 0)):
        assert np.sum(picture[..., channel] > 10.0 * picture[..., other]) > 0.2 * np.sum(picture[..., 3])
    inner, outer = picture[len(picture) // 2, [14, 7], :3].max(axis=-1)
    assert inner > 3.0 * outer > 0.0


def difference(seen: Seen, one: str, other: str) -> float:
    """The largest difference of two pictures, relative to the brightest pixel of the other."""
    assert np.max(seen.pictures[other]) > 10.0
    return float(np.max(np.abs(seen.pictures[one] - seen.pictures[other])) / np.max(seen.pictures[other]))


@pytest.mark.parametrize("name", MATERIALS)
def test_the_picture_is_that_of_the_ordinary_form(seen, name):
    assert difference(seen, f"{name}.aligned", f"{name}.aligned.external") < SAME_PICTURE
    means = [np.mean(seen.pictures[f"{name}.cycles{form}"][..., :3]) for form in ("", ".external")]
    assert means[0] == pytest.approx(means[1], rel=SAME_MEAN)
    # And the modes are two: a lobe that is approximate, and one that is not.
    assert difference(seen, f"{name}.cycles", f"{name}.aligned") > 100.0 * SAME_PICTURE


def test_a_width_that_is_off_by_a_ten_thousandth_is_seen(seen):
    assert difference(seen, "wider", "segmented_trim.aligned.external") > 2.0 * SAME_PICTURE


def test_cycles_has_nothing_to_say_against_the_portals_of_several_lobes(seen):
    assert "ERROR" not in seen.log
    assert "message" not in seen.log


def test_a_message_that_is_set_by_each_lobe_is_heard_of(blender, made):
    source = made("hi_vis_tape_silver", OslMode.CYCLES)[1].shader.sources["pixel"]
    damaged = source.replace("    normal earlier = N;\n", '    setmessage("mrm_portal", N);\n    normal earlier = N;\n')
    assert damaged != source
    assert 'message "mrm_portal" already exists' in blender({"damaged": damaged}).log
