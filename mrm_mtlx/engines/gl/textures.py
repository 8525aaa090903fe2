"""Image files as OpenGL textures, read by OpenImageIO."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray


# Largest image that is read, in values: 16384 x 16384 with one channel. A header can claim more than memory holds.
MAXIMUM_VALUES = 1 << 28
# Longest side that OpenGL drivers of this generation take.
MAXIMUM_SIDE = 16384


def read_image(path: Path) -> NDArray[np.float32]:
    """Pixels of an image file, shape (height, width, channels), float32, row 0 at the top, values as stored.

    Raises
    ------
    ValueError
        If the file is missing, no image that OpenImageIO reads, or larger than `MAXIMUM_SIDE` or `MAXIMUM_VALUES`.
    """
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(str(path))
    if source is None:
        msg = f"{path.name}: cannot be read as an image ({oiio.geterror().strip() or 'no reason given'})"
        raise ValueError(msg)
    try:
        spec = source.spec()
        too_wide = max(spec.width, spec.height) > MAXIMUM_SIDE
        if too_wide or spec.width * spec.height * spec.nchannels > MAXIMUM_VALUES:
            msg = f"{path.name}: {spec.width} x {spec.height} pixels are more than are read"
            raise ValueError(msg)
        pixels = source.read_image(format=oiio.FLOAT)
        if pixels is None:
            msg = f"{path.name}: cannot be decoded ({source.geterror().strip()})"
            raise ValueError(msg)
    finally:
        source.close()
    return np.asarray(pixels, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)


def upload(context: Any, pixels: NDArray[np.floating], *, mipmaps: bool = True) -> Any:
    """A float texture of an image, flipped so that v grows upward as MaterialX has it; repeats at its borders."""
    height, width, channels = pixels.shape
    components = min(channels, 4)
    data = np.ascontiguousarray(pixels[::-1, :, :components], dtype="f4")
    texture = context.texture((width, height), components, data.tobytes(), dtype="f4", alignment=4)
    if components == 1:
        texture.swizzle = "RRR1"
    elif components == 2:
        texture.swizzle = "RRRG"
    if mipmaps:
        texture.build_mipmaps()
        texture.filter = (context.LINEAR_MIPMAP_LINEAR, context.LINEAR)
    else:
        texture.filter = (context.LINEAR, context.LINEAR)
    return texture
