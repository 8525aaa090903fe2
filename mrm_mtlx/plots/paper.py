"""Data of the figures of Portsmouth et al. 2026 that need no path tracer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.plots.curves import lobe_curve
from mrm_mtlx.plots.parameters import lobe

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.measured import Measurement
    from mrm_mtlx.plots.curves import Curve

# Figure 2: light angles, azimuths, and the artist's roughness with its place among the line styles.
FIGURE_2_LIGHTS_DEG = (45.0, 80.0)
FIGURE_2_AZIMUTHS_DEG = (0.0, 45.0)
FIGURE_2_ROUGHNESS = (0.666, 0.1)
# Figure 4: light angles, and the lobe that was fitted to yellow tape: F82-tint, which reaches 1 at 90 degrees.
FIGURE_4_LIGHTS_DEG = (15.0, 30.0, 60.0)
FIGURE_4_FIT = {"roughness": 0.23, "color0": 0.19, "color82": 0.0, "color90": 1.0}


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a figure.

    Attributes
    ----------
    theta_l, azimuth
        Angles [rad] of the light, and between the planes of v and l.
    curves
        What is drawn as lines.
    points
        What is drawn as dots: view angles [rad] and values [1/sr], each shape (n,); None if nothing.
    """

    theta_l: float
    azimuth: float
    curves: tuple[Curve, ...]
    points: tuple[Array, Array] | None = None


def figure_2() -> list[Panel]:
    """GGX, MRM and EON against the view angle: a row per light angle, in it a panel per azimuth; Fresnel is 1."""
    panels = []
    for theta_l in np.deg2rad(FIGURE_2_LIGHTS_DEG):
        for azimuth in np.deg2rad(FIGURE_2_AZIMUTHS_DEG):
            curves = []
            for roughness in FIGURE_2_ROUGHNESS:
                given = {"roughness": roughness}
                lobes = {
                    "GGX": lobe("schlick", given),
                    "MRM": lobe("schlick", given, retroreflective=True),
                    "EON": lobe("eon", given),
                }
                for name, model in lobes.items():
                    curves.append(lobe_curve(name, f"roughness {roughness:g}", model, theta_l, azimuth))
            panels.append(Panel(float(theta_l), float(azimuth), tuple(curves)))
    return panels


def figure_4(measured: Measurement | None = None) -> list[Panel]:
    """The fit of MRM to yellow tape in the plane of incidence, a panel per light angle, with what was measured.

    Raises
    ------
    ValueError
        If the measurement has no sample in the plane of incidence under one of the light angles.
    """
    fit = lobe("schlick", FIGURE_4_FIT, retroreflective=True)
    panels = []
    for theta_l in np.deg2rad(FIGURE_4_LIGHTS_DEG):
        curve = lobe_curve("MRM", "fit", fit, theta_l)
        panels.append(Panel(float(theta_l), 0.0, (curve,), None if measured is None else _points(measured, theta_l)))
    return panels


def _points(measured: Measurement, theta_l: float) -> tuple[Array, Array]:
    theta_v, f = measured.plane_of_incidence(theta_l)
    if not len(theta_v):
        lights = ", ".join(f"{angle:.4g}" for angle in np.rad2deg(measured.lights()))
        msg = (
            f"no sample in the plane of incidence at theta_l = {np.rad2deg(theta_l):g} degrees; its lights are {lights}"
        )
        raise ValueError(msg)
    return theta_v, f.mean(axis=1)
