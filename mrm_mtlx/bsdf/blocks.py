"""Evaluation over large arrays: in blocks that stay in the processor's cache, on all processors."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# Measured best of 2^10 to 2^18 for the conductor (benchmarks/oracle.md): smaller blocks wait for the interpreter
# lock, larger ones leave the cache.
BLOCK = 16384


# Freed below this, memory stays with the process, see `_keep_freed_memory` [bytes].
_KEPT = 16 << 20


def _keep_freed_memory() -> None:
    """Lets the C library keep what a block's temporaries leave behind, for those of the next.

    glibc returns freed memory to the system above twice the size of the largest array freed so far (mallopt(3),
    M_TRIM_THRESHOLD). A block's arrays are small: it would return all of it after each block, and half the time would
    go into getting it back page by page. This one is never written to and costs nothing. Elsewhere it has no effect.
    """
    np.empty(_KEPT, dtype=np.uint8)


_keep_freed_memory()


def processors() -> int:
    """Number of processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def evaluate_in_blocks(
    function: Callable[..., Array],
    scalars: dict[str, Array],
    colors: dict[str, Array],
    vectors: tuple[Array, ...],
    components: int = 3,
) -> Array:
    """Evaluate a lobe over the broadcast shape of its samples and parameters.

    Parameters
    ----------
    function
        Called as `function(*vectors, **scalars, **colors)` with the components first: vectors (3, m), scalars () or
        (m,), colours (3, 1) or (3, m); returns (components, m).
    scalars
        By name, shape (...).
    colors
        By name, shape (..., 3).
    vectors
        In order, shape (..., 3).
    components
        Of the result.

    Returns
    -------
    ndarray, shape (..., components)

    Raises
    ------
    ValueError
        If the shapes do not broadcast.
    """
    shapes = [a.shape for a in scalars.values()] + [a.shape[:-1] for a in (*colors.values(), *vectors)]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError as error:
        msg = f"samples and parameters do not broadcast: {', '.join(str(s) for s in shapes)}"
        raise ValueError(msg) from error
    count = math.prod(shape)
    flat_vectors = [np.broadcast_to(a, (*shape, 3)).reshape(count, 3) for a in vectors]
    flat_scalars = {k: a.reshape(()) if a.size == 1 else np.broadcast_to(a, shape).ravel() for k, a in scalars.items()}
    flat_colors = {
        k: a.reshape(1, 3) if a.size == 3 else np.broadcast_to(a, (*shape, 3)).reshape(count, 3)
        for k, a in colors.items()
    }
    result = np.empty((count, components))

    def fill(start: int) -> None:
        part = slice(start, start + BLOCK)
        result[part] = function(
            *(np.ascontiguousarray(a[part].T) for a in flat_vectors),
            **{k: a[part] if a.ndim else a for k, a in flat_scalars.items()},
            **{k: np.ascontiguousarray((a[part] if len(a) > 1 else a).T) for k, a in flat_colors.items()},
        ).T

    starts = range(0, count, BLOCK)
    if len(starts) < 2:
        for start in starts:
            fill(start)
    else:
        with ThreadPoolExecutor(min(processors(), len(starts))) as pool:
            for _ in pool.map(fill, starts):  # iterating raises what a block raised
                pass
    return result.reshape(*shape, components)
