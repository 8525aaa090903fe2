"""Ranges of parameters, and what is said of a value outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Range:
    """Values that a parameter may have.

    Parameters
    ----------
    lowest, highest
        Bounds; the highest is one of the values unless it is infinite.
    above
        Whether values have to be above the lowest, which is none of them.
    reason
        What explains the range, at the end of the message.
    """

    lowest: float
    highest: float = np.inf
    above: bool = False
    reason: str = ""

    def check(self, name: str, value: ArrayLike) -> None:
        """Raise ValueError, naming the parameter, if a value is outside or no finite number."""
        array = np.asarray(value, dtype=float)
        inside = array > self.lowest if self.above else array >= self.lowest
        if np.all(inside & (array <= self.highest) & np.isfinite(array)):
            return
        low, high = np.min(array), np.max(array)
        found = f"{low:g} to {high:g}" if high > low else f"{low:g}"
        reason = f"; {self.reason}" if self.reason else ""
        msg = f"{name} must be {self._expected()}, got {found}{reason}"
        raise ValueError(msg)

    def _expected(self) -> str:
        if np.isinf(self.highest):
            return f"{'>' if self.above else '>='} {self.lowest:g}"
        return f"in {'(' if self.above else '['}{self.lowest:g}, {self.highest:g}]"


POSITIVE = Range(0.0, above=True)
NOT_NEGATIVE = Range(0.0)
UNIT_INTERVAL = Range(0.0, 1.0)
