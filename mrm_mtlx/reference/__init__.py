"""The oracle of documents: evaluates a MaterialX surface in float64, as MaterialX's closures define it.

Built on the pure optics of `mrm_mtlx.bsdf`; what MaterialX does on top of them is here and nowhere else:

* `closures`: response and throughput of each BSDF in three modes: clamps, masking with the mean width, energy
  compensation, the cosine, weights, layers.
* `nodes`: one function per node definition.
* `evaluation`: walks the document's graph (`graph`) for many samples; `survey` says beforehand what is unknown.
* `surface`: a renderable element, ready to be evaluated.
* `rounding`, `precision`: how far float32 arithmetic may move a result, from which every tolerance is derived.

`response(v, l)` includes the cosine of l.
"""

from mrm_mtlx.reference.closures import Environment, Model
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, Tolerance
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.state import Illumination
from mrm_mtlx.reference.surface import Surface, constant_input, input_at, narrowest_width
from mrm_mtlx.reference.survey import UnsupportedError

__all__ = [
    "ROUNDING_FACTOR",
    "Environment",
    "Illumination",
    "Model",
    "ShadingPoints",
    "Surface",
    "Tolerance",
    "UnsupportedError",
    "constant_input",
    "input_at",
    "narrowest_width",
]
