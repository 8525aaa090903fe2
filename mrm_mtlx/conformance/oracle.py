"""The oracle over many samples: in batches, on all processors, while an engine is at work."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.blocks import processors
from mrm_mtlx.reference import Tolerance

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from mrm_mtlx.reference import ShadingPoints, Surface

# Samples per evaluation: its temporaries stay in the processor's cache.
_BATCH = 1 << 14


class Oracle:
    """The expected values of a surface, evaluated in the background; a context manager."""

    def __init__(self, surface: Surface, points: ShadingPoints) -> None:
        self._pool = ThreadPoolExecutor(processors())
        batches = [points.part(slice(start, start + _BATCH)) for start in range(0, len(points), _BATCH)]
        self._futures = [self._pool.submit(surface.tolerance, batch) for batch in batches]

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop what did not begin."""
        self._pool.shutdown(cancel_futures=True)

    def tolerance(self) -> Tolerance:
        """Expected values of all samples and what is allowed; waits for them."""
        found = [future.result() for future in self._futures]
        return Tolerance(np.concatenate([t.expected for t in found]), np.concatenate([t.allowed for t in found]))
