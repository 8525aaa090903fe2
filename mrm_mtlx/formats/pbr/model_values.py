"""The inputs of gltf_pbr that a surface has, with the model's defaults, and their means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.images import as_values, component, srgb_decoded
from mrm_mtlx.formats.pbr.term import Term

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.formats.pbr.nearest import Pixels

# Of the inputs that are not 0 by default.
_DEFAULTS: dict[str, float | tuple[float, ...]] = {
    "base_color": (1.0, 1.0, 1.0),
    "metallic": 1.0,
    "roughness": 1.0,
    "specular": 1.0,
    "specular_color": (1.0, 1.0, 1.0),
    "ior": 1.5,
    "alpha": 1.0,
    "alpha_cutoff": 0.5,
    "emissive": (0.0, 0.0, 0.0),
    "emissive_strength": 1.0,
}


class ModelValues:
    """Inputs of gltf_pbr, `given` by name; with what gives the pixels of a file by its name."""

    def __init__(self, given: Mapping[str, Any], images: Pixels) -> None:
        self.given, self._images = given, images

    def term(self, name: str) -> Term:
        """An input."""
        value = self.given.get(name)
        return value if isinstance(value, Term) else Term.constant(_DEFAULTS.get(name, 0.0))

    def number(self, name: str) -> float:
        """An input of one component, in the mean."""
        return float(self.mean(self.term(name))[0])

    def mean(self, value: Term) -> Array:
        """A term in the mean over its image, (components,); an image that is not there is black."""
        pixels = None if value.lookup is None else self._images(value.lookup.file)
        if value.lookup is None or pixels is None:
            return value.offset
        means = []
        for channel in value.channels:
            stored = component(pixels, channel)
            seen = np.ones(1) if stored is None else as_values(stored).astype(float)
            means.append(np.mean(srgb_decoded(seen) if value.lookup.encoded and channel < 3 else seen))
        return np.asarray(value.offset + value.scale * np.array(means))

    def means(self, **other: Term) -> dict[str, Term | int]:
        """All inputs that are numbers, in the mean, with others in the place of some."""
        found: dict[str, Term | int] = {"alpha_mode": self.given.get("alpha_mode", 0)}
        for name, value in self.given.items():
            if isinstance(value, Term):
                found[name] = Term.constant(self.mean(value))
        return {**found, **other}
