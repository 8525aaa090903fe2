"""Curves of documents: the reference's response without its cosine."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx import bsdf
from mrm_mtlx.plots.documents import surface_curve
from mrm_mtlx.reference import Surface, versions

METAL = """<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.2, 0.2"/>
<input name="retroreflective" type="boolean" value="{flag}"/></conductor_bsdf>"""
# conductor_bsdf's own default, gold.
GOLD = {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770), "alpha": (0.2, 0.2)}

# Relative: a document's numbers are float32, 2^-24 each, and a value goes with a few powers of seven of them.
PARAMETERS = 16 * 2.0**-24


@pytest.fixture
def curve_of(surface_document):
    """Function from BSDF nodes, as text, and the angles to the curve of the surface."""

    def make(nodes: str, theta_l: float, azimuth: float = 0.0):
        document = surface_document(nodes)
        return surface_curve("m", "", Surface(document.getNode("m")), theta_l, azimuth)

    return make


@pytest.mark.parametrize("azimuth", [0.0, 0.8])
@pytest.mark.parametrize("flag", ["false", "true"])
def test_a_conductor_is_that_of_the_optics(curve_of, is_the_curve_of, flag, azimuth):
    curve = curve_of(METAL.format(flag=flag), 0.7, azimuth)
    white_albedo = versions.installed().microfacet_albedo.white
    lobe = bsdf.Conductor(**GOLD, retroreflective=flag == "true", energy_compensation=white_albedo)
    other = bsdf.Conductor(**GOLD, retroreflective=flag != "true", energy_compensation=white_albedo)
    assert is_the_curve_of(curve, lobe.eval, azimuth, PARAMETERS)
    assert not is_the_curve_of(curve, other.eval, azimuth, PARAMETERS)


def test_the_cosine_of_the_light_is_divided_out_and_emission_left_out(surface_document):
    document = surface_document(
        '<burley_diffuse_bsdf name="unused" type="BSDF"/><oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">'
        '<input name="color" type="color3" value="0.5, 0.5, 0.5"/></oren_nayar_diffuse_bsdf>'
        '<uniform_edf name="glow" type="EDF"/>'
    )
    shader = document.getNode("s")
    shader.addInput("edf", "EDF").setNodeName("glow")
    curve = surface_curve("m", "", Surface(document.getNode("m")), 1.2)
    # Roughness 0: 0.5 / pi everywhere, but for a division by the cosine, 0.36, and the clamp of a shader at n.v = 1e-8.
    np.testing.assert_allclose(curve.value, 0.5 / np.pi, rtol=1e-12)


def test_what_varies_over_the_surface_is_that_of_the_middle(curve_of):
    curve = curve_of(
        '<ramplr name="ramp" type="color3"><input name="valuel" type="color3" value="0, 0, 0"/>'
        '<input name="valuer" type="color3" value="1, 1, 1"/></ramplr>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="ramp"/>'
        "</oren_nayar_diffuse_bsdf>",
        0.3,
    )
    np.testing.assert_allclose(curve.value, 0.5 / np.pi, rtol=1e-12)


def test_a_surface_that_is_not_finite_is_refused():
    class Broken:
        def response(self, points):
            return np.where(points.view[:, :1] > 0.5, np.nan, 1.0) * np.ones((1, 3))

    message = r"^m has no finite value at the view angle 30\.\d degrees under light at 17\.2 degrees$"
    with pytest.raises(ValueError, match=message):
        surface_curve("m", "", Broken(), 0.3)
