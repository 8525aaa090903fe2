"""Pictures of Cycles show what those of the OpenGL engine show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.engines import gl as gl_engine
from mrm_mtlx.engines.osl import CYCLES, renderer
from mrm_mtlx.render import picture, scenes
from mrm_mtlx.shadergen import OslMode

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.bsdf.arrays import Array

SIZE = 32
PATHS = 16

PAPER = (
    '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" value="0.2, 0.5, 0.8"/>'
    "</oren_nayar_diffuse_bsdf>"
)
PRINTED = (
    '<image name="print" type="color3"><input name="file" type="filename" value="print.exr"/></image>'
    '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="print"/>'
    "</oren_nayar_diffuse_bsdf>"
)
# The axes of the surface as colours.
AXES = (
    '<{axis} name="axis" type="vector3"/><convert name="said" type="color3">'
    '<input name="in" type="vector3" nodename="axis"/></convert>'
    '<multiply name="half" type="color3"><input name="in1" type="color3" nodename="said"/>'
    '<input name="in2" type="float" value="0.4"/></multiply>'
    '<add name="shown" type="color3"><input name="in1" type="color3" nodename="half"/>'
    '<input name="in2" type="float" value="0.5"/></add>'
    '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="shown"/>'
    "</oren_nayar_diffuse_bsdf>"
)
METAL = (
    '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.05, 0.05"/>'
    "</conductor_bsdf>"
)


@pytest.fixture
def both(cycles, gl, surface_document, library, tmp_path) -> Callable[..., tuple[Array, Array]]:
    """Function from BSDF nodes and settings to the pictures of OpenGL and of Cycles, one value per pixel."""

    def draw(nodes: str, mode: OslMode = OslMode.ALIGNED, **changes: object) -> tuple[Array, Array]:
        plain = {"shape": "sphere", "light_degrees": 30.0, "size": SIZE, "environment": None, "compare": False}
        settings = picture.PictureOptions(**{**plain, **changes})
        first, second = (surface_document(nodes) for _ in range(2))
        drawn = picture.render(first.getNode("m"), library, Reach.only(tmp_path), settings, gl_engine.ENGINE)
        step = picture.OVERSAMPLING
        drawn = drawn.reshape(drawn.shape[0] // step, step, drawn.shape[1] // step, step, 3).mean(axis=(1, 3))
        traced = scenes.render(
            second.getNode("m"), library, Reach.only(tmp_path), settings, CYCLES.scene_renderer, paths=PATHS, mode=mode
        )
        return drawn, traced

    return draw


def assert_alike(drawn: Array, traced: Array, share: float = 0.03, inside: float = 0.9) -> None:
    """Nine pixels in ten are the same within a share of the bright ones; outlines are sampled otherwise by each."""
    assert drawn.shape == traced.shape
    off = np.max(np.abs(drawn - traced), axis=-1) / np.quantile(drawn, 0.95)
    assert np.quantile(off, inside) < share


@pytest.mark.parametrize("shape", ["sphere", "plane", "cone"])
def test_paper_under_a_lamp_aside_is_the_same_on_every_shape(both, shape):
    assert_alike(*both(PAPER, shape=shape))


# A point lamp falls off as 1 / d^2 in Cycles, as 1 / (d + 1)^2 in MaterialX: 6 % apart at the front of the sphere.
@pytest.mark.parametrize("mode", [OslMode.ALIGNED, OslMode.CYCLES])
def test_a_tape_is_as_bright_under_a_headlight(both, tape_nodes, mode):
    drawn, traced = both(tape_nodes("true"), mode, light_degrees=None)
    assert_alike(drawn, traced, share=0.08)
    ordinary, _ = both(tape_nodes("false"), mode, light_degrees=None)
    assert np.mean(traced) > 2.0 * np.mean(ordinary)


def test_a_comparison_has_the_flag_off_and_on(both, tape_nodes):
    # The width of 0.1 is near its aligned twin within 11 %, of the lobe alone.
    assert_alike(*both(tape_nodes("true"), compare=True, light_degrees=20.0, shape="cone"), share=0.12)


def test_there_is_nothing_to_compare_without_the_flag(both):
    with pytest.raises(ValueError, match="no lobe of the material is retroreflective"):
        both(PAPER, compare=True)


@pytest.mark.parametrize("shape", ["sphere", "plane"])
def test_an_image_lies_the_same_way(both, write_image: Callable[[Path, Array], Path], tmp_path, shape):
    # Four corners of four colours: neither a flip nor a turn goes unseen.
    corners = np.zeros((64, 64, 3), np.float32)
    corners[:32, :32, 0], corners[:32, 32:, 1], corners[32:, :32, 2], corners[32:, 32:] = 0.9, 0.9, 0.9, 0.4
    write_image(tmp_path / "print.exr", corners)
    drawn, traced = both(PRINTED, shape=shape, light_degrees=10.0)
    # Outlines, and the two lines between the colours, take 15 % of the pixels.
    assert_alike(drawn, traced, share=0.05, inside=0.8)
    for wrong in (drawn[::-1], drawn[:, ::-1]):
        with pytest.raises(AssertionError):
            assert_alike(wrong, traced, share=0.05, inside=0.8)


@pytest.mark.parametrize(("axis", "shape"), [("tangent", "sphere"), ("bitangent", "sphere"), ("tangent", "cone")])
def test_the_axes_of_the_surface_are_the_same(both, axis, shape):
    assert_alike(*both(AXES.format(axis=axis), shape=shape, light_degrees=10.0))


def test_an_edge_of_the_triangle_is_no_tangent(both, monkeypatch):
    monkeypatch.setattr(renderer, "with_mesh_inputs", lambda source: source)
    with pytest.raises(AssertionError):
        assert_alike(*both(AXES.format(axis="tangent"), light_degrees=10.0))


def test_surroundings_lie_the_same_way(both):
    sky = np.full((32, 64, 3), 0.1, np.float32)
    sky[:12, :, 2], sky[8:20, 4:20, 0], sky[12:18, 40:52, 1] = 1.0, 3.0, 3.0
    drawn, traced = both(METAL, environment=sky, light_degrees=120.0)
    # Both are estimates, of 16 directions: what lies where is asked for, in blocks of 4 by 4 pixels.
    blocks = [a.reshape(SIZE // 4, 4, SIZE // 4, 4, 3).mean(axis=(1, 3))[2:-2, 2:-2] for a in (drawn, traced)]
    assert np.corrcoef(*(b.ravel() for b in blocks))[0, 1] > 0.97
    for wrong in (blocks[0][:, ::-1], blocks[0][::-1]):
        assert np.corrcoef(wrong.ravel(), blocks[1].ravel())[0, 1] < 0.9


def test_progress_is_told_and_the_seed_fixes_the_picture(cycles, surface_document, library, tmp_path):
    settings = picture.PictureOptions("plane", None, SIZE, np.full((4, 8, 3), 0.5, np.float32), compare=False)
    heard: list[tuple[int, int]] = []

    def trace(seed: int) -> Array:
        document = surface_document(METAL)
        return scenes.render(
            document.getNode("m"),
            library,
            Reach.only(tmp_path),
            settings,
            CYCLES.scene_renderer,
            paths=32,
            seed=seed,
            progress=lambda done, total: heard.append((done, total)),
        )

    first, again, other = trace(3), trace(3), trace(4)
    assert heard == [(1, 2), (2, 2)] * 3
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
