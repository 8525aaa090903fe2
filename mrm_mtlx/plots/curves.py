"""The value of a BSDF against the view angle, for a light that stands still."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mrm_mtlx.bsdf import Lobe
    from mrm_mtlx.bsdf.arrays import Array

# Largest view angle [rad], 89.9 degrees: at the horizon itself a BSDF is 0 by definition.
LARGEST = float(np.deg2rad(89.9))
# Relative luminance of linear Rec. 709, the colour space of MaterialX's documents; a grey keeps its value.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Every half a degree, the same on both sides.
_EVEN = np.linspace(0.0, LARGEST, 181)
# Angles about a peak [rad], 24 to a decade, from a hundredth of the narrowest width of float32 to a right angle:
# a lobe of any width between has its samples where it bends, without its width being known.
_ABOUT_A_PEAK = np.geomspace(2.5e-7, np.pi / 2, 164)


@dataclass(frozen=True)
class Curve:
    """A BSDF against the view angle.

    Attributes
    ----------
    name
        Of what is evaluated; one colour in a picture.
    variant
        How, where there are several; one line style in a picture.
    theta_l
        Angle of the light [rad], >= 0.
    theta_v : shape (n,)
        View angles [rad], ascending; positive on the side of the light.
    value : shape (n,)
        Luminance of the BSDF [1/sr], without the cosine.
    """

    name: str
    variant: str
    theta_l: float
    theta_v: Array
    value: Array


def view_angles(theta_l: float) -> Array:
    """View angles [rad] for a light at `theta_l`, ascending: evenly spaced, and dense about both peaks.

    The peaks are the directions of retroreflection, theta_l, and of the mirror, -theta_l; both are among the angles.
    """
    about = np.concatenate([-_ABOUT_A_PEAK, [0.0], _ABOUT_A_PEAK])
    every = np.concatenate([-_EVEN, _EVEN, about + theta_l, about - theta_l])
    return np.unique(every[np.abs(every) <= LARGEST])


def directions(theta: Array | float, azimuth: float = 0.0) -> Array:
    """Unit vectors at these signed angles from the normal in the plane of this azimuth [rad], shape (..., 3).

    Azimuth 0 is the half-plane of the light.
    """
    theta = np.asarray(theta, dtype=float)
    x = np.sin(theta)
    return np.stack([x * np.cos(azimuth), x * np.sin(azimuth), np.cos(theta)], axis=-1)


def luminance(f: Array) -> Array:
    """Relative luminance of linear Rec. 709 colours, shape (..., 3) -> (...)."""
    return np.asarray(f @ LUMINANCE)


def lobe_curve(name: str, variant: str, lobe: Lobe, theta_l: float, azimuth: float = 0.0) -> Curve:
    """A lobe against the view angle.

    Parameters
    ----------
    name, variant
        See `Curve`.
    lobe
        What is evaluated.
    theta_l
        Angle of the light [rad], in [0, pi/2).
    azimuth
        Angle between the planes of v and of l [rad].

    Raises
    ------
    ValueError
        If the lobe has values that are not finite, as parameters beyond double precision give.
    """
    theta_v = view_angles(theta_l)
    with np.errstate(all="ignore"):
        f = lobe.eval(directions(theta_v, azimuth), directions(theta_l))
    if not np.all(np.isfinite(f)):
        msg = f"the lobe '{name}' has values that are not finite; its parameters are too small or too large"
        raise ValueError(msg)
    return Curve(name, variant, theta_l, theta_v, luminance(f))
