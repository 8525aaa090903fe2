"""Normals that come from an image of them, as formats have them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.term import Lookup, Term
from mrm_mtlx.formats.pbr.terms import look_up, term
from mrm_mtlx.formats.pbr.value_sources import source
from mrm_mtlx.reference import constant_input

if TYPE_CHECKING:
    import MaterialX as mx


class NormalMap(NamedTuple):
    """An image of normals.

    Attributes
    ----------
    lookup, channels
        The image, and which of its channels are x, y and z, from 0 for -1 to 1 for 1.
    scale
        Of x and y.
    """

    lookup: Lookup
    channels: tuple[int, ...]
    scale: float

    @property
    def vector(self) -> Term:
        """The normal in the frame of tangent, bitangent and normal, not normalised."""
        stretched = np.array([self.scale, self.scale, 1.0])
        return Term(-stretched, 2.0 * stretched, self.lookup, self.channels)


def normal_map(document: mx.Document, path: str) -> NormalMap:
    """The normal map that a node is, by its path in a document.

    Raises
    ------
    InexpressibleError
        If it is none of an image as it stands.
    """
    node = document.getDescendant(path)
    if node.getCategory() == "gltf_normalmap":
        return NormalMap(look_up(node), (0, 1, 2), 1.0)
    if node.getCategory() != "normalmap":
        msg = f"a normal from {node.getCategory()}, which has no form in glTF"
        raise InexpressibleError(msg)
    value, scale = term(node, "in"), _scale_of(node)
    if value.lookup is None or np.any(value.offset != 0.0) or np.any(value.scale != 1.0):
        msg = "its normal is no image as it stands"
        raise InexpressibleError(msg)
    return NormalMap(value.lookup, value.channels, scale)


def _scale_of(node: Any) -> float:
    scale = constant_input(node, "scale")
    if not isinstance(scale, np.ndarray) or len(set(np.atleast_1d(scale).tolist())) != 1:
        msg = "the scale of its normal varies, or differs between x and y"
        raise InexpressibleError(msg)
    if any(source(node, name) is not None for name in ("normal", "tangent", "bitangent")):
        msg = "its normal map stands in another frame than the surface's"
        raise InexpressibleError(msg)
    return float(np.atleast_1d(scale)[0])
