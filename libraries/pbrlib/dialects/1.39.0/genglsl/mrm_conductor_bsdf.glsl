#include "libraries/pbrlib/genglsl/mx_conductor_bsdf.glsl"
#include "lib/mrm_retroreflection.glsl"

// The standard functions, seen from V' where the lobe is retroreflective.
void mrm_conductor_bsdf_reflection(vec3 L, vec3 V, vec3 P, float occlusion, float weight, vec3 ior_n, vec3 ior_k, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, inout BSDF bsdf)
{
    mx_conductor_bsdf_reflection(L, mrm_mirror_view(V, N, retroreflective), P, occlusion, weight, ior_n, ior_k, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, bsdf);
}

void mrm_conductor_bsdf_indirect(vec3 V, float weight, vec3 ior_n, vec3 ior_k, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, inout BSDF bsdf)
{
    mx_conductor_bsdf_indirect(mrm_mirror_view(V, N, retroreflective), weight, ior_n, ior_k, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, bsdf);
}
