"""Colour spaces have the names that MaterialX's generators take, and are known by those of OpenColorIO."""

from __future__ import annotations

import pytest
from MaterialX import PyMaterialXGenGlsl as mx_gen_glsl
from MaterialX import PyMaterialXGenShader as mx_gen

from mrm_mtlx.library.color_spaces import canonical, color_transform, equivalent, in_opencolorio, is_handled, is_linear

# Names that MaterialX's specification, its default colour management and its test documents have, and others.
NAMES = (
    *("srgb_texture", "lin_rec709", "g22_rec709", "g18_rec709", "acescg", "lin_ap1", "g22_ap1", "g18_ap1", "lin_srgb"),
    *("adobergb", "lin_adobergb", "srgb_displayp3", "lin_displayp3", "rec709_display", "gamma18", "gamma22", "gamma24"),
    *("lin_ap1_scene", "lin_rec709_scene", "lin_p3d65_scene", "lin_adobergb_scene", "srgb_rec709_scene"),
    *("g22_rec709_scene", "g18_rec709_scene", "g22_ap1_scene", "srgb_p3d65_scene", "g22_adobergb_scene"),
    *("Raw", "raw", "ACES2065-1", "Linear Rec.2020", "Utility - sRGB - Texture", "sRGB", "Gamma22", "unheard_of"),
)


@pytest.fixture(scope="module")
def is_transformed(library):
    """Function from a name and a type to whether MaterialX's generators have a transform to linear Rec.709."""
    generator = mx_gen_glsl.GlslShaderGenerator.create()
    generator.registerTypeDefs(library.document)
    context = mx_gen.GenContext(generator)
    management = mx_gen.DefaultColorManagementSystem.create(generator.getTarget())
    management.loadLibrary(library.document)

    def ask(space: str, kind: str) -> bool:
        transform = mx_gen.ColorSpaceTransform(space, "lin_rec709", context.getTypeDesc(kind))
        return bool(management.supportsTransform(transform))

    return ask


@pytest.mark.parametrize("space", NAMES)
def test_there_is_a_transform_for_those_names_that_generators_transform(library, is_transformed, space):
    found = color_transform(library.document, space) is not None
    assert [is_transformed(space, kind) for kind in ("color3", "color4")] == [found, found]


def test_every_transform_of_the_library_is_known_by_its_name(library):
    nodes = {d.getNodeString() for d in library.document.getNodeDefs() if d.getNodeGroup() == "colortransform"}
    spaces = {name.removesuffix("_to_lin_rec709") for name in nodes}
    assert spaces
    assert spaces <= set(NAMES)
    assert all(canonical(space) == space for space in spaces)


@pytest.mark.parametrize(
    ("space", "name"),
    [("Utility - sRGB - Texture", "srgb_texture"), ("Raw", "none"), ("raw", "none"), ("lin_srgb", "lin_rec709")],
)
def test_a_name_of_opencolorio_leads_to_the_space_that_materialx_has(library, space, name):
    assert equivalent(library.document, space) == name
    assert is_handled(library.document, space) == is_linear(name)


@pytest.mark.parametrize("space", ["", "none", "lin_rec709", "lin_rec709_scene"])
def test_numbers_in_the_space_of_the_generators_are_used_as_they_are(library, space):
    assert is_linear(space)
    assert is_handled(library.document, space)
    assert color_transform(library.document, space) is None


@pytest.mark.parametrize(("space", "known"), [("ACES2065-1", True), ("Linear Rec.2020", True), ("unheard_of", False)])
def test_a_space_that_materialx_lacks_has_no_equivalent(library, space, known):
    assert bool(in_opencolorio(space)) == known
    assert equivalent(library.document, space) == ""
    assert not is_handled(library.document, space)
