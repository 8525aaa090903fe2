"""Luminance and chromaticity under the illuminants, and what the spectra behind them are."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from mrm_mtlx.photometry import chromaticity, luminance, luminance_weights
from mrm_mtlx.photometry.color import to_xyz
from mrm_mtlx.standards import boxes

# Absolute: the digits of the constants; the basis adds up to 1 within 1e-5, in luminance within 1.1e-10.
DIGITS = 5e-10
# x, y of the illuminants, and of D65 as Rec.709 has it, to the digits printed.
WHITES = {"A": (0.44757, 0.40745), "D65": (0.3127, 0.3290)}

COMPUTE = """
import warnings
warnings.simplefilter("ignore")
import colour, json
from colour.recovery import MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019 as basis
shape = colour.SpectralShape(380, 780, 5)
light = colour.SDS_ILLUMINANTS["A"].copy().align(shape).values
observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
basis = basis.copy().align(shape).values
scale = (light * observer[:, 1]).sum()
print(json.dumps(((light[:, None] * observer).T @ basis / scale).tolist()))
"""


def test_the_spectral_constants_are_those_of_the_library():
    found = subprocess.run([sys.executable, "-c", COMPUTE], capture_output=True, text=True, check=False)
    if "ModuleNotFoundError" in found.stderr:
        pytest.skip("colour-science is not installed; pip install colour-science")
    assert found.returncode == 0, found.stderr
    expected = np.array(json.loads(found.stdout))
    np.testing.assert_allclose(to_xyz("A", "spectral"), expected, rtol=0.0, atol=DIGITS)


@pytest.mark.parametrize("method", ["spectral", "rgb"])
@pytest.mark.parametrize("illuminant", WHITES)
def test_white_has_the_luminance_1_and_the_colour_of_the_light(illuminant, method):
    assert luminance(np.ones(3), illuminant, method) == pytest.approx(1.0, abs=1e-15)  # three roundings
    found = chromaticity(np.ones(3), illuminant, method)
    # The last printed digit of x and y.
    np.testing.assert_allclose(found, WHITES[illuminant], rtol=0.0, atol=5e-5)


def test_the_product_has_the_weights_that_were_derived():
    np.testing.assert_allclose(luminance_weights("A", "rgb"), [0.392, 0.591, 0.017], rtol=0.0, atol=5e-4)
    np.testing.assert_allclose(luminance_weights("D65"), [0.2126, 0.7152, 0.0722], rtol=0.0, atol=5e-5)


def test_the_weights_of_daylight_would_be_seen():
    """By a red and a blue: red gains under A, blue loses."""
    for method in ("spectral", "rgb"):
        ratio = luminance_weights("A", method) / luminance_weights("D65")
        assert ratio[0] > 1.5
        assert ratio[2] < 0.6


def test_the_spectral_answer_is_that_of_smooth_spectra():
    """Of Jakob and Hanika 2019 by colour-science 0.4.7, under A: luminance of a red, a blue, and a yellow."""
    rgb = np.array([[0.9, 0.05, 0.03], [0.02, 0.05, 0.6], [0.8, 0.6, 0.02]])
    smooth = np.array([0.3282, 0.0614, 0.6441])
    # Two methods that share no step: what a spectrum of given colour leaves open, here 1.5 %.
    np.testing.assert_allclose(luminance(rgb), smooth, rtol=0.02)
    assert np.max(np.abs(luminance(rgb, "A", "rgb") / smooth - 1.0)) > 0.15


def test_whites_lie_in_the_white_boxes_of_their_light():
    """A itself in those of the night, D65 in those of the day."""
    for box in boxes():
        if box.colour == "white":
            inside = {name: box.margin(*white) > 0.0 for name, white in WHITES.items()}
            assert inside == {"A": box.illuminant == "A", "D65": box.illuminant == "D65"}


@pytest.mark.parametrize(("illuminant", "method"), [("C", "rgb"), ("A", "smits")])
def test_an_unknown_light_or_method_is_refused(illuminant, method):
    with pytest.raises(ValueError, match="expected one of"):
        to_xyz(illuminant, method)


def test_black_has_no_colour():
    assert np.all(np.isnan(chromaticity(np.zeros(3))))
