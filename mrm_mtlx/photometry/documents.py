"""The surfaces of documents as BRDFs, by the reference."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.reference import ShadingPoints, Surface

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.photometry.coefficients import Brdf

# Where on a texture: its middle. What varies over the surface is taken as it is there.
TEXCOORD = (0.5, 0.5)


def document_brdf(element: Any, images: Callable[[str], NDArray[np.floating] | None] = lambda _name: None) -> Brdf:
    """The BRDF of a document's surface, as the reference evaluates it.

    Parameters
    ----------
    element
        A material, or an output or node of type surfaceshader, in a document whose data library is set.
    images
        As `reference.Surface`.

    Returns
    -------
    Brdf
        Function brdf(v, l) of unit directions in the local frame, (..., 3), broadcast, to f = response / n.l [1/sr],
        (..., 3), of linear Rec.709 channels. 0 where v or l is not above the surface.

    Raises
    ------
    UnsupportedError, RecursionError
        As `reference.Surface`. The function raises ValueError where the surface has no finite value.
    """
    return surface_brdf(Surface(element, images=images))


def surface_brdf(surface: Surface) -> Brdf:
    """The same of a surface that is ready to be evaluated."""

    def brdf(v: Array, l: Array) -> Array:
        v, l = np.broadcast_arrays(np.asarray(v, dtype=float), np.asarray(l, dtype=float))
        flat_v, flat_l = v.reshape(-1, 3), l.reshape(-1, 3)
        above = (flat_v[:, 2] > 0.0) & (flat_l[:, 2] > 0.0)
        f = np.zeros(flat_v.shape)
        if np.any(above):
            f[above] = surface.response(_points(flat_v[above], flat_l[above])) / flat_l[above, 2:]
        if not np.all(np.isfinite(f)):
            bad = np.flatnonzero(~np.isfinite(f).all(axis=1))[0]
            where = np.rad2deg(np.arccos([flat_v[bad, 2], flat_l[bad, 2]]))
            msg = f"no finite value at the view angle {where[0]:.1f} degrees under light at {where[1]:.1f} degrees"
            raise ValueError(msg)
        return f.reshape(v.shape)

    return brdf


def _points(v: Array, l: Array) -> ShadingPoints:
    count = len(v)
    return ShadingPoints(
        view=v,
        light=l,
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (count, 1)),
        position=np.zeros((count, 3)),
        texcoord=np.tile(TEXCOORD, (count, 1)),
    )
