"""The numbers of MaterialX 1.39.5.

In `libraries/pbrlib/genglsl/lib`: mx_microfacet_specular.glsl, mx_microfacet_sheen.glsl, mx_microfacet_diffuse.glsl.
"""

import numpy as np

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.versions.combination import SPECIFIED
from mrm_mtlx.reference.versions.fits import BurleyAlbedo, ClothCosine, FibreAlbedo, MicrofacetAlbedo, OrenNayarAlbedo
from mrm_mtlx.reference.versions.fresnel_average import of_the_facet
from mrm_mtlx.reference.versions.numbers import Numbers

# Deviations that earlier versions have.
MENDED = frozenset(
    {
        Deviation.MEDIUMP_FLOATS,
        Deviation.COMBINED_THROUGHPUT,
        Deviation.IGNORED_MEDIA,
        Deviation.VERTICAL_RAMPS,
        Deviation.HSV_ALPHA,
        Deviation.HEXTILE_ALPHA,
        Deviation.BLACK_BOOLEANS,
        Deviation.MATRIX_PRODUCTS,
        Deviation.UNDECLARED_BLOCK,
    }
)

NUMBERS = Numbers(
    microfacet_albedo=MicrofacetAlbedo(
        factors_above=(
            (0.1003, -0.6303, 9.748, -2.038, 29.34, -8.245, -26.44, 19.99, -5.448),
            (0.9345, -2.323, 2.229, -3.748, 1.424, -0.7684, 1.436, 0.2913, 0.6286),
        ),
        factors_below=(
            (1.0, -1.765, 8.263, 11.53, 28.96, -7.507, -36.11, 15.86, 33.37),
            (1.0, 0.2281, 15.94, -55.83, 13.08, 41.26, 54.9, 300.2, -285.1),
        ),
    ),
    fibre_albedo=FibreAlbedo(
        above=(13.67300, -68.78018, 799.08825, -905.00061, 60.28956, 1086.96473),
        below=(1.0, 61.57746, 442.78211, 2597.49308, 121.81241, 3045.55075),
    ),
    cloth_cosine=ClothCosine(
        scale_above=(2.58126, 0.813703),
        scale_below=(0.310327, 2.60994),
        shear_below=(0.0000254053, 1.71228, -1.71506, 1.34174),
        width_above=(0.0206607, 1.58491),
        width_below=(0.0379424, 1.32227),
        mean_above=(-0.193854, -1.14885, 1.7932, 0.0, -0.95943),
        mean_below=(0.046391, 1.0),
        offset_above=(0.000654023, -0.0207818, 0.119681),
        offset_below=(1.26264, -1.92021, 1.0),
    ),
    oren_nayar_albedo=OrenNayarAlbedo(above=(-0.4297, -0.7632, 1.4385), below=(-0.6076, -0.4993, 2.0315)),
    # A curve fit by Stephen Hill.
    burley_albedo=BurleyAlbedo(smooth=(0.97619, -0.488095), rough=(1.55754, -2.02221, 2.56283, -1.06244)),
    mean_reflectance=of_the_facet,
    throughputs=SPECIFIED,
    hair_rest_azimuthal=0.5 * np.pi,  # written 1.0 / 2.0 * pi
    blackbody_lowest=800.0,
    deviations=frozenset(Deviation) - MENDED,
)
