"""A document's OSL under suns in Cycles: what is compared, what is not and why, and an error that is seen."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.engines.osl import CYCLES
from mrm_mtlx.validation.comparison.closures import compare_closures, sun_points
from mrm_mtlx.validation.comparison.sampling import LobeShape, generator

METAL = """
  <conductor_bsdf name="bsdf" type="BSDF">
    <input name="weight" type="float" value="0.7"/>
    <input name="roughness" type="vector2" value="0.2, 0.2"/>
    <input name="retroreflective" type="boolean" value="{0}"/>
  </conductor_bsdf>
"""
PARTIAL = """
  <mrm_conductor_bsdf name="bsdf" type="BSDF">
    <input name="roughness" type="vector2" value="0.2, 0.2"/>
    <input name="retroreflectivity" type="float" value="{0}"/>
  </mrm_conductor_bsdf>
"""
LAYERED = """
  <dielectric_bsdf name="top" type="BSDF"/>
  <oren_nayar_diffuse_bsdf name="base" type="BSDF"/>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="top"/><input name="base" type="BSDF" nodename="base"/>
  </layer>
"""
SAMPLES = 8 * 12 * 40


@pytest.mark.parametrize("flag", ["false", "true"])
def test_a_metal_compares_with_and_without_the_flag(cycles, surface_document, library, flag):
    document = surface_document(METAL.format(flag))
    found = compare_closures(document.getNode("m"), library, SAMPLES, generator(0, flag), CYCLES.bench)
    assert found.passed
    assert found.samples == 12 * 40


@pytest.mark.parametrize("amount", [0, 1])
def test_an_amount_at_its_ends_is_one_lobe_and_compares(cycles, surface_document, library, amount):
    # Without a weight, the retroreflective part makes no portal: the ordinary one is not approximated.
    document = surface_document(PARTIAL.format(amount))
    assert compare_closures(document.getNode("m"), library, SAMPLES, generator(0, "partial"), CYCLES.bench).passed


def test_a_wrong_input_of_the_closure_is_seen(cycles, surface_document, changed_library):
    wrong, _ = changed_library("genosl/mrm_conductor_bsdf.osl", "weight *", "0.99 * weight *")
    document = surface_document(METAL.format("false"), data=wrong)
    assert not compare_closures(document.getNode("m"), wrong, SAMPLES, generator(0, "wrong"), CYCLES.bench).passed


@pytest.mark.parametrize(
    ("nodes", "reason"),
    [
        pytest.param(LAYERED, "its layer is another model in OSL's renderers", id="a layer"),
        pytest.param(
            '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="roughness" type="float" value="0.5"/>'
            "</oren_nayar_diffuse_bsdf>",
            "its rough oren_nayar_diffuse_bsdf is another model in OSL's renderers",
            id="rough diffuse",
        ),
        pytest.param(
            PARTIAL.format(0.5),
            "its ordinary lobes are seen from the wrong side where the retroreflective ones are exact in OSL",
            id="a lobe that is half ordinary, half retroreflective",
        ),
        pytest.param(
            METAL.format("false").replace("0.2, 0.2", "0.002, 0.002"),
            "a lobe is narrower than 0.0025, which renderers of OSL cannot hold in float32",
            id="a narrow lobe",
        ),
        pytest.param(
            '<blackbody name="b" type="color3"/><oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" '
            'type="color3" nodename="b"/></oren_nayar_diffuse_bsdf>',
            "its blackbody is another model in OSL's renderers",
            id="blackbody",
        ),
        pytest.param(
            METAL.format("false").replace("0.2, 0.2", "0.2, 0.3"),
            "facets for the measurement have no tangents, positions or texture coordinates of their own",
            id="two widths",
        ),
        pytest.param(
            '<image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>'
            '<conductor_bsdf name="bsdf" type="BSDF"><input name="ior" type="color3" nodename="i"/></conductor_bsdf>',
            "facets for the measurement have no tangents, positions or texture coordinates of their own",
            id="an image",
        ),
        pytest.param(
            '<position name="p" type="vector3"/><magnitude name="d" type="float"><input name="in" type="vector3" '
            'nodename="p"/></magnitude><oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" '
            'type="float" nodename="d"/></oren_nayar_diffuse_bsdf>',
            "facets for the measurement have no tangents, positions or texture coordinates of their own",
            id="position",
        ),
    ],
)
def test_what_is_not_compared_has_its_reason(surface_document, library, nodes, reason):
    document = surface_document(nodes)
    assert compare_closures(document.getNode("m"), library, 512, generator(0, "reason"), CYCLES.bench) == reason


def test_a_layer_whose_top_is_off_is_its_base(cycles, surface_document, library):
    off = '<dielectric_bsdf name="top" type="BSDF"><input name="weight" type="float" value="0"/></dielectric_bsdf>'
    document = surface_document(LAYERED.replace('<dielectric_bsdf name="top" type="BSDF"/>', off))
    assert compare_closures(document.getNode("m"), library, SAMPLES, generator(0, "off"), CYCLES.bench).passed


def test_suns_stand_at_their_angles_above_every_facet(rng):
    groups = sun_points(rng, 200, [LobeShape(0.1, 0.1, False)])
    assert len(groups) == 12
    for points in groups:
        cosines = [np.sum(points.normal * a, axis=1) for a in (points.view, points.light)]
        assert min(c.min() for c in cosines) > 0.0
        assert np.allclose(np.linalg.norm(points.normal, axis=1), 1.0)
        assert np.allclose(np.sum(points.normal * points.tangent, axis=1), 0.0)
