"""Image nodes: what image files show at texture coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.library.images import ADDRESS_MODES
from mrm_mtlx.reference import hextile, texture_lookup
from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.nodes.registry import node
from mrm_mtlx.reference.precision import widened
from mrm_mtlx.reference.texture_lookup import AddressModes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.hextile import Tiles
    from mrm_mtlx.reference.nodes.registry import Inputs, Value

# What the generators make of an address mode: UsdUVTexture's "black" is its place in the enumeration, the first, and
# what is no mode is the default.
_MODES = {name: name for name in ADDRESS_MODES} | {"black": "constant"}

# Ways in which coordinates may be off. From a texel's corner, the one across is reached along a diagonal alone.
_WAYS = {"u": (1.0, 0.0), "v": (0.0, 1.0), "rising": (1.0, 1.0), "falling": (1.0, -1.0)}


@node(*(f"ND_image_{kind}" for kind in ("float", "color3", "color4", "vector2", "vector3", "vector4")))
def _image(inputs: Inputs) -> Value:
    """The image, or the default where there is none: a colour in the file's space, as hosts have it.

    A cubic filter is linear: OpenGL has none, and MaterialX's hosts have neither. Layer and frames are passed over, as
    in MaterialX's hardware shaders.
    """
    default, pixels, texcoord = inputs.stored("default"), inputs.image("file"), inputs.array("texcoord")
    border = np.atleast_2d(default)
    if pixels is None:
        value = border
    else:
        modes = AddressModes(*(_MODES.get(inputs.text(name), "periodic") for name in ("uaddressmode", "vaddressmode")))
        look_up = _closest if inputs.text("filtertype") == "closest" else _linear
        value = look_up(inputs, pixels, texcoord, modes, border)
    return value if default.ndim == 2 else value[0]


def _linear(inputs: Inputs, pixels: NDArray[np.floating], uv: Array, modes: AddressModes, border: Array) -> Array:
    def at(**ways: Array | float) -> Array:
        return texture_lookup.linear(pixels, _moved(pixels, uv, ways), modes, border)

    return _sampled(inputs, at, "u", "v")


def _closest(inputs: Inputs, pixels: NDArray[np.floating], uv: Array, modes: AddressModes, border: Array) -> Array:
    decided = inputs.discrete(texture_lookup.cell(pixels, uv))
    settled = decided.shape[-1] == 1

    def at(**ways: Array | float) -> Array:
        moved = texture_lookup.cell(pixels, _moved(pixels, uv, ways)) if _WAYS.keys() & ways.keys() else decided
        return texture_lookup.texel(pixels, moved, modes, border)

    return _sampled(inputs, at, *(() if settled else _WAYS))


def _sampled(inputs: Inputs, at: Callable[..., Array], *ways: str) -> Array:
    """What is looked up; in the move of textures, what it may be off in these ways."""
    return widened(at, **dict.fromkeys(ways, 1.0)) if inputs.light.moves("texture") else at()


def _moved(pixels: NDArray[np.floating], uv: Array, ways: Mapping[str, Array | float], suffix: str = "") -> Array:
    """Coordinates moved by these multiples of their error, by the names of `_WAYS` with the suffix."""
    steps = [ways.get(name + suffix, 0.0) * np.array(way)[:, None] for name, way in _WAYS.items()]
    return np.asarray(uv + np.sum(steps, axis=0) * texture_lookup.coordinate_error(pixels, uv))


@node("ND_hextiledimage_color3", "ND_hextiledimage_color4")
def _hextiled_image(inputs: Inputs) -> Value:
    contrast, coefficients = inputs.array("falloffcontrast"), inputs.array("lumacoeffs")
    falloff = inputs.array("falloff")

    def blended(tiles: Tiles, shown: Array) -> Array:
        luminance = np.sum(shown[:, :3] * coefficients, axis=1)
        shares = hextile.blend_weights(1.0 + (luminance - 1.0) * contrast, tiles.weights, falloff)
        color: Array = np.sum(shown[:, :3] * shares[:, None], axis=0)
        if shown.shape[1] == 3:
            return color
        alpha = np.sum(shown[:, 3] * hextile.blend_weights(np.ones(1), tiles.weights, falloff), axis=0)
        return np.concatenate([color, alpha[None]])

    return _hextiled(inputs, blended)


@node("ND_hextilednormalmap_vector3")
def _hextiled_normal_map(inputs: Inputs) -> Value:
    strength, falloff = inputs.array("strength"), inputs.array("falloff")
    normal, tangent, bitangent = (inputs.array(name) for name in ("normal", "tangent", "bitangent"))
    sign = np.where(inputs.array("flip_g"), -1.0, 1.0)

    def bump(map_value: Array, angle: Array) -> Array:
        x, y, z = 2.0 * map_value - 1.0
        along, across = (hextile.turned(axis, normal, angle) * strength for axis in (tangent, bitangent))
        return unit(along * x + across * y * sign + normal * z)

    def blended(tiles: Tiles, shown: Array) -> Array:
        bumps = _stacked(bump(value, angle) for value, angle in zip(shown, tiles.angles, strict=True))
        shares = hextile.blend_weights(np.ones(1), tiles.weights, falloff)
        return hextile.blend_normals(normal, bumps, shares)

    return _hextiled(inputs, blended)


def _hextiled(inputs: Inputs, blended: Callable[[Tiles, Array], Array]) -> Array:
    """What three tiles show, (3, components, samples), blended; each shows the default where there is no image."""
    coord = inputs.array("texcoord") * inputs.array("tiling")
    names = ("rotation", "rotationrange", "scale", "scalerange", "offset", "offsetrange")
    spread = hextile.Spread(*(inputs.array(name) for name in names))
    default, image = inputs.stored("default"), inputs.image("file")
    # As hosts have it, and not the default itself: black with a full contrast of luminance is 0/0.
    pixels = image if image is not None else default[:, 0][None, None]

    def at(**moved: Array | float) -> Array:
        way = np.array([[1.0], [0.0]]) * moved.get("u", 0.0) + np.array([[0.0], [1.0]]) * moved.get("v", 0.0)
        tiles = hextile.tiles(coord + way * hextile.coordinate_error(coord), spread, hextile.displaced(moved))
        shown = []
        for tile, uv in enumerate(tiles.coordinates):
            place = _moved(pixels, uv, moved, f"_{tile}")
            shown.append(texture_lookup.linear(pixels, place, AddressModes(), default))
        return blended(tiles, _stacked(shown))

    if inputs.light.moves("functions"):
        return widened(at, **hextile.errors(coord))
    if inputs.light.moves("texture"):
        of_tiles = (f"{name}_{tile}" for name in ("u", "v") for tile in range(hextile.TILES))
        return widened(at, **dict.fromkeys(("u", "v", *of_tiles), 1.0))
    return at()


def _stacked(arrays: Iterable[Array]) -> Array:
    return np.stack(np.broadcast_arrays(*arrays))
