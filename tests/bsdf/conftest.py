"""Quadrature for lobes of any width."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.fixtures.quadrature import unit_interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array


@dataclass(frozen=True)
class SeenFacets:
    """Facets that a direction sees, as quadrature points, and where they send it."""

    m: Array  # (k, 3)
    facet_angle: Array  # solid angle of the facets, (k,)
    l: Array  # direction reflected or refracted, (k, 3); the zero vector where it is lost
    solid_angle: Array  # that of l, (k,); 0 where it is lost
    ring: Array  # which of the rings of slope, (k,)
    sector: Array  # which of the sectors of azimuth, (k,)


def scattered(w: Array, m: Array, eta: float | None) -> tuple[Array, Array]:
    """Where the facets (..., 3) send w, and the solid angle of that over the facets': by reflection, or Snell's law.

    Zeros where nothing is sent. This is written anew for the tests: tangent and normal part of l are found apart.
    """
    c = np.sum(w * m, axis=-1)
    if eta is None:
        l, stretch = 2.0 * c[..., None] * m - w, 4.0 * c
        sent = (c > 0.0) & (l[..., 2] > 0.0)
    else:
        along = (c[..., None] * m - w) / eta
        square = 1.0 - np.sum(along * along, axis=-1)
        depth = np.sqrt(np.maximum(square, 0.0))
        l = along - depth[..., None] * m
        sent = (c > 0.0) & (square > 0.0) & (l[..., 2] < 0.0)
        stretch = np.square(c - eta * depth) / (eta * eta * np.where(sent, depth, 1.0))
    return np.where(sent[..., None], l, 0.0), np.where(sent, stretch, 0.0)


# Where the integrands bend: the azimuths across the view, where facets begin to turn away from it, and slopes of many
# widths, which narrow lobes have at their far end.
_AZIMUTH_GRADES = np.array([1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.4])
_SLOPE_GRADES = np.array([0.3, 1.0, 3.0, 10.0, 100.0, 1000.0, 1e5])


@pytest.fixture(scope="session")
def seen_facets() -> Callable[..., SeenFacets]:
    """Function from a direction above, two widths, and an index for refraction, to the facets that it sees.

    Slopes are (ax tan(psi) cos(phi), ay tan(psi) sin(phi)); in psi and phi what is integrated is smooth but for known
    bends, at which the panels of Gauss's rule end: where facets turn away (and V-cavities begin to mask), where what
    they send is lost, where reflection becomes total for the index `critical`. `rings` (of slopes over widths) and
    `sectors` (a number) cut the points into cells.
    """

    def make(
        w: Array,
        alpha_x: float,
        alpha_y: float,
        eta: float | None = None,
        critical: float | None = None,
        rings: tuple[float, ...] = (),
        sectors: int = 1,
        nodes: int = 8,
    ) -> SeenFacets:
        def facets(psi: Array, phi: Array) -> Array:
            m = np.stack([-alpha_x * np.cos(phi) * np.tan(psi), -alpha_y * np.sin(phi) * np.tan(psi)], axis=-1)
            m = np.concatenate([m, np.ones((*m.shape[:-1], 1))], axis=-1)
            return np.asarray(m / np.linalg.norm(m, axis=-1, keepdims=True))

        across = np.arctan2(alpha_y * w[1], alpha_x * w[0]) + np.array([0.5, 1.5]) * np.pi
        bends = (across[:, None] + np.concatenate([-_AZIMUTH_GRADES, [0.0], _AZIMUTH_GRADES])).ravel()
        even = np.arange(sectors * -(-8 // sectors)) * (2.0 * np.pi / (sectors * -(-8 // sectors)))
        edges = np.sort(np.concatenate([np.mod(bends, 2.0 * np.pi), even, [2.0 * np.pi]]))
        x, weight = unit_interval(nodes)
        phi = (edges[:-1, None] + np.diff(edges)[:, None] * x).ravel()
        phi_weight = (np.diff(edges)[:, None] * weight).ravel()

        turned = alpha_x * w[0] * np.cos(phi) + alpha_y * w[1] * np.sin(phi)
        away, opposite = (np.arctan2(w[2], np.maximum(sign * turned, 0.0)) for sign in (1.0, -1.0))

        def last(holds: Callable[[Array], Array]) -> Array:
            """Largest psi up to which facets hold, as the one at 0 does."""
            low, high = np.zeros_like(phi), away.copy()
            for _ in range(60):
                middle = 0.5 * (low + high)
                held = holds(facets(middle, phi))
                low, high = np.where(held, middle, low), np.where(held, high, middle)
            return low

        low = last(lambda m: scattered(w, m, eta)[1] > 0.0)
        total = last(lambda m: 1.0 - np.square(m @ w) < np.square(critical)) if critical else low
        fixed = np.arctan(np.sort(np.concatenate([[0.0], rings, _SLOPE_GRADES])))[:, None] + 0.0 * phi
        psi_edges = np.sort(np.minimum(np.concatenate([fixed, [low, total, opposite, away]]), away), axis=0)
        width = np.diff(psi_edges, axis=0)
        psi = psi_edges[:-1] + width * x[:, None, None]  # (nodes, panels, azimuths)
        middle = np.broadcast_to(psi_edges[:-1] + 0.5 * width, psi.shape)
        m = facets(psi, np.broadcast_to(phi, psi.shape))
        area = weight[:, None, None] * width * phi_weight
        facet_angle = area * alpha_x * alpha_y * m[..., 2] ** 3 * np.tan(psi) / np.cos(psi) ** 2
        l, stretch = scattered(w, m, eta)
        sent = (middle < low) & (stretch > 0.0)
        sector = np.broadcast_to(np.floor(phi / (2.0 * np.pi) * sectors).astype(int), psi.shape)
        return SeenFacets(
            m.reshape(-1, 3),
            facet_angle.ravel(),
            np.where(sent[..., None], l, 0.0).reshape(-1, 3),
            np.where(sent, stretch * facet_angle, 0.0).ravel(),
            np.searchsorted(np.asarray(rings), np.tan(middle)).ravel(),
            sector.ravel(),
        )

    return make
