"""Coefficients of retroreflection against the observation and the entrance angle: the data of a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.photometry.report import values
from mrm_mtlx.standards.quantities import Quantity

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
    """One curve, and the marks that lie on it.

    Attributes
    ----------
    name
        The angle that stands still.
    angle_deg, value : shape (n,)
    limit_deg, limit : shape (k,)
        Angles and values of the marks; empty where there are none.
    """

    name: str
    angle_deg: Array
    value: Array
    limit_deg: Array
    limit: Array


@dataclass(frozen=True)
class CoefficientPanel:
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
    quantity: Quantity
    unit: str
    series: list[Series]


@dataclass(frozen=True)
class Mark:
    """A value that is drawn beside the curves, in its geometry [degrees]: a minimum, or what was measured."""

    observation_deg: float
    entrance_deg: float
    beta1_deg: float
    beta2_deg: float
    value: float


def class_panels(brdf: Brdf, limits: Sequence[Limit], options: PhotometryOptions) -> list[CoefficientPanel]:
    """Curves through the geometries of a class, with its minima; of no class, of R_A at an even choice of angles.

    Parameters
    ----------
    brdf, limits, options
        As `photometry.report.measure`.

    Raises
    ------
    ValueError
        As `photometry.report.values`.
    """
    quantity, unit = (limits[0].quantity, limits[0].unit) if limits else (Quantity.R_A, "cd/lx/m2")
    marks = [Mark(c.observation_deg, c.entrance_deg, c.beta1_deg, c.beta2_deg, c.minimum) for c in limits]
    return panels(brdf, marks, options, quantity, unit)


def panels(
    brdf: Brdf,
    marks: Sequence[Mark],
    options: PhotometryOptions,
    quantity: Quantity = Quantity.R_A,
    unit: str = "cd/lx/m2",
) -> list[CoefficientPanel]:
    """Curves against the observation angle and against the entrance angle, through the geometries of the marks.

    Raises
    ------
    ValueError
        As `photometry.report.values`.
    """

    def of(observation: Array, beta1: Array, beta2: Array) -> Array:
        return values(brdf, quantity, unit, np.deg2rad(observation), np.deg2rad(beta1), np.deg2rad(beta2), options)

    return [_by_observation(of, quantity, unit, marks), _by_entrance(of, quantity, unit, marks)]


def _by_observation(of: Callable[..., Array], quantity: Quantity, unit: str, marks: Sequence[Mark]) -> CoefficientPanel:
    ordered = sorted(marks, key=lambda mark: mark.entrance_deg)
    entrances = list(dict.fromkeys((mark.beta1_deg, mark.beta2_deg) for mark in ordered)) or _ENTRANCES_DEG
    last = max(_LAST_DEG, *(1.25 * mark.observation_deg for mark in marks), 0.0)
    angle = np.geomspace(_FIRST_DEG, last, 120)
    found = []
    for beta1, beta2 in entrances:
        there = [mark for mark in marks if (mark.beta1_deg, mark.beta2_deg) == (beta1, beta2)]
        name = f"{beta1:g}°".replace("-", "−") if beta2 == 0.0 else f"across {beta2:g}°"
        value = of(angle, np.full_like(angle, beta1), np.full_like(angle, beta2))
        found.append(Series(name, angle, value, *_points([(mark.observation_deg, mark.value) for mark in there])))
    return CoefficientPanel("observation", False, quantity, unit, found)


def _by_entrance(of: Callable[..., Array], quantity: Quantity, unit: str, marks: Sequence[Mark]) -> CoefficientPanel:
    """Along beta1; of a reflector that is turned left and right, along beta2."""
    across = any(mark.beta2_deg for mark in marks)
    observations = sorted({mark.observation_deg for mark in marks}) or _OBSERVATIONS_DEG
    along = [mark for mark in marks if not (across and mark.beta1_deg)]
    reach = 90.0 if any(mark.entrance_deg > _STEEPEST_DEG for mark in along) else _STEEPEST_DEG
    # A smooth surface mirrors towards the receiver near 0: fine steps there.
    angle = np.unique(np.concatenate([np.linspace(-10.0, reach, 161), np.linspace(-3.0, 3.0, 121)]))
    zero, found = np.zeros_like(angle), []
    for observation in observations:
        there = [mark for mark in along if mark.observation_deg == observation]
        value = of(np.full_like(angle, observation), *((zero, angle) if across else (angle, zero)))
        points = _points([(mark.beta2_deg if across else mark.beta1_deg, mark.value) for mark in there])
        found.append(Series(f"{observation:g}°", angle, value, *points))
    return CoefficientPanel("entrance", across, quantity, unit, found)


def _points(points: list[tuple[float, float]]) -> tuple[Array, Array]:
    array = np.array(sorted(points)).reshape(-1, 2)
    return array[:, 0], array[:, 1]
