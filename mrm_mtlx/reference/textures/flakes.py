"""Flakes: cubes of a random turn in the cells of a grid, of which the one on top is seen; as MaterialX has them.

Positions are in units of a flake, shape (3, samples).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.float32.precision import SINE_ERROR
from mrm_mtlx.reference.float32.rounding import UNIT
from mrm_mtlx.reference.textures.noise import cell_noise, cell_noises

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# Half a flake's edge.
HALF = 1.5 / np.sqrt(3.0)

# Fit of MaterialX's authors: how likely a cell has a flake, for a share of the surface x that flakes cover, is
# (-26.2 x^2 + 26.4 x) / (85.5 x^3 - 102.4 x^2 - 101.4 x + 118.5); highest power first.
_LIKELY = (-26.19771808, 26.39663835, 0.0)
_OF_ALL = (85.53857017, -102.35069432, -101.42634862, 118.45082288)

# Random numbers of a cell are told apart by one more coordinate.
_DEPTH, _LOOKS = np.asarray(3.0), np.asarray(2.0)

# The largest id.
_IDS = np.float32(16777215.0)


@dataclass(frozen=True)
class Flake:
    """The flake seen at each sample: its cell, shape (3, samples), and its priority, (samples,); 0 without a flake."""

    cell: Array
    priority: Array

    def differs(self, other: Flake) -> NDArray[np.bool_]:
        """True where another flake is seen, shape (samples,)."""
        return np.asarray(np.any(self.cell != other.cell, axis=0) | (self.priority != other.priority))

    def where(self, condition: NDArray[np.bool_], other: Flake) -> Flake:
        """Itself where the condition holds, elsewhere the other."""
        return Flake(np.where(condition, self.cell, other.cell), np.where(condition, self.priority, other.priority))


def likelihood(coverage: Array) -> tuple[Array, Array]:
    """Probability that a cell has a flake, and its error in float32; the denominator cancels near full coverage."""
    x = np.clip(coverage, 0.0, 1.0)
    above, below = np.polyval(_LIKELY, x), np.polyval(_OF_ALL, x)
    value = above / below
    above_error, below_error = (4.0 * UNIT * np.polyval(np.abs(terms), x) for terms in (_LIKELY, _OF_ALL))
    return value, (above_error + value * below_error) / below


def top_flake(position: Array, likely: Array, half: Array | float = HALF) -> Flake:
    """The flake of the highest priority among those of this half edge that a position lies in."""
    x, y, z, likely, half = np.broadcast_arrays(*position, likely, half)
    position = np.stack([x, y, z])
    base = np.floor(position)
    cells, priorities = np.zeros(position.shape), np.zeros(x.shape)
    for step in product((-1.0, 0.0, 1.0), repeat=3):
        cell = base + np.array(step)[:, None]
        # Cheapest first: most samples are too far away for the cube of a cell, or the cell has none.
        places = np.flatnonzero(np.sum(np.square(position - cell - 0.5), axis=0) <= 3.0 * half * half)
        places = places[cell_noise(*cell[:, places]) <= likely[places]]
        cell = cell[:, places]
        priority = cell_noise(*cell, _DEPTH)
        turned = _turned(position[:, places] - cell - 0.5, cell_noises(*cell))
        inside = np.max(np.abs(turned), axis=0, initial=0.0) <= half[places]
        seen = inside & (priority >= priorities[places])
        cells[:, places[seen]], priorities[places[seen]] = cell[:, seen], priority[seen]
    return Flake(cells, priorities)


def alternative(position: Array, likely: Array, error: Array) -> Flake:
    """Another flake that float32 may see, at the edge of one or of one that barely is; else the same."""
    flake = other = top_flake(position, likely)
    # Nine sums and products of sines and cosines, and the roundings of the position.
    edge = 9.0 * SINE_ERROR + 2.0 * UNIT * np.max(np.abs(position), axis=0)
    for half, chance in ((HALF + edge, likely), (HALF - edge, likely), (HALF, likely + error), (HALF, likely - error)):
        tried = top_flake(position, chance, half)
        other = tried.where(tried.differs(flake), other)
    return other


def number(flake: Flake) -> Array:
    """The flake's random number, in [0, 1]."""
    return np.where(flake.priority > 0.0, _looks(flake)[2], 0.0)


def identity(flake: Flake) -> Array:
    """The flake's number as a whole one, as a product in float32 has it."""
    return np.asarray(np.trunc((number(flake).astype(np.float32) * _IDS).astype(float)))


def normal(flake: Flake, roughness: Array, frame: Sequence[Array], **errors: Array | float) -> Array:
    """The flake's normal, GGX distributed about the surface's, shape (3, samples).

    Parameters
    ----------
    flake, roughness
        alpha = roughness^2.
    frame
        Tangent, bitangent and normal, shape (3, samples) each.
    errors
        `sine`, `cosine` of the azimuth and `tilt`, of the polar angle's sine, relative; each 0 by default.
    """
    azimuth, polar, _ = _looks(flake)
    tangent, bitangent, up = frame
    slope = roughness * roughness * np.sqrt(polar) / np.sqrt(1.0 - polar)
    sine = np.minimum(slope / np.sqrt(1.0 + slope * slope) * (1.0 + errors.get("tilt", 0.0)), 1.0)
    x = (np.cos(2.0 * np.pi * azimuth) + errors.get("cosine", 0.0)) * sine
    y = (np.sin(2.0 * np.pi * azimuth) + errors.get("sine", 0.0)) * sine
    tilted = unit(tangent * x + bitangent * y + up * np.sqrt(1.0 - sine * sine))
    return np.where(flake.priority > 0.0, tilted, up)


# Errors of what `normal` names, in full. The polar sine comes by some eight roundings.
NORMAL_ERRORS = {"sine": SINE_ERROR, "cosine": SINE_ERROR, "tilt": 8.0 * UNIT}


def _looks(flake: Flake) -> Array:
    return cell_noises(*flake.cell, _LOOKS)


def _turned(vector: Array, random: Array) -> Array:
    """The vector in a random frame, by three random numbers (Arvo 1992, "Fast Random Rotation Matrices").

    A turn about z, and a reflection by a plane through the origin that moves z anywhere: (a a^T - 1) times the turn,
    with a of the length sqrt(2).
    """
    theta, phi, double = 2.0 * np.pi * random[0], 2.0 * np.pi * random[1], 2.0 * random[2]
    a = np.stack([np.sin(phi) * np.sqrt(double), np.cos(phi) * np.sqrt(double), np.sqrt(2.0 - double)])
    reflected = a * np.sum(a * vector, axis=0) - vector
    c, s = np.cos(theta), np.sin(theta)
    x, y, z = reflected
    return np.stack([c * x - s * y, s * x + c * y, z])
