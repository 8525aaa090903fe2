"""Which numbers a version of MaterialX has."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mrm_mtlx.library import dialects
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.closures import Light, Mode, sheen
from mrm_mtlx.reference.closures.light import Environment
from mrm_mtlx.reference.versions import NUMBERS
from mrm_mtlx.reference.versions.fits import FibreAlbedo


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
