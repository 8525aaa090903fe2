"""What standards measure of a surface, by the formulas of a diffuser and by photometry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.formats.pbr import comparison
from mrm_mtlx.photometry import coefficients, color, documents

MATERIALS = Path(__file__).parents[3] / "materials"
DIFFUSER = """
<oren_nayar_diffuse_bsdf name="b" type="BSDF"><input name="color" type="color3" value="0.5, 0.5, 0.5" />
</oren_nayar_diffuse_bsdf>
<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b" /></surface>
"""


def no_images(_name):
    return None


def test_a_diffuser_has_its_colour_by_day_and_returns_what_its_formula_says(make_document):
    document = make_document(DIFFUSER)
    found = comparison.photometry(document.getNode("s"), no_images)
    # The weights of white are 1 to the digits of the tables of the illuminants.
    assert found.day == pytest.approx(0.5, rel=1e-3)
    # f cos(beta) cos(nu) with f = 0.5 / pi, at 4 and 4.2 degrees from the normal.
    expected = 0.5 / np.pi * np.cos(np.deg2rad(4.0)) * np.cos(np.deg2rad(4.2))
    assert found.night == pytest.approx(expected, rel=1e-3)


def test_sheeting_is_measured_as_photometry_does(make_document):
    text = (MATERIALS / "conspicuity_tape_red.mtlx").read_text(encoding="utf-8")
    document = make_document(
        text[text.index("<nodegraph") : text.index("</materialx>")], attributes='colorspace="lin_rec709"'
    )
    element = document.getMaterialNodes()[0]
    brdf = documents.document_brdf(element)
    expected = color.luminance(coefficients.coefficient(brdf, np.deg2rad(0.2), np.deg2rad(-4.0)), "A")
    # The same function of the same directions, in another order.
    assert comparison.photometry(element, no_images).night == pytest.approx(float(expected), rel=1e-9)


def test_a_night_that_returns_nothing_is_not_told():
    words = comparison.told((0.5, 0.25), comparison.Photometry(0.4, 0.15), comparison.Photometry(0.3, 0.12))
    assert words == (
        "its values differ by up to 50 %, 25 % in the mean; by day (45:0) it reflects 0.3 instead of 0.4 of the light"
    )
    words = comparison.told((0.5, 0.25), comparison.Photometry(0.4, 90.0), comparison.Photometry(0.3, 0.12))
    assert words.endswith(", by night its R_A (0.2, -4 degrees) is 0.12 instead of 90 cd/lx/m2")
