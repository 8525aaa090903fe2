"""Data beside the document that was fitted to them."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.measured import Measurement
from mrm_mtlx.plots import fits


class Grey:
    """A surface whose BRDF is 0.2 everywhere."""

    def response(self, points):
        return np.full((len(points), 3), 0.2) * points.light[..., 2:]


def measurement(theta_l, theta_v, dphi):
    return Measurement("", theta_l, theta_v, dphi, np.ones((len(theta_l), 1)))


def test_panels_are_of_a_few_lights_with_their_points():
    lights = np.deg2rad(np.arange(10.0, 80.0, 10.0))
    theta_l, theta_v = (a.ravel() for a in np.meshgrid(lights, np.deg2rad([0.0, 30.0, 88.0])))
    panels = fits.panels(measurement(theta_l, theta_v, np.zeros(theta_l.size)), Grey())
    assert [round(np.rad2deg(panel.theta_l)) for panel in panels] == [10, 30, 50, 70]
    for panel in panels:
        np.testing.assert_allclose(panel.points[0], np.deg2rad([0.0, 30.0]))  # 88 degrees are left out
        np.testing.assert_allclose(panel.curves[0].value, 0.2)


def test_values_that_had_the_cosine_of_the_viewer_are_drawn_as_they_were_read():
    panel = fits.panels(measurement(*np.deg2rad([[60.0], [0.0], [0.0]])), Grey(), viewed=True)[0]
    np.testing.assert_allclose(panel.points[1], [0.5])  # cos 60 / cos 0


def test_scattered_lights_are_drawn_near_a_few(rng):
    theta_l, theta_v, dphi = rng.random((3, 200_000)) * np.array([[1.5], [1.4], [np.pi]])
    panels = fits.panels(measurement(theta_l, theta_v, dphi), Grey())
    assert [round(np.rad2deg(panel.theta_l)) for panel in panels] == [15, 30, 45, 60]
    assert all(np.all(np.diff(panel.points[0]) >= 0.0) for panel in panels)


def test_data_without_a_plane_of_incidence_are_refused():
    with pytest.raises(ValueError, match="no sample is in the plane of incidence"):
        fits.panels(measurement(*np.deg2rad([[30.0], [40.0], [90.0]])), Grey())
