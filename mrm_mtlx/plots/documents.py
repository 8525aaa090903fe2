"""The surfaces of a document against the view angle, by the reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.plots.curves import Curve, directions, luminance, view_angles
from mrm_mtlx.reference import ShadingPoints

if TYPE_CHECKING:
    from mrm_mtlx.reference import Surface

# Where on a texture: its middle. What varies over the surface is plotted as it is there.
TEXCOORD = (0.5, 0.5)


def surface_curve(name: str, variant: str, surface: Surface, theta_l: float, azimuth: float = 0.0) -> Curve:
    """A surface against the view angle, at one point of it.

    Parameters
    ----------
    name, variant, theta_l, azimuth
        As `curves.lobe_curve`.
    surface
        What is evaluated. Its response has the cosine of l in it, which is divided out.

    Raises
    ------
    ValueError
        If the surface has no finite value for one of the directions.
    """
    theta_v, light = view_angles(theta_l), directions(theta_l)
    count = len(theta_v)
    points = ShadingPoints(
        view=directions(theta_v, azimuth),
        light=light,
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (count, 1)),
        position=np.zeros((count, 3)),
        texcoord=np.tile(TEXCOORD, (count, 1)),
    )
    value = luminance(surface.response(points)) / light[2]
    if not np.all(np.isfinite(value)):
        where = np.rad2deg(theta_v[~np.isfinite(value)][0])
        msg = f"{name} has no finite value at the view angle {where:.1f} degrees"
        raise ValueError(msg)
    return Curve(name, variant, theta_l, theta_v, value)
