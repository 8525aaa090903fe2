"""MaterialX's closures: what its hardware shaders compute, built on the optics of `mrm_mtlx.bsdf`.

Everything that MaterialX 1.39.5 does and the papers do not say is in this package:

* a closure is a pair (response, throughput); the response to a light has the cosine of l, which cancels against
  1 / (4 n.v n.l);
* alpha is clamped to [1e-8, 1], n.v, n.l and v.m to [1e-8, 1]; light from below is not cut off, only clamped;
* masking and energy compensation use the mean width sqrt(alpha_x alpha_y), D both widths;
* colours are clamped from below at 0; a weight under 1e-8 switches a lobe off;
* BSDFs are evaluated in three modes (`light.Mode`), whose results are added.

A quantity that `light.perturbs` is taken at the edge of the error that float32 gives it (`float32.precision`).

Arrays: directions, colours and frames have the component first, shape (3, samples); scalars (samples,) or ().
"""

from mrm_mtlx.reference.closures.combine import add, layer, layer_medium, mix, multiply, premultiplied_mix
from mrm_mtlx.reference.closures.diffuse import burley, oren_nayar, subsurface, translucent
from mrm_mtlx.reference.closures.hair import Fibre, chiang_hair
from mrm_mtlx.reference.closures.light import EPSILON, Closure, Environment, Light, Mode, nothing, opaque
from mrm_mtlx.reference.closures.medium import absorbing
from mrm_mtlx.reference.closures.microfacet import Facets, conductor, dielectric, generalized_schlick
from mrm_mtlx.reference.closures.sheen import sheen
from mrm_mtlx.reference.models import Model

__all__ = [
    "EPSILON",
    "Closure",
    "Environment",
    "Facets",
    "Fibre",
    "Light",
    "Mode",
    "Model",
    "absorbing",
    "add",
    "burley",
    "chiang_hair",
    "conductor",
    "dielectric",
    "generalized_schlick",
    "layer",
    "layer_medium",
    "mix",
    "multiply",
    "nothing",
    "opaque",
    "oren_nayar",
    "premultiplied_mix",
    "sheen",
    "subsurface",
    "translucent",
]
