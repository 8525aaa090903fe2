"""Looks up images as OpenGL does (OpenGL 4.6, section 8.14), at level of detail 0: samples have no neighbours.

Texture coordinates are (u, v), shape (2, samples), v growing upward; texels are counted from the lower left, their
centres lie at halves. Images are as `documents.images.read_image` gives them, row 0 at the top.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.documents.images import as_read
from mrm_mtlx.reference.float32.rounding import UNIT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# Half a step of the weights that graphics hardware filters with, in texels: they have 8 fractional bits (NVIDIA, CUDA
# C++ Programming Guide, "Texture Fetching"; Vulkan 1.3 asks for 4, `subTexelPrecisionBits`). Mesa's llvmpipe filters
# float textures in float32: what is measured there is within the roundings below.
WEIGHT_ERROR = 2.0**-9

# Roundings of a coordinate on its way to a texel: folded into the first repetition, times the size, minus a half, and
# the fraction; each is relative to the coordinate, or to the whole image where the folding cancels.
COORDINATE_ROUNDINGS = 4.0

# Along an axis, as many texels or blocks of texels are looked at, each at all samples, for the extremes within a reach.
_MOST_BLOCKS = 16


@dataclass(frozen=True)
class AddressModes:
    """Continuation of an image beyond its borders along u and v: one of `documents.images.ADDRESS_MODES` each."""

    u: str = "periodic"
    v: str = "periodic"


def linear(pixels: NDArray[np.floating], uv: Array, modes: AddressModes, border: Array) -> Array:
    """The image between its texels' centres, bilinear; shape (components, samples).

    `border`, shape (components, 1) or (components, samples), is what mode "constant" has outside, and says how many
    components are read.
    """
    at = uv * _size(pixels) - 0.5
    corner = np.floor(at)
    upper = at - corner
    result = np.zeros((len(border), 1))
    for step in product((0.0, 1.0), repeat=2):
        share_u, share_v = (w if s else 1.0 - w for s, w in zip(step, upper, strict=True))
        result = result + share_u * share_v * texel(pixels, corner + np.array(step)[:, None], modes, border)
    return result


def extremes(pixels: NDArray[np.floating], uv: Array, reach: Array, components: int) -> tuple[Array, Array]:
    """Least and most that `linear` shows of a periodic image within a reach of coordinates, (components, samples) each.

    `reach` has shape (2, samples). Where it is less than a texel, exactly: the extremes of what is bilinear lie at the
    corners of pieces. Beyond, of all texels that have a share in it; of a reach of many, a few more.
    """
    size, border = _size(pixels), np.zeros((components, 1))
    low, high = uv * size - 0.5 - reach * size, uv * size - 0.5 + reach * size
    first = np.floor(low)
    least, most = np.full((2, components, uv.shape[-1]), [[[np.inf]], [[-np.inf]]])
    for step in product(range(4), repeat=2):
        place = np.clip(first + np.array(step)[:, None], low, high)
        value = linear(pixels, (place + 0.5) / size, AddressModes(), border)
        least, most = np.minimum(least, value), np.maximum(most, value)
    wide = np.flatnonzero(np.any(reach * size >= 1.0, axis=0))
    if len(wide):
        least[:, wide], most[:, wide] = _widest(pixels, first[:, wide], np.floor(high[:, wide]) + 1.0, components)
    return least, most


def _widest(pixels: NDArray[np.floating], first: Array, last: Array, components: int) -> tuple[Array, Array]:
    """Least and most of texels from `first` to `last`, whole numbers, shape (2, samples), of a periodic image."""
    block = 1
    while np.max(last - first) / block > _MOST_BLOCKS:
        block *= 2
    low, high = (_block_extremes(pixels, components, block, reduce) for reduce in (np.minimum, np.maximum))
    height, width = pixels.shape[:2]
    columns, rows = (list(_blocks(first[k], last[k], n, block)) for k, n in enumerate((width, height)))
    least = most = low[rows[0], columns[0]]
    for row, column in product(rows, columns):
        least, most = np.minimum(least, low[row, column]), np.maximum(most, high[row, column])
    return least.T, most.T


def _blocks(first: Array, last: Array, size: int, block: int) -> Iterator[NDArray[np.intp]]:
    """Blocks along an axis that cover the texels from `first` to `last`: of each sample the first, the next, and so on.

    A sample with fewer than others repeats its last one.
    """
    place = first
    while np.any(place <= last):
        yield (np.minimum(place, last) % size).astype(np.intp) // block
        place = place + block - place % size % block


def _block_extremes(pixels: NDArray[np.floating], components: int, block: int, reduce: np.ufunc) -> Array:
    """Least or most of each block of texels, (blocks, blocks, components), row 0 at the bottom; the last ones wrap."""
    reduced = as_read(pixels[::-1], components).astype(float)
    for axis in (0, 1):
        starts = range(0, reduced.shape[axis], block)
        texels = (np.arange(block) + np.array(starts)[:, None]) % reduced.shape[axis]
        reduced = reduce.reduce(np.take(reduced, texels, axis=axis), axis=axis + 1)
    return np.asarray(reduced)


def cell(pixels: NDArray[np.floating], uv: Array) -> Array:
    """Texels at these coordinates, whole numbers, shape (2, samples)."""
    return np.floor(uv * _size(pixels))


def texel(pixels: NDArray[np.floating], cells: Array, modes: AddressModes, border: Array) -> Array:
    """The values of texels, which may lie outside the image, shape (components, samples); `border` as in `linear`."""
    width, height = _size(pixels)[:, 0]
    column, in_u = _wrapped(cells[0], width, modes.u)
    row, in_v = _wrapped(cells[1], height, modes.v)
    values = as_read(pixels[len(pixels) - 1 - row, column], len(border)).T.astype(float)
    return np.where(in_u & in_v, values, border)


def coordinate_error(pixels: NDArray[np.floating], uv: Array) -> Array:
    """Error of hardware in texture coordinates, shape (2, samples)."""
    rounded = COORDINATE_ROUNDINGS * UNIT * np.maximum(np.abs(uv), 1.0)
    return rounded + WEIGHT_ERROR / _size(pixels)


def _size(pixels: NDArray[np.floating]) -> Array:
    """Width and height in texels, shape (2, 1)."""
    return np.array([[float(pixels.shape[1])], [float(pixels.shape[0])]])


def _wrapped(place: Array, size: float, mode: str) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Place along one axis of the image at which an address mode finds a texel, and whether that is not the border."""
    inside = (place >= 0.0) & (place < size)
    if mode == "periodic":
        place = place % size
    elif mode == "mirror":
        place = place % (2.0 * size)
        place = np.where(place < size, place, 2.0 * size - 1.0 - place)
    place = np.nan_to_num(np.clip(place, 0.0, size - 1.0))  # of 0/0 any texel will do
    return place.astype(np.intp), inside | (mode != "constant")
