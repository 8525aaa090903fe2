"""Image files: reading them, and how an image node takes their pixels."""

from __future__ import annotations

import contextlib
import errno
import os
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.system.console import silenced
from mrm_mtlx.system.text import printable
from mrm_mtlx.system.writing import replacing

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

# Largest image that is read, in values: 16384 x 16384 with one channel. A header can claim more than memory holds.
MAXIMUM_VALUES = 1 << 28
# Largest file: as much as the largest image of float32, uncompressed. Some decoders take all of it into memory.
MAXIMUM_FILE_BYTES = 4 * MAXIMUM_VALUES
# Longest side that OpenGL drivers of this generation take.
MAXIMUM_SIDE = 16384

# What is read, by OpenImageIO's names: what the first bytes are. It has more decoders, of formats that no texture has.
FORMATS = {
    "png": rb"\x89PNG\r\n\x1a\n",
    "jpeg": rb"\xff\xd8\xff",
    "openexr": rb"v/1\x01",
    "tiff": rb"II[*+]\0|MM\0[*+]",
    "hdr": rb"#\?",
    "webp": rb"RIFF....WEBP",
    "bmp": rb"BM",
    "dds": rb"DDS ",
    "pnm": rb"P[1-6fF]\s",
    "sgi": rb"\x01\xda",
    "dpx": rb"SDPX|XPDS",
    "cineon": rb"\x80\x2a\x5f\xd7|\xd7\x5f\x2a\x80",
    "psd": rb"8BPS",
    "iff": rb"FOR[4M8]",
}
# Targa files begin with nothing of their own.
_TARGA = (".tga", ".tpic")
# Channels that an image node reads at most.
_CHANNELS = 4
# OpenImageIO's names of the types that are kept as they are stored.
_TYPES = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}
# The channels that a node of four components reads, by the number that there are.
_OF_FOUR = {1: (0, 0, 0, None), 2: (0, 0, 0, 1), 3: (0, 1, 2, None), 4: (0, 1, 2, 3)}
# Of libjpeg's warnings, those after which pixels are made up.
_DAMAGE = re.compile("premature end|bad Huffman|bad arithmetic|instead of RST", re.IGNORECASE)

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
        As `read_stored`.
    """
    return as_values(read_stored(path))


def as_values(stored: NDArray[Any]) -> NDArray[Any]:
    """The numbers that stored ones stand for: whole numbers are shares of the largest, float32; others are as given."""
    if stored.dtype.kind == "u":
        return stored.astype(np.float32) / np.float32(np.iinfo(stored.dtype).max)
    return stored.astype(np.float32) if stored.dtype == np.float16 else stored


def read_stored(path: Path) -> NDArray[Any]:
    """Pixels of an image file in the type that it stores, shape (height, width, channels), row 0 at the top.

    Whole numbers of 8 and 16 bits, float16, and float32, which all others become; at most four channels. It and
    `stored_bytes` are the only ones that open what a document calls an image: no other format is decoded than those of
    `FORMATS`, nothing is decoded before its size is known, and what decoders print is dropped.

    Raises
    ------
    ValueError
        If the file is missing, no image of these formats, damaged, or larger than the bounds above.
    """
    with _opened(path) as source:
        pixels = source.read_image(0, 0, 0, min(source.spec().nchannels, _CHANNELS), _kept_type(source.spec()))
        # Of a file that ends too early, libjpeg and libtiff make up the rest, and call that a warning.
        said = source.geterror() if source.has_error else ""
        if pixels is None or (said and (source.format_name() != "jpeg" or _DAMAGE.search(said))):
            msg = f"{path.name}: cannot be decoded ({_plain(said, path)})"
            raise ValueError(msg)
        return np.asarray(pixels).reshape(source.spec().height, source.spec().width, -1)


def stored_bytes(path: Path) -> int:
    """Bytes that `read_stored` will return, from the file's header.

    Raises
    ------
    ValueError
        As `read_stored`, as far as the header tells.
    """
    with _opened(path) as source:
        spec = source.spec()
        return int(spec.width * spec.height * min(spec.nchannels, _CHANNELS) * _kept_type(spec).size())


def write_image(path: Path, pixels: NDArray[Any], attributes: Mapping[str, str]) -> None:
    """Write an image file whole or not at all, and be sure of it: it is read back.

    Parameters
    ----------
    path
        Its ending names the format, one without loss.
    pixels
        Shape (height, width, channels), of a type that the format stores: see `read_stored`.
    attributes
        Metadata, by OpenImageIO's names.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, _TYPES[pixels.dtype.name])
    spec.attribute("oiio:UnassociatedAlpha", 1)  # else colours would be divided by it
    for name, value in attributes.items():
        spec.attribute(name, value)
    with replacing(path) as unfinished:
        with silenced():
            target: Any = oiio.ImageOutput.create(str(unfinished))
            done = target is not None and target.open(str(unfinished), spec)
            done = done and target.write_image(np.ascontiguousarray(pixels)) and target.close()
            said = oiio.geterror() or (target.geterror() if target is not None else "")
        if not done:
            raise OSError(errno.EIO, _plain(said, unfinished))
        # To a full disk, OpenImageIO writes a stump and reports success.
        try:
            found = read_stored(unfinished)
        except ValueError:
            found = np.empty(0)
        if not np.array_equal(found, pixels):
            raise OSError(errno.ENOSPC, "what was written does not read back; the disk may be full")


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The file in OpenImageIO, of a format that is read and within the bounds; ValueError otherwise."""
    import OpenImageIO as oiio

    kind = _format_of(path)
    as_stored = oiio.ImageSpec()
    as_stored.attribute("oiio:UnassociatedAlpha", 1)  # else the colours of a PNG come out multiplied by its alpha
    with silenced():  # libpng and OpenEXR print what is wrong, with the path
        source = oiio.ImageInput.open(str(path), as_stored)
        if source is None or source.format_name() != kind:
            msg = f"{path.name}: cannot be read as an image ({_plain(oiio.geterror(), path)})"
            raise ValueError(msg)
        try:
            _check_bounds(path.name, source.spec())
            yield source
        finally:
            source.close()


def _format_of(path: Path) -> str:
    """OpenImageIO's name of a file's format, by its first bytes."""
    reason = "it is no file"
    try:
        if path.is_file():  # a pipe would wait for ever
            if path.stat().st_size > MAXIMUM_FILE_BYTES:
                msg = f"{path.name}: a file of more than {MAXIMUM_FILE_BYTES // 2**20} MiB"
                raise ValueError(msg)
            with path.open("rb") as stream:
                start = stream.read(12)
            for kind, pattern in FORMATS.items():
                if re.match(pattern, start, re.DOTALL):
                    return kind
            if path.suffix.lower() in _TARGA:
                return "targa"
            reason = "its first bytes are those of no format that is read"
    except OSError as error:
        reason = error.strerror or "no reason given"
    msg = f"{path.name}: cannot be read as an image ({reason})"
    raise ValueError(msg)


def _check_bounds(name: str, spec: Any) -> None:
    tile = spec.tile_width * spec.tile_height * max(spec.tile_depth, 1)
    if spec.deep or spec.depth > 1:
        msg = f"{name}: cannot be read as an image (it is {'deep' if spec.deep else 'a volume'})"
        raise ValueError(msg)
    too_wide = max(spec.width, spec.height) > MAXIMUM_SIDE
    if too_wide or max(spec.width * spec.height, tile) * spec.nchannels > MAXIMUM_VALUES:
        msg = f"{name}: {spec.width} x {spec.height} pixels are more than are read"
        raise ValueError(msg)


def _kept_type(spec: Any) -> Any:
    import OpenImageIO as oiio

    return spec.format if str(spec.format) in _TYPES.values() else oiio.TypeFloat


def _plain(said: str, path: Path) -> str:
    """OpenImageIO's message, on one line and without the folder."""
    names = said.replace(str(path), path.name).replace(f"{path.parent}{os.sep}", "")
    return printable(names.strip()) or "no reason given"


def component(pixels: NDArray[Any], number: int) -> NDArray[Any] | None:
    """The component that a node of four reads as the last, as it is stored, shape (...); None where that is opaque."""
    channel = _OF_FOUR[min(pixels.shape[-1], 4)][number]
    return None if channel is None else pixels[..., channel]


def as_read(pixels: NDArray[Any], components: int) -> NDArray[np.floating]:
    """Values of pixels as an image node of so many components reads them, shape (..., components).

    `pixels`, shape (..., channels), may be as stored.

    One channel is a grey, two are a grey and its opacity, but x and y to a node of two components; what has no
    opacity is opaque. Channels that the node does not read are left out.
    """
    channels = min(pixels.shape[-1], 4)
    order = (0, 1) if components == channels == 2 else _OF_FOUR[channels][:components]
    chosen = as_values(pixels[..., [channel for channel in order if channel is not None]])
    if chosen.shape[-1] == components:
        return chosen
    opaque = np.ones((*pixels.shape[:-1], 1), dtype=chosen.dtype)
    return np.concatenate([chosen, opaque], axis=-1)
