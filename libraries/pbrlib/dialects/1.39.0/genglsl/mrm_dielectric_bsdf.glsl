#include "libraries/pbrlib/genglsl/mx_dielectric_bsdf.glsl"
#include "lib/mrm_retroreflection.glsl"

// The standard functions, seen from V' where the lobe is retroreflective; transmission is as it is.
void mrm_dielectric_bsdf_reflection(vec3 L, vec3 V, vec3 P, float occlusion, float weight, vec3 tint, float ior, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, int scatter_mode, inout BSDF bsdf)
{
    mx_dielectric_bsdf_reflection(L, mrm_mirror_view(V, N, retroreflective), P, occlusion, weight, tint, ior, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, scatter_mode, bsdf);
}

void mrm_dielectric_bsdf_transmission(vec3 V, float weight, vec3 tint, float ior, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, int scatter_mode, inout BSDF bsdf)
{
    mx_dielectric_bsdf_transmission(V, weight, tint, ior, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, scatter_mode, bsdf);
}

void mrm_dielectric_bsdf_indirect(vec3 V, float weight, vec3 tint, float ior, vec2 roughness, bool retroreflective, float thinfilm_thickness, float thinfilm_ior, vec3 N, vec3 X, int distribution, int scatter_mode, inout BSDF bsdf)
{
    mx_dielectric_bsdf_indirect(mrm_mirror_view(V, N, retroreflective), weight, tint, ior, roughness, thinfilm_thickness, thinfilm_ior, N, X, distribution, scatter_mode, bsdf);
}
