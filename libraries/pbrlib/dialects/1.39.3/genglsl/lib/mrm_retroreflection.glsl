#include "libraries/pbrlib/genglsl/lib/mx_closure_type.glsl"

// Closure data as a retroreflective lobe has to see it: the view direction V is replaced by V' = 2 (N.V) N - V.
// Ref: Portsmouth et al. 2026 (MRM), eq. 3 and Listing 1. Oracle: mrm_mtlx.bsdf.vectors.mirror
// Reflection and indirect light only: the standards keep the classic BTDF (MRM, section 5), since a retroreflective
// one would bend the background even at an index of refraction of 1.
ClosureData mrm_mirror_view(ClosureData closureData, vec3 N, bool retroreflective)
{
    bool reflects = closureData.closureType == CLOSURE_TYPE_REFLECTION || closureData.closureType == CLOSURE_TYPE_INDIRECT;
    ClosureData mirrored = closureData;
    if (retroreflective && reflects)
        mirrored.V = reflect(-closureData.V, N);
    return mirrored;
}
