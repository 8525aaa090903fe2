"""Photometry of retroreflection: from BRDFs and documents to the numbers that standards ask for.

* `goniometer`: observation and entrance angles to directions, and back.
* `coefficients`: R_A, R_L and the retroreflected fraction of any BRDF, with apertures.
* `color`: luminance and chromaticity under illuminants A and D65.
* `documents`: a document's surface as a BRDF.
* `standards`: the minima and colour boxes that were read, with their sources.

Angles are in radians, those of the standards in degrees as their names say. CIE writes alpha for the observation angle;
here alpha is the microfacet width alone.
"""

from mrm_mtlx.photometry.coefficients import coefficient, r_l, retroreflected_fraction
from mrm_mtlx.photometry.color import chromaticity, luminance, luminance_weights
from mrm_mtlx.photometry.documents import document_brdf, surface_brdf
from mrm_mtlx.photometry.goniometer import angles, directions
from mrm_mtlx.photometry.standards import Box, Limit, boxes, limits, standards

__all__ = [
    "Box",
    "Limit",
    "angles",
    "boxes",
    "chromaticity",
    "coefficient",
    "directions",
    "document_brdf",
    "limits",
    "luminance",
    "luminance_weights",
    "r_l",
    "retroreflected_fraction",
    "standards",
    "surface_brdf",
]
