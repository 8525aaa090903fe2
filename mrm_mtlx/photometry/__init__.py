"""Photometry of retroreflection: from BRDFs and documents to the numbers that standards ask for.

* `goniometer`: observation and entrance angles to directions, and back.
* `coefficients`: R_A, R_L and the retroreflected fraction of any BRDF, with apertures.
* `color`: luminance and chromaticity under illuminants A and D65.
* `documents`: a document's surface as a BRDF.

Angles are in radians, those of the standards in degrees as their names say. CIE writes alpha for the observation angle;
here alpha is the microfacet width alone.
"""

from mrm_mtlx.photometry.coefficients import coefficient, r_l, retroreflected_fraction
from mrm_mtlx.photometry.color import chromaticity, luminance, luminance_weights
from mrm_mtlx.photometry.documents import document_brdf, surface_brdf
from mrm_mtlx.photometry.goniometer import angles, directions

__all__ = [
    "angles",
    "chromaticity",
    "coefficient",
    "directions",
    "document_brdf",
    "luminance",
    "luminance_weights",
    "r_l",
    "retroreflected_fraction",
    "surface_brdf",
]
