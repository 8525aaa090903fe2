"""The surfaces of a document against the view angle, by the reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.photometry.documents import surface_brdf
from mrm_mtlx.plots.curves import Curve, directions, luminance, view_angles

if TYPE_CHECKING:
    from mrm_mtlx.reference import Surface


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
    try:
        value = luminance(surface_brdf(surface)(directions(theta_v, azimuth), light))
    except ValueError as error:
        msg = f"{name} has {error}"
        raise ValueError(msg) from error
    return Curve(name, variant, theta_l, theta_v, value)
