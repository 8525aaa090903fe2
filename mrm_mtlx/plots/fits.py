"""A fitted document beside what it was fitted to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.photometry import Limit, surface_brdf
from mrm_mtlx.photometry.report import Settings
from mrm_mtlx.plots import coefficients
from mrm_mtlx.plots.documents import surface_curve
from mrm_mtlx.plots.paper import Panel

if TYPE_CHECKING:
    from mrm_mtlx.measured import CoefficientSamples, Measurement
    from mrm_mtlx.plots.coefficients import Panel as CoefficientPanel
    from mrm_mtlx.reference import Surface

# View angles that are drawn [rad]: beyond, noise is divided by the cosine.
STEEPEST = np.deg2rad(85.0)
# Lights that are drawn, evenly chosen of all there are.
MAXIMUM_LIGHTS = 4


def panels(measured: Measurement, surface: Surface, *, viewed: bool = False) -> list[Panel]:
    """Measured points and the document's curve in the plane of incidence, a panel per light.

    `viewed`: the values had the cosine of v in them and not that of l, which the reader divided out.

    Raises
    ------
    ValueError
        If there is no sample in the plane of incidence.
    """
    lights = [light for light in measured.lights() if len(measured.plane_of_incidence(light)[0])]
    if not lights:
        msg = "no sample is in the plane of incidence, which a picture shows"
        raise ValueError(msg)
    chosen = np.unique(np.linspace(0, len(lights) - 1, min(MAXIMUM_LIGHTS, len(lights))).round().astype(int))
    found = []
    for light in (float(lights[i]) for i in chosen):
        theta_v, f = measured.plane_of_incidence(light)
        away = np.abs(theta_v) < STEEPEST
        theta_v, f = theta_v[away], f[away]
        value = f.mean(axis=1)
        if viewed:
            value = value * np.cos(light) / np.cos(theta_v)
        curve = surface_curve("fitted", "", surface, light)
        found.append(Panel(light, 0.0, (replace(curve, variant="fit"),), (theta_v, value)))
    return found


def coefficient_panels(measured: CoefficientSamples, surface: Surface) -> list[CoefficientPanel]:
    """The document's R_A against observation and entrance angle, with what was given."""
    degrees = np.rad2deg([measured.observation, measured.beta1, measured.beta2]).round(9).T
    given = [
        Limit("", "", "", "", float(o), float(b1), float(b1), float(b2), "R_A", "cd/lx/m2", float(ra), "", "")
        for (o, b1, b2), ra in zip(degrees, measured.ra, strict=True)
    ]
    return coefficients.panels(surface_brdf(surface), given, Settings(rotations_deg=(0.0,)))
