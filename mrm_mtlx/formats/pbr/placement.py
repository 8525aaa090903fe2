"""Texture coordinates at which an image is read: affine functions of a mesh's, and KHR_texture_transform.

MaterialX's v grows upward from the lower edge of an image, glTF's downward from the upper one: v = 1 - v_gltf.

KHR_texture_transform scales, rotates counter-clockwise as seen on the image, and moves:

    u' = sx cos(r) u + sy sin(r) v + ox,    v' = -sx sin(r) u + sy cos(r) v + oy

The GLSL listing in its description turns the other way round (KhronosGroup/glTF#1563); the text, the example with the
lower left quadrant, the renderers and MaterialX's gltf_image agree on this one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.reference import ShadingPoints, constant_input, input_at

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

# Relative size of what is left out of a transform that is called exact: some roundings of float32.
_EXACT = 1e-6
# What is left of a number that cancelled, of those around 1.
_SMALLEST = 1e-7


class InexpressibleError(Exception):
    """glTF cannot say something; the message is why."""


def constant(node: Any, name: str) -> Array:
    """The number, or numbers, that an input has everywhere.

    Raises
    ------
    InexpressibleError
        If it varies.
    """
    value = constant_input(node, name)
    if not isinstance(value, np.ndarray):
        msg = f"{name} of {node.getCategory()} varies"
        raise InexpressibleError(msg)
    return value


class Placement(NamedTuple):
    """(u', v') = (a u + b v + c, d u + e v + f), in MaterialX's coordinates."""

    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0
    e: float = 1.0
    f: float = 0.0


class Transform(NamedTuple):
    """Of KHR_texture_transform; the rotation in radians."""

    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)


def transform(placement: Placement) -> Transform:
    """The same in glTF's coordinates.

    Raises
    ------
    InexpressibleError
        If it shears, or shows one line of the image.
    """
    linear, moved = _parts(placement)
    flip, origin = np.diag([1.0, -1.0]), np.array([0.0, 1.0])
    matrix = flip @ linear @ flip
    offset = flip @ (linear @ origin + moved) + origin
    across, along = matrix[:, 0], matrix[:, 1]
    size = float(np.hypot(*across))
    if size == 0.0 or abs(across @ along) > _EXACT * size * max(float(np.hypot(*along)), size):
        msg = "its texture coordinates are sheared"
        raise InexpressibleError(msg)
    # Of the two ways to say it, the one that turns less.
    size = math.copysign(size, across[0]) if across[0] else size
    rotation = math.atan2(-across[1] / size, across[0] / size)
    height = math.sin(rotation) * along[0] + math.cos(rotation) * along[1]
    rounded = [written(x) for x in (*offset, rotation, size, height)]
    return Transform((rounded[0], rounded[1]), rounded[2], (rounded[3], rounded[4]))


def placed_by(node: Any) -> tuple[Placement, int]:
    """The placement of the input `texcoord` of an image node, and its set of texture coordinates.

    Raises
    ------
    InexpressibleError
        If it is no affine function of one set of texture coordinates.
    """
    indices = _sets(node.getInput("texcoord"))
    found = input_at(node, "texcoord", _points(_CORNERS)) if len(indices) == 1 else None
    if found is not None:
        moved, across, along = found[:, 0], found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]
        expected = moved[:, None] + np.outer(across, _CORNERS[:, 0]) + np.outer(along, _CORNERS[:, 1])
        if np.allclose(found, expected, rtol=_EXACT, atol=_EXACT):
            return Placement(across[0], along[0], moved[0], across[1], along[1], moved[1]), indices.pop()
    msg = f"where {node.getCategory()} reads its image is no affine function of one set of texture coordinates"
    raise InexpressibleError(msg)


def through(node: Any, placement: Placement) -> Placement:
    """The placement of what an image node reads: its own scale, rotation and offset come after `placement`."""
    linear, moved = _parts(placement)
    match node.getCategory():
        case "tiledimage":
            repeats = constant(node, "realworldtilesize") / constant(node, "realworldimagesize")
            tiling, offset = constant(node, "uvtiling") * repeats, constant(node, "uvoffset") * repeats
            return _placement(np.diag(tiling) @ linear, tiling * moved - offset)
        case "image":
            return placement
    pivot, scale, offset = (constant(node, name) for name in ("pivot", "scale", "offset"))
    angle = math.radians(float(constant(node, "rotate")))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    step = np.array([offset[0], -offset[1]])
    if _order(node) == 0:
        own, shift = turn @ np.diag(scale), step + pivot
        return _placement(own @ linear, own @ (moved - pivot) + shift)
    own = np.diag(scale) @ turn
    return _placement(own @ linear, own @ (moved - pivot + step) + pivot)


def _order(node: Any) -> int:
    # gltf_colorimage has the input, and passes another number on.
    named = node.getCategory() != "gltf_colorimage" and node.getNodeDef().getActiveInput("operationorder") is not None
    return int(constant(node, "operationorder")) if named else 0


def _sets(given: Any) -> set[int]:
    """Sets of texture coordinates that an input depends on; the first where it depends on none."""
    found, seen = set(), set()
    waiting = [] if given is None else [given]
    while waiting:
        node = waiting.pop().getConnectedNode()
        if node is None or node.getNamePath() in seen:
            continue
        seen.add(node.getNamePath())
        if node.getCategory() == "texcoord":
            found.add(int(constant(node, "index")))
        waiting += node.getInputs()
    return found or {0}


def _points(texcoord: Array) -> ShadingPoints:
    """Points at these texture coordinates that differ in everything else, too."""
    count = len(texcoord)
    angle = np.linspace(0.1, 1.0, count)
    sine, cosine, zero = np.sin(angle), np.cos(angle), np.zeros(count)
    return ShadingPoints(
        view=np.stack([sine, zero, cosine], axis=1),
        light=np.stack([zero, sine, cosine], axis=1),
        normal=np.stack([zero, zero, zero + 1.0], axis=1),
        tangent=np.stack([zero + 1.0, zero, zero], axis=1),
        position=np.stack([angle, angle**2, angle**3], axis=1),
        texcoord=texcoord,
    )


# The first three say what an affine function is, the others whether it is one.
_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.7], [-2.2, 3.1], [5.4, -1.7]])


def _parts(placement: Placement) -> tuple[Array, Array]:
    a, b, c, d, e, f = placement
    return np.array([[a, b], [d, e]]), np.array([c, f])


def _placement(linear: Array, moved: Array) -> Placement:
    return Placement(*(float(x) for x in (*linear[0], moved[0], *linear[1], moved[1])))


def written(value: float) -> float:
    """A number of a document, which is float32 there, with as few digits as say it; 0 without a sign.

    Raises
    ------
    InexpressibleError
        If it is not finite there.
    """
    with np.errstate(over="ignore"):
        single = np.float32(value)
    if not np.isfinite(single):
        msg = f"one of its numbers is {single}, which JSON has not"
        raise InexpressibleError(msg)
    return 0.0 if abs(single) < _SMALLEST else float(str(single))
