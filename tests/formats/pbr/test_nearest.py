"""The nearest inputs of gltf_pbr: they come back where there are some, and come near where there are none."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.formats.pbr import comparison, nearest
from mrm_mtlx.formats.pbr.directions import DAY, NIGHT, pairs
from mrm_mtlx.formats.pbr.model_nodes import MODEL, model_document
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.term import Term


def no_images(_name):
    return None


@pytest.fixture(scope="module")
def pbr(library):
    """Function from inputs of gltf_pbr, as numbers, to a document with a node that has them."""

    def make(**inputs):
        terms = {name: Term.constant(value) for name, value in inputs.items()}
        return model_document(library.document, "gltf_pbr", terms)

    return make


@pytest.fixture
def material(make_document):
    """Function from BSDF nodes, the last of them called "top", to a document with a surface of it, called "s"."""

    def make(nodes, more=""):
        given = f'<input name="bsdf" type="BSDF" nodename="top" />{more}'
        return make_document(f'{nodes}<surface name="s" type="surfaceshader">{given}</surface>')

    return make


# Beads under a film: all that the fit has.
SHEETING = {
    "base_color": (0.5, 0.3, 0.1), "metallic": 0.0, "specular": 0.4, "specular_color": (6.0, 4.0, 3.0),
    "roughness": 0.2, "retroreflectivity": 1.0, "clearcoat": 1.0, "clearcoat_roughness": 0.3,
}  # fmt: skip
# Relative: numbers are rounded to four digits, and the sum of squares is settled to 1e-4 of itself, which near to zero
# is far below what two percent of a parameter would make.
CLOSE = 0.02


def reflectance(found):
    """That at normal incidence, of which the two inputs are a product."""
    return found["specular_color"].value * found["specular"].value


def test_a_surface_that_gltf_pbr_has_is_found(pbr):
    wanted = pbr(**SHEETING)
    found = nearest.nearest(wanted.getNode(MODEL), no_images)
    for name in ("base_color", "roughness", "clearcoat_roughness", "retroreflectivity"):
        np.testing.assert_allclose(found[name].value, np.atleast_1d(SHEETING[name]), rtol=CLOSE, err_msg=name)
    product = np.array(SHEETING["specular_color"]) * SHEETING["specular"]
    np.testing.assert_allclose(reflectance(found), product, rtol=CLOSE)


def test_the_same_surface_has_the_same_numbers(pbr):
    document = pbr(**SHEETING)
    first, second = (nearest.nearest(document.getNode(MODEL), no_images) for _ in range(2))
    assert {name: value.value.tolist() for name, value in first.items()} == {
        name: value.value.tolist() for name, value in second.items()
    }


MIX = """
<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value="0.5, 0.2, 0.1" />
</oren_nayar_diffuse_bsdf>
<conductor_bsdf name="mirrors" type="BSDF"><input name="roughness" type="vector2" value="0.01, 0.01" />
  <input name="retroreflective" type="boolean" value="{flag}" /></conductor_bsdf>
<mix name="top" type="BSDF"><input name="fg" type="BSDF" nodename="mirrors" />
  <input name="bg" type="BSDF" nodename="paint" /><input name="mix" type="float" value="0.1" /></mix>
"""


@pytest.mark.parametrize("flag", ["true", "false"])
def test_a_mixture_is_met_by_day_and_by_night(material, library, flag):
    document = material(MIX.format(flag=flag))
    found = nearest.nearest(document.getNode("s"), no_images)
    model = model_document(library.document, "gltf_pbr", found)
    before, after = (comparison.photometry(node, no_images) for node in (document.getNode("s"), model.getNode(MODEL)))
    # Within 2 % by day and 5 % by night: the share of the mixture and a layer differ toward grazing incidence alone.
    assert after.day == pytest.approx(before.day, rel=0.02)
    assert after.night == pytest.approx(before.night, rel=0.05)
    assert (before.night > 50.0) == (flag == "true")
    assert (found["retroreflectivity"].value[0] > 0.9) == (flag == "true")


def test_emission_and_opacity_are_not_taken_for_reflection(material):
    light = '<uniform_edf name="e" type="EDF"><input name="color" type="color3" value="3, 2, 1" /></uniform_edf>'
    inputs = '<input name="edf" type="EDF" nodename="e" /><input name="opacity" type="float" value="0.5" />'
    plain, other = material(MIX.format(flag="true")), material(MIX.format(flag="true") + light, inputs)
    expected = nearest.nearest(plain.getNode("s"), no_images)
    found = nearest.nearest(other.getNode("s"), no_images, alpha=0.5)
    np.testing.assert_allclose(found["emissive"].value, [3.0, 2.0, 1.0], rtol=1e-3)  # four digits
    np.testing.assert_allclose(reflectance(found), reflectance(expected), rtol=CLOSE)
    for name in ("base_color", "roughness", "retroreflectivity"):
        np.testing.assert_allclose(found[name].value, expected[name].value, rtol=CLOSE, err_msg=name)


def test_what_lets_light_through_or_is_black_is_refused(material):
    cases = {
        '<translucent_bsdf name="top" type="BSDF" />': "light through",
        '<oren_nayar_diffuse_bsdf name="top" type="BSDF"><input name="color" type="color3" value="0, 0, 0" />'
        "</oren_nayar_diffuse_bsdf>": "reflects nothing",
    }
    for nodes, words in cases.items():
        document = material(nodes)
        with pytest.raises(InexpressibleError, match=words):
            nearest.nearest(document.getNode("s"), no_images)


def test_directions_are_unit_above_the_surface_and_reach_the_peaks(rng):
    v, l = pairs(rng, 100)
    for directions in (v, l, *(w[None] for w in (*DAY, *NIGHT))):
        np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-12)
        assert np.all(directions[:, 2] >= 0.0)
    away = np.rad2deg(np.arccos(np.clip(np.sum(v[200:] * l[200:], axis=1), -1.0, 1.0)))
    mirrored = v[100:200] * [-1.0, -1.0, 1.0]
    aside = np.rad2deg(np.arccos(np.clip(np.sum(mirrored * l[100:200], axis=1), -1.0, 1.0)))
    for angles in (away, aside):
        assert angles.min() < 0.1
        assert angles.max() > 20.0


def test_a_wrong_parameter_is_seen_by_the_values(pbr):
    """That a fit which stops elsewhere would not pass for the nearest: 5 % of one parameter show."""
    images = no_images
    right = pbr(**SHEETING)
    for name in ("base_color", "roughness", "specular", "clearcoat_roughness"):
        wrong = pbr(**{**SHEETING, name: np.multiply(SHEETING[name], 1.05)})
        largest, _ = comparison.difference((right.getNode(MODEL), images), (wrong.getNode(MODEL), images))
        assert largest > CLOSE, name
