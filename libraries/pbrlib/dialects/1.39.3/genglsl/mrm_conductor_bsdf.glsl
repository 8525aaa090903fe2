#include "libraries/pbrlib/genglsl/mx_conductor_bsdf.glsl"
#include "lib/mrm_retroreflection.glsl"

// The standard function, seen from V' where the lobe is retroreflective.
void mrm_conductor_bsdf(ClosureData closureData, float weight, vec3 ior_n, vec3 ior_k, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, inout BSDF bsdf)
{
    ClosureData mirrored = mrm_mirror_view(closureData, N, retroreflective);
    mx_conductor_bsdf(mirrored, weight, ior_n, ior_k, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, bsdf);
}
