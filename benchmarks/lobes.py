"""What the benchmarks of lobes share: a metal, directions, and what is timed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

GOLD: dict[str, Any] = {"ior": (0.183, 0.421, 1.373), "extinction": (3.424, 2.346, 1.770)}
COUNT = 1 << 20
COLUMNS = ("eval", "pdf", "sample")


def directions() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Directions v and l over the upper hemisphere, and random numbers."""
    rng = np.random.default_rng(0)
    v, l = (np.abs(rng.normal(size=(COUNT, 3))) for _ in range(2))
    v, l = (a / np.linalg.norm(a, axis=1, keepdims=True) for a in (v, l))
    return v, l, rng.uniform(size=(COUNT, 3))


def timed(lobe: Any, v: Any, l: Any, u: Any) -> tuple[Callable[[], object], ...]:
    """The calls of a lobe that are timed, as in COLUMNS."""
    return lambda: lobe.eval(v, l), lambda: lobe.pdf(v, l), lambda: lobe.sample(v, u)
