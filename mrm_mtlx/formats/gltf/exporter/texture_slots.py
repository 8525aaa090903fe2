"""Images as glTF's texture slots want them: a file as it stands where it fits, else an image made of its channels."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.documents.document_images import DocumentImages, ImagesTooLargeError
from mrm_mtlx.documents.images import as_values, component, srgb_decoded, srgb_encoded, write_image
from mrm_mtlx.formats.gltf.exporter.asset import ImageFile
from mrm_mtlx.formats.gltf.image_kinds import PLAIN_KINDS, kind_of
from mrm_mtlx.formats.pbr.placement import InexpressibleError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.formats.pbr.term import Lookup

_ALPHA = 3
# Of an image that is looked into, whose making takes 20 bytes for each: 8192 x 8192.
MAXIMUM_PIXELS = 1 << 26
# Rows of an image that are composed at a time.
_ROWS = 256


class Channel(NamedTuple):
    """The content that one channel of a texture is to have.

    Attributes
    ----------
    lookup, channel
        The image, and which of its channels.
    encoded
        Whether glTF takes the texture's channel for sRGB.
    """

    lookup: Lookup
    channel: int
    encoded: bool

    @property
    def is_decoded(self) -> bool:
        """True if the document takes the image's channel for sRGB."""
        return self.lookup.encoded and self.channel != _ALPHA


class Images(DocumentImages):
    """The images of a document, as they may be written beside an asset."""

    def __init__(self, source: Document, output: Path) -> None:
        super().__init__(source.reach)
        self._source, self._folder = source, output.parent.resolve()

    def slot(self, wanted: Mapping[int, Channel | None], name: str) -> ImageFile:
        """The image of a texture.

        Parameters
        ----------
        wanted
            By channel of the texture: what it has, or None where it has to be 1. Other channels are not read.
        name
            Stem of the file, if it is made.

        Raises
        ------
        InexpressibleError
            If an image cannot be read, or two that go into one differ in size.
        """
        channels = [channel for channel in wanted.values() if channel is not None]
        loaded = {channel.lookup.file: self._loaded(channel.lookup.file) for channel in channels}
        if len(loaded) == 1 and all(self._fits(target, channel, loaded) for target, channel in wanted.items()):
            found = self._as_it_is(channels[0].lookup.file)
            if found is not None:
                return found
        if len({pixels.shape[:2] for pixels in loaded.values()}) > 1:
            msg = "images of different size would have to be one"
            raise InexpressibleError(msg)
        return ImageFile(f"{name}.png", _png(wanted, loaded))

    def _loaded(self, name: str) -> NDArray[Any]:
        try:
            pixels = self(name)
        except ImagesTooLargeError as error:
            msg = f"it has {error}"
            raise InexpressibleError(msg) from error
        if pixels is None:
            msg = f"the image {name} cannot be read"
            raise InexpressibleError(msg)
        if pixels.shape[0] * pixels.shape[1] > MAXIMUM_PIXELS:
            msg = f"the image {name} has {pixels.shape[1]} x {pixels.shape[0]} pixels, more than are converted"
            raise InexpressibleError(msg)
        return pixels

    def _fits(self, target: int, channel: Channel | None, loaded: Mapping[str, NDArray[Any]]) -> bool:
        """True if the file as it stands has in this channel what is wanted."""
        (pixels,) = loaded.values()
        there = component(pixels, target)
        if channel is None:
            opaque = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1.0
            return there is None or bool(np.all(there == opaque))
        wanted = component(pixels, channel.channel)
        both = there is not None and wanted is not None and np.array_equal(wanted, there)
        return (channel.channel == target or both) and channel.is_decoded == channel.encoded

    def _as_it_is(self, name: str) -> ImageFile | None:
        path = self._source.reach.regular(name)
        content = b"" if path is None else path.read_bytes()
        if path is None or kind_of(content) not in PLAIN_KINDS:
            return None
        if path.is_relative_to(self._folder) and not self._source.packed:
            return ImageFile(path.name, content, os.path.relpath(path, self._folder).replace(os.sep, "/"))
        return ImageFile(path.name, content)


def _png(wanted: Mapping[int, Channel | None], loaded: Mapping[str, NDArray[Any]]) -> bytes:
    """Bytes of a PNG with these channels, of 8 bits per value where these are exact, else of 16."""
    height, width = next(iter(loaded.values())).shape[:2]
    pixels, is_exact = np.empty((height, width, 4 if _ALPHA in wanted else 3), dtype=np.uint16), True
    for first in range(0, height, _ROWS):
        rows = slice(first, first + _ROWS)
        values = _composed(wanted, {file: image[rows] for file, image in loaded.items()})
        is_exact = is_exact and np.allclose(255.0 * values, np.round(255.0 * values), rtol=0.0, atol=1e-4)
        pixels[rows] = np.round(65535.0 * values)
    with tempfile.TemporaryDirectory(prefix="mrm-") as folder:
        path = Path(folder) / "image.png"
        write_image(path, np.round(pixels / np.float32(257.0)).astype(np.uint8) if is_exact else pixels, {})
        return path.read_bytes()


def _composed(wanted: Mapping[int, Channel | None], loaded: Mapping[str, NDArray[Any]]) -> NDArray[np.floating[Any]]:
    """Some rows of pixels with these channels; those that are not wanted are 1."""
    height, width = next(iter(loaded.values())).shape[:2]
    pixels = np.ones((height, width, 4 if _ALPHA in wanted else 3))
    for target, channel in wanted.items():
        stored = None if channel is None else component(loaded[channel.lookup.file], channel.channel)
        if channel is None or stored is None:
            continue
        values = as_values(stored).astype(float)
        if channel.is_decoded and not channel.encoded:
            values = srgb_decoded(values)
        elif channel.encoded and not channel.is_decoded:
            values = srgb_encoded(values)
        if np.any(values < 0.0) or np.any(values > 1.0):
            msg = f"the image {channel.lookup.file} has values beyond 0 to 1, which a PNG has not"
            raise InexpressibleError(msg)
        pixels[..., target] = values
    return pixels
