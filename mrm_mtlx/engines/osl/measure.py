"""Measures in Cycles: values of OSL functions, and what closures reflect."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.engines.osl import process
from mrm_mtlx.engines.osl.compiler import compile_for_cycles
from mrm_mtlx.engines.osl.scenes import Scene, cloud, render, samples_of, sun

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array

# Facets per render: bounds the memory of a scene.
_BATCH = 1 << 16


def evaluate(shader: Path, inputs: Mapping[str, Array]) -> NDArray[np.float32]:
    """What a shader emits for each sample, (samples, 3): its output is `emission() * value`, which may be negative.

    Parameters
    ----------
    shader
        Compiled, see `compiler.compile_for_cycles`.
    inputs
        Values of its inputs by name, (samples,) or (samples, 3), at least one; they reach it bit by bit as float32.

    Raises
    ------
    RuntimeFailure
        If Cycles refuses or dies.
    """
    count = len(next(iter(inputs.values())))
    facing = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    found = []
    for start in range(0, count, _BATCH):
        part = slice(start, start + _BATCH)
        arrays, camera = cloud(facing[part], {name: value[part] for name, value in inputs.items()})
        found.append(samples_of(render(shader, Scene(arrays, camera))["Combined"], len(facing[part])))
    return np.concatenate(found)


def direct_light(
    shader: Path, normals: Array, inputs: Mapping[str, Array], to_light: Sequence[float]
) -> NDArray[np.float32]:
    """Radiance of facets under a sun of unit irradiance, seen along z: f(v, l) cos(l), shape (samples, 3).

    Parameters
    ----------
    shader, inputs
        As `evaluate`; the shader's output is a surface closure.
    normals : shape (samples, 3)
        Wanted normals, z > 0; what float32 makes of them, in the corners of a facet, `true_normals` tells.
    to_light
        l, a unit vector.
    """
    found = []
    for start in range(0, len(normals), _BATCH):
        part = slice(start, start + _BATCH)
        arrays, camera = cloud(normals[part], {name: value[part] for name, value in inputs.items()})
        image = render(shader, Scene(arrays, camera, [sun(to_light)]))["Combined"]
        found.append(samples_of(image, len(normals[part])))
    return np.concatenate(found)


def true_normals(normals: Array) -> NDArray[np.float32]:
    """The normals N that a shader sees on facets with these wanted normals, (samples, 3).

    Not those of a rendered normal pass, which averages the closures' normals: an aligned lobe has its own.
    """
    shader = _normal_shader(process.runtime())
    found = []
    for start in range(0, len(normals), _BATCH):
        part = normals[start : start + _BATCH]
        arrays, camera = cloud(part, {})
        found.append(samples_of(render(shader, Scene(arrays, camera))["Combined"], len(part)))
    return np.concatenate(found)


@lru_cache(maxsize=1)
def _normal_shader(runtime: process.CyclesProcess) -> Path:
    """A shader that emits N, compiled in this runtime."""
    del runtime  # tells one process's files from the next one's
    source = "shader mrm_normals(output closure color out = 0)\n{\n    out = emission() * color(N[0], N[1], N[2]);\n}\n"
    return compile_for_cycles(source, "mrm_normals")


def furnace(
    shader: Path, normals: Array, inputs: Mapping[str, Array], samples: int, bounces: int = 4, seed: int = 0
) -> NDArray[np.float32]:
    """Radiance of facets in white surroundings of radiance 1, (samples, 3): their directional albedo, with noise.

    `samples` is the number of paths per facet.
    """
    arrays, camera = cloud(normals, inputs)
    scene = Scene(arrays, camera, world={"radiance": [1.0, 1.0, 1.0]}, samples=samples, bounces=bounces)
    return samples_of(render(shader, scene, seed)["Combined"], len(normals))
