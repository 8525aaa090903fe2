"""Diffusion of light below a surface (Christensen and Burley 2015).

"Approximate reflectance profiles for efficient subsurface scattering".
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


def diffusion_profile(distance: ArrayLike, shape: ArrayLike) -> Array:
    """Light that leaves a surface at a distance from where it came in (Christensen and Burley 2015, eq. 2); (...).

        R(r) = s (exp(-s r) + exp(-s r / 3)) / (8 pi r)

    Parameters
    ----------
    distance : array_like, shape (...)
        r, > 0, in any unit of length.
    shape : array_like, shape (...)
        s, in inverse units of length.

    Returns
    -------
    ndarray, shape (...)
        Per unit of area; the integral of 2 pi r R(r) is 1.

    Examples
    --------
    >>> r = (np.arange(200000) + 0.5) * 1e-3
    >>> round(float(np.sum(2 * np.pi * r * diffusion_profile(r, 0.5)) * 1e-3), 5)
    1.0
    """
    r, s = np.asarray(distance, dtype=float), np.asarray(shape, dtype=float)
    return np.asarray(s * (np.exp(-s * r) + np.exp(-s * r / 3.0)) / (8.0 * np.pi * r))
