"""Scenes for renderers of whole pictures, and the contract of one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.shadergen import Shader


@dataclass(frozen=True)
class Scene:
    """A mesh, seen by a camera.

    Attributes
    ----------
    arrays
        "vertices" (n, 3), "faces" (m, corners); "normals" (m, corners, 3) for a smooth surface, "uv" (m, corners, 2)
        and "environment", see `world`, where there are any.
    camera
        "resolution", "matrix", "clip", "filter_width", "alone" (nothing but the camera sees the mesh), and "width" or
        "field".
    world
        The environment: {} is black, and transparent in the picture; "radiance" is a colour. A latitude-longitude
        image, (height, width, 3), row 0 at +y and its centre column at -z, is the array "environment".
    samples, bounces
        Paths per pixel, and how often one may be reflected.
    """

    arrays: Mapping[str, NDArray[Any]]
    camera: Mapping[str, Any]
    world: Mapping[str, Any] = field(default_factory=dict)
    samples: int = 1
    bounces: int = 0


@dataclass(frozen=True)
class Take:
    """One render of a scene: its lights, and the rows wanted, as fractions of the height from the bottom."""

    lights: Sequence[Mapping[str, Any]] = ()
    rows: tuple[float, float] | None = None

    def to_json(self, output: Path) -> dict[str, Any]:
        """The take as plain data, to be rendered into this file."""
        told: dict[str, Any] = {"lights": [dict(light) for light in self.lights], "output": str(output)}
        return told if self.rows is None else {**told, "rows": list(self.rows)}


class SceneRenderer(Protocol):
    """A renderer of scenes whose mesh has a generated shader.

    Attributes
    ----------
    target
        Name of the target whose source it takes.
    traces_paths
        Whether it traces as many paths through each pixel as a scene says; else it shades the middle of each, light
        comes from lamps and the world alone, and the seed means nothing.
    """

    target: str
    traces_paths: bool

    def compile(self, shader: Shader) -> Path:
        """Compile a shader for a mesh with texture coordinates; the compiled file, in the renderer's folder.

        Raises
        ------
        CompileError
            If the compiler refuses the source.
        EngineFailure
            If there is no renderer, or it died.
        """
        ...

    def render(
        self, shader: Path, scene: Scene, takes: Sequence[Take] = (Take(),), seed: int = 0
    ) -> list[NDArray[np.float32]]:
        """Render a scene once for each take; many takes cost little more than one.

        Returns one image per take, (height, width, 4), row 0 on top; rows that are not wanted are black. `seed` fixes
        the noise.

        Raises
        ------
        EngineFailure
            If the renderer refuses, dies, or its picture cannot be read back.
        """
        ...


def sun(to_light: Sequence[float], irradiance: float = 1.0, *, shadow: bool = False) -> dict[str, Any]:
    """A light infinitely far away in the direction `to_light`, a unit vector."""
    return {"irradiance": irradiance, "matrix": looking_along(to_light), "shadow": shadow}


def point(position: Sequence[float], intensity: float) -> dict[str, Any]:
    """A light at a point, with this radiant intensity in all directions; it casts shadows."""
    return {"intensity": intensity, "matrix": looking_along((0.0, 0.0, 1.0), position), "shadow": True}


def looking_along(backward: Sequence[float], position: Sequence[float] = (0.0, 0.0, 0.0)) -> list[list[float]]:
    """Matrix of an object whose +z is `backward`, a unit vector: lights shine and cameras look along -z."""
    z = np.asarray(backward, dtype=float)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.999 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    columns = np.stack([x, np.cross(z, x), z, np.asarray(position, dtype=float)], axis=1)
    return [*columns.tolist(), [0.0, 0.0, 0.0, 1.0]]
