"""The oracle of documents: evaluates a MaterialX surface in float64, as MaterialX's closures define it.

Built on the pure optics of `mrm_mtlx.bsdf`; what MaterialX does on top of them is here and nowhere else:

* `closures`: clamps, masking with the mean width, energy compensation, the cosine, weights, throughput of layers.
* `nodes`: one function per node definition.
* `surface`: walks the document's graph.
* `rounding`, `precision`: how far float32 arithmetic may move a result, from which every tolerance is derived.

`response(v, l)` includes the cosine of l.
"""

from mrm_mtlx.reference.closures import Model
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.rounding import ROUNDING_FACTOR, Tolerance
from mrm_mtlx.reference.surface import Surface, UnsupportedError, constant_input

__all__ = ["ROUNDING_FACTOR", "Model", "ShadingPoints", "Surface", "Tolerance", "UnsupportedError", "constant_input"]
