"""GGX microfacets: distribution of normals and height-correlated Smith masking."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


def distribution(mx: ArrayLike, my: ArrayLike, mz: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Density of facet normals, anisotropic GGX (Burley 2012, eq. 13; Walter et al. 2007, eq. 33).

        D(m) = 1 / (pi ax ay ((mx/ax)^2 + (my/ay)^2 + mz^2)^2)

    Parameters
    ----------
    mx, my, mz : array_like, shape (...)
        Components of the unit facet normal in the local frame.
    alpha_x, alpha_y : array_like, shape (...)
        Widths along x and y, > 0.

    Returns
    -------
    ndarray, shape (...)
        [1/sr]; the integral of D(m) mz over the hemisphere is 1.

    Examples
    --------
    >>> round(float(distribution(0.0, 0.0, 1.0, 0.5, 0.5)), 4)
    1.2732
    """
    alpha_x, alpha_y = np.asarray(alpha_x, dtype=float), np.asarray(alpha_y, dtype=float)
    slope = np.square(np.asarray(mx) / alpha_x) + np.square(np.asarray(my) / alpha_y) + np.square(np.asarray(mz))
    return np.asarray(1.0 / (np.pi * alpha_x * alpha_y * np.square(slope)))


def smith_lambda(x: ArrayLike, y: ArrayLike, z: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
    """Smith's Lambda of a direction for GGX (Heitz 2014, eq. 72, 86): (-1 + sqrt(1 + a^2 tan^2)) / 2.

    `x, y, z` are the direction's components, z > 0; `a^2 tan^2 = (ax^2 x^2 + ay^2 y^2) / z^2`. Shape (...), >= 0.
    """
    stretched = np.square(np.asarray(alpha_x) * x) + np.square(np.asarray(alpha_y) * y)
    return np.asarray(0.5 * (np.sqrt(1.0 + stretched / np.square(np.asarray(z, dtype=float))) - 1.0))


def masking_shadowing(lambda_v: ArrayLike, lambda_l: ArrayLike) -> Array:
    """Height-correlated masking and shadowing, G2 = 1 / (1 + Lambda(v) + Lambda(l)) (Heitz 2014, eq. 99); in (0, 1]."""
    return np.asarray(1.0 / (1.0 + np.asarray(lambda_v) + np.asarray(lambda_l)))


def masking_shadowing_isotropic(cos_v: ArrayLike, cos_l: ArrayLike, alpha: ArrayLike) -> Array:
    """Height-correlated G2 for one width, from the cosines alone (Heitz 2014, eq. 72 and 99).

    The same function as `masking_shadowing` of the two `smith_lambda`, multiplied through by the cosines, so that it
    stays finite where a cosine vanishes. Shape (...), in [0, 1].
    """
    cos_v, cos_l, squared = np.asarray(cos_v, dtype=float), np.asarray(cos_l, dtype=float), np.square(alpha)
    root_v = np.sqrt(squared + (1.0 - squared) * np.square(cos_v))
    root_l = np.sqrt(squared + (1.0 - squared) * np.square(cos_l))
    return np.asarray(2.0 * cos_v * cos_l / (root_l * cos_v + root_v * cos_l))
