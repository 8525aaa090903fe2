"""Coefficients and colours as a caller gives them: numbers, or their text on a command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mrm_mtlx.measured import Coefficient, CoefficientSamples
from mrm_mtlx.system.arguments import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

# The three numbers of a `measured.Coefficient`; or their text with colons between.
CoefficientLike: TypeAlias = str | tuple[float, float, float]
# Linear Rec.709; or the text of the numbers with commas between.
Color: TypeAlias = str | tuple[float, float, float]
# Largest R_A that is taken [cd/(lx m^2)]: full cube corners at 0.1 degrees stay below a hundredth of it.
LARGEST_RA = 1e6


def coefficient_samples(given: Sequence[CoefficientLike]) -> CoefficientSamples:
    """Coefficients to be fitted.

    Raises
    ------
    ArgumentError
        If one is not three numbers, or out of range.
    """
    observation, entrance, value = np.array([_coefficient(one) for one in given]).T
    return CoefficientSamples("", np.deg2rad(observation), np.deg2rad(entrance), np.zeros(len(given)), value)


def _coefficient(given: CoefficientLike) -> Coefficient:
    try:
        observation, entrance, value = _numbers(given, ":")
    except (TypeError, ValueError):
        msg = f"'{text(given, ':')}': expected OBS:ENTRANCE:VALUE, such as 0.2:-4:250"
        raise ArgumentError(msg, "ra") from None
    if not (0.0 <= observation < 90.0 and -90.0 < entrance < 90.0 and 0.0 < value <= LARGEST_RA):
        expected = "angles of 0 to 90 and -90 to 90 degrees, and an R_A above 0 (at most 1e6)"
        msg = f"'{text(given, ':')}': expected {expected}"
        raise ArgumentError(msg, "ra")
    return Coefficient(observation, entrance, value)


def tints(tint: Color | None, base: Color | None) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Colour of the lobe, its largest 1, by default white; and of the base, by default half of it.

    Raises
    ------
    ArgumentError
        If one is not three numbers from 0 to 1, or the lobe's is black.
    """
    lobe = (1.0, 1.0, 1.0) if tint is None else _color(tint, "tint")
    if max(lobe) <= 0.0:
        msg = f"'{text(tint, ',')}': expected a colour that is not black"
        raise ArgumentError(msg, "tint")
    red, green, blue = (x / max(lobe) for x in lobe)
    return (red, green, blue), _color(base, "base") if base is not None else (red / 2, green / 2, blue / 2)


def _color(given: Color, argument: str) -> tuple[float, float, float]:
    try:
        red, green, blue = _numbers(given, ",")
    except (TypeError, ValueError):
        msg = f"'{text(given, ',')}': expected three numbers, R,G,B"
        raise ArgumentError(msg, argument) from None
    if not all(0.0 <= x <= 1.0 for x in (red, green, blue)):
        msg = f"'{text(given, ',')}': expected numbers from 0 to 1"
        raise ArgumentError(msg, argument)
    return red, green, blue


def _numbers(given: str | Iterable[float], separator: str) -> list[float]:
    return [float(x) for x in (given.split(separator) if isinstance(given, str) else given)]


def text(given: Any, separator: str) -> str:
    """A coefficient or a colour as the command line writes it."""
    if isinstance(given, str) or not hasattr(given, "__iter__"):
        return str(given)
    return separator.join(f"{x:g}" if isinstance(x, float | int) else str(x) for x in given)
