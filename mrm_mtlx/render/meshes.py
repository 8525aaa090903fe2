"""The shapes of a picture as triangles, for renderers that want a mesh; the same surfaces as in `shapes`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.render import shapes

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# Steps around and along a curved shape: a chord is then within 2e-5 of the sphere, well under a pixel.
_AROUND, _ALONG = 512, 256
# Latitudes end just before the poles, where longitude means nothing.
_POLE = 1e-4


@dataclass(frozen=True)
class Mesh:
    """Triangles with smooth normals.

    Attributes
    ----------
    vertices : shape (corners, 3)
    faces : shape (triangles, 3)
        Indices of vertices, anticlockwise from outside. The first and the last corner lie along the tangent: renderers
        without texture coordinates take their difference for it.
    normals : shape (triangles, 3, 3)
        Per corner.
    texcoords : shape (triangles, 3, 2)
        Per corner.
    """

    vertices: Array
    faces: NDArray[np.int32]
    normals: Array
    texcoords: Array


def mesh(shape: str) -> Mesh:
    """The mesh of a shape.

    Raises
    ------
    KeyError
        If there is no such shape.
    """
    return MESHES[shape]()


def _sphere() -> Mesh:
    def point(u: Array, v: Array) -> tuple[Array, Array]:
        longitude, latitude = (u - 0.5) * 2.0 * np.pi, (v - 0.5) * (np.pi - 2.0 * _POLE)
        cosine = np.cos(latitude)
        p = np.stack([cosine * np.sin(longitude), np.sin(latitude), cosine * np.cos(longitude)], axis=-1)
        return p, p

    return _grid(point, _AROUND, _ALONG)


def _cone() -> Mesh:
    slope = shapes.CONE_RADIUS / (shapes.CONE_APEX - shapes.CONE_BASE)

    def point(u: Array, v: Array) -> tuple[Array, Array]:
        turn = (u - 0.5) * 2.0 * np.pi
        y = shapes.CONE_BASE + v * (1.0 - _POLE) * (shapes.CONE_APEX - shapes.CONE_BASE)
        radius = slope * (shapes.CONE_APEX - y)
        p = np.stack([radius * np.sin(turn), y, radius * np.cos(turn)], axis=-1)
        n = np.stack([np.sin(turn), np.full_like(turn, slope), np.cos(turn)], axis=-1)
        return p, n / np.sqrt(1.0 + slope * slope)

    return _grid(point, _AROUND, 1)


def _plane() -> Mesh:
    normal = np.array([np.sin(shapes.PLANE_TURN), 0.0, np.cos(shapes.PLANE_TURN)])
    tangent = np.array([np.cos(shapes.PLANE_TURN), 0.0, -np.sin(shapes.PLANE_TURN)])

    def point(u: Array, v: Array) -> tuple[Array, Array]:
        across, up = ((a - 0.5)[..., None] * 2.0 * shapes.PLANE_HALF for a in (u, v))
        return across * tangent + up * np.array([0.0, 1.0, 0.0]), np.broadcast_to(normal, (*u.shape, 3))

    return _grid(point, 1, 1)


def _grid(point: Callable[[Array, Array], tuple[Array, Array]], across: int, along: int) -> Mesh:
    """A surface over the unit square: u along the tangent, v to the left of it, seen from outside."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, across + 1), np.linspace(0.0, 1.0, along + 1))
    vertices, normals = (a.reshape(-1, 3) for a in point(u, v))
    index = np.arange(u.size).reshape(u.shape)
    low, right, top, far = (a.ravel() for a in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    faces = np.concatenate([np.stack([right, top, low], axis=1), np.stack([top, right, far], axis=1)]).astype(np.int32)
    texcoords = np.stack([u.ravel(), v.ravel()], axis=1)
    return Mesh(vertices, faces, np.asarray(normals)[faces], texcoords[faces])


MESHES: dict[str, Callable[[], Mesh]] = {"sphere": _sphere, "plane": _plane, "cone": _cone}
