"""Pictures of materials: requests to the process in which Storm draws, and what it says."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import CompileError, CompileMessage, EngineFailure, looking_along
from mrm_mtlx.engines.blender.pictures import read_picture
from mrm_mtlx.engines.storm import process
from mrm_mtlx.engines.storm.messages import complaints
from mrm_mtlx.system.process_limits import MAXIMUM_MEMORY

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from mrm_mtlx.engines.storm.material import Material

_SERIAL = itertools.count()

# Memory that Storm's process may have taken before it is started anew [bytes]: half of what a process may take.
_MOST_MEMORY = MAXIMUM_MEMORY // 2


def draw(
    material: Material, meshes: Mapping[str, Mapping[str, NDArray[Any]]], takes: Sequence[Mapping[str, Any]]
) -> list[NDArray[np.float32]]:
    """Draw a material on meshes, once for each take.

    Parameters
    ----------
    material
        What the meshes are made of.
    meshes
        By name, their arrays; see `storm_server.render`.
    takes
        The "mesh", "camera" and "lights" of each picture, as `storm_server.render` has them.

    Returns
    -------
    list of ndarray, shape (height, width, 4)
        Row 0 on top.

    Raises
    ------
    CompileError
        If Storm refuses the material: it would draw something else in its place.
    EngineFailure
        If there is no Storm, it died, or its picture cannot be read back.
    """
    if not takes:
        return []
    runtime = process.RUNTIME.process()
    path = material.written(runtime.folder)
    serial = next(_SERIAL)
    outputs = [runtime.folder / f"picture_{serial}_{number}.exr" for number in range(len(takes))]
    arrays = {f"{name}/{key}": array for name, mesh in meshes.items() for key, array in mesh.items()}
    told = [{**take, "output": str(output)} for take, output in zip(takes, outputs, strict=True)]
    answer, log = runtime.request("render", arrays, material=str(path), values=list(material.values), takes=told)
    messages = complaints(answer["errors"], log)
    if messages:
        raise CompileError(messages)
    if not all(output.is_file() for output in outputs):
        said = answer["errors"][0][1] if answer["errors"] else "is the disk of temporary files full?"
        raise EngineFailure(f"Storm wrote no picture: {said}")
    images = [read_picture(output, "Storm's") for output in outputs]
    if answer["memory"] > _MOST_MEMORY:  # Storm keeps what it has compiled
        process.RUNTIME.stop()
    return images


# A square of four tilted quarters, lit from aside, to have a material compiled and seen.
_PROBE = {
    "points": np.array([[x, y, -1.0] for y in (-1, 0, 1) for x in (-1, 0, 1)], dtype=np.float32),
    "faces": np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]], dtype=np.int32),
    "normals": np.array([[n] * 4 for n in ((0, 0, 1), (0.6, 0, 0.8), (0, 0.6, 0.8), (0.6, -0.64, 0.48))], np.float32),
    "st": np.array([[[0, 0], [1, 0], [1, 1], [0, 1]]] * 4, dtype=np.float32),
}
_SEEN = {"window": [-1.0, 1.0, -1.0, 1.0], "resolution": [16, 16], "clip": [0.5, 2.0], "matrix": np.eye(4).tolist()}


def emission(material: Material) -> bool:
    """Have a material compiled: whether it shines without a light.

    Raises
    ------
    CompileError
        As `draw`; or if it is drawn as a mesh without a material, for whatever reason.
    EngineFailure
        As `draw`.
    """
    lights = [{"irradiance": 1.0, "colour": [1.0, 0.5, 0.25], "matrix": looking_along((0.36, 0.48, 0.8))}]
    dark = {"mesh": "probe", "camera": _SEEN, "lights": []}
    lit = {**dark, "lights": lights}
    unlit, with_it, without = draw(material, {"probe": _PROBE}, [dark, lit, {**lit, "bare": True}])
    if np.array_equal(with_it, without):
        message = "it is drawn in the grey of a mesh without a material, and Storm does not say why"
        raise CompileError([CompileMessage(0, "", message)])
    return bool(np.any(unlit[..., :3]))
