"""Procedural nodes: noise, cells, flakes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.reference.float32.function_errors import displaced
from mrm_mtlx.reference.float32.precision import widened
from mrm_mtlx.reference.float32.rounding import ROUNDING_FACTOR, UNIT, Quantity
from mrm_mtlx.reference.nodes.registry import node
from mrm_mtlx.reference.textures import flakes
from mrm_mtlx.reference.textures import noise as noise_functions
from mrm_mtlx.reference.textures.flakes import Flake

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs, Value

_COMPONENTS = {"float": 1, "vector2": 2, "vector3": 3, "vector4": 4}
_POSITIONS = {2: "texcoord", 3: "position"}

# Where the channel lies for which a hash has no bits left: the fourth, and of fractal noise of two channels the second.
_NOISE_OFFSET = (19.0, 73.0, 29.0)
_FRACTAL_OFFSET = (19.0, 193.0, 17.0)


def _noise(inputs: Inputs, position: Array, components: int) -> Array:
    once = np.ones(1)
    octaves = partial(noise_functions.fractal_noise, octaves=once, lacunarity=once, diminish=once)
    value = _channels(inputs, octaves, position, min(components, 3), _NOISE_OFFSET if components == 4 else ())
    return np.asarray(value * inputs.array("amplitude") + inputs.array("pivot"))


def _fractal(inputs: Inputs, position: Array, components: int) -> Array:
    octaves = partial(
        noise_functions.fractal_noise,
        octaves=inputs.array("octaves"),
        lacunarity=inputs.array("lacunarity"),
        diminish=inputs.array("diminish"),
    )
    together = 1 if components == 2 else min(components, 3)
    value = _channels(inputs, octaves, position, together, _FRACTAL_OFFSET if components > together else ())
    return np.asarray(value * inputs.array("amplitude"))


def _channels(
    inputs: Inputs,
    octaves: Callable[..., tuple[Array, Array]],
    position: Array,
    together: int,
    offset: tuple[float, ...],
) -> Array:
    """Channels of noise, so many of one hash and one more at an offset, if there is one."""
    parts = [octaves(position, together)]
    if offset:
        parts.append(octaves(position + np.array(offset[: len(position)])[:, None], 1, roundings=1))
    every = [np.broadcast_arrays(value, error) for value, error in parts]
    value, error = (np.concatenate(arrays) for arrays in zip(*every, strict=True))
    return _missed(inputs, value, error)


def _cells(inputs: Inputs, position: Array, _components: int) -> Array:
    """A random number per cell; where roundings reach beyond the cells next to it, it may be any."""
    cell = inputs.discrete(np.floor(position))
    anywhere = np.any(inputs.skipped(cell), axis=0)
    return np.where(anywhere, inputs.level, noise_functions.cell_noise(*cell))[None]


def _worley(inputs: Inputs, position: Array, components: int) -> Array:
    """Distances to the nearest points, or random numbers of the nearest one's cell where the style is 1."""
    jitter, style = inputs.array("jitter"), inputs.array("style")
    distances, ways = noise_functions.nearest_points(position, jitter, max(components, 2))
    error = noise_functions.distance_error(jitter)
    value = _missed(inputs, distances[:components], error)
    if not np.any(style == 1.0):
        return value

    def looks(cell: Array) -> Array:
        random = noise_functions.cell_noise(*cell)[None] if components == 1 else noise_functions.cell_noises(*cell)
        return random[:components]

    tied = distances[1] - distances[0] < 2.0 * error

    def alternative(second: float = 0.0, edge: float = 0.0) -> Array:
        way = np.where(tied & (second != 0.0), ways[1], ways[0])
        return looks(np.floor(position + way + edge * (error + 2.0 * UNIT * np.abs(position))))

    # The nearest point's cell is found from its position, which may lie on the cell's edge.
    cell = inputs.discrete(np.floor(position + ways[0]))
    unsettled = _perturbed(inputs) and cell.shape[-1] > 1
    random = widened(alternative, second=1.0, edge=1.0) if unsettled else looks(cell)
    return np.where(style == 1.0, random, value)


def _perturbed(inputs: Inputs) -> bool:
    return inputs.light.perturbs(Quantity.FUNCTIONS)


def _missed(inputs: Inputs, value: Array, error: Array) -> Array:
    """The value, or where functions are perturbed one that is off by the error, which is given in full."""
    return displaced(inputs, value, error / ROUNDING_FACTOR)


@node("ND_flake2d")
def _flake_in_plane(inputs: Inputs) -> dict[str, Value]:
    u, v = inputs.array("texcoord")
    return _flake(inputs, np.stack([u, v, np.zeros_like(u)]))


@node("ND_flake3d")
def _flake_in_space(inputs: Inputs) -> dict[str, Value]:
    return _flake(inputs, inputs.array("position"))


def _flake(inputs: Inputs, position: Array) -> dict[str, Value]:
    position = position / inputs.array("size")
    likely, error = flakes.likelihood(inputs.array("coverage"))
    seen = flakes.top_flake(position, likely)
    decided = inputs.discrete(np.concatenate([seen.cell, seen.priority[None]]))
    seen = Flake(decided[:3], decided[3])
    if _perturbed(inputs) and decided.shape[-1] > 1:
        seen = flakes.alternative(position, likely, error)
    tilted = partial(flakes.normal, seen, inputs.array("roughness"), [inputs.array(name) for name in _FRAME])
    return {
        "id": flakes.identity(seen),
        "rand": flakes.number(seen),
        "presence": seen.priority,
        "flakenormal": widened(tilted, **flakes.NORMAL_ERRORS) if _perturbed(inputs) else tilted(),
    }


_FRAME = ("tangent", "bitangent", "normal")


def _register(name: str, kinds: tuple[str, ...], function: Callable[[Inputs, Array, int], Array]) -> None:
    """Register a noise over the plane and over space for these types of its value."""
    for dimensions, place in _POSITIONS.items():
        for kind in kinds:
            components = _COMPONENTS[kind]

            def evaluated(inputs: Inputs, place: str = place, components: int = components) -> Value:
                value = function(inputs, inputs.array(place), components)
                return value[0] if components == 1 else value

            node(f"ND_{name}{dimensions}d_{kind}")(evaluated)


_register("noise", ("float", "vector2", "vector3", "vector4"), _noise)
_register("fractal", ("float", "vector2", "vector3", "vector4"), _fractal)
_register("cellnoise", ("float",), _cells)
_register("worleynoise", ("float", "vector2", "vector3"), _worley)
