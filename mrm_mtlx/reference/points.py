"""The samples of an evaluation: points of a surface, and the directions that they are looked at and lit from."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.bsdf.arrays import Array


@dataclass(frozen=True)
class ShadingPoints:
    """Samples of a surface, all in world space.

    Attributes
    ----------
    view : shape (samples, 3)
        v, unit to float32.
    light : shape (3,) or (samples, 3)
        l, as the light shader reports it; unit to float32.
    normal, tangent : shape (samples, 3)
        The shading frame; unit to float32, not exactly orthogonal.
    position : shape (samples, 3)
    texcoord : shape (samples, 2)
    properties
        Geometric properties by name, shape (samples,) or (samples, components).
    """

    view: Array
    light: Array
    normal: Array
    tangent: Array
    position: Array
    texcoord: Array
    properties: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        """The number of samples."""
        return len(self.view)

    def perturbed(self, view: Array | float = 0.0, light: Array | float = 0.0) -> ShadingPoints:
        """The same samples with these vectors added to the directions."""
        return replace(self, view=self.view + view, light=self.light + light)

    def part(self, where: slice) -> ShadingPoints:
        """Some of the samples."""
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "properties"}
        chosen = {name: array if array.ndim == 1 else array[where] for name, array in arrays.items()}
        return replace(self, **chosen, properties={name: value[where] for name, value in self.properties.items()})

    @staticmethod
    def joined(points: list[ShadingPoints]) -> ShadingPoints:
        """All samples as one, each with a light of its own."""

        def together(name: str) -> Array:
            arrays = [getattr(p, name) for p in points]
            every = [np.broadcast_to(a, (len(p), a.shape[-1])) for a, p in zip(arrays, points, strict=True)]
            return np.concatenate(every)

        names = [f.name for f in fields(ShadingPoints) if f.name != "properties"]
        properties = {name: np.concatenate([p.properties[name] for p in points]) for name in points[0].properties}
        return ShadingPoints(**{name: together(name) for name in names}, properties=properties)
