"""Which numbers a version of MaterialX has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.bsdf import GeneralizedSchlick
from mrm_mtlx.library import dialects
from mrm_mtlx.reference import Surface, versions
from mrm_mtlx.reference.closures import Light, Mode, sheen
from mrm_mtlx.reference.closures.light import Environment
from mrm_mtlx.reference.versions import NUMBERS
from mrm_mtlx.reference.versions.fits import FibreAlbedo, MicrofacetAlbedo


def test_the_installed_materialx_has_numbers_of_its_own_or_of_the_version_before_it():
    assert versions.installed() is NUMBERS["1.39.5"]
    assert dialects.entry(NUMBERS, "1.40.0") is NUMBERS["1.39.5"]
    with pytest.raises(LookupError, match=r"^MaterialX 1\.39\.4 is older than 1\.39\.5, the first version"):
        dialects.entry(NUMBERS, "1.39.4")


def test_a_closure_has_the_numbers_of_its_light(polar):
    v = polar(0.5)[:, None]
    around = Environment.constant((1.0, 1.0, 1.0))
    half = replace(versions.installed(), fibre_albedo=FibreAlbedo((0.5, 0, 0, 0, 0, 0), (1.0, 0, 0, 0, 0, 0)))
    light = Light(v, v, mode=Mode.INDIRECT, environment=around, numbers=half)
    one, normal = v[0] ** 0, polar(0.0)[:, None]
    assert sheen(light, "conty_kulla", one, v**0, 0.3 * one, normal).throughput == pytest.approx(0.5)
    other = replace(light, numbers=versions.installed())
    assert sheen(other, "conty_kulla", one, v**0, 0.3 * one, normal).throughput != pytest.approx(0.5, abs=0.1)


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
