"""The light on the points of an evaluation: at most one light, and an environment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Vector: TypeAlias = Sequence[float]  # three numbers


@dataclass(frozen=True)
class DirectionalLight:
    """A light infinitely far away.

    `to_light` is the unit vector l from the surface to the light, in world space; `irradiance` is what a surface
    perpendicular to l receives.
    """

    to_light: Vector
    irradiance: Vector = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class PointLight:
    """A light at a point; MaterialX has its irradiance fall as intensity / (distance + 1)^2. World space."""

    position: Vector
    intensity: Vector


@dataclass(frozen=True)
class Environment:
    """Light from all around, as latitude-longitude images.

    `radiance` has shape (height, width, 3), linear, row 0 at +y; the centre column is -z. `irradiance` is its
    cosine-weighted mean over each hemisphere (irradiance / pi), of any size. `samples` is the number of directions that
    the shader's filtered importance sampling uses per point.
    """

    radiance: NDArray[np.floating]
    irradiance: NDArray[np.floating]
    samples: int = 64


@dataclass(frozen=True)
class Lighting:
    """Light and eye of one evaluation; without an environment, all around is black."""

    light: DirectionalLight | PointLight | None = None
    environment: Environment | None = None
    view_position: Vector = (0.0, 0.0, 0.0)
