"""What MaterialX from 1.39.0 to 1.39.4 has otherwise than 1.39.5; the fits are the same.

To 1.39.2 the generators write the throughputs (`ClosureAddNode` and others of MaterialXGenShader); from 1.39.3 on they
are functions of `libraries/pbrlib/genglsl` (mx_add_bsdf.glsl and others), of which 1.39.4 has mended all but that of a
medium (mx_layer_vdf.glsl). mx_anisotropic_vdf.glsl does nothing in any of them. Not followed is 1.39.0 in environments,
where a facet refracts 1 - F G and a generalised Schlick interface tints what it refracts by color0.
"""

from dataclasses import replace

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.versions import materialx_1_39_5
from mrm_mtlx.reference.versions.combination import SPECIFIED, Throughputs, product, total

NUMBERS_1_39_0 = replace(
    materialx_1_39_5.NUMBERS,
    throughputs=Throughputs(added=product, multiplied=product, layered=product, over_medium=product),
    blackbody_lowest=1667.0,
    # What came with 1.39.5 alone.
    deviations=frozenset(Deviation) - {Deviation.PREMULTIPLIED_MIX, Deviation.BLACK_MATERIALS},
)
NUMBERS_1_39_3 = replace(
    NUMBERS_1_39_0,
    throughputs=Throughputs(added=total, multiplied=product, layered=total, over_medium=total),
)
NUMBERS_1_39_4 = replace(
    NUMBERS_1_39_0,
    throughputs=replace(SPECIFIED, over_medium=total),
    deviations=NUMBERS_1_39_0.deviations - {Deviation.UNDECLARED_BLOCK, Deviation.MATRIX_PRODUCTS},
)
