"""Directions at which a surface is compared: where its lobes are, and where arithmetic is hard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from mrm_mtlx.bsdf.vectors import mirror
from mrm_mtlx.reference import ShadingPoints

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mrm_mtlx.bsdf.arrays import Array

# The one direction of light of a draw, in world space: a generic one, so that no product is exact by luck. Every sample
# is turned so that its l comes to lie here.
LIGHT = tuple(float(np.float32(x)) for x in (0.26726124, 0.5345225, 0.8017837))

# Smallest n.v sampled; below it a surface is seen edge-on and shaders clamp.
_GRAZING = 1e-3
# One sample in this many is seen from the back.
_BACK = 16


@dataclass(frozen=True)
class LobeShape:
    """A microfacet lobe as the sampling needs it: widths, scalars or shape (samples,), and the flag."""

    alpha_x: Array
    alpha_y: Array
    retroreflective: bool


def generator(seed: int, name: str) -> np.random.Generator:
    """Random numbers that depend on the seed and a name, and not on what else is checked or in which order."""
    return np.random.default_rng([seed, crc32(name.encode())])


def sample_local(rng: np.random.Generator, count: int, lobes: Sequence[LobeShape] = ()) -> tuple[Array, Array]:
    """Directions v and l in the local frame, shape (count, 3).

    v: half uniform over the hemisphere, a quarter near the normal, a quarter grazing (n.v log-uniform down to 1e-3).
    l: a quarter uniform over the hemisphere; the others around the peaks of the lobes in turn, half of them within one
    width of it and half drawn from the lobe; a lobe's l below the surface is replaced by a uniform one.
    """
    cos_v = rng.random(count)
    kind = rng.integers(0, 4, count)
    cos_v = np.where(kind == 2, np.sqrt(1.0 - 0.05 * cos_v), cos_v)
    cos_v = np.where(kind == 3, _GRAZING * 100.0**cos_v, cos_v)
    v = spherical(np.maximum(cos_v, _GRAZING), rng.random(count))
    l = spherical(np.maximum(rng.random(count), _GRAZING), rng.random(count))
    choice = rng.integers(0, 4 * max(len(lobes), 1), count)
    for index, lobe in enumerate(lobes):
        around = _around_peak(rng, v, lobe)
        use = (choice % len(lobes) == index) & (choice >= len(lobes)) & (around[:, 2] > 0.0)
        l = np.where(use[:, None], around, l)
    return v, l


def shading_points(
    rng: np.random.Generator, v: Array, l: Array, properties: Mapping[str, Array] | None = None
) -> ShadingPoints:
    """World-space samples with these local directions, in random frames, rounded to float32.

    Each frame is turned so that l is `LIGHT`; the eye is at the origin, so that the position is along -v, a quarter to
    four units away. One sample in 16 has its normal turned to the back. Texture coordinates lie in three tiles along
    each axis. `properties` are per-sample geometric properties, rounded to float32 too.
    """
    count = len(v)
    light = np.array(LIGHT)
    to_light = light / np.linalg.norm(light)
    # Two orthonormal frames, about l and about LIGHT; the turn takes one to the other, with a random spin.
    first = perpendicular(l)
    second = np.cross(l, first)
    spin = 2.0 * np.pi * rng.random((count, 1))
    axis_1 = perpendicular(np.broadcast_to(to_light, (count, 3)))
    axis_2 = np.cross(to_light, axis_1)
    turned_1 = np.cos(spin) * axis_1 + np.sin(spin) * axis_2
    turned_2 = np.cos(spin) * axis_2 - np.sin(spin) * axis_1

    def turn(a: Array) -> Array:
        along = [np.sum(a * b, axis=1, keepdims=True) for b in (first, second, l)]
        return np.asarray(along[0] * turned_1 + along[1] * turned_2 + along[2] * to_light)

    facing = np.where(np.arange(count) % _BACK == _BACK - 1, -1.0, 1.0)[:, None]
    position = float32(-turn(v) * 4.0 ** rng.uniform(-1.0, 1.0, (count, 1)))
    return ShadingPoints(
        view=-position / np.linalg.norm(position, axis=1, keepdims=True),
        light=light,
        normal=float32(turn(np.broadcast_to([0.0, 0.0, 1.0], (count, 3))) * facing),
        tangent=float32(turn(np.broadcast_to([1.0, 0.0, 0.0], (count, 3)))),
        position=position,
        texcoord=float32(rng.uniform(-1.0, 2.0, (count, 2))),
        properties={name: float32(value) for name, value in (properties or {}).items()},
    )


def geometric_properties(rng: np.random.Generator, kinds: Mapping[str, str], count: int) -> dict[str, Array]:
    """Values of geometric properties by name, from their types: (count,) or (count, components), in [0, 1].

    Integers are 0 to 3. A boolean is the same at all samples, false: generated shaders have it as a uniform.
    """
    drawn: dict[str, Array] = {}
    for name, kind in sorted(kinds.items()):
        if kind == "boolean":
            drawn[name] = np.zeros(count)
        elif kind == "integer":
            drawn[name] = rng.integers(0, 4, count).astype(float)
        else:
            drawn[name] = rng.random(count if kind == "float" else (count, int(kind[-1])))
    return drawn


def reflect_at_slopes(v: Array, lobe: LobeShape, radius: Array, phi: Array) -> Array:
    """Directions of the light that a lobe sends to v, for facets given by their slope, shape (samples, 3).

    `v` has shape (samples, 3) or (3,); the slope is `radius`, in units of the lobe's widths, at azimuth `phi`. The
    facet's mirror direction of v, or of v' for a retroreflective lobe.
    """
    slopes = [radius * np.cos(phi) * lobe.alpha_x, radius * np.sin(phi) * lobe.alpha_y]
    m = np.stack([*slopes, np.ones_like(radius)], axis=1)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    seen = mirror(v) if lobe.retroreflective else v
    return np.asarray(2.0 * np.sum(seen * m, axis=1, keepdims=True) * m - seen)


def spherical(cos_theta: Array, turn: Array) -> Array:
    """Directions of this polar cosine and azimuth, in turns; shape (samples, 3)."""
    sine, phi = np.sqrt(1.0 - cos_theta**2), 2.0 * np.pi * turn
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cos_theta], axis=1)


def rotated(a: Array, angle: float | Array, phi: Array) -> Array:
    """Directions at this angle [rad] from `a`, shape (samples, 3), in the direction `phi` [rad] around it."""
    first = perpendicular(a)
    side = np.cos(phi)[:, None] * first + np.sin(phi)[:, None] * np.cross(a, first)
    angle = np.broadcast_to(angle, phi.shape)[:, None]
    return np.asarray(np.cos(angle) * a + np.sin(angle) * side)


def local_directions(points: ShadingPoints, index: int) -> tuple[list[float], list[float]]:
    """v and l of one sample in its own frame, for reports; rounded to 7 digits."""
    n, x = points.normal[index], points.tangent[index]
    n = n if np.dot(n, points.view[index]) >= 0.0 else -n
    frame = np.stack([x, np.cross(n, x), n])
    light = np.asarray(points.light)
    rounded = [np.round(frame @ a, 7) + 0.0 for a in (points.view[index], light if light.ndim == 1 else light[index])]
    return rounded[0].tolist(), rounded[1].tolist()


def _around_peak(rng: np.random.Generator, v: Array, lobe: LobeShape) -> Array:
    count = len(v)
    u = rng.random(count)
    # Slope over width: uniform in the disc of one width, or the GGX distribution's own, sqrt(u / (1 - u)).
    radius = np.where(rng.random(count) < 0.5, np.sqrt(u), np.sqrt(u / np.maximum(1.0 - u, 1e-6)))
    phi = 2.0 * np.pi * rng.random(count)
    return reflect_at_slopes(v, lobe, radius, phi)


def perpendicular(a: Array) -> Array:
    """For each unit vector, shape (samples, 3), some unit vector across it."""
    axis = np.where(np.abs(a[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    p = axis - np.sum(axis * a, axis=1, keepdims=True) * a
    return np.asarray(p / np.linalg.norm(p, axis=1, keepdims=True))


def float32(a: Array) -> Array:
    """Numbers as a float32 shader gets them, in float64."""
    return np.asarray(a, dtype=np.float32).astype(float)
