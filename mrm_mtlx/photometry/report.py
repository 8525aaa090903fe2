"""Values of a surface in the geometries of a class, beside the minima and colour boxes: plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.photometry import color, goniometer
from mrm_mtlx.photometry.coefficients import (
    MARKING_ENTRANCE,
    MARKING_OBSERVATION,
    coefficient,
    r_l,
    retroreflected_fraction,
)
from mrm_mtlx.standards.quantities import Quantity
from mrm_mtlx.standards.tables import boxes
from mrm_mtlx.system.arguments import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.photometry.coefficients import Brdf
    from mrm_mtlx.standards.tables import Box, Limit

# Geometries where no class is asked for [degrees]: those of the classes, along the normal, and beyond them.
OBSERVATIONS_DEG = (0.1, 0.2, 0.33, 0.5, 1.0, 2.0)
ENTRANCES_DEG = (-4.0, 0.0, 5.0, 30.0, 45.0, 60.0)
# Units of R_I in a cd/lx; there are as many square feet in a square metre: 1 fc = 10.76 lx.
_INTENSITY_UNITS = {"mcd/lx": 1000.0, "cd/fc": 0.3048**-2}
# A mirror does not reach the receiver at this entrance angle [degrees], where the returned share is taken.
RETURNED_ENTRANCE_DEG = 5.0
# Colours of reflectors under the names of the boxes.
_BOX_COLOURS = {"clear": "white", "amber": "yellow"}


@dataclass(frozen=True)
class PhotometryOptions:
    """Options of a measurement.

    Attributes
    ----------
    rotations_deg
        Rotations epsilon, over which values are averaged; ASTM D4956 has 0 and 90 degrees.
    source_aperture_deg, receiver_aperture_deg
        Diameters of the discs [degrees].
    method
        Of `color.METHODS`.
    area_cm2
        Of the reflector, for intensities R_I.
    radius_cm
        Inner radius of the strip, for R_I/r.
    """

    rotations_deg: tuple[float, ...] = (0.0, 90.0)
    source_aperture_deg: float = 0.0
    receiver_aperture_deg: float = 0.0
    method: str = "spectral"
    area_cm2: float | None = None
    radius_cm: float | None = None


@dataclass(frozen=True)
class Cell:
    """A value in one geometry, and the minimum it is held to, if any."""

    observation_deg: float
    entrance_deg: float
    beta1_deg: float
    beta2_deg: float
    quantity: Quantity
    unit: str
    value: float
    minimum: float | None = None

    @property
    def met(self) -> bool:
        """True if the value is no less than the minimum, or there is none."""
        return self.minimum is None or self.value >= self.minimum


@dataclass(frozen=True)
class Chromaticity:
    """Colour of a surface in one geometry, and the box it is held to.

    Attributes
    ----------
    illuminant, observation_deg, beta1_deg
        Its geometry.
    x, y
        CIE 1931; NaN where the surface is black.
    factor
        Luminance factor pi f, 1 for a perfect diffuser.
    box, margin
        The box, and the distance to its nearest edge, negative outside; None where there is none.
    counts
        Whether the box belongs to the standard that was asked for; else it is a yardstick.
    """

    illuminant: str
    observation_deg: float
    beta1_deg: float
    x: float
    y: float
    factor: float
    box: Box | None
    margin: float | None
    counts: bool

    @property
    def met(self) -> bool:
        """True if the colour is in the box, or that does not count."""
        return not self.counts or self.margin is None or self.margin >= 0.0


@dataclass(frozen=True)
class SurfaceReport:
    """The values of a surface.

    Attributes
    ----------
    cells
        A value per geometry.
    colors
        By day and at night.
    returned
        Share of the luminous flux that comes back within `coefficients.WITHIN` at entrance `RETURNED_ENTRANCE_DEG`.
    """

    cells: list[Cell]
    colors: list[Chromaticity]
    returned: float

    @property
    def met(self) -> bool:
        """True if every minimum and every box that counts is met."""
        return all(cell.met for cell in self.cells) and all(color.met for color in self.colors)


def measure(
    brdf: Brdf,
    limits: Sequence[Limit],
    options: PhotometryOptions,
    observations_deg: Sequence[float] = OBSERVATIONS_DEG,
    entrances_deg: Sequence[float] = ENTRANCES_DEG,
) -> SurfaceReport:
    """Measure a surface in the geometries of a class, or in a grid and that of road markings where there is none.

    Parameters
    ----------
    brdf
        Of linear Rec.709 channels.
    limits
        The minima of one class, or none.
    options
        How.
    observations_deg, entrances_deg
        The grid.

    Raises
    ------
    ValueError
        If a quantity needs a size that the options do not have, or the surface has no finite value somewhere.
    """
    cells = _against(brdf, limits, options) if limits else _grid(brdf, options, observations_deg, entrances_deg)
    returned = _averaged(
        lambda epsilon: retroreflected_fraction(brdf, np.deg2rad(RETURNED_ENTRANCE_DEG), 0.0, epsilon), options
    )
    return SurfaceReport(cells, _colors(brdf, limits, options), float(color.luminance(returned, "A", options.method)))


def values(
    brdf: Brdf,
    quantity: Quantity,
    unit: str,
    observation: ArrayLike,
    beta1: ArrayLike,
    beta2: ArrayLike,
    options: PhotometryOptions,
) -> Array:
    """A quantity of the standards, in its unit, under illuminant A; angles [rad], shape (...) -> (...).

    R_I = R_A A, and 1 cd/fc = 10.76 cd/lx.

    Raises
    ------
    ValueError
        If the size that the quantity needs is not known.
    """
    found_by = _MEASURES[quantity]
    discs = {
        "source_aperture": float(np.deg2rad(options.source_aperture_deg)),
        "receiver_aperture": float(np.deg2rad(options.receiver_aperture_deg)),
    }
    found = _averaged(lambda epsilon: found_by.function(brdf, observation, beta1, beta2, epsilon, **discs), options)
    return color.luminance(found, "A", options.method) * found_by.scale(quantity, unit, options)


def check_sizes(limits: Sequence[Limit], options: PhotometryOptions) -> None:
    """Raise an ArgumentError if a minimum needs a size that the options lack, or none needs one that they have."""
    quantities = {limit.quantity for limit in limits}
    for limit in limits:
        _MEASURES[limit.quantity].scale(limit.quantity, limit.unit, options)
    if options.area_cm2 is not None and not any(quantity.needs_area for quantity in quantities):
        msg = "an area is for limits of intensity (R_I); R_A and R_L are of the material, whatever its size"
        raise ArgumentError(msg)
    if options.radius_cm is not None and not any(quantity.needs_radius for quantity in quantities):
        msg = "a radius is for strips on tyres and rims (R_I/r) alone"
        raise ArgumentError(msg)


def _of_material(_quantity: Quantity, _unit: str, _options: PhotometryOptions) -> float:
    return 1.0


def _area_m2(quantity: Quantity, unit: str, options: PhotometryOptions) -> float:
    if options.area_cm2 is None:
        msg = f"{quantity} [{unit}] is of a whole reflector: give its area, `area` CM2"
        raise ArgumentError(msg)
    return 1e-4 * options.area_cm2


def _of_reflector(quantity: Quantity, unit: str, options: PhotometryOptions) -> float:
    return _area_m2(quantity, unit, options) * _INTENSITY_UNITS[unit]


def _of_strip(quantity: Quantity, unit: str, options: PhotometryOptions) -> float:
    area = _area_m2(quantity, unit, options)
    if options.radius_cm is None:
        msg = f"{quantity} [{unit}] is of a whole strip over its inner radius: give that, `radius` CM"
        raise ArgumentError(msg)
    return area / (0.01 * options.radius_cm)


@dataclass(frozen=True)
class _Measure:
    """The way a quantity is found: a coefficient of the material, and the factor on it, which may need a size."""

    function: Callable[..., Array]
    scale: Callable[[Quantity, str, PhotometryOptions], float] = _of_material


_MEASURES = {
    Quantity.R_A: _Measure(coefficient),
    Quantity.R_L: _Measure(r_l),
    Quantity.R_I: _Measure(coefficient, _of_reflector),
    Quantity.R_I_OVER_R: _Measure(coefficient, _of_strip),
}


def _averaged(function: Callable[[float], Array], options: PhotometryOptions) -> Array:
    found = [np.asarray(function(epsilon)) for epsilon in np.deg2rad(options.rotations_deg)]
    return np.asarray(np.mean(found, axis=0))


def _against(brdf: Brdf, limits: Sequence[Limit], options: PhotometryOptions) -> list[Cell]:
    geometries = [(limit.observation_deg, limit.beta1_deg, limit.beta2_deg) for limit in limits]
    observation, beta1, beta2 = np.deg2rad(geometries).T
    found = np.empty(len(limits))
    for kind in dict.fromkeys((limit.quantity, limit.unit) for limit in limits):
        chosen = [i for i, limit in enumerate(limits) if (limit.quantity, limit.unit) == kind]
        found[chosen] = values(brdf, *kind, observation[chosen], beta1[chosen], beta2[chosen], options)
    return [
        Cell(
            limit.observation_deg,
            limit.entrance_deg,
            limit.beta1_deg,
            limit.beta2_deg,
            limit.quantity,
            limit.unit,
            float(value),
            limit.minimum,
        )
        for limit, value in zip(limits, found, strict=True)
    ]


def _grid(
    brdf: Brdf, options: PhotometryOptions, observations: Sequence[float], entrances: Sequence[float]
) -> list[Cell]:
    geometries = [(observation, entrance) for observation in observations for entrance in entrances]
    angles = np.deg2rad(geometries)
    found = values(brdf, Quantity.R_A, "cd/lx/m2", angles[:, 0], angles[:, 1], 0.0, options)
    cells = [
        Cell(observation, entrance, entrance, 0.0, Quantity.R_A, "cd/lx/m2", float(value))
        for (observation, entrance), value in zip(geometries, found, strict=True)
    ]
    marking = values(brdf, Quantity.R_L, "mcd/lx/m2", MARKING_OBSERVATION, MARKING_ENTRANCE, 0.0, options)
    observation, entrance = (round(float(np.rad2deg(a)), 6) for a in (MARKING_OBSERVATION, MARKING_ENTRANCE))
    return [*cells, Cell(observation, entrance, entrance, 0.0, Quantity.R_L, "mcd/lx/m2", float(marking))]


def _colors(brdf: Brdf, limits: Sequence[Limit], options: PhotometryOptions) -> list[Chromaticity]:
    return [_color(brdf, _candidates(illuminant, limits), limits, options) for illuminant in ("D65", "A")]


def _candidates(illuminant: str, limits: Sequence[Limit]) -> list[Box]:
    """Boxes for what the class is made of: those of its own standard, or of sheeting or pavement markings."""
    there = [box for box in boxes() if box.illuminant == illuminant]
    own = [box for box in there if limits and box.standard == limits[0].standard]
    subject = (limits[0].quantity if limits else Quantity.R_A).subject
    return own or [box for box in there if box.subject == subject]


def _color(brdf: Brdf, candidates: list[Box], limits: Sequence[Limit], options: PhotometryOptions) -> Chromaticity:
    """The colour in the geometry of the boxes, against that of the class's colour, or else the one that fits best."""
    first = candidates[0]  # they share illuminant and geometry
    observation, beta1 = np.deg2rad([first.observation_deg, first.beta1_deg])
    f = _averaged(lambda epsilon: brdf(*goniometer.directions(observation, beta1, 0.0, epsilon)), options)
    x, y = (float(value) for value in color.chromaticity(f, first.illuminant, options.method))
    wanted = limits[0].colour if limits else ""
    wanted = _BOX_COLOURS.get(wanted, wanted)
    named = [box for box in candidates if box.colour == wanted]
    fitting = named or ([] if wanted not in ("", "unspecified") else candidates)
    margins = {box: box.margin(x, y) for box in fitting if np.isfinite(x)}
    best = max(margins, key=lambda box: margins[box], default=None)
    return Chromaticity(
        first.illuminant,
        first.observation_deg,
        first.beta1_deg,
        x,
        y,
        float(np.pi * color.luminance(f, first.illuminant, options.method)),
        best,
        None if best is None else margins[best],
        best is not None and bool(limits) and best.standard == limits[0].standard,
    )
