"""Deviations that a line more in the source mends: they are told by name, and nothing else passes as one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.shadergen.precision import with_highp
from mrm_mtlx.validation.comparison.drawing import check_draws
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.mending import mended_sources
from mrm_mtlx.validation.comparison.sampling import generator
from tests.fixtures.versions import planted

# Hash of integers: of 32 bits where they are mediump, in a driver that has 16 for those.
NOISE = '<noise3d name="n" type="float"/><output name="o" type="float" nodename="n"/>'
IMAGE = """
  <image name="i" type="color3"><input name="file" type="filename" value="flat.exr"/></image>
  <output name="o" type="color3" nodename="i"/>
"""
BOTH = """
  <image name="i" type="color3"><input name="file" type="filename" value="flat.exr"/></image>
  <noise3d name="n" type="color3"/>
  <multiply name="product" type="color3">
    <input name="in1" type="color3" nodename="i"/><input name="in2" type="color3" nodename="n"/>
  </multiply>
  <output name="o" type="color3" nodename="product"/>
"""
CASES = {
    "noise": (NOISE, {Deviation.MEDIUMP_INTEGERS}),
    "an image": (IMAGE, {Deviation.LOWP_SAMPLERS}),
    "an image and noise": (BOTH, {Deviation.MEDIUMP_INTEGERS, Deviation.LOWP_SAMPLERS}),
}


@pytest.fixture
def images(tmp_path, write_image):
    """The images of a document: one of a colour that no number of 11 bits holds, so that no filter hides an error."""
    write_image(tmp_path / "flat.exr", np.full((3, 5, 3), 0.7))
    return CheckedImages(Reach.only(tmp_path), "")


@pytest.fixture
def checked(gl, make_document, library, images):
    """Function from a document with one output, a target, and a change of its source to the result and findings."""

    def check(text, target="essl", old="", new=""):
        document = make_document(text)
        (element,) = renderable_elements(document)
        expectation = Expectation(element, generator(0, "mending"), 512, images)
        shader = with_highp(generate(element, target, library))
        pixel = shader.sources["pixel"]
        changed = replace(shader, sources={**shader.sources, "pixel": planted(pixel, old, new) if old else pixel})
        return check_draws(ENGINE, changed, images, {"": (expectation, {})}, "")[""]

    return check


@pytest.mark.parametrize("name", CASES)
def test_the_low_precision_of_essl_is_told_by_name(gl, checked, name):
    text, deviations = CASES[name]
    result, findings = checked(text)
    assert result.status == "pass"
    # A driver may compute in more than it has to; Mesa does in 16 bits.
    assert [f.code for f in findings] == ["UPSTREAM_DEVIATION"] * ("llvmpipe" in gl.detail)
    named = f"({', '.join(sorted(d.value for d in deviations))})"
    assert all(named in f.message for f in findings)


@pytest.mark.parametrize("name", CASES)
def test_another_target_has_no_low_precision(checked, name):
    result, findings = checked(CASES[name][0], "glsl")
    assert (result.status, findings) == ("pass", [])


# What is replaced in the source of each case, and by what.
SCALE = "mx_gradient_scale3d({} v) {{ return 0.982{} * v; }}"
ERRORS = {
    "noise": (SCALE.format("float", 0), SCALE.format("float", 1)),
    "an image": ("texture(tex_sampler, uv)", "1.0001 * texture(tex_sampler, uv)"),
    "an image and noise": (SCALE.format("vec3", 0), SCALE.format("vec3", 1)),
}


@pytest.mark.parametrize("name", CASES)
def test_another_error_is_no_low_precision(checked, name):
    result, findings = checked(CASES[name][0], "essl", *ERRORS[name])
    assert result.status == "fail"
    assert [f.code for f in findings] == ["SHADER_DIFFERS"]


def test_every_mend_is_tried_alone_and_with_the_others(make_document, library):
    document = make_document(NOISE)
    shader = with_highp(generate(document.getOutput("o"), "essl", library))
    tried = dict(mended_sources(shader))
    assert [len(deviations) for deviations in tried] == [1, 1, 2]
    assert frozenset().union(*tried) == {Deviation.MEDIUMP_INTEGERS, Deviation.LOWP_SAMPLERS}
    assert len({mended.sources["pixel"] for mended in tried.values()} | {shader.sources["pixel"]}) == 4
    assert list(mended_sources(generate(document.getOutput("o"), "glsl", library))) == []


HEXAGONS = """
  <tiledhexagons name="h" type="color3">
    <input name="uvtiling" type="vector2" value="3, 3"/><input name="staggered" type="boolean" value="true"/>
  </tiledhexagons>
  <output name="o" type="color3" nodename="h"/>
"""


@pytest.mark.parametrize("target", ["glsl", "essl"])
def test_the_root_of_a_negative_number_in_hexagons_is_told_by_name(gl, checked, target):
    result, findings = checked(HEXAGONS, target)
    assert result.status == "pass"
    # What a driver makes of it is its own business; Mesa loses the hexagons of two of three rows.
    assert [f.code for f in findings] == ["UPSTREAM_DEVIATION"] * ("llvmpipe" in gl.detail)
    assert all("(hexagon-root)" in f.message for f in findings)


def test_another_error_in_hexagons_is_seen(checked):
    result, findings = checked(
        HEXAGONS, "glsl", "vec3(-0.866025, 0.500000, 0.577350)", "vec3(-0.866025, 0.500000, 0.500000)"
    )
    assert result.status == "fail"
    assert [f.code for f in findings] == ["SHADER_DIFFERS"]
