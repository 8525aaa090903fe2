#include "libraries/pbrlib/genglsl/mx_generalized_schlick_bsdf.glsl"
#include "lib/mrm_retroreflection.glsl"

// The standard function, seen from V' where the lobe is retroreflective.
void mrm_generalized_schlick_bsdf(ClosureData closureData, float weight, vec3 color0, vec3 color82, vec3 color90, float exponent, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, int scatter_mode, inout BSDF bsdf)
{
    ClosureData mirrored = mrm_mirror_view(closureData, N, retroreflective);
    mx_generalized_schlick_bsdf(mirrored, weight, color0, color82, color90, exponent, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, scatter_mode, bsdf);
}
