"""Image files: reading them, and how an image node takes their pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

# Largest image that is read, in values: 16384 x 16384 with one channel. A header can claim more than memory holds.
MAXIMUM_VALUES = 1 << 28
# Longest side that OpenGL drivers of this generation take.
MAXIMUM_SIDE = 16384

# What the image nodes' enumerations offer; the hardware generators pass a value's place in here.
ADDRESS_MODES = ("constant", "clamp", "periodic", "mirror")
FILTER_TYPES = ("closest", "linear", "cubic")


def srgb_encoded(linear: NDArray[np.floating]) -> NDArray[np.floating]:
    """Linear values as sRGB encodes them (IEC 61966-2-1); negative ones by the line that begins at 0."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055)


def srgb_decoded(encoded: NDArray[np.floating]) -> NDArray[np.floating]:
    """Linear values of sRGB ones (IEC 61966-2-1); negative ones by the line that begins at 0."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4)


def read_image(path: Path) -> NDArray[np.float32]:
    """Pixels of an image file, shape (height, width, channels), float32, row 0 at the top, values as stored.

    Raises
    ------
    ValueError
        If the file is missing, no image that OpenImageIO reads, or larger than `MAXIMUM_SIDE` or `MAXIMUM_VALUES`.
    """
    import OpenImageIO as oiio

    as_stored = oiio.ImageSpec()
    as_stored.attribute("oiio:UnassociatedAlpha", 1)  # else the colours of a PNG come out multiplied by its alpha
    source = oiio.ImageInput.open(str(path), as_stored)
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


def as_read(pixels: NDArray[np.floating], components: int) -> NDArray[np.floating]:
    """Pixels as an image node of so many components reads them, shape (..., components) from (..., channels).

    One channel is a grey, two are a grey and its opacity, but x and y to a node of two components; what has no
    opacity is opaque. Channels that the node does not read are left out.
    """
    channels = pixels.shape[-1]
    if channels == 1:
        order = [0, 0, 0]
    elif channels == 2:
        order = [0, 1] if components == 2 else [0, 0, 0, 1]
    else:
        order = list(range(min(channels, 4)))
    chosen = pixels[..., order[:components]]
    if chosen.shape[-1] == components:
        return chosen
    opaque = np.ones((*pixels.shape[:-1], 1), dtype=pixels.dtype)
    return np.concatenate([chosen, opaque], axis=-1)
