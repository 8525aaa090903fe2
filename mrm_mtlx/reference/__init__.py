"""The oracle of documents: evaluates a MaterialX surface in float64, as MaterialX's closures define it.

Built on the pure optics of `mrm_mtlx.bsdf`; what MaterialX does on top of them is here and nowhere else. From the top:

* `surface`: a renderable element of a document, ready to be evaluated at `points`; `display` makes its value a colour.
  `survey` says beforehand what of the graph is unknown, `coverage` of a whole library. `probing` gives single inputs.
* `evaluation`: the walk over a document's graph for many samples. `state` has what it has met so far, `sharing` the
  values that a perturbed evaluation takes from the exact one, `node_inputs` a node as its function sees it.
* `nodes`: one function per node definition that MaterialX implements in source; `textures` are what some look up.
* `closures`: response and throughput of each BSDF in three modes: clamps, masking with the mean width, energy
  compensation, the cosine, weights, layers.
* `float32`: how float32 arithmetic may change a result, from which every tolerance is derived.
* `versions`: numbers of MaterialX's shaders, by version. `models`: the two families of targets, and what they have in
  different ways. `deviations`: where MaterialX's code is known to differ from its specification.

`response(v, l)` includes the cosine of l.
"""

from mrm_mtlx.reference.closures import Environment, Model
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, Tolerance
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.probing import constant_input, input_at, narrowest_width
from mrm_mtlx.reference.state import Illumination
from mrm_mtlx.reference.surface import Surface
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
