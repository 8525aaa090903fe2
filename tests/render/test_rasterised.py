"""Pictures of Storm show what those of the OpenGL engine show."""

from __future__ import annotations

import numpy as np
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.images import write_image
from mrm_mtlx.engines import gl as gl_engine
from mrm_mtlx.engines import storm as storm_engine
from mrm_mtlx.render import picture, scenes

SIZE = 48
# Of half floats that are cut off to eleven bits.
HALF = 2.0**-10

METAL = (
    '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.1, 0.1"/>'
    '<input name="retroreflective" type="boolean" value="{flag}"/></conductor_bsdf>'
)
PRINTED = (
    '<image name="print" type="color3"><input name="file" type="filename" value="print.png"{space}/></image>'
    '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="print"/>'
    "</oren_nayar_diffuse_bsdf>"
)


@pytest.fixture
def both(storm, gl, surface_document, library, tmp_path):
    """Function from BSDF nodes and settings to the pictures of OpenGL and of Storm, one value per pixel."""

    def draw(nodes, **changes):
        plain = {"shape": "sphere", "light_degrees": None, "size": SIZE, "environment": None, "compare": False}
        settings = picture.PictureOptions(**{**plain, **changes})
        first, second = (surface_document(nodes) for _ in range(2))  # the second's names of files are changed
        reach = Reach.only(tmp_path)
        drawn = picture.render(first.getNode("m"), library, reach, settings, gl_engine.ENGINE)
        renderer = storm_engine.ENGINE.scene_renderer
        return (
            picture.reduced(drawn, picture.OVERSAMPLING),
            scenes.render(second.getNode("m"), library, reach, settings, renderer),
        )

    return draw


@pytest.mark.parametrize(("flag", "degrees"), [("true", None), ("true", 1.0), ("false", 30.0)])
def test_camera_lights_and_scale_are_those_of_the_other_pictures(both, flag, degrees):
    drawn, rasterised = both(METAL.format(flag=flag), light_degrees=degrees)
    inside = np.max(drawn, axis=2) > 0.02 * drawn.max()
    ratio = (rasterised / drawn)[inside]
    assert abs(np.median(ratio) - 1.0) < HALF
    assert np.quantile(np.abs(ratio - 1.0), 0.95) < 0.01  # outlines are sampled otherwise
    outside = np.all(drawn == picture.BACKDROP, axis=2)
    np.testing.assert_allclose(rasterised[outside], picture.BACKDROP, rtol=HALF)


@pytest.mark.parametrize("space", ["", ' colorspace="srgb_texture"'])
def test_an_image_lies_on_the_plane_as_it_does_in_the_other_pictures(both, tmp_path, space):
    # Smooth, so that the filters of the two do not matter; no symmetry, so that a turn would show.
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 64), np.linspace(0.0, 1.0, 64))
    pixels = np.stack([40.0 + 200.0 * x, 40.0 + 200.0 * y, 60.0 + 120.0 * x * y], axis=2)
    write_image(tmp_path / "print.png", np.round(pixels).astype(np.uint8), {})
    drawn, rasterised = both(PRINTED.format(space=space), shape="plane")
    inside = np.s_[SIZE // 2 - 14 : SIZE // 2 + 14, SIZE // 2 - 14 : SIZE // 2 + 14]
    # Where two triangles meet, Storm looks images up in pixels of their smallest versions.
    off = np.max(np.abs(rasterised / drawn - 1.0)[inside], axis=2)
    assert np.quantile(off, 0.95) < 0.03


def test_in_a_dome_the_retroreflective_lobe_keeps_the_light_behind_the_viewer(both):
    radiance = np.full((32, 64, 3), 0.05, dtype=np.float32)
    radiance[10:18, :4] = radiance[10:18, -4:] = 6.0  # at +z, where the eye is
    settings = {"light_degrees": 180.0, "environment": radiance}
    retroreflective, ordinary = (both(METAL.format(flag=flag), **settings) for flag in ("true", "false"))
    # From the middle of the sphere to a tilt of 75 degrees, at the side.
    radius = SIZE / 2 / np.tan(np.deg2rad(12.0)) / np.sqrt(6.1**2 - 1.0)
    line = np.s_[SIZE // 2, SIZE // 2 : SIZE // 2 + round(radius * np.sin(np.deg2rad(75.0))), 1]
    for bright, dark in zip(retroreflective, ordinary, strict=True):
        assert bright[line].min() > 0.7 * bright[line].max()
        assert dark[line][0] > 0.7 * bright[line][0]
        assert dark[line][-1] < 0.1 * dark[line][0]
    # Storm filters the surroundings beforehand, in its own way.
    assert 0.7 < np.median(retroreflective[1][line] / retroreflective[0][line]) < 1.4


def test_the_command_takes_the_engine_and_refuses_what_is_for_paths(storm, tmp_path, repository):
    material = repository / "materials" / "cats_eye.mtlx"
    made = mrm.render(material, engine="storm", size=16, compare=True)
    assert np.asarray(made).shape == (16, 4 * 16 + 3 * 4, 3)
    assert float(np.asarray(made).max()) > 10.0
    with pytest.raises(mrm.ArgumentError, match="traces paths: `engine` cycles"):
        mrm.render(material, engine="storm", paths=4)
    with pytest.raises(mrm.ArgumentError, match="library mrm is given; not upstream"):
        mrm.render(material, engine="storm", library="upstream")
