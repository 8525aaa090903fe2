"""Measured BRDFs and coefficients: readers of the formats they come in.

Angles are in radians, values in 1/sr without the cosine, as everywhere in the package; what a file has otherwise is
converted by its reader.
"""

from mrm_mtlx.measured.alta import read_alta
from mrm_mtlx.measured.any_format import read
from mrm_mtlx.measured.measurement import Coefficient, CoefficientSamples, Measurement
from mrm_mtlx.measured.merl import read_merl
from mrm_mtlx.measured.table import read_table

__all__ = ["Coefficient", "CoefficientSamples", "Measurement", "read", "read_alta", "read_merl", "read_table"]
