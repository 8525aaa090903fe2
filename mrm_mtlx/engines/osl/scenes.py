"""Scenes in Cycles: a cloud of facets, one per sample and pixel, or the mesh of a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.bsdf.blocks import processors
from mrm_mtlx.engines.base import Take
from mrm_mtlx.engines.blender.pictures import read_picture
from mrm_mtlx.engines.osl import process

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.engines.base import Scene

# Height of the camera of a cloud, which looks along -z: facets seen at a grazing angle are long.
_HEIGHT = 1e4
# Half the base of a facet, in pixels: none reaches into another's pixel.
_HALF_SIDE = 0.3
# Pixels per row, and the smallest picture that Blender renders.
_ROW, _SMALLEST_PICTURE = 256, 4
# Smallest cosine for which a facet still covers its pixel's centre.
_STEEPEST = 2e-4


def render(shader: Path, scene: Scene, takes: Sequence[Take] = (Take(),), seed: int = 0) -> list[NDArray[np.float32]]:
    """Render a compiled shader once for each take; many takes cost little more than one.

    Returns one image per take, (height, width, 4), row 0 on top; rows that are not wanted are black.

    Raises
    ------
    EngineFailure
        If Cycles refuses, dies, or its picture cannot be read back.
    """
    runtime = process.runtime()
    outputs = [runtime.folder / f"take_{number}.exr" for number in range(len(takes))]
    for output in outputs:
        output.unlink(missing_ok=True)
    runtime.request(
        "render",
        scene.arrays,
        shader=str(shader),
        camera=dict(scene.camera),
        takes=[take.to_json(output) for take, output in zip(takes, outputs, strict=True)],
        world=dict(scene.world),
        samples=scene.samples,
        bounces=scene.bounces,
        seed=seed,
        threads=processors(),
    )
    return [_read(output) for output in outputs]


def cloud(normals: Array, inputs: Mapping[str, Array]) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Arrays and camera of a mesh with one triangle per sample, around the middle of a pixel each.

    `normals`, (samples, 3), have z > 0: the camera looks along -z. `inputs`: shader inputs by name, (samples,) or
    (samples, 3).
    """
    count = len(normals)
    width = min(_ROW, max(count, _SMALLEST_PICTURE))
    height = max(-(-count // width), _SMALLEST_PICTURE)
    index = np.arange(count)
    centre = np.stack([index % width + 0.5 - width / 2, height / 2 - index // width - 0.5, np.zeros(count)], axis=1)
    cos_v = np.maximum(normals[:, 2], _STEEPEST)
    # One edge along the horizon; across it the triangle is as much longer as it is seen shorter.
    level = np.stack([-normals[:, 1], normals[:, 0], np.zeros(count)], axis=1)
    size = np.linalg.norm(level, axis=1, keepdims=True)
    level = np.where(size > 1e-6, level / np.maximum(size, 1e-12), [1.0, 0.0, 0.0])
    steep = np.cross(normals, level) / cos_v[:, None]
    corners = [centre + _HALF_SIDE * (a * level + b * steep) for a, b in ((-1.0, -0.7), (1.0, -0.7), (0.0, 1.0))]
    arrays: dict[str, NDArray[Any]] = {
        "vertices": np.stack(corners, axis=1).reshape(-1, 3).astype(np.float32),
        "faces": np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
    }
    arrays |= {f"input:{name}": np.asarray(value, dtype=np.float32) for name, value in inputs.items()}
    camera = {
        "width": float(max(width, height)),
        "resolution": [width, height],
        "clip": [1.0, 2.0 * _HEIGHT],
        "filter_width": 0.01,
        "alone": True,
        "matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, _HEIGHT], [0, 0, 0, 1]],
    }
    return arrays, camera


def rows_of(group: int, groups: int, count: int) -> tuple[float, float]:
    """The rows of a cloud of `count` samples that hold this one of equal groups, widened to whole rows."""
    rows = max(-(-count // _ROW), _SMALLEST_PICTURE)
    first, last = group * count // groups // _ROW, -(-(group + 1) * count // groups // _ROW)
    return 1.0 - min(last + 1, rows) / rows, 1.0 - max(first - 1, 0) / rows


def samples_of(image: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """The pixels of a cloud as (samples, 3)."""
    return image.reshape(-1, image.shape[-1])[:count, :3].copy()


def _read(path: Path) -> NDArray[np.float32]:
    """The combined pass of a multi-layer file, RGBA; the file is removed."""
    return read_picture(path, "Cycles'", "ViewLayer.Combined.")
