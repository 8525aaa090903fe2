"""Numbers that artists give BSDFs by: widths, indices, colours of glow and of hair."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import hair
from mrm_mtlx.reference import closures
from mrm_mtlx.reference.float32.precision import logarithm_error, power_error
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, UNIT, Quantity
from mrm_mtlx.reference.nodes.registry import node

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs, Value


def _functions(inputs: Inputs) -> float:
    """1 where functions are perturbed, built-in ones and fitted formulas, else 0."""
    return float(inputs.light.perturbs(Quantity.FUNCTIONS))


@node("ND_roughness_anisotropy")
def _roughness_anisotropy(inputs: Inputs) -> Value:
    """alpha = roughness^2, stretched by the aspect sqrt(1 - anisotropy) (Burley 2012, section 5.4)."""
    roughness, anisotropy = inputs.array("roughness"), inputs.array("anisotropy")
    alpha = np.clip(roughness * roughness, closures.EPSILON, 1.0)
    aspect = np.sqrt(1.0 - np.clip(anisotropy, 0.0, 0.98))
    stretched = anisotropy > 0.0
    alpha_x = np.where(stretched, np.minimum(alpha / aspect, 1.0), alpha)
    alpha_y = np.where(stretched, alpha * aspect, alpha)
    return np.stack([np.atleast_1d(alpha_x), np.atleast_1d(alpha_y)])  # (2, 1) and not (2,), which would be two samples


@node("ND_artistic_ior")
def _artistic_ior(inputs: Inputs) -> dict[str, Value]:
    """Complex index from reflectance and edge tint (Gulbrandsen 2014, "Artist Friendly Metallic Fresnel")."""
    r, edge = np.clip(inputs.array("reflectivity"), 0.0, 0.99), inputs.array("edge_color")
    root = np.sqrt(r)
    ior = (1.0 + root) / (1.0 - root) * (1.0 - edge) + (1.0 - r) / (1.0 + r) * edge
    squared = (np.square(ior + 1.0) * r - np.square(ior - 1.0)) / (1.0 - r)
    return {"ior": ior, "extinction": np.sqrt(np.maximum(squared, 0.0))}


@node("ND_roughness_dual")
def _roughness_dual(inputs: Inputs) -> Value:
    """alpha = roughness^2 along each axis; a negative second roughness stands for the first."""
    roughness = inputs.array("roughness")
    second = np.where(inputs.discrete(np.sign(roughness[1])) < 0.0, roughness[0], roughness[1])
    return np.asarray(np.clip(np.square(np.stack([roughness[0], second])), closures.EPSILON, 1.0))


# Chromaticity of a black body, cubics in 1000 K / T: x up to 4000 K and above; y, cubics in x, up to 2222 K, 4000 K and
# above (Kang et al. 2002, "Design of advanced color temperature control system for HDTV applications", with the limits
# of MaterialX 1.39.5, which takes them down to 800 K; published for 1667 K and more). Highest power first.
_LOCUS_X = np.array([[-0.2661239, -0.2343580, 0.8776956, 0.179910], [-3.0258469, 2.1070379, 0.2226347, 0.240390]])
_LOCUS_Y = np.array(
    [
        [-1.1063814, -1.34811020, 2.18555832, -0.20219683],
        [-0.9549476, -1.37418593, 2.09137015, -0.16748867],
        [3.0817580, -5.87338670, 3.75112997, -0.37001483],
    ]
)
_LOCUS_PARTS = 2222.0, 4000.0
_LOCUS_SLOPE = 2.2  # y changes by at most so many times the change of x
_HOTTEST = 25000.0
_XYZ_TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


@node("ND_blackbody")
def _blackbody(inputs: Inputs) -> Value:
    """Colour of a black body at a temperature [K], of luminance 1; negative channels are 0."""
    kelvin = np.clip(inputs.array("temperature"), inputs.light.numbers.blackbody_lowest, _HOTTEST)
    # Which cubic: 0 below 2222 K, 1 below 4000 K, 2 above.
    part = inputs.discrete(np.asarray(np.digitize(kelvin, _LOCUS_PARTS), dtype=float))
    rounding = _functions(inputs) * UNIT
    x, x_error = _cubic(1000.0 / kelvin, _LOCUS_X, np.maximum(part - 1.0, 0.0))
    y, y_error = _cubic(x, _LOCUS_Y, part)
    y_error = y_error + _LOCUS_SLOPE * x_error
    # Per unit roundoff of the cubics' terms, and of the sums over the channels.
    xyz = np.stack([x / y, np.ones_like(x), (1.0 - x - y) / y])
    off = np.stack([x_error + x * y_error / y, np.zeros_like(x), x_error + y_error + (1.0 - x) * y_error / y]) / y
    scale = np.abs(_XYZ_TO_RGB)
    color = np.einsum("ij,j...->i...", _XYZ_TO_RGB, xyz)
    color = color + rounding * np.einsum("ij,j...->i...", scale, np.abs(xyz) + off)
    return np.where(y <= 0.0, 1.0, np.maximum(color, 0.0)).reshape(3, -1)


def _cubic(x: Array, coefficients: Array, row: Array) -> tuple[Array, Array]:
    """A polynomial by one of the rows of coefficients, highest power first, and the sum of its terms' magnitudes."""
    chosen = coefficients[np.asarray(row, dtype=int)]
    terms = [chosen[..., k] * x ** (3 - k) for k in range(4)]
    return np.asarray(sum(terms)), np.asarray(sum(np.abs(term) for term in terms))


