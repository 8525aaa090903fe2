"""The difference of two materials: of their reference values at fixed random points, and as standards measure them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.formats.pbr.directions import DAY, NIGHT, points
from mrm_mtlx.photometry.color import luminance
from mrm_mtlx.reference import Environment, Illumination, ShadingPoints, Surface

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

    Pixels = Callable[[str], NDArray[np.floating] | None]

# Largest relative difference that is rounding: numbers are written with nine digits and made images with sixteen bits,
# and the flank of a narrow lobe multiplies what its width is off by.
ROUNDING = 1e-4
_POINTS, _IN_ENVIRONMENT = 120, 8
_SEED = 7
# R_A of a white diffuser, 1 / pi, and rounding [cd/(lx m^2)]: what is below returns nothing of its own.
_PAINT = 0.32
# Places over which what standards measure is averaged: they measure areas.
_PLACES = 64


def difference(
    first: tuple[Any, Pixels], second: tuple[Any, Pixels], *, transmits: bool = False
) -> tuple[float, float]:
    """Largest and mean difference of two renderable elements, relative to the larger value at each point.

    Each comes with what gives it the pixels of its files. Points are seen under one light, a third of them near the
    direction back to it and a third near the mirror's; emission is included. What is seen through what `transmits` is
    there in an environment alone, so that some points are then seen in a white one, too.

    Raises
    ------
    UnsupportedError, RecursionError
        If the reference cannot evaluate one of them.
    """
    surfaces = [Surface(element, images=pixels) for element, pixels in (first, second)]
    samples = _points(np.random.default_rng(_SEED))
    around = Illumination(light=False, environment=Environment.constant((1.0, 1.0, 1.0), samples=8))
    few = samples.part(slice(None, None, _POINTS // _IN_ENVIRONMENT))
    shades = [np.concatenate([s.shade(samples), *([s.shade(few, around)] if transmits else [])]) for s in surfaces]
    scale = np.maximum(np.abs(shades[0]).max(axis=1), np.abs(shades[1]).max(axis=1))
    # Where both are dark, a difference is one of what can be seen: a hundredth of a white diffuser.
    apart = np.abs(shades[0] - shades[1]).max(axis=1) / np.maximum(scale, 0.01 / np.pi)
    if not np.all(np.isfinite(apart)):
        return float("inf"), float("inf")
    return float(apart.max()), float(apart.mean())


class Photometry(NamedTuple):
    """What standards measure of a surface, in the mean over places.

    Attributes
    ----------
    day
        Luminance factor under D65, viewed along the normal and lit at 45 degrees: 1 is a white diffuser.
    night
        R_A under illuminant A, observation 0.2 and entrance -4 degrees [cd/(lx m^2)].
    """

    day: float
    night: float


def photometry(element: Any, pixels: Pixels) -> Photometry:
    """What standards measure of a renderable element, which comes with what gives it the pixels of its files.

    Raises
    ------
    UnsupportedError, RecursionError
        If the reference cannot evaluate it.
    """
    at = points(np.stack([DAY[0], NIGHT[0]]), np.stack([DAY[1], NIGHT[1]]), _PLACES, _SEED)
    day, night = Surface(element, images=pixels).response(at).reshape(_PLACES, 2, 3).mean(axis=0)
    factor = np.pi * float(luminance(day, "D65")) / DAY[1][2]
    return Photometry(factor, float(luminance(night, "A") * NIGHT[0][2]))


def told(apart: tuple[float, float], before: Photometry, after: Photometry) -> str:
    """A `difference`, and what standards measure of both, in words that go on from "it" or "in which"."""
    largest, mean = (f"{100.0 * share:.3g} %" for share in apart)
    words = f"its values differ by up to {largest}, {mean} in the mean"
    words += f"; by day (45:0) it reflects {after.day:.3g} instead of {before.day:.3g} of the light"
    if max(before.night, after.night) > _PAINT:
        words += f", by night its R_A (0.2, -4 degrees) is {after.night:.3g} instead of {before.night:.3g} cd/lx/m2"
    return words


def _points(rng: np.random.Generator) -> ShadingPoints:
    view, light = _directions(rng, _POINTS), _directions(rng, _POINTS)
    third = _POINTS // 3
    spread = rng.normal(0.0, 0.1, (2 * third, 3))
    near = np.concatenate([view[:third], view[third : 2 * third] * [-1.0, -1.0, 1.0]]) + spread
    near[:, 2] = np.maximum(np.abs(near[:, 2]), 0.05)
    light[: 2 * third] = near / np.linalg.norm(near, axis=1, keepdims=True)
    return ShadingPoints(
        view=view,
        light=light,
        normal=np.tile([0.0, 0.0, 1.0], (_POINTS, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (_POINTS, 1)),
        position=rng.uniform(-1.0, 1.0, (_POINTS, 3)),
        texcoord=rng.uniform(0.0, 1.0, (_POINTS, 2)),
    )


def _directions(rng: np.random.Generator, count: int) -> Array:
    """Unit directions over the upper hemisphere, up to 87 degrees from the normal."""
    z, phi = rng.uniform(0.05, 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
