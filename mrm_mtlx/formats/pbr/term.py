"""A number times channels of an image, plus one: what glTF and UsdPreviewSurface can say of an input."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mrm_mtlx.formats.pbr.placement import InexpressibleError

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.formats.pbr.placement import Placement

# Colour space of images of colours; the others hold numbers as they are.
ENCODED = "srgb_texture"


class Lookup(NamedTuple):
    """A lookup of an image.

    Attributes
    ----------
    file
        Its name in the document.
    encoded
        Whether its colours are sRGB.
    modes, filter
        As MaterialX names them.
    texcoord
        Set of texture coordinates.
    placement
        From these to where the image is read.
    """

    file: str
    encoded: bool
    modes: tuple[str, str]
    filter: str
    texcoord: int
    placement: Placement


@dataclass(frozen=True)
class Term:
    """offset + scale * channels of an image; arrays of shape (components,). Without a lookup it is the offset alone."""

    offset: Array
    scale: Array
    lookup: Lookup | None = None
    channels: tuple[int, ...] = ()

    @staticmethod
    def constant(value: Array | float | tuple[float, ...]) -> Term:
        """A number, or a colour."""
        offset = np.atleast_1d(np.asarray(value, dtype=float))
        return Term(offset, np.zeros_like(offset), None, (0,) * len(offset))

    @property
    def value(self) -> Array | None:
        """The constant that it is, or None."""
        return self.offset if self.lookup is None else None

    def __mul__(self, factor: Array | float) -> Term:
        return replace(self._wide(factor), offset=self.offset * factor, scale=self.scale * factor)

    def __add__(self, number: Array | float) -> Term:
        wide = self._wide(number)
        return replace(wide, offset=wide.offset + number)

    def select(self, components: tuple[int, ...]) -> Term:
        """Some of the components."""
        chosen = list(components)
        if max(chosen) >= len(self.offset):
            msg = "it reads a component that is not there"
            raise InexpressibleError(msg)
        channels = tuple(self.channels[c] for c in chosen)
        return replace(self, offset=self.offset[chosen], scale=self.scale[chosen], channels=channels)

    def _wide(self, other: Array | float) -> Term:
        """With as many components as another."""
        count = np.size(other)
        return self.select((0,) * count) if len(self.offset) == 1 < count else self


def constant_of(part: Term) -> Array:
    """The constant that a term is.

    Raises
    ------
    InexpressibleError
        If it is an image.
    """
    if part.value is None:
        msg = "it multiplies images, divides by one or compares one"
        raise InexpressibleError(msg)
    return part.value


def blended(low: Term, high: Term, amount: Term) -> Term:
    """(1 - amount) low + amount high.

    Raises
    ------
    InexpressibleError
        If two of them are images.
    """
    if low.lookup is None and high.lookup is None:
        step = np.atleast_1d(constant_of(high) - constant_of(low))
        if not np.any(step):
            return low
        return amount * step + constant_of(low)
    share = constant_of(amount)
    if low.lookup is None:
        return high * share + constant_of(low) * (1.0 - share)
    return low * (1.0 - share) + constant_of(high) * share


def joined(terms: list[Term]) -> Term:
    """A term of the components of several, one after the other.

    Raises
    ------
    InexpressibleError
        If they read several images.
    """
    lookups = {t.lookup for t in terms if t.lookup is not None}
    if len(lookups) > 1:
        msg = "it combines several images"
        raise InexpressibleError(msg)
    return Term(
        np.concatenate([t.offset for t in terms]),
        np.concatenate([t.scale for t in terms]),
        next(iter(lookups), None),
        tuple(channel for t in terms for channel in t.channels),
    )
