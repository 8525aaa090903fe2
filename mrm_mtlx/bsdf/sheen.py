"""Sheen of cloth: the lobe of Conty and Kulla 2017, and that of Zeltner, Burley and Chiang 2022.

"Production friendly microfacet sheen BRDF"; "Practical multiple-scattering sheen using linearly transformed cosines".
The albedos and the coefficients of the transformation are tables or fits of each renderer: the caller's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


def fibre_distribution(sin2_h: ArrayLike, roughness: ArrayLike) -> Array:
    """Distribution of facet normals about the tangent plane (Conty and Kulla 2017, eq. 2), shape (...), 1/sr.

        D = (2 + 1/r) sin^(1/r) / (2 pi)

    Parameters
    ----------
    sin2_h : array_like, shape (...)
        Squared sine between facet normal and n, in [0, 1].
    roughness : array_like, shape (...)
        r, > 0.

    Examples
    --------
    >>> round(float(fibre_distribution(1.0, 0.5) * 2 * np.pi), 12)
    4.0
    """
    inverse = fibre_exponent(roughness)
    return np.asarray((2.0 + inverse) * np.asarray(sin2_h, dtype=float) ** (0.5 * inverse) / (2.0 * np.pi))


def fibre_exponent(roughness: ArrayLike) -> Array:
    """Exponent 1/r of the sine in `fibre_distribution`, shape (...)."""
    return np.asarray(1.0 / np.asarray(roughness, dtype=float))


def fibre_visibility(cos_v: ArrayLike, cos_l: ArrayLike) -> Array:
    """Stands for masking and 1 / (4 n.v n.l): 1 / (4 (n.l + n.v - n.l n.v)) (Neubelt and Pettineo 2013); (...)."""
    cos_v, cos_l = np.asarray(cos_v, dtype=float), np.asarray(cos_l, dtype=float)
    return np.asarray(0.25 / (cos_l + cos_v - cos_l * cos_v))


def ltc_density(x: ArrayLike, y: ArrayLike, z: ArrayLike, a: ArrayLike, b: ArrayLike) -> Array:
    """Density of a linearly transformed cosine (Heitz et al. 2016, eq. 1) in direction (x, y, z), shape (...), 1/sr.

        wo = (a x + b z, a y, z)        D = max(z, 0) a^2 / (pi |wo|^4)

    Parameters
    ----------
    x, y, z : array_like, shape (...)
        Components of a unit direction; z along n, x in the plane of n and v on v's side.
    a, b : array_like, shape (...)
        Coefficients of the inverse transformation, which the roughness and n.v give; a > 0.

    Returns
    -------
    ndarray, shape (...)
        The integral over the hemisphere is 1; the cosine of l is included.

    Examples
    --------
    >>> round(float(ltc_density(0.0, 0.0, 1.0, 1.0, 0.0) * np.pi), 12)
    1.0
    """
    x, y, z, a = (np.asarray(w, dtype=float) for w in (x, y, z, a))
    squared = np.square(a * x + np.asarray(b) * z) + np.square(a * y) + np.square(z)
    return np.asarray(np.maximum(z, 0.0) / np.pi * np.square(a / squared))
