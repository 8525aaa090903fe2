"""A fitted document beside what it was fitted to."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.measured.measurement import SAME_LIGHT
from mrm_mtlx.photometry import surface_brdf
from mrm_mtlx.photometry.report import PhotometryOptions
from mrm_mtlx.plots import coefficients
from mrm_mtlx.plots.documents import surface_curve
from mrm_mtlx.plots.paper import Panel

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.measured import CoefficientSamples, Measurement
    from mrm_mtlx.plots.coefficients import CoefficientPanel
    from mrm_mtlx.reference import Surface

# View angles that are drawn [rad]: beyond, noise is divided by the cosine.
STEEPEST = np.deg2rad(85.0)
# Lights that are drawn, evenly chosen of all there are.
MAXIMUM_LIGHTS = 4
# With more lights than this, a file has no planes, as MERL's: samples near one are drawn, by this angle [rad].
SCATTERED, NEAR = 500, np.deg2rad(0.5)


def panels(measured: Measurement, surface: Surface, *, viewed: bool = False) -> list[Panel]:
    """Measured points and the document's curve in the plane of incidence, a panel per light.

    `viewed`: the values had the cosine of v in them and not that of l, which the reader divided out.

    Raises
    ------
    ValueError
        If there is no sample in the plane of incidence.
    """
    found = []
    for light, (theta_v, f) in _slices(measured).items():
        away = np.abs(theta_v) < STEEPEST
        theta_v, f = theta_v[away], f[away]
        value = f.mean(axis=1)
        if viewed:
            value = value * np.cos(light) / np.cos(theta_v)
        curve = surface_curve("fitted", "", surface, light)
        found.append(Panel(light, 0.0, (replace(curve, variant="fit"),), (theta_v, value)))
    if not found:
        msg = "no sample is in the plane of incidence, which a picture shows"
        raise ValueError(msg)
    return found


def _slices(measured: Measurement) -> dict[float, tuple[Array, Array]]:
    """View angles and values in the plane of incidence, by light; of scattered lights, near a few."""
    lights = measured.lights()
    # So many of them lie closer together than those of one goniometer's setting, and are not told apart by `lights`.
    if len(np.unique((measured.theta_l / SAME_LIGHT).round())) > SCATTERED:
        near = {light: _near(measured, light) for light in np.deg2rad([15.0, 30.0, 45.0, 60.0])}
        return {float(light): points for light, points in near.items() if len(points[0])}
    found = {float(light): measured.plane_of_incidence(light) for light in lights}
    there = [light for light, (theta_v, _) in found.items() if len(theta_v)]
    chosen = np.unique(np.linspace(0, len(there) - 1, min(MAXIMUM_LIGHTS, len(there))).round().astype(int))
    return {there[i]: found[there[i]] for i in chosen}


def _near(measured: Measurement, light: float) -> tuple[Array, Array]:
    across = np.abs(measured.theta_v * np.sin(measured.dphi))
    chosen = (np.abs(measured.theta_l - light) < NEAR) & (across < NEAR)
    signed = (measured.theta_v * np.cos(measured.dphi))[chosen]
    order = np.argsort(signed, kind="stable")
    return signed[order], measured.f[chosen][order]


def coefficient_panels(measured: CoefficientSamples, surface: Surface) -> list[CoefficientPanel]:
    """The document's R_A against observation and entrance angle, with what was given."""
    degrees = np.rad2deg([measured.observation, measured.beta1, measured.beta2]).round(9).T
    given = [
        coefficients.Mark(float(o), float(b1), float(b1), float(b2), float(ra))
        for (o, b1, b2), ra in zip(degrees, measured.ra, strict=True)
    ]
    return coefficients.panels(surface_brdf(surface), given, PhotometryOptions(rotations_deg=(0.0,)))
