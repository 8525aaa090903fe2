"""Directions at which surfaces are compared: all around, about the mirror's and the way back, and as standards do."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.photometry import goniometer
from mrm_mtlx.reference import ShadingPoints

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# Daylight: viewed along the normal, lit at 45 degrees (CIE 15, geometry 45:0, by which sheeting's daytime colours are
# measured). Night: observation 0.2 and entrance -4 degrees, the geometry that most classes of R_A begin with.
DAY = (np.array([0.0, 0.0, 1.0]), np.array([np.sqrt(0.5), 0.0, np.sqrt(0.5)]))
NIGHT = goniometer.directions(np.deg2rad(0.2), np.deg2rad(-4.0))
# Angles from the peak of a lobe [deg]: from what sheeting returns to what paint does.
_NEAREST, _FARTHEST = 0.03, 30.0
# Cosines of the largest angles from the normal: of a third all around, and of those about the mirror's and back.
_ALL_AROUND, _MIRRORED, _BACK = 0.05, 0.5, 0.7


def pairs(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Directions v and l, (3 count, 3): a third all around, a third about the mirror's direction, a third about back.

    They are as dense as light falls onto the surface: weighted by the cosine.
    """
    views = [upper(rng, count, least) for least in (_ALL_AROUND, _MIRRORED, _BACK)]
    mirror = views[1] * [-1.0, -1.0, 1.0]
    lights = [upper(rng, count, _ALL_AROUND), _about(rng, mirror), _about(rng, views[2])]
    return np.concatenate(views), np.concatenate(lights)


def upper(rng: np.random.Generator, count: int, least: float) -> Array:
    """Unit directions above the surface whose cosine is `least` or more, weighted by it, (count, 3)."""
    z, phi = np.sqrt(rng.uniform(least**2, 1.0, count)), rng.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)


def points(v: Array, l: Array, places: int = 1, seed: int = 0) -> ShadingPoints:
    """Points with these directions at each of several random places, place by place; the first is the middle."""
    rng = np.random.default_rng(seed)
    texcoord, position = rng.uniform(0.0, 1.0, (places, 2)), rng.uniform(-1.0, 1.0, (places, 3))
    texcoord[0], position[0] = 0.5, 0.0
    count = places * len(v)
    return ShadingPoints(
        view=np.tile(v, (places, 1)),
        light=np.tile(l, (places, 1)),
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (count, 1)),
        position=np.repeat(position, len(v), axis=0),
        texcoord=np.repeat(texcoord, len(v), axis=0),
    )


def _about(rng: np.random.Generator, axis: Array) -> Array:
    """Directions about others, (count, 3), at angles that are spread evenly over their orders of magnitude."""
    angle = np.deg2rad(np.geomspace(_NEAREST, _FARTHEST, len(axis)))[:, None]
    phi = rng.uniform(0.0, 2.0 * np.pi, len(axis))[:, None]
    first = np.cross(axis, [0.6, 0.0, -0.8])  # of no axis above the surface the opposite, nor often the same
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    turned = axis * np.cos(angle) + np.sin(angle) * (first * np.cos(phi) + np.cross(axis, first) * np.sin(phi))
    turned[:, 2] = np.abs(turned[:, 2])
    return np.asarray(turned)
