"""Compensation for the energy that single scattering loses, from the directional albedo of a white lobe.

A retroreflective lobe has the albedo of the ordinary one (Portsmouth et al. 2026, eq. 18): it takes the same function.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


class WhiteAlbedo(Protocol):
    """Share of the light that a lobe with reflectance 1 returns by single scattering, by n.v and width.

    Renderers have a table or a fit of it: whose it is, is up to the caller. MaterialX's is
    `mrm_mtlx.reference.versions.installed().microfacet_albedo.white`.
    """

    def __call__(self, cos_v: ArrayLike, alpha: ArrayLike, /) -> Array:
        """Shape (...), in (0, 1]."""
        ...


def compensation(reflectance: ArrayLike, white: ArrayLike) -> Array:
    """Factor that gives multiply scattered light back, 1 + F (1 - Ess) / Ess (Turquin 2019, eq. 14 and 16).

    `reflectance` is F, `white` the `WhiteAlbedo` Ess; broadcast.
    """
    white = np.asarray(white, dtype=float)
    return np.asarray(1.0 + np.asarray(reflectance) * ((1.0 - white) / white))
