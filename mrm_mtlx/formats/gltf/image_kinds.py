"""The kinds of image files that glTF has, by their first bytes."""

from __future__ import annotations

from typing import NamedTuple


class Kind(NamedTuple):
    """A kind of image file: what it begins with, the ending of its name, and its media type."""

    start: bytes
    suffix: str
    media_type: str


# The kinds that glTF has, and WebP by EXT_texture_webp.
PLAIN_KINDS = (Kind(b"\x89PNG\r\n\x1a\n", ".png", "image/png"), Kind(b"\xff\xd8\xff", ".jpg", "image/jpeg"))
_KINDS = (*PLAIN_KINDS, Kind(b"RIFF", ".webp", "image/webp"))


def kind_of(content: bytes) -> Kind | None:
    """The kind of an image file by its first bytes, None if it is none that is read."""
    return next((kind for kind in _KINDS if content.startswith(kind.start)), None)
