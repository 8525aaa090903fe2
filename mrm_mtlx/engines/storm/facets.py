"""Points of a surface as facets in front of cameras, so that each is drawn in a pixel of its own.

A renderer shades what a camera sees, at the middles of its pixels. Each point becomes a small square that faces the eye
and fills one pixel; its normal is its own. To get there, it is turned about the eye by less than a pixel, position,
normal and tangent together, so that it stays as it was but for the direction of the light.

The cameras stand at the eye and look along the axes of the world, so that turning to and from their space rounds
nothing. They see the six faces of a cube; near the light, where retroreflective lobes are narrow, ever smaller windows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import DirectionalLight, SurfacePoints

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.engines.base import Lighting

# Pixels of a picture along each side.
SIZE = 512
# How many times smaller each window is than the one around it, and how many there are in a face of the cube.
_STEP, _WINDOWS = 8.0, 4
# Texture coordinates change by this in a pixel: too little for an image, enough for their differences.
_GRADIENT = 2.0**-10

# Rows right, up and back of the cameras.
_CAMERAS = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    ],
    dtype=float,
)
_CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


@dataclass(frozen=True)
class Frame:
    """One picture of facets.

    Attributes
    ----------
    which
        Indices of the points in it.
    pixels : shape (points, 2)
        Their columns and rows, row 0 on top.
    camera
        "window", "matrix", "clip" and "resolution", as the server has them.
    corners : shape (points, 4, 3)
        Of their squares, anticlockwise.
    steps : shape (2, points, 3)
        What the position changes by from a pixel to the next, to the right and up.
    """

    which: NDArray[np.intp]
    pixels: NDArray[np.intp]
    camera: dict[str, Any]
    corners: Array
    steps: Array


@dataclass(frozen=True)
class Layout:
    """Points where they are drawn, and the pictures that they are drawn in."""

    points: SurfacePoints
    frames: tuple[Frame, ...]


def layout(points: SurfacePoints, lighting: Lighting) -> Layout:
    """Turn points about the eye into pixels of their own."""
    eye = np.asarray(lighting.view_position, dtype=float)
    away = np.asarray(points.position, dtype=float) - eye
    distance = np.linalg.norm(away, axis=1)
    direction = away / distance[:, None]
    to_light = None
    if isinstance(lighting.light, DirectionalLight):
        light = np.asarray(lighting.light.to_light, dtype=float)
        to_light = -light / np.linalg.norm(light)
    turned, frames = np.empty_like(direction), []
    position = np.empty_like(direction)
    for which, view, window in _windows(direction, to_light):
        plane = direction[which] @ view.T
        plane = plane[:, :2] / -plane[:, 2:]
        low, pixel = window[[0, 2]], (window[[1, 3]] - window[[0, 2]]) / SIZE
        column = np.clip(np.floor((plane - low) / pixel).astype(int), 0, SIZE - 1)
        seen = np.concatenate([low + (column + 0.5) * pixel, np.full((len(which), 1), -1.0)], axis=1)
        depth = _float32(distance[which] / np.linalg.norm(seen, axis=1))
        turned[which] = seen @ view / np.linalg.norm(seen, axis=1, keepdims=True)
        position[which] = eye + depth[:, None] * (seen @ view)
        for sheet in _sheets(column):
            corners = seen[sheet, None, :].repeat(4, axis=1)
            corners[:, :, :2] += _CORNERS * pixel
            at = depth[sheet, None, None]
            steps = np.stack([at[:, 0] * pixel[axis] * view[axis] for axis in (0, 1)])
            camera = {
                "window": window.tolist(),
                "resolution": [SIZE, SIZE],
                "clip": [float(depth[sheet].min()) / 2.0, float(depth[sheet].max()) * 2.0],
                "matrix": [*np.concatenate([view.T, eye[:, None]], axis=1).tolist(), [0.0, 0.0, 0.0, 1.0]],
            }
            pixels = np.stack([column[sheet, 0], SIZE - 1 - column[sheet, 1]], axis=1)
            frames.append(Frame(which[sheet], pixels, camera, eye + at * (corners @ view), steps))
    normal = _float32(_turn(np.asarray(points.normal, dtype=float), direction, turned))
    moved = replace(points, position=position, normal=normal, tangent=tangents(normal))
    return Layout(moved, tuple(frames))


def tangents(normal: Array) -> Array:
    """The tangents that Storm has where nothing says otherwise: along the horizon, as the normal has its y up."""
    across = np.cross(normal, [0.0, 1.0, 0.0])
    vertical = np.linalg.norm(across, axis=1, keepdims=True) < 1e-8
    across = np.where(vertical, np.cross(normal, [1.0, 0.0, 0.0]), across)
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def texture_coordinates(texcoord: Array, normal: Array, steps: Array) -> Array:
    """Texture coordinates at the corners of squares, (points, 4, 2), from those in the middle.

    They change from pixel to pixel so that the tangents that Storm makes of it are `tangents`: it takes the position's
    differences s and t, projected along the normal, times those of v, (dv/dy) s - (dv/dx) t.
    """
    n = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    s, t = (step - np.sum(step * n, axis=1, keepdims=True) * n for step in steps)
    wanted = tangents(normal)
    # Least squares in the plane across the normal, whose two vectors are nearly one where it is seen edge-on.
    ss, st, tt = (np.sum(a * b, axis=1) for a, b in ((s, s), (s, t), (t, t)))
    sw, tw = np.sum(s * wanted, axis=1), np.sum(t * wanted, axis=1)
    a, b = sw * tt - tw * st, tw * ss - sw * st
    length = np.maximum(np.hypot(a, b), 1e-30)
    a, b = _GRADIENT * a / length, _GRADIENT * b / length
    du, dv = np.stack([a, b], axis=1), np.stack([-b, a], axis=1)
    return np.asarray(
        texcoord[:, None, :] + np.stack([_CORNERS @ du[..., None], _CORNERS @ dv[..., None]], -1)[:, :, 0]
    )


def _windows(direction: Array, to_light: Array | None) -> Iterator[tuple[NDArray[np.intp], Array, Array]]:
    """Points by camera: indices, rows of the camera, and the window (left, right, bottom, top) at distance 1."""
    face = _faces(direction)
    level = np.zeros(len(direction), dtype=int)
    if to_light is not None:
        angle = np.linalg.norm(direction - to_light, axis=1)
        level = np.clip(np.floor(-np.log(np.maximum(angle, 1e-30)) / np.log(_STEP)), 0, _WINDOWS).astype(int)
        view = _CAMERAS[int(_faces(to_light[None])[0])]
        centre = view @ to_light
        centre = centre[:2] / -centre[2]
        for number in range(1, _WINDOWS + 1):
            which = np.flatnonzero(level == number)
            if len(which):
                # A direction at an angle a from the centre c lies within (1 + c^2) a of it in the plane, and a little.
                half = 1.2 * (1.0 + centre @ centre) * _STEP**-number
                # As the camera has it: the numbers of its lens are float32.
                half, (x, y) = float(np.float32(half)), _float32(centre)
                yield which, view, np.array([x - half, x + half, y - half, y + half])
    for number in range(len(_CAMERAS)):
        which = np.flatnonzero((level == 0) & (face == number))
        if len(which):
            yield which, _CAMERAS[number], np.array([-1.0, 1.0, -1.0, 1.0])


def _faces(direction: Array) -> NDArray[np.intp]:
    """The camera that looks most along each direction."""
    return np.asarray(np.argmax(direction @ -_CAMERAS[:, 2].T, axis=1))


def _sheets(column: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """Points in pixels of their own: those that share one are in as many sheets."""
    key = column[:, 0] * SIZE + column[:, 1]
    order = np.argsort(key, kind="stable")
    first = np.concatenate([[True], np.diff(key[order]) != 0])
    start = np.maximum.accumulate(np.where(first, np.arange(len(key)), 0))
    rank = np.empty(len(key), dtype=int)
    rank[order] = np.arange(len(key)) - start
    yield from (np.flatnonzero(rank == number) for number in range(int(rank.max()) + 1))


def _turn(vectors: Array, before: Array, after: Array) -> Array:
    """Vectors after the least turn that takes unit vectors `before` to `after`, which are near each other."""
    axis = np.cross(before, after)
    cosine = np.sum(before * after, axis=1, keepdims=True)
    along = np.sum(axis * vectors, axis=1, keepdims=True)
    return np.asarray(cosine * vectors + np.cross(axis, vectors) + along / (1.0 + cosine) * axis)


def _float32(a: Array) -> Array:
    return np.asarray(a, dtype=np.float32).astype(float)
