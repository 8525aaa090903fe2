"""Integers to pseudo-random numbers, to the bit as shaders have them: Bob Jenkins' hash "lookup3" (2006).

http://burtleburtle.net/bob/c/lookup3.c, the function `hashword` with an initial value of 13. OSL's noise is built on
it, and MaterialX's after OSL's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

_START = 0xDEADBEEF + 13

# Bits by which the steps of the hash rotate, in their order; each step takes the three words one place on.
_MIX = (4, 6, 8, 16, 19, 4)
_FINAL = (14, 11, 25, 16, 4, 14, 24)


def hashed(*keys: Array | float) -> NDArray[np.uint32]:
    """The hash of whole numbers, each of which counts by its 32 lowest bits, negative ones in two's complement.

    Parameters
    ----------
    keys
        Whole numbers of magnitude below 2^53, broadcast.

    Returns
    -------
    ndarray of uint32
    """
    words = [np.asarray(key).astype(np.int64).astype(np.uint32) for key in keys]
    state = [np.full(1, (_START + 4 * len(words)) & 0xFFFFFFFF, dtype=np.uint32)] * 3
    for first in range(0, len(words), 3):
        if first:
            state = _mixed(state)
        block = words[first : first + 3]
        state = [a + b for a, b in zip(state, block, strict=False)] + state[len(block) :]
    return _final(state)


def unit_interval(bits: NDArray[np.uint32]) -> Array:
    """Hashes as numbers in [0, 1], as float32 has them: rounded to 24 bits, so that 1 is among them."""
    return bits.astype(np.float32).astype(float) / 2.0**32


def _mixed(state: list[NDArray[np.uint32]]) -> list[NDArray[np.uint32]]:
    a, b, c = state
    for bits in _MIX:
        a, b, c = b, c + b, (a - c) ^ _rotated(c, bits)
    return [a, b, c]


def _final(state: list[NDArray[np.uint32]]) -> NDArray[np.uint32]:
    a, b, c = state
    for bits in _FINAL:
        a, b, c = b, (c ^ b) - _rotated(b, bits), a
    return b  # the word of the last step


def _rotated(word: NDArray[np.uint32], bits: int) -> NDArray[np.uint32]:
    return (word << np.uint32(bits)) | (word >> np.uint32(32 - bits))
