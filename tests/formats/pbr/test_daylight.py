"""A material as it looks by day: the colour of standards' measurements, and what shines by day."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.formats.pbr import comparison, daylight
from mrm_mtlx.formats.pbr.model_nodes import MODEL
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.formats.pbr.value_sources import resolved
from mrm_mtlx.formats.reading import read_document
from mrm_mtlx.shadergen import renderable_elements

MATERIALS = Path(__file__).parents[3] / "materials"
# Relative: the colour is rounded to four digits.
CLOSE = 1e-3


@pytest.fixture
def looks(library, tmp_path):
    """Function from a file to its first element and the look of that, with the images of its folder."""

    def make(path):
        read = read_document(path, Reach.beside(path), library, tmp_path)
        document = resolved(read.materialx)
        images = CheckedImages(read.reach, "")
        element = renderable_elements(document)[0]
        return document, element, images, daylight.daylight(element, images)

    return make


def by_day(look, library, images) -> float:
    document = look.document(library.document)
    return comparison.photometry(document.getNode(MODEL), images).day


# Between them: a layer under a film, a mixture, a sum, a weight that varies with the directions, a share of metal.
NAMES = ("traffic_cone_collar", "shoe_trim", "hi_vis_tape_silver", "prismatic_tape_orange", "segmented_trim")


@pytest.mark.parametrize("name", NAMES)
def test_a_material_has_its_daytime_colour_and_returns_nothing(looks, library, name):
    _document, element, images, look = looks(MATERIALS / f"{name}.mtlx")
    before = comparison.photometry(element, images)
    assert by_day(look, library, images) == pytest.approx(before.day, rel=CLOSE)
    document = look.document(library.document)
    after = comparison.photometry(document.getNode(MODEL), images)
    assert after.night < 0.5 < 10.0 < before.night
    assert look.inputs["metallic"].value == 0.0


def test_a_look_of_another_colour_is_seen(looks, library, monkeypatch):
    """A planted error: the colour of the base in the place of that which is seen through the film and the beads."""
    monkeypatch.setattr(daylight, "_calibrated", lambda *args: args[-1]["diffuseColor"])
    _document, element, images, look = looks(MATERIALS / "traffic_cone_collar.mtlx")
    before = comparison.photometry(element, images).day
    assert by_day(look, library, images) > 1.1 * before


def test_the_film_shines_by_day_and_not_the_beads(looks):
    *_, look = looks(MATERIALS / "traffic_cone_collar.mtlx")
    assert look.inputs["roughness"].value[0] == pytest.approx(np.sqrt(0.03))  # that of the vinyl film
    assert 1.4 < look.inputs["ior"].value[0] < 1.6
    assert "clearcoat" not in look.inputs


def test_a_metal_stays_one(looks):
    *_, look = looks(MATERIALS / "embossed_foil.mtlx")
    assert look.inputs["metallic"].value == 1.0
    assert np.all(look.inputs["diffuseColor"].value > 0.8)


HEAD = '<materialx version="1.39" colorspace="lin_rec709">'
FOOT = (
    '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />'
    "</surfacematerial></materialx>"
)
IMAGE = (
    '<image name="i" type="color3"><input name="file" type="filename" value="a.ppm" colorspace="srgb_texture" />'
    '<input name="texcoord" type="vector2" nodename="p" /></image><texcoord name="t" type="vector2" />'
    '<multiply name="p" type="vector2"><input name="in1" type="vector2" nodename="t" />'
    '<input name="in2" type="vector2" value="2, 3" /></multiply>'
)


def made(folder, nodes):
    """The file of a document with a shader "s", and an image beside it."""
    (folder / "a.ppm").write_bytes(b"P6\n2 2\n255\n" + bytes(range(40, 160, 10)))
    path = folder / "a.mtlx"
    path.write_text(HEAD + nodes + FOOT, encoding="utf-8")
    return path


def test_an_image_stays_one_and_its_colours_are_those_by_day(looks, library, tmp_path):
    nodes = IMAGE + (
        '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i" />'
        '<input name="metallic" type="float" value="0" /><input name="retroreflectivity" type="float" value="1" />'
        '<input name="specular_color" type="color3" value="8, 8, 8" /><input name="clearcoat" type="float" value="1" />'
        '<input name="roughness" type="float" value="0.2" /></gltf_pbr>'
    )
    _document, element, images, look = looks(made(tmp_path, nodes))
    color = look.inputs["diffuseColor"]
    assert color.lookup.file == "a.ppm"
    assert color.lookup.placement[:2] == (2.0, 0.0)
    assert np.all(color.scale < 0.8)  # beads of 0.32 are over it, and a film
    before = comparison.photometry(element, images).day
    # A factor and an offset of the image for what is no more than nearly linear: 1 %.
    assert by_day(look, library, images) == pytest.approx(before, rel=0.01)


def test_a_surface_of_the_model_itself_is_its_own_look(looks, library, tmp_path):
    nodes = IMAGE + (
        '<UsdPreviewSurface name="s" type="surfaceshader"><input name="diffuseColor" type="color3" nodename="i" />'
        '<input name="roughness" type="float" value="0.25" /><input name="clearcoat" type="float" value="0.5" />'
        "</UsdPreviewSurface>"
    )
    _document, element, images, look = looks(made(tmp_path, nodes))
    document = look.document(library.document)
    apart = comparison.difference((element, images), (document.getNode(MODEL), images))
    assert apart[0] <= comparison.ROUNDING


def test_light_opacity_and_mask_are_carried_over(looks, library, tmp_path):
    inputs = (
        '<input name="emissive" type="color3" value="0.2, 0.3, 0.4" /><input name="alpha" type="float" value="0.25" />'
        '<input name="emissive_strength" type="float" value="2" /><input name="alpha_mode" type="integer" value="1" />'
        '<input name="alpha_cutoff" type="float" value="0.125" /><input name="metallic" type="float" value="0" />'
    )
    *_, look = looks(made(tmp_path, f'<gltf_pbr name="s" type="surfaceshader">{inputs}</gltf_pbr>'))
    numbers = {name: value.value.tolist() for name, value in look.inputs.items() if isinstance(value, Term)}
    assert numbers["emissiveColor"] == pytest.approx([0.4, 0.6, 0.8])
    assert (numbers["opacity"], numbers["opacityThreshold"]) == ([0.25], [0.125])


def test_an_unlit_surface_shines_by_itself_alone(looks, tmp_path):
    inputs = '<input name="emission_color" type="color3" value="0.2, 0.3, 0.4" />'
    *_, look = looks(made(tmp_path, f'<surface_unlit name="s" type="surfaceshader">{inputs}</surface_unlit>'))
    assert look.inputs["emissiveColor"].value == pytest.approx([0.2, 0.3, 0.4])
    assert not np.any(look.inputs["diffuseColor"].value)


def test_what_is_transparent_keeps_its_colour(looks, tmp_path):
    inputs = (
        '<input name="base_color" type="color3" value="0.2, 0.3, 0.4" /><input name="alpha" type="float" value="0" />'
        '<input name="metallic" type="float" value="0" /><input name="alpha_mode" type="integer" value="2" />'
    )
    *_, look = looks(made(tmp_path, f'<gltf_pbr name="s" type="surfaceshader">{inputs}</gltf_pbr>'))
    assert look.inputs["diffuseColor"].value == pytest.approx([0.2, 0.3, 0.4])


def test_a_number_that_is_not_finite_makes_no_look(looks, tmp_path):
    divided = (
        '<divide name="d" type="float"><input name="in1" type="float" value="1" />'
        '<input name="in2" type="float" value="0" /></divide>'
    )
    inputs = '<input name="roughness" type="float" nodename="d" />'
    path = made(tmp_path, f'{divided}<UsdPreviewSurface name="s" type="surfaceshader">{inputs}</UsdPreviewSurface>')
    with pytest.raises(InexpressibleError, match="its roughness would be no finite number"):
        looks(path)
