"""Storm as a renderer of whole pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.images import write_image
from mrm_mtlx.engines.base import EngineFailure, Take
from mrm_mtlx.engines.storm.drawing import draw, emission
from mrm_mtlx.engines.storm.material import Material
from mrm_mtlx.engines.storm.process import RUNTIME

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Scene
    from mrm_mtlx.shadergen import Shader


class StormRenderer:
    """The renderer; see `SceneRenderer`. It casts no shadows, and its surroundings are blurred beforehand."""

    traces_paths = False

    def __init__(self, target: str) -> None:
        self.target = target

    def compile(self, shader: Shader) -> Path:
        """As `SceneRenderer.compile`."""
        material = Material(shader.sources["pixel"])
        emission(material)
        return material.written(RUNTIME.process().folder)

    def render(
        self, shader: Path, scene: Scene, takes: Sequence[Take] = (Take(),), seed: int = 0
    ) -> list[NDArray[np.float32]]:
        """As `SceneRenderer.render`; of the world, only an image, which does not show in the picture itself."""
        del seed  # nothing is drawn by lot
        material = Material(shader.read_text(encoding="utf-8"))
        names = {"vertices": "points", "faces": "faces", "normals": "normals", "uv": "st"}
        mesh = {names[name]: array for name, array in scene.arrays.items() if name in names}
        middle = np.asarray(scene.arrays["vertices"], dtype=float).mean(axis=0)
        half = float(np.tan(scene.camera["field"] / 2.0))
        camera = {
            "window": [-half, half, -half, half],
            "resolution": scene.camera["resolution"],
            "clip": scene.camera["clip"],
            "matrix": scene.camera["matrix"],
        }
        around = [_dome(scene.arrays["environment"])] if "environment" in scene.arrays else []
        told = [
            {"mesh": "scene", "camera": camera, "lights": [*around, *(_light(light, middle) for light in take.lights)]}
            for take in takes
        ]
        return draw(material, {"scene": mesh}, told)


def _light(light: Mapping[str, Any], middle: NDArray[np.floating]) -> dict[str, Any]:
    """A light of a take as the server has it; one at a point is exact where the middle of the mesh is.

    MaterialX has the light of a point fall with the square of the distance and one more.
    """
    told = {"colour": [1.0, 1.0, 1.0], "matrix": light["matrix"]}
    if "irradiance" in light:
        return {**told, "irradiance": light["irradiance"]}
    distance = float(np.linalg.norm(np.asarray(light["matrix"])[:3, 3] - middle))
    return {**told, "intensity": light["intensity"] * ((distance + 1.0) / distance) ** 2}


def _dome(radiance: NDArray[np.floating]) -> dict[str, Any]:
    """A dome with a latitude-longitude image, (height, width, 3), row 0 at +y and its centre column at -z."""
    path = RUNTIME.process().folder / "environment.exr"
    try:
        write_image(path, np.asarray(radiance, dtype=np.float32), {})
    except OSError as error:
        raise EngineFailure(f"the environment could not be written for Storm: {error.strerror}") from error
    return {"image": str(path), "matrix": np.diag([-1.0, 1.0, -1.0, 1.0]).tolist()}
