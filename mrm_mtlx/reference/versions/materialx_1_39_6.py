"""What MaterialX after 1.39.5 has otherwise, as read on its main branch of 2026-07-01.

In `libraries/pbrlib/genglsl`: `mx_fresnel_average` of lib/mx_microfacet_specular.glsl, which energy compensation takes
in all modes; the rest lobe of mx_chiang_hair_bsdf.glsl has its constant, while the division by pi is still there.
"""

from dataclasses import replace

import numpy as np

from mrm_mtlx.reference.versions import materialx_1_39_5
from mrm_mtlx.reference.versions.fresnel_average import of_schlick

NUMBERS = replace(materialx_1_39_5.NUMBERS, mean_reflectance=of_schlick, hair_rest_azimuthal=0.5 / np.pi)
