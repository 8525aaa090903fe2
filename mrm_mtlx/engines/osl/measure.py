"""Measurements in Cycles: values of OSL functions, and the light that closures reflect."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.engines.base import Scene, Take, sun
from mrm_mtlx.engines.osl import process
from mrm_mtlx.engines.osl.compiler import compile_for_cycles
from mrm_mtlx.engines.osl.scenes import cloud, render, rows_of, samples_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.engines.blender.process import BlenderProcess

# Facets per render: bounds the memory of a scene.
_BATCH = 1 << 16


def evaluate(shader: Path, inputs: Mapping[str, Array]) -> NDArray[np.float32]:
    """Values that a shader emits for each sample, (samples, 3): it puts out `emission() * value`, of either sign.

    Parameters
    ----------
    shader
        Compiled, see `compiler.compile_for_cycles`.
    inputs
        Values of its inputs by name, (samples,) or (samples, 3), at least one; they reach it bit by bit as float32.

    Raises
    ------
    EngineFailure
        If Cycles refuses or dies.
    """
    count = len(next(iter(inputs.values())))
    facing = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    found = []
    for start in range(0, count, _BATCH):
        part = slice(start, start + _BATCH)
        arrays, camera = cloud(facing[part], {name: value[part] for name, value in inputs.items()})
        found.append(samples_of(render(shader, Scene(arrays, camera))[0], len(facing[part])))
    return np.concatenate(found)


def direct_light(shader: Path, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike) -> NDArray[np.float32]:
    """Radiance of facets under suns of unit irradiance, one at a time, seen along z: f(v, l) cos(l).

    Parameters
    ----------
    shader, inputs
        As `evaluate`; the shader's output is a surface closure.
    normals : shape (samples, 3)
        Wanted normals, z > 0; what float32 makes of them, in the corners of a facet, `true_normals` tells.
    to_light : shape (suns, 3)
        l, unit vectors.

    Returns
    -------
    ndarray, shape (suns, samples, 3)
    """
    suns = [Take([sun(direction)]) for direction in np.asarray(to_light, dtype=float).tolist()]
    arrays, camera = cloud(normals, inputs)
    return np.stack([samples_of(image, len(normals)) for image in render(shader, Scene(arrays, camera), suns)])


def direct_light_by_groups(
    shader: Path, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike
) -> NDArray[np.float32]:
    """As `direct_light`, but with as many equal groups of facets as suns, each lit by its own; shape (samples, 3)."""
    directions = np.asarray(to_light, dtype=float).tolist()
    count, groups = len(normals), len(directions)
    takes = [Take([sun(l)], rows_of(k, groups, count)) for k, l in enumerate(directions)]
    arrays, camera = cloud(normals, inputs)
    images = render(shader, Scene(arrays, camera), takes)
    parts = [slice(k * count // groups, (k + 1) * count // groups) for k in range(groups)]
    return np.concatenate([samples_of(image, count)[part] for image, part in zip(images, parts, strict=True)])


def true_normals(normals: Array) -> NDArray[np.float32]:
    """The normals N that a shader sees on facets with these wanted normals, (samples, 3).

    Those of the same cloud alone: they depend, in the last digits, on where in it a facet lies. Not those of a rendered
    normal pass, which averages the closures' normals: an aligned lobe has its own.
    """
    arrays, camera = cloud(normals, {})
    (image,) = render(_normal_shader(process.runtime()), Scene(arrays, camera))
    return samples_of(image, len(normals))


@lru_cache(maxsize=1)
def _normal_shader(runtime: BlenderProcess) -> Path:
    """A shader that emits N, compiled in this runtime."""
    del runtime  # tells one process's files from the next one's
    source = "shader mrm_normals(output closure color out = 0)\n{\n    out = emission() * color(N[0], N[1], N[2]);\n}\n"
    return compile_for_cycles(source, "mrm_normals")


def furnace(
    shader: Path, normals: Array, inputs: Mapping[str, Array], samples: int, bounces: int = 4, seed: int = 0
) -> NDArray[np.float32]:
    """Radiance of facets in a white environment of radiance 1, (samples, 3): their directional albedo, with noise.

    `samples` is the number of paths per facet.
    """
    arrays, camera = cloud(normals, inputs)
    scene = Scene(arrays, camera, world={"radiance": [1.0, 1.0, 1.0]}, samples=samples, bounces=bounces)
    return samples_of(render(shader, scene, seed=seed)[0], len(normals))
