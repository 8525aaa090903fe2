"""Which numbers a version of MaterialX has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import dialects
from mrm_mtlx.reference import Surface, versions
from mrm_mtlx.reference.closures import Light, Mode, sheen
from mrm_mtlx.reference.closures.light import Environment
from mrm_mtlx.reference.versions import NUMBERS
from mrm_mtlx.reference.versions.fits import FibreAlbedo, MicrofacetAlbedo
from mrm_mtlx.reference.versions.fresnel_average import of_schlick, of_the_facet
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.sampling import generator


def test_the_installed_materialx_has_numbers_of_its_own_or_of_the_version_before_it():
    assert versions.installed() is dialects.entry(NUMBERS, dialects.materialx_version())
    assert dialects.entry(NUMBERS, "1.39.2") is NUMBERS["1.39.0"]
    assert dialects.entry(NUMBERS, "1.40.0") is NUMBERS["1.39.6"]
    with pytest.raises(LookupError, match=r"^MaterialX 1\.38\.10 is older than 1\.39\.0, the first version"):
        dialects.entry(NUMBERS, "1.38.10")


def test_a_closure_has_the_numbers_of_its_light(polar):
    v = polar(0.5)[:, None]
    around = Environment.constant((1.0, 1.0, 1.0))
    half = replace(versions.installed(), fibre_albedo=FibreAlbedo((0.5, 0, 0, 0, 0, 0), (1.0, 0, 0, 0, 0, 0)))
    light = Light(v, v, mode=Mode.INDIRECT, environment=around, numbers=half)
    one, normal = v[0] ** 0, polar(0.0)[:, None]
    assert sheen(light, "conty_kulla", one, v**0, 0.3 * one, normal).throughput == pytest.approx(0.5)
    other = replace(light, numbers=versions.installed())
    assert sheen(other, "conty_kulla", one, v**0, 0.3 * one, normal).throughput != pytest.approx(0.5, abs=0.1)


GLOWING = """
  <blackbody name="glow" type="color3"><input name="temperature" type="float" value="1200"/></blackbody>
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="glow"/>
  </oren_nayar_diffuse_bsdf>
"""
ROUGH_METAL = """
  <conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.5, 0.5"/></conductor_bsdf>
"""


OTHER_FORMS = {
    "the energy compensation": (ROUGH_METAL, "mean_reflectance", {of_the_facet: of_schlick, of_schlick: of_the_facet}),
    "the lowest temperature": (GLOWING, "blackbody_lowest", {800.0: 1667.0, 1667.0: 800.0}),
}


@pytest.fixture
def with_numbers(monkeypatch):
    """Function that gives the reference these numbers, whatever MaterialX is installed."""

    def give(numbers):
        for version in NUMBERS:
            monkeypatch.setitem(NUMBERS, version, numbers)
        versions.installed.cache_clear()

    yield give
    monkeypatch.undo()
    versions.installed.cache_clear()


@pytest.mark.parametrize("form", OTHER_FORMS)
def test_a_form_of_another_version_is_not_that_of_the_installed_shaders(
    gl, surface_document, library, with_numbers, form
):
    own = versions.installed()
    nodes, name, others = OTHER_FORMS[form]
    document = surface_document(nodes)
    element = document.getNode("m")
    for numbers, is_right in ((own, True), (replace(own, **{name: others[getattr(own, name)]}), False)):
        with_numbers(numbers)
        expectation = Expectation(element, generator(0, "form"), 512, lambda _name: None)
        with SurfaceProgram(generate(element, "glsl", library)) as program:
            found = expectation.compare(expectation.draw(program))
        assert found.comparison.passed is is_right


# A version whose lobes lose nothing: A is 1 and B is 0, whatever the angle and the width.
ONE, ZERO = (1.0, *[0.0] * 8), (0.0,) * 9
LOSSLESS = MicrofacetAlbedo((ONE, ZERO), (ONE, ONE))


@pytest.fixture
def toy_version(monkeypatch):
    """A MaterialX that comes after the installed one, with an entry of its own."""
    toy = replace(versions.installed(), microfacet_albedo=LOSSLESS)
    monkeypatch.setitem(NUMBERS, "1.39.99", toy)
    monkeypatch.setattr(dialects, "materialx_version", lambda: "1.39.99")
    versions.installed.cache_clear()
    yield toy
    versions.installed.cache_clear()


def compensated(surface_document, flat_points, polar) -> tuple[np.ndarray, np.ndarray]:
    """Response of a rough surface as the installed numbers have it, and that of the lobe that is scattered once."""
    width = '<input name="roughness" type="vector2" value="0.5, 0.5"/>'
    document = surface_document(f'<generalized_schlick_bsdf name="bsdf" type="BSDF">{width}</generalized_schlick_bsdf>')
    v, l = polar(np.array([0.3, 0.9])), polar(np.array([0.6, 0.2]), 1.0)
    single = GeneralizedSchlick(1.0, alpha=(0.5, 0.5)).eval(v, l) * l[:, 2:]
    return Surface(document.getNode("m")).response(flat_points(v, l)), single


def test_a_version_is_an_entry(toy_version, surface_document, flat_points, polar):
    assert versions.installed() is toy_version
    response, single = compensated(surface_document, flat_points, polar)
    np.testing.assert_allclose(response, single, rtol=1e-12)


def test_without_the_entry_the_numbers_are_the_installed_ones(surface_document, flat_points, polar):
    response, single = compensated(surface_document, flat_points, polar)
    assert np.all(response > 1.05 * single)


def test_the_mean_of_schlicks_curve_is_that_over_the_hemisphere():
    f0, f90 = np.array([0.04, 0.5, 0.9]), np.array([1.0, 0.2, 1.0])
    cosine, weight = np.polynomial.legendre.leggauss(8)  # exact to the degree 15
    cosine = 0.5 * (cosine[:, None] + 1.0)
    curve = f0 + (f90 - f0) * (1.0 - cosine) ** 5
    np.testing.assert_allclose(of_schlick(curve, lambda: f0, f90), weight @ (curve * cosine), rtol=1e-13)


def test_a_sum_of_two_lobes_lets_through_what_each_version_says():
    t1, t2 = np.array(0.91), np.array(0.944)
    through = {version: NUMBERS[version].throughputs.added(t1, t2) for version in ("1.39.0", "1.39.3", "1.39.4")}
    assert through == pytest.approx({"1.39.0": 0.91 * 0.944, "1.39.3": 1.854, "1.39.4": 0.854})
    # The two lobes of silver high-visibility tape: what lies below is 0.6 % too bright before 1.39.3.
    assert through["1.39.0"] / through["1.39.4"] == pytest.approx(1.0059, abs=1e-4)
