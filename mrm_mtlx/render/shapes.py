"""The shapes of a picture: where the rays of a camera meet them, in NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# The camera looks at the origin, where every shape of about unit size stands, from above the horizon.
EYE = np.array([0.0, 1.1, 6.0])
HALF_FIELD = np.tan(np.deg2rad(12.0))

CONE_APEX, CONE_BASE, CONE_RADIUS = 1.05, -1.0, 0.72
PLANE_HALF = 0.95
# The panel is turned away from the eye: a sign seen from the side, at an entrance angle of about 20 degrees.
PLANE_TURN = np.deg2rad(18.0)


@dataclass(frozen=True)
class Hits:
    """Points in which rays meet a shape; all arrays over the rays, world space, unit vectors.

    `found` tells which rays meet it at all; the other arrays hold anything where it is False.
    """

    found: Array
    position: Array
    normal: Array
    tangent: Array
    texcoord: Array


def camera_rays(size: int, rows: slice = slice(None)) -> Array:
    """Unit directions of the rays through the pixel centres of some rows, shape (rows * size, 3), from the top."""
    forward = -EYE / np.linalg.norm(EYE)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    steps = ((np.arange(size) + 0.5) / size * 2.0 - 1.0) * HALF_FIELD
    rays = forward + steps[None, :, None] * right - steps[rows, None, None] * up
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True)).reshape(-1, 3)


def intersect(shape: str, rays: Array) -> Hits:
    """Points in which rays from the eye meet a shape.

    Raises
    ------
    KeyError
        If there is no such shape.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return SHAPES[shape](rays)


def _sphere(rays: Array) -> Hits:
    along = rays @ EYE
    root = along**2 - (EYE @ EYE - 1.0)
    distance = -along - np.sqrt(root)
    p = EYE + distance[:, None] * rays
    tangent = np.stack([p[:, 2], np.zeros(len(p)), -p[:, 0]], axis=1)
    uv = np.stack(
        [np.arctan2(p[:, 0], p[:, 2]) / (2 * np.pi) + 0.5, np.arcsin(np.clip(p[:, 1], -1, 1)) / np.pi + 0.5], 1
    )
    return Hits(root > 0.0, p, _unit(p), _unit(tangent), uv)


def _plane(rays: Array) -> Hits:
    normal = np.array([np.sin(PLANE_TURN), 0.0, np.cos(PLANE_TURN)])
    tangent = np.array([np.cos(PLANE_TURN), 0.0, -np.sin(PLANE_TURN)])
    distance = -(EYE @ normal) / (rays @ normal)
    p = EYE + distance[:, None] * rays
    x, y = p @ tangent, p[:, 1]
    found = (distance > 0.0) & (np.abs(x) < PLANE_HALF) & (np.abs(y) < PLANE_HALF)
    uv = np.stack([x, y], axis=1) / (2.0 * PLANE_HALF) + 0.5
    ones = np.ones((len(p), 1))
    return Hits(found, p, ones * normal, ones * tangent, uv)


def _cone(rays: Array) -> Hits:
    # x^2 + z^2 = slope^2 (apex - y)^2
    slope = CONE_RADIUS / (CONE_APEX - CONE_BASE)
    height = CONE_APEX - EYE[1]
    a = rays[:, 0] ** 2 + rays[:, 2] ** 2 - slope**2 * rays[:, 1] ** 2
    b = EYE[0] * rays[:, 0] + EYE[2] * rays[:, 2] + slope**2 * height * rays[:, 1]
    c = EYE[0] ** 2 + EYE[2] ** 2 - slope**2 * height**2
    root = b**2 - a * c
    distance = (-b - np.sqrt(root)) / a
    p = EYE + distance[:, None] * rays
    found = (root > 0.0) & (p[:, 1] < CONE_APEX) & (p[:, 1] > CONE_BASE)
    radial = _unit(p * [1.0, 0.0, 1.0])
    normal = _unit(radial + slope * np.array([0.0, 1.0, 0.0]))
    tangent = np.stack([radial[:, 2], np.zeros(len(p)), -radial[:, 0]], axis=1)
    turn = np.arctan2(p[:, 0], p[:, 2]) / (2 * np.pi) + 0.5
    uv = np.stack([turn, (p[:, 1] - CONE_BASE) / (CONE_APEX - CONE_BASE)], axis=1)
    return Hits(found, p, normal, tangent, uv)


def _unit(a: Array) -> Array:
    return np.asarray(a / np.linalg.norm(a, axis=-1, keepdims=True))


SHAPES: dict[str, Callable[[Array], Hits]] = {"sphere": _sphere, "plane": _plane, "cone": _cone}
