"""Quadrature for lobes of any width."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array


def unit_interval(count: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (x + 1.0), 0.5 * w


@pytest.fixture(scope="session")
def facets() -> Callable[..., tuple[Array, Array]]:
    """Function from the two widths to facet normals (k, 3) and their solid angles (k,).

    The slopes are stretched by the widths, (ax r cos phi, ay r sin phi), and the radius is mapped to
    s = r^2 / (1 + r^2) in [0, 1): in (s, phi), D(m) mz is the constant 1 / (2 pi) for GGX, however narrow.
    """

    def make(alpha_x: float, alpha_y: float, radii: int = 96, azimuths: int = 192) -> tuple[Array, Array]:
        s, weight = unit_interval(radii)
        phi = (np.arange(azimuths) + 0.5) * (2.0 * np.pi / azimuths)
        square = (s / (1.0 - s))[:, None]
        slope_x = alpha_x * np.sqrt(square) * np.cos(phi)
        slope_y = alpha_y * np.sqrt(square) * np.sin(phi)
        z = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_y**2)
        solid_angle = 0.5 * alpha_x * alpha_y * np.square(1.0 + square) * z**3
        solid_angle = solid_angle * weight[:, None] * (2.0 * np.pi / azimuths)
        return np.stack([-slope_x * z, -slope_y * z, z], axis=-1).reshape(-1, 3), solid_angle.ravel()

    return make


@pytest.fixture(scope="session")
def lobe_directions(facets: Callable[..., tuple[Array, Array]]) -> Callable[..., tuple[Array, Array]]:
    """Function from a direction and two widths to the directions l it is mirrored into, and their solid angles.

    These are dense where a lobe of those widths is; any function of l can be integrated with them.
    """

    def make(v: Array, alpha_x: float, alpha_y: float, **counts: int) -> tuple[Array, Array]:
        m, solid_angle = facets(alpha_x, alpha_y, **counts)
        cosine = m @ v
        l = 2.0 * cosine[:, None] * m - v
        # Facets that face away mirror into the same directions again; those below the surface do not count.
        kept = (cosine > 0.0) & (l[:, 2] > 0.0)
        return l[kept], (4.0 * cosine * solid_angle)[kept]

    return make


@pytest.fixture(scope="session")
def hemisphere_grid() -> Callable[..., tuple[Array, Array]]:
    """Function to directions over the hemisphere and their solid angles: Gauss in the cosine, even in azimuth."""

    def make(cosines: int = 128, azimuths: int = 256) -> tuple[Array, Array]:
        z, weight = unit_interval(cosines)
        phi = np.arange(azimuths) * (2.0 * np.pi / azimuths)
        sine = np.sqrt(1.0 - z * z)[:, None]
        z = np.broadcast_to(z[:, None], (cosines, azimuths))
        l = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)
        return l.reshape(-1, 3), np.repeat(weight * 2.0 * np.pi / azimuths, azimuths)

    return make
