#include "libraries/pbrlib/genglsl/mx_dielectric_bsdf.glsl"
#include "lib/mrm_retroreflection.glsl"

// The standard function, seen from V' where the lobe is retroreflective.
void mrm_dielectric_bsdf(ClosureData closureData, float weight, vec3 tint, float ior, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, int scatter_mode, inout BSDF bsdf)
{
    ClosureData mirrored = mrm_mirror_view(closureData, N, retroreflective);
    mx_dielectric_bsdf(mirrored, weight, tint, ior, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, scatter_mode, bsdf);
}
