"""Directional albedo of a surface, the share of light that it reflects, by importance sampling of every lobe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import ggx
from mrm_mtlx.bsdf.vectors import half_vector, mirror
from mrm_mtlx.reference import ShadingPoints
from mrm_mtlx.validation.comparison.sampling import reflect_at_slopes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference import Surface
    from mrm_mtlx.validation.comparison.sampling import LobeShape

# View angles at which the albedo is taken [degrees]: gain shows at normal or at grazing incidence.
VIEW_DEGREES = (0.0, 30.0, 60.0, 75.0, 85.0)
SAMPLES = 2048


@dataclass(frozen=True)
class Albedo:
    """Directional albedo at one view angle: the largest channel, and the standard error of its estimate."""

    view_deg: float
    value: float
    error: float


def directional_albedos(surface: Surface, lobes: Sequence[LobeShape], rng: np.random.Generator) -> list[Albedo]:
    """Integral of the response over l, at each of `VIEW_DEGREES`; along both tangents where a lobe is anisotropic.

    One-sample multiple importance sampling (Veach 1997, section 9.2.4) over a cosine lobe and the facet normals of each
    microfacet lobe, about its mirror or its retroreflected direction: the combined density is at least a share of each
    lobe's own, so that the estimate's error stays small for any width.
    """
    anisotropic = any(lobe.alpha_x != lobe.alpha_y for lobe in lobes)
    axes = ((1.0, 0.0), (0.0, 1.0)) if anisotropic else ((1.0, 0.0),)
    return [_albedo(surface, lobes, degrees, axis, rng) for axis in axes for degrees in VIEW_DEGREES]


def _albedo(
    surface: Surface,
    lobes: Sequence[LobeShape],
    degrees: float,
    axis: tuple[float, float],
    rng: np.random.Generator,
) -> Albedo:
    theta = np.deg2rad(degrees)
    v = np.array([np.sin(theta) * axis[0], np.sin(theta) * axis[1], np.cos(theta)])
    parts = [_cosine_directions(rng)] + [_lobe_directions(rng, v, lobe) for lobe in lobes]
    l = np.concatenate(parts)
    # Balance heuristic: every direction is weighted by the mean density of all strategies.
    density = np.maximum(l[:, 2], 0.0) / np.pi
    for lobe in lobes:
        density = density + _lobe_density(l, v, lobe)
    density /= 1 + len(lobes)
    count = len(l)
    points = ShadingPoints(
        view=np.broadcast_to(v, (count, 3)),
        light=l,
        normal=np.broadcast_to([0.0, 0.0, 1.0], (count, 3)),
        tangent=np.broadcast_to([1.0, 0.0, 0.0], (count, 3)),
        position=np.zeros((count, 3)),
        texcoord=np.full((count, 2), 0.5),
    )
    response = surface.response(points)
    above = (l[:, 2] > 0.0) & (density > 0.0)
    weighted = np.where(above[:, None], response / np.where(above, density, 1.0)[:, None], 0.0)
    mean = weighted.mean(axis=0)
    # Variance within each strategy, since each has a fixed share of the samples.
    spread = sum(part.var(axis=0) for part in np.split(weighted, 1 + len(lobes))) / (1 + len(lobes))
    channel = int(np.argmax(mean))
    return Albedo(degrees, float(mean[channel]), float(np.sqrt(spread[channel] / count)))


def _cosine_directions(rng: np.random.Generator) -> Array:
    u, phi = rng.random(SAMPLES), 2.0 * np.pi * rng.random(SAMPLES)
    return np.stack([np.sqrt(u) * np.cos(phi), np.sqrt(u) * np.sin(phi), np.sqrt(1.0 - u)], axis=1)


def _lobe_directions(rng: np.random.Generator, v: Array, lobe: LobeShape) -> Array:
    u, phi = rng.random(SAMPLES), 2.0 * np.pi * rng.random(SAMPLES)
    return reflect_at_slopes(v, lobe, np.sqrt(u / (1.0 - u)), phi)


def _lobe_density(l: Array, v: Array, lobe: LobeShape) -> Array:
    """D(m) m_z / (4 |v.m|), the density of l for m drawn from D (Walter et al. 2007, eq. 38)."""
    seen = mirror(v) if lobe.retroreflective else v
    m = half_vector(seen, l)
    d = ggx.distribution(m[:, 0], m[:, 1], m[:, 2], lobe.alpha_x, lobe.alpha_y)
    with np.errstate(divide="ignore", invalid="ignore"):
        density = d * m[:, 2] / (4.0 * np.abs(m @ seen))
    return np.asarray(np.nan_to_num(density, nan=0.0, posinf=0.0))
