"""The optics of retroreflective microfacet materials, in float64 NumPy and nothing else.

Conventions, for the whole project
----------------------------------
* Directions are unit vectors that point away from the surface: `v` to the viewer, `l` to the light, `n` the normal.
  Lobes refuse a length that is not 1 to within a thousandth (`vectors.UNIT`); the zero vector is a sample that is lost.
* The local frame has z = n and x = tangent; its arrays have shape `(..., 3)`.
* Angles are in radians; the command line converts from degrees.
* `alpha` is the microfacet width, `roughness` an artist's value; `alpha = roughness**2`. What a MaterialX BSDF node
  calls `roughness` is already `alpha`.
* `eval(v, l)` returns the BSDF in 1/sr, without the cosine of l. The reference's `response(v, l)` includes that cosine,
  as MaterialX's closures do.
* `h` is the half-vector of v and l; `v' = mirror(v)` is v mirrored about n; `b`, the half-vector of v' and l, is the
  back-vector. A retroreflective lobe is the ordinary lobe seen from v' (Portsmouth et al. 2026, eq. 3 and 10).
* Parameters broadcast with the samples: a scalar parameter is a scalar or an array of the samples' shape `(...)`, a
  colour a scalar, a triple, or an array `(..., 3)`.
* A lobe has `eval(v, l)`, `pdf(v, l)`, `sample(v, u)` and `albedo(v)`, see `lobe.Lobe`. Transmission is that of
  radiance, with the factor (eta_v / eta_l)^2 (Walter et al. 2007, eq. 21; Portsmouth et al. 2026, eq. 2); `albedo`
  counts energy.

The pieces are plain functions: distributions of facets (`ggx`, `beckmann`, `phong`, over `slopes`), `masking`, Fresnel
terms (`fresnel`, `thin_film`, `reflectance`), `diffuse`, `sheen`, `hair`, `subsurface` and `vectors`. `microfacet`
composes facets, `microfacet_lobe` sees them from v or v', `lobes` and `diffuse_lobes` are the public BSDFs, `blend`
mixes them, `quadrature` integrates.
`prismatic` and `sheeting` have cube corners. `compensation` gives back what single scattering loses, by an albedo that
the caller has; `intermediates` is where an analysis of another precision gets in.

This is the physics as the papers have it; a film ends its series where MaterialX does (`thin_film`). Whatever else its
shaders do differently (mean-width masking, clamps, closure arithmetic, fits) is in `mrm_mtlx.reference`, which is built
on these pieces.
"""

from mrm_mtlx.bsdf.blend import Blend, environment_radiance, partially_retroreflective
from mrm_mtlx.bsdf.diffuse_lobes import EON, Lambert
from mrm_mtlx.bsdf.lobe import Lobe
from mrm_mtlx.bsdf.lobes import Conductor, Dielectric, GeneralizedSchlick
from mrm_mtlx.bsdf.sheeting import PrismaticSheeting
from mrm_mtlx.bsdf.vectors import back_vector, half_vector, mirror

__all__ = [
    "EON",
    "Blend",
    "Conductor",
    "Dielectric",
    "GeneralizedSchlick",
    "Lambert",
    "Lobe",
    "PrismaticSheeting",
    "back_vector",
    "environment_radiance",
    "half_vector",
    "mirror",
    "partially_retroreflective",
]
