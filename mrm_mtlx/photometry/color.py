"""Luminance and chromaticity of linear Rec.709 colours under an illuminant.

R_A is photopic under illuminant A (ASTM E809), a document has colours for D65. Between them stands a spectrum that the
document does not have. Two answers, both linear in the colour, so that the sum of lobes has the sum of values:

* "spectral": the spectrum of Mallett and Yuksel 2019, a sum of three basis spectra, one per channel. It is a
  reflectance for every colour in the cube and gives exactly the colour asked for under D65.
* "rgb": the product of the colour with that of illuminant A, channel by channel, as a renderer does that lights the
  document with a warm lamp.

They agree on greys. For saturated colours the product is off: pure red has 0.392 instead of 0.326 of the luminance of
white, while the smooth spectra of other methods agree with the basis spectra within 2 % (docs/photometry.md).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

ILLUMINANTS = ("A", "D65")
METHODS = ("spectral", "rgb")

# Linear Rec.709 to XYZ, white D65 (ITU-R BT.709 primaries, x, y of D65 = 0.3127, 0.3290).
_REC709_TO_XYZ = np.array(
    [
        [0.4123907992659595, 0.3575843393838780, 0.1804807884018343],
        [0.2126390058715104, 0.7151686787677559, 0.0721923153607337],
        [0.0193308187155918, 0.1191947797946259, 0.9505321522496608],
    ]
)
# XYZ of illuminant A, of luminance 1: CIE 1931 observer, x, y = 0.44757, 0.40745.
_XYZ_OF_A = np.array([0.44757 / 0.40745, 1.0, (1.0 - 0.44757 - 0.40745) / 0.40745])
# XYZ under illuminant A of the three basis spectra of Mallett and Yuksel 2019, CIE 1931 observer, 380 to 780 nm every
# 5 nm, luminance of white 1. By colour-science, whose import takes seconds: a test makes them again.
_BASIS_UNDER_A = np.array(
    [
        [0.651078775448, 0.377388965376, 0.070022189850],
        [0.325573195166, 0.634248085632, 0.040178719091],
        [0.005633640365, 0.056222506897, 0.293968589059],
    ]
)


def to_xyz(illuminant: str = "A", method: str = "spectral") -> Array:
    """Matrix from linear Rec.709 colours to XYZ of what they are under an illuminant, shape (3, 3).

    White has Y = 1. There is no adaptation: white under A is as yellow as A.

    Raises
    ------
    ValueError
        If the illuminant is not one of `ILLUMINANTS` or the method not one of `METHODS`.
    """
    for value, allowed in ((illuminant, ILLUMINANTS), (method, METHODS)):
        if value not in allowed:
            msg = f"expected one of {', '.join(allowed)}, got {value!r}"
            raise ValueError(msg)
    if illuminant == "D65":
        return _REC709_TO_XYZ.copy()
    if method == "spectral":
        return np.asarray(_BASIS_UNDER_A / np.sum(_BASIS_UNDER_A[1]))  # the basis adds up to 1 within 1e-5
    return np.asarray(_REC709_TO_XYZ * np.linalg.solve(_REC709_TO_XYZ, _XYZ_OF_A))


def luminance_weights(illuminant: str = "A", method: str = "spectral") -> Array:
    """Luminance of the three channels under an illuminant, shape (3,); they sum to 1.

    Errors as `to_xyz`.

    Examples
    --------
    >>> luminance_weights().round(3).tolist(), luminance_weights("A", "rgb").round(3).tolist()
    ([0.326, 0.634, 0.04], [0.392, 0.591, 0.017])
    """
    return np.asarray(to_xyz(illuminant, method)[1])


def luminance(values: ArrayLike, illuminant: str = "A", method: str = "spectral") -> Array:
    """Photopic value of what is given per channel, (..., 3) -> (...). Errors as `to_xyz`."""
    return np.asarray(np.asarray(values, dtype=float) @ luminance_weights(illuminant, method))


def chromaticity(values: ArrayLike, illuminant: str = "A", method: str = "spectral") -> Array:
    """CIE 1931 x, y under an illuminant, (..., 3) -> (..., 2); NaN for black. Errors as `to_xyz`."""
    xyz = np.asarray(values, dtype=float) @ to_xyz(illuminant, method).T
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(xyz[..., :2] / np.sum(xyz, axis=-1)[..., None])
