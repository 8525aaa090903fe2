"""A material that Storm has compiled, evaluated at points."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import Capabilities, DirectionalLight, Program, looking_along
from mrm_mtlx.engines.storm.drawing import draw, emission
from mrm_mtlx.engines.storm.facets import layout, texture_coordinates
from mrm_mtlx.engines.storm.material import for_facets, place_in, properties
from mrm_mtlx.engines.storm.process import RUNTIME
from mrm_mtlx.shadergen.usd.values import sdf_type

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Lighting, SurfacePoints
    from mrm_mtlx.engines.storm.facets import Frame, Layout
    from mrm_mtlx.engines.storm.material import Material
    from mrm_mtlx.shadergen import Shader

# Storm's pictures are half floats: eleven bits, and steps of 2^-24 between the smallest.
_BITS, _STEP = 11, 2.0**-24
# What a picture may show, well below the largest half float, 65504.
_BRIGHTEST = 2.0**15
# Exposures of the light, as powers of two: of each point, the brightest picture that holds it counts.
_EXPOSURES = (12, 0, -12)

CAPABILITIES = Capabilities(
    runs=True,
    derivatives=True,
    lights=frozenset({DirectionalLight}),
    color_bits=_BITS,
    color_step=_STEP * 2.0 ** -_EXPOSURES[0],
    largest_batch=1 << 15,
)


class StormProgram(Program):
    """A material on facets, see `facets`.

    Parameters
    ----------
    material
        One that Storm takes.
    kinds
        Types of its inputs in USD, by variable.
    version
        Of the MaterialX that Storm has.
    emits
        Whether it shines without a light: what it emits does not follow the exposure of the light.
    """

    def __init__(self, material: Material, kinds: Mapping[str, str], version: str, *, emits: bool = False) -> None:
        self._material, self._kinds, self._emits = material, kinds, emits
        step = _STEP if emits else CAPABILITIES.color_step
        self.capabilities = replace(CAPABILITIES, color_step=step, materialx=version)

    @classmethod
    def compiled(cls, shader: Shader) -> StormProgram:
        """The program of a shader that Storm takes; errors as for `Engine.compile`."""
        material = for_facets(shader)
        kinds = {port.variable: str(sdf_type(port.type)) for port in shader.uniforms}
        emits = emission(material)
        return cls(material, kinds, RUNTIME.process().versions["materialx"], emits=emits)

    def places(self, points: SurfacePoints, lighting: Lighting) -> SurfacePoints:
        """As `Program.places`: turned into pixels, with the tangents that Storm has."""
        return layout(points, lighting).points

    def evaluate(
        self, points: SurfacePoints, lighting: Lighting, uniforms: Mapping[str, Any] | None = None
    ) -> NDArray[np.floating]:
        """As `Program.evaluate`; the fourth channel is that of the picture."""
        changed = [(place_in(self._material.source, v), self._kinds[v], x) for v, x in (uniforms or {}).items()]
        material = replace(self._material, values=(*self._material.values, *changed))
        placed = layout(points, lighting)
        found = np.zeros((len(points), 4))
        todo = np.ones((len(points), 3), dtype=bool)
        for exposure in (0,) if self._emits else _EXPOSURES:
            lit = _seen(material, placed, _sun(lighting.light, 2.0**exposure), np.any(todo, axis=1))
            found[:, :3] = np.where(todo, lit[:, :3] * 2.0**-exposure, found[:, :3])
            found[:, 3] = np.where(np.any(todo, axis=1), lit[:, 3], found[:, 3])
            todo &= ~(np.abs(lit[:, :3]) < _BRIGHTEST)
        return found


def _sun(light: Any, exposure: float) -> list[dict[str, Any]]:
    """The light, if it is the one that is taken."""
    if not isinstance(light, DirectionalLight):
        return []
    to_light = np.asarray(light.to_light, dtype=float)
    backward = (to_light / np.linalg.norm(to_light)).tolist()
    colour = [float(x) for x in light.irradiance]
    return [{"irradiance": exposure, "colour": colour, "matrix": looking_along(backward)}]


def _seen(
    material: Material, placed: Layout, lights: list[dict[str, Any]], wanted: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """What is seen of the points that are wanted, (points, 4), and perhaps of others."""
    frames = {str(number): frame for number, frame in enumerate(placed.frames) if np.any(wanted[frame.which])}
    meshes = {name: _mesh(placed.points, frame) for name, frame in frames.items()}
    takes = [{"mesh": name, "camera": frame.camera, "lights": lights} for name, frame in frames.items()]
    found = np.zeros((len(wanted), 4))
    for frame, image in zip(frames.values(), draw(material, meshes, takes), strict=True):
        found[frame.which] = image[frame.pixels[:, 1], frame.pixels[:, 0]]
    return found


def _mesh(points: SurfacePoints, frame: Frame) -> dict[str, NDArray[Any]]:
    """The arrays of a frame's facets."""
    which = frame.which
    corners = frame.corners.reshape(-1, 3)
    normal, texcoord = (np.asarray(a, dtype=float)[which] for a in (points.normal, points.texcoord))
    arrays = {
        "points": corners.astype(np.float32),
        "faces": np.arange(len(corners), dtype=np.int32).reshape(-1, 4),
        "normals": normal[:, None, :].repeat(4, axis=1).astype(np.float32),
        "st": texture_coordinates(texcoord, normal, frame.steps).astype(np.float32),
    }
    own = properties({name: np.asarray(values)[which] for name, values in points.properties.items()})
    return arrays | {f"property:{name}": values.astype(np.float32) for name, values in own.items()}
