"""Materials that meet the minima of a class, from above and as closely as a few lobes can.

Of a lobe, the minima of a class know the width, the entrance-angle fall-off and the height. With m the margin and R the
material's values where the class has minima M, what is sought is

    min sum ln^2(R / (m M))        so that R >= m M everywhere, and the returned share <= ceiling of the construction.

The share is what comes back within 2 degrees, the largest observation angle of any class: of a GGX lobe at normal
incidence, where a falling lobe returns most, color0 t^2 / (alpha^2 + t^2) with t = tan(1 degree).

What the class does not fix is given: the fall-off where there is one entrance angle, the width where there is one
observation angle. A second lobe comes in only if one cannot meet the class below the ceiling. The mirror image of a
clear face counts for nothing. The base gets the colour by day that is asked for, at 45/0 degrees under D65.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.fitting.model import NARROWEST, Evaluator, LayerStack, Part, albedos
from mrm_mtlx.photometry import goniometer
from mrm_mtlx.photometry.coefficients import WITHIN
from mrm_mtlx.photometry.color import luminance, to_xyz
from mrm_mtlx.photometry.report import PhotometryOptions, measure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.standards.tables import Limit

# Largest share of the light that a construction returns: a supplier's figures (Traffic Signs Minnesota, "Reflective
# Sign Standards": beads 7 to 14 %, cube corners that are cut about 32 %, whole ones 58 %).
CEILINGS = {"glass beads": 0.14, "truncated cube corners": 0.32, "full cube corners": 0.58}
# How far above each minimum a material stands: rounded numbers and single precision take a thousandth of it.
MARGIN = 1.03
# Where the minima do not say: as prismatic tape falls off, and as wide as keeps markings level from 10 to 50 m.
USUAL_EXPONENT, USUAL_ALPHA = 0.5, 0.04
_WIDEST = 0.1
# Below a third, single precision loses the peak: F = color0 (1 - (1 - c)^e) at c = 1 - 1e-7 is off by 1e-7^e.
_EXPONENTS = (0.35, 5.0)
# The geometry of colour by day [rad]: light at 45 degrees, the viewer along the normal.
_DAY = np.deg2rad([45.0, 45.0])


@dataclass(frozen=True)
class Make:
    """The make of a material: what its class does not say.

    Attributes
    ----------
    construction
        A name of `CEILINGS`.
    tint : (3,)
        Colour of the lobes, linear Rec.709; the largest is 1.
    day : (x, y, Y)
        CIE 1931 by day; Y is the luminance factor, 1 for white.
    face_alpha
        Width of the clear face, None for none.
    area_cm2
        Of the reflector, where the class is of intensities.
    """

    construction: str
    tint: tuple[float, float, float]
    day: tuple[float, float, float]
    face_alpha: float | None = None
    area_cm2: float | None = None


@dataclass(frozen=True)
class Met:
    """A material that meets a class: its parameters as a document has them, and its values over the minima."""

    stack: LayerStack
    values: dict[str, Array]
    ratios: Array

    @property
    def share(self) -> float:
        """Share that the lobes return within 2 degrees at normal incidence; brightest channel, without a face."""
        return _share(self.stack, self.values)


def meet(limits: Sequence[Limit], make: Make, margin: float = MARGIN) -> Met:
    """The material of a make that meets the minima of a class most closely.

    Raises
    ------
    ValueError
        If two lobes below the ceiling do not meet it, or the colour by day needs a base that is none.
    """
    ceiling = CEILINGS[make.construction]
    for lobes in (1, 2):
        problem = _Problem(limits, make, lobes, margin)
        found = problem.best()
        if found is not None and found.share <= ceiling:
            return _with_day_color(problem, found, make)
    msg = f"two lobes do not meet the class within the {ceiling:g} that {make.construction} return"
    raise ValueError(msg)


class _Problem:
    """One class and a number of lobes; what is free are logarithms of its numbers."""

    def __init__(self, limits: Sequence[Limit], make: Make, lobes: int, margin: float) -> None:
        self.stack = LayerStack(coats=int(make.face_alpha is not None), lobes=lobes, falling=True, channels=3)
        self._make, self._ceiling = make, CEILINGS[make.construction]
        geometries = np.deg2rad([(limit.observation_deg, limit.beta1_deg, limit.beta2_deg) for limit in limits])
        directions = goniometer.directions(*geometries.T)
        self._model = Evaluator(self.stack, *directions)
        self._face = Evaluator(replace(self.stack, lobes=0, diffuse=False), *directions)
        # What a BRDF of 1 measures is the factor between f and the quantity of each minimum.
        options = PhotometryOptions(rotations_deg=(0.0,), area_cm2=make.area_cm2)
        cells = measure(lambda v, l: np.ones(np.broadcast_shapes(v.shape, l.shape)), limits, options).cells
        self._factor = np.array([cell.value for cell in cells])
        self._wanted = margin * np.array([limit.minimum for limit in limits])
        free = len(np.unique(geometries[:, 0])) > 1, len(np.unique(geometries[:, 1:], axis=0)) > 1
        self._widths = (NARROWEST, _WIDEST) if free[0] else (USUAL_ALPHA, USUAL_ALPHA)
        self._exponents = _EXPONENTS if free[1] else (USUAL_EXPONENT, USUAL_EXPONENT)

    def best(self) -> Met | None:
        """The closest from above, of searches from several starts; None if none meets the class below the ceiling."""
        from scipy.optimize import minimize

        bounds = np.log([self._exponents, *[self._widths, _HEIGHTS] * self.stack.lobes])
        above = {"type": "ineq", "fun": self._room}
        options = {"ftol": 1e-9, "maxiter": 100}
        results = [
            minimize(self._distance, np.clip(start, *bounds.T), bounds=bounds, constraints=above, options=options)
            for start in self._starts()
        ]
        feasible = [result for result in results if np.min(self._room(result.x)) > -_MISSED]
        if not feasible:
            return None
        best = min(feasible, key=lambda result: float(result.fun))
        values = self.stack.rounded(self._as_high_as_needed(self._values(best.x)))
        return Met(self.stack, values, self.ratios(values))

    def ratios(self, values: dict[str, Array]) -> Array:
        """Values over the minima with their margin."""
        f = self._model.eval(values)
        if self.stack.coats:
            f = f - self._face.eval(values)
        return np.asarray(luminance(f) * self._factor / self._wanted)

    def _starts(self) -> list[Array]:
        """Vectors of the exponent, and of width and height of each lobe."""
        lobes = [[(0.0035, 0.1)], [(0.006, 0.2)], [(0.015, 0.3)]]
        if self.stack.lobes == 2:
            lobes = [[first[0], (4.0 * first[0][0], first[0][1])] for first in lobes]
        return [np.log([e, *np.ravel(lobe)]) for lobe in lobes for e in (0.4, 1.0)]

    def _values(self, x: Array) -> dict[str, Array]:
        exponent, *lobes = np.exp(x)
        values = {"diffuse.color": np.full(3, self._make.day[2])}
        for name, alpha, height in zip((Part.LOBE, Part.LOBE2), lobes[::2], lobes[1::2], strict=False):
            values |= {f"{name}.alpha": np.array([alpha]), f"{name}.exponent": np.array([exponent])}
            values[f"{name}.color0"] = height * np.array(self._make.tint)
        if self._make.face_alpha is not None:
            values |= {"coat.weight": np.ones(1), "coat.alpha": np.array([self._make.face_alpha])}
        return values

    def _distance(self, x: Array) -> float:
        return float(np.sum(np.square(self._room(x)[:-1])))

    def _room(self, x: Array) -> Array:
        """Logarithms: how far each value is above its minimum, and at the end the share below its ceiling."""
        values = self._values(x)
        share = np.log(_SLACK * self._ceiling / _share(self.stack, values))
        return np.append(np.log(self.ratios(values)), share)

    def _as_high_as_needed(self, values: dict[str, Array]) -> dict[str, Array]:
        """The same with heights that meet every minimum, and the nearest exactly."""
        for _ in range(_ROUNDS):  # what is not of the lobes does not grow with them
            factor = 1.0 / np.min(self.ratios(values))
            values = {name: value * factor if name.endswith(".color0") else value for name, value in values.items()}
        return values


# Rounds in which the height is found: exact after one but for the layers' shares.
_ROUNDS = 4
# How far a search may end below a minimum, and how much below the ceiling it stays, which raising it has to spare.
_MISSED, _SLACK = 1e-3, 0.998
# Bounds of heights, color0.
_HEIGHTS = (1e-4, 1.0)


def _share(stack: LayerStack, values: dict[str, Array]) -> float:
    """A bound of it: layers let less through than everything."""
    t2 = np.tan(0.5 * WITHIN) ** 2
    shares = [values[f"{lobe}.color0"] * t2 / (values[f"{lobe}.alpha"] ** 2 + t2) for lobe in stack.retroreflective]
    return float(np.max(np.sum(shares, axis=0)))


def _with_day_color(problem: _Problem, found: Met, make: Make) -> Met:
    """The base in the colour that gives the one asked for, which what lies above dims."""
    x, y, factor = make.day
    wanted = np.linalg.solve(to_xyz("D65"), factor * np.array([x / y, 1.0, (1.0 - x - y) / y])) / np.pi
    v, l = (part[None] for part in goniometer.directions(*_DAY))
    model = Evaluator(found.stack, v, l)
    black, white = (model.eval(found.values | {"diffuse.color": np.full(3, c)})[0] for c in (0.0, 1.0))
    color = (wanted - black) / (white - black)
    values = found.stack.rounded(found.values | {"diffuse.color": color})
    if not np.all((color >= 0.0) & (color <= 1.0)):
        msg = f"the base would need the colour {', '.join(f'{c:.3f}' for c in color)} for x {x}, y {y}, Y {factor}"
        raise ValueError(msg)
    if (most := float(np.max(albedos(found.stack, values, np.cos(np.deg2rad([0.0, 60.0, 75.0, 85.0])))))) > 1.0:
        msg = f"the material would reflect {most:.3f} of the light"
        raise ValueError(msg)
    return Met(found.stack, values, problem.ratios(values))
