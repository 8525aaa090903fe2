// The view direction as a retroreflective lobe has to see it: V is replaced by V' = 2 (N.V) N - V.
// Ref: Portsmouth et al. 2026 (MRM), eq. 3 and Listing 1. Oracle: mrm_mtlx.bsdf.vectors.mirror
// For reflection and indirect light only: the standards keep the classic BTDF (MRM, section 5), since a retroreflective
// one would bend the background even at an index of refraction of 1.
vec3 mrm_mirror_view(vec3 V, vec3 N, bool retroreflective)
{
    return retroreflective ? reflect(-V, N) : V;
}
