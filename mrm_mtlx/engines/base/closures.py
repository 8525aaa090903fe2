"""Measurements of closures: of OSL shaders, which return no colour, in a renderer that shows what they reflect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.shadergen import OslMode


class ClosureBench(Protocol):
    """A renderer of OSL that lights a facet per sample, seen along z, and measures what it sends to the camera.

    Attributes
    ----------
    name
        That of its engine.
    target
        Name of the target whose source it takes.
    exact_mode
        The way in which the node library makes a retroreflective lobe that is exact in this renderer.
    narrowest_alpha
        Width below which the renderer's arithmetic cannot hold a lobe.
    smallest_weight
        Weight below which the renderer leaves a closure out.
    geometry
        Geometric quantities that its facets have as the reference has them, as `Surface.traits` names them; where
        facets lie and their texture coordinates are their own.
    """

    name: str
    target: str
    exact_mode: OslMode
    narrowest_alpha: float
    smallest_weight: float
    geometry: frozenset[str]

    def compile(self, source: str, name: str, headers: Sequence[Path] = ()) -> ClosureProgram:
        """Compile OSL that may include these headers, by their file names.

        Raises
        ------
        CompileError
            If the compiler refuses the source.
        EngineFailure
            If there is no renderer, or it died.
        """
        ...

    def true_normals(self, normals: Array) -> NDArray[np.float32]:
        """The normals that a shader sees on facets with these wanted normals, (samples, 3), z > 0."""
        ...


class ClosureProgram(Protocol):
    """A compiled shader on a bench.

    `inputs` are values of the shader's inputs by name, (samples,) or (samples, 3). All methods raise EngineFailure if
    the renderer refuses or dies.
    """

    def emitted(self, inputs: Mapping[str, Array]) -> NDArray[np.float32]:
        """Values that a shader emits for each sample, (samples, 3): its output is `emission() * value`."""
        ...

    def direct_light(self, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike) -> NDArray[np.float32]:
        """Radiance of facets under suns of unit irradiance, one at a time: f(v, l) cos(l), (suns, samples, 3).

        `to_light` has one l per sun, (suns, 3), unit vectors.
        """
        ...

    def direct_light_by_groups(
        self, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike
    ) -> NDArray[np.float32]:
        """As `direct_light`, but with as many equal groups of facets as suns, each lit by its own; (samples, 3)."""
        ...