@node("ND_deon_hair_absorption_from_melanin")
def _absorption_from_melanin(inputs: Inputs) -> Value:
    """Absorption of two pigments by concentration and share of the red one (d'Eon et al. 2011, section 6.1)."""
    left = np.maximum(1.0 - inputs.array("melanin_concentration"), 0.0001)
    redness = inputs.array("melanin_redness")
    pigments = ((1.0 - redness, inputs.array("eumelanin_color")), (redness, inputs.array("pheomelanin_color")))
    absorption = sum(-np.log(left) * share * -np.log(color) for share, color in pigments)
    off = sum(
        np.abs(share) * (logarithm_error(left) * np.abs(np.log(color)) - np.log(left) * logarithm_error(color))
        for share, color in pigments
    )
    return np.maximum(absorption, 0.0) + _functions(inputs) * np.asarray(off) / ROUNDING_FACTOR


@node("ND_chiang_hair_absorption_from_color")
def _absorption_from_color(inputs: Inputs) -> Value:
    """Absorption that gives hair of an azimuthal roughness a colour; see `bsdf.hair.absorption_fit`."""
    color, roughness = np.clip(inputs.array("color"), 0.001, 1.0), inputs.array("azimuthal_roughness")
    fit = hair.absorption_fit(roughness)
    condition = np.polynomial.polynomial.polyval(np.abs(roughness), np.abs(hair.ABSORPTION_FIT))
    root = np.log(color) / fit
    error = logarithm_error(color) / ROUNDING_FACTOR + UNIT * condition * np.abs(root)
    return np.square(root) + _functions(inputs) * 2.0 * np.abs(root) * error / np.abs(fit)


@node("ND_chiang_hair_roughness")
def _hair_roughness(inputs: Inputs) -> dict[str, Value]:
    """Variance and azimuthal scale of the paths from artists' roughnesses; see `bsdf.hair.variances`."""
    along, about = (np.clip(inputs.array(name), 0.001, 1.0) for name in ("longitudinal", "azimuthal"))
    functions = _functions(inputs)
    l20, a22 = (
        base**k + functions * power_error(base, np.asarray(float(k)), fast=False)
        for base, k in ((along, 20), (about, 22))
    )
    variance, scale = hair.variances(along, about, high_powers=(l20, a22))

    def path(factor: Array | float) -> Array:
        return np.stack(np.broadcast_arrays(np.atleast_1d(variance * np.square(factor)), scale))

    return {
        "roughness_R": path(1.0),
        "roughness_TT": path(inputs.array("scale_TT")),
        "roughness_TRT": path(inputs.array("scale_TRT")),
    }
