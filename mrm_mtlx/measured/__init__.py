"""Measured BRDFs: readers of the formats they come in.

Angles are in radians, values in 1/sr without the cosine, as everywhere in the package; what a file has otherwise is
converted by its reader.
"""

from mrm_mtlx.measured.alta import read_alta
from mrm_mtlx.measured.measurement import Measurement

__all__ = ["Measurement", "read_alta"]
