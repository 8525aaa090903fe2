"""Coefficients of retroreflection against the observation and the entrance angle: the data of a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.photometry.report import values

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.photometry.coefficients import Brdf
    from mrm_mtlx.photometry.report import PhotometryOptions
    from mrm_mtlx.standards.tables import Limit

# Curves where no class is asked for: an even choice of what reports have [degrees].
_OBSERVATIONS_DEG = (0.2, 0.5, 1.0, 2.0)
_ENTRANCES_DEG = ((-4.0, 0.0), (30.0, 0.0), (45.0, 0.0), (60.0, 0.0))
# Where curves against the observation angle begin, and end unless a class goes farther [degrees].
_FIRST_DEG, _LAST_DEG = 0.05, 2.5
# Where curves against the entrance angle end unless a class goes farther, then at the horizon [degrees].
_STEEPEST_DEG = 70.0


@dataclass(frozen=True)
class Series:
    """One curve, and the minima that lie on it.

    Attributes
    ----------
    name
        The angle that stands still.
    angle_deg, value : shape (n,)
    limit_deg, limit : shape (k,)
        Angles and values of the minima; empty where there are none.
    """

    name: str
    angle_deg: Array
    value: Array
    limit_deg: Array
    limit: Array


@dataclass(frozen=True)
class Panel:
    """Curves against one angle.

    Attributes
    ----------
    angle
        "observation" or "entrance".
    across
        Whether the entrance angle is beta2, to the left or right.
    quantity, unit
        Of the values.
    series
    """

    angle: str
    across: bool
    quantity: str
    unit: str
    series: list[Series]


def panels(brdf: Brdf, limits: Sequence[Limit], options: PhotometryOptions) -> list[Panel]:
    """Curves against the observation angle and against the entrance angle, through the geometries of a class.

    Parameters
    ----------
    brdf, limits, options
        As `photometry.report.measure`.

    Raises
    ------
    ValueError
        As `photometry.report.values`.
    """
    quantity, unit = (limits[0].quantity, limits[0].unit) if limits else ("R_A", "cd/lx/m2")

    def of(observation: Array, beta1: Array, beta2: Array) -> Array:
        return values(brdf, quantity, unit, np.deg2rad(observation), np.deg2rad(beta1), np.deg2rad(beta2), options)

    return [_by_observation(of, quantity, unit, limits), _by_entrance(of, quantity, unit, limits)]


def _by_observation(of: Callable[..., Array], quantity: str, unit: str, limits: Sequence[Limit]) -> Panel:
    ordered = sorted(limits, key=lambda limit: limit.entrance_deg)
    entrances = list(dict.fromkeys((limit.beta1_deg, limit.beta2_deg) for limit in ordered)) or _ENTRANCES_DEG
    last = max(_LAST_DEG, *(1.25 * limit.observation_deg for limit in limits), 0.0)
    angle = np.geomspace(_FIRST_DEG, last, 120)
    found = []
    for beta1, beta2 in entrances:
        there = [limit for limit in limits if (limit.beta1_deg, limit.beta2_deg) == (beta1, beta2)]
        name = f"{beta1:g}°".replace("-", "−") if beta2 == 0.0 else f"across {beta2:g}°"
        value = of(angle, np.full_like(angle, beta1), np.full_like(angle, beta2))
        found.append(Series(name, angle, value, *_marks([(c.observation_deg, c.minimum) for c in there])))
    return Panel("observation", False, quantity, unit, found)


def _by_entrance(of: Callable[..., Array], quantity: str, unit: str, limits: Sequence[Limit]) -> Panel:
    """Along beta1; of a reflector that is turned left and right, along beta2."""
    across = any(limit.beta2_deg for limit in limits)
    observations = sorted({limit.observation_deg for limit in limits}) or _OBSERVATIONS_DEG
    along = [limit for limit in limits if not (across and limit.beta1_deg)]
    reach = 90.0 if any(limit.entrance_deg > _STEEPEST_DEG for limit in along) else _STEEPEST_DEG
    # A smooth surface mirrors towards the receiver near 0: fine steps there.
    angle = np.unique(np.concatenate([np.linspace(-10.0, reach, 161), np.linspace(-3.0, 3.0, 121)]))
    zero, found = np.zeros_like(angle), []
    for observation in observations:
        there = [limit for limit in along if limit.observation_deg == observation]
        value = of(np.full_like(angle, observation), *((zero, angle) if across else (angle, zero)))
        marks = _marks([(c.beta2_deg if across else c.beta1_deg, c.minimum) for c in there])
        found.append(Series(f"{observation:g}°", angle, value, *marks))
    return Panel("entrance", across, quantity, unit, found)


def _marks(points: list[tuple[float, float]]) -> tuple[Array, Array]:
    array = np.array(sorted(points)).reshape(-1, 2)
    return array[:, 0], array[:, 1]
