"""Image nodes: what image files show at texture coordinates."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mrm_mtlx.documents.images import ADDRESS_MODES
from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32.precision import widened
from mrm_mtlx.reference.float32.rounding import RANGE, Quantity
from mrm_mtlx.reference.nodes.registry import node
from mrm_mtlx.reference.textures import hextile
from mrm_mtlx.reference.textures import lookup as texture_lookup
from mrm_mtlx.reference.textures.lookup import AddressModes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes.registry import Inputs, Value
    from mrm_mtlx.reference.textures.hextile import Spread, Tiles

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
        return texture_lookup.linear(pixels, _displaced(pixels, uv, ways), modes, border)

    return _sampled(inputs, at, "u", "v")


def _closest(inputs: Inputs, pixels: NDArray[np.floating], uv: Array, modes: AddressModes, border: Array) -> Array:
    decided = inputs.discrete(texture_lookup.cell(pixels, uv))
    settled = decided.shape[-1] == 1

    def at(**ways: Array | float) -> Array:
        seen = texture_lookup.cell(pixels, _displaced(pixels, uv, ways)) if _WAYS.keys() & ways.keys() else decided
        return texture_lookup.texel(pixels, seen, modes, border)

    return _sampled(inputs, at, *(() if settled else _WAYS))


def _sampled(inputs: Inputs, at: Callable[..., Array], *ways: str) -> Array:
    """The lookup; where textures are perturbed, with all that it may be off in these ways."""
    return widened(at, **dict.fromkeys(ways, 1.0)) if inputs.light.perturbs(Quantity.TEXTURE) else at()


def _displaced(pixels: NDArray[np.floating], uv: Array, ways: Mapping[str, Array | float], suffix: str = "") -> Array:
    """Coordinates displaced by these multiples of their error, by the names of `_WAYS` with the suffix."""
    steps = [ways.get(name + suffix, 0.0) * np.array(way)[:, None] for name, way in _WAYS.items()]
    return np.asarray(uv + np.sum(steps, axis=0) * texture_lookup.coordinate_error(pixels, uv))


@node("ND_hextiledimage_color3", "ND_hextiledimage_color4")
def _hextiled_image(inputs: Inputs) -> Value:
    contrast, coefficients = inputs.array("falloffcontrast"), inputs.array("lumacoeffs")
    falloff = inputs.array("falloff")

    def blended(tiles: Tiles, shown: Array, luminous: Array) -> Array:
        luminance = np.sum(luminous[:, :3] * coefficients, axis=1)
        shares = hextile.blend_weights(1.0 + (luminance - 1.0) * contrast, tiles.weights, falloff)
        color: Array = np.sum(shown[:, :3] * shares[:, None], axis=0)
        if shown.shape[1] == 3:
            return color
        if inputs.deviates(Deviation.HEXTILE_ALPHA):
            alpha = hextile.gain(np.mean(shown[:, 3], axis=0), falloff)
        else:
            alpha = np.sum(shown[:, 3] * hextile.blend_weights(np.ones(1), tiles.weights, falloff), axis=0)
        return np.concatenate([color, alpha[None]])

    # The channels of one tile may be off together, its luminance by other ones.
    return _hextiled(inputs, blended, [((a,) * len(inputs.stored("default")), b) for a, b in product((0, 1), repeat=2)])


@node("ND_hextilednormalmap_vector3")
def _hextiled_normal_map(inputs: Inputs) -> Value:
    strength, falloff = inputs.array("strength"), inputs.array("falloff")
    normal, tangent, bitangent = (inputs.array(name) for name in ("normal", "tangent", "bitangent"))
    sign = np.where(inputs.array("flip_g"), -1.0, 1.0)

    def bump(map_value: Array, angle: Array) -> Array:
        x, y, z = 2.0 * map_value - 1.0
        along, across = (hextile.turned(axis, normal, angle) * strength for axis in (tangent, bitangent))
        return unit(along * x + across * y * sign + normal * z)

    def blended(tiles: Tiles, shown: Array, _luminous: Array) -> Array:
        bumps = _stacked(bump(value, angle) for value, angle in zip(shown, tiles.angles, strict=True))
        shares = hextile.blend_weights(np.ones(1), tiles.weights, falloff)
        return hextile.blend_normals(normal, bumps, shares)

    # In between as well: a normal within the surface is the steepest of all, and has a slope without bound.
    return _hextiled(inputs, blended, [(ends, 0) for ends in product((0, 1, 2), repeat=3)])


_Blended: TypeAlias = "Callable[[Tiles, Array, Array], Array]"
_Corners: TypeAlias = "list[tuple[tuple[int, ...], int]]"


def _hextiled(inputs: Inputs, blended: _Blended, corners: _Corners) -> Array:
    """Three tiles, (3, components, samples), blended; each shows the default where there is no image.

    `blended` is given what counts for the luminance apart. `corners` are the ends of a tile's range at which it is
    taken (0 least, 1 most, 2 as near to a half as it goes), of each component and for the luminance.
    """
    coord = inputs.array("texcoord") * inputs.array("tiling")
    names = ("rotation", "rotationrange", "scale", "scalerange", "offset", "offsetrange")
    spread = hextile.Spread(*(inputs.array(name) for name in names))
    default, image = inputs.stored("default"), inputs.image("file")
    # As hosts have it, and not the default itself: black with a full contrast of luminance is 0/0.
    pixels = image if image is not None else default[:, 0][None, None]

    def at(**ways: Array | float) -> Array:
        way = np.array([[1.0], [0.0]]) * ways.get("u", 0.0) + np.array([[0.0], [1.0]]) * ways.get("v", 0.0)
        tiles = hextile.tiles(coord + way * hextile.coordinate_error(coord), spread)
        shown = _shown_by(tiles, pixels, default, ways)
        return blended(tiles, shown, shown)

    least, most = (inputs.light.perturbs(end) for end in RANGE)
    if least or most:
        tiles = hextile.tiles(coord, spread)
        shown, ends = _shown_by(tiles, pixels, default, {}), _tile_extremes(coord, spread, pixels, len(default))
        exact = blended(tiles, shown, shown)
        end = _at_the_end(partial(blended, tiles), shown, ends, corners, np.maximum if most else np.minimum)
        return np.asarray(exact + inputs.light.share * (end - exact))
    if inputs.light.perturbs(Quantity.FUNCTIONS):
        tiles = hextile.tiles(coord, spread)
        return _off_by_numbers(blended, tiles, _shown_by(tiles, pixels, default, {}), coord, spread)
    if inputs.light.perturbs(Quantity.TEXTURE):
        of_tiles = (f"{name}_{tile}" for name in ("u", "v") for tile in range(hextile.TILES))
        return widened(at, **dict.fromkeys(("u", "v", *of_tiles), 1.0))
    return at()


def _shown_by(tiles: Tiles, pixels: NDArray[np.floating], default: Array, ways: Mapping[str, Array | float]) -> Array:
    places = (_displaced(pixels, uv, ways, f"_{tile}") for tile, uv in enumerate(tiles.coordinates))
    return _stacked(texture_lookup.linear(pixels, place, AddressModes(), default) for place in places)


def _tile_extremes(coord: Array, spread: Spread, pixels: NDArray[np.floating], components: int) -> Array:
    """Least, most and nearest to a half that each tile may show, as float32 has its random numbers.

    Shape (3, 3, components, samples), the tile second.

    Their errors may span several texels, between which an image may have anything: nothing less than all of them is
    looked at. A number that may come out at the other end of [0, 1) has the tile look elsewhere.
    """
    reach, wrapped = hextile.reach(coord, spread), hextile.wrapped(coord)
    exact = hextile.tiles(coord, spread).coordinates
    found = [texture_lookup.extremes(pixels, uv, r, components) for uv, r in zip(exact, reach, strict=True)]
    for axis in range(2):
        shift = wrapped * np.array([[1.0], [0.0]] if axis == 0 else [[0.0], [1.0]])
        elsewhere = hextile.tiles(coord, spread, hextile.Errors(random=shift)).coordinates
        for tile, (least, most) in enumerate(found):
            at = np.flatnonzero(wrapped[tile, axis])
            low, high = texture_lookup.extremes(pixels, elsewhere[tile][:, at], reach[tile][:, at], components)
            least[:, at], most[:, at] = np.minimum(least[:, at], low), np.maximum(most[:, at], high)
    least, most = (np.stack(end) for end in zip(*found, strict=True))
    return np.stack([least, most, np.clip(0.5, least, most)])


def _at_the_end(
    blended: Callable[[Array, Array], Array], shown: Array, ends: Array, corners: _Corners, farther: np.ufunc
) -> Array:
    """The texture at the least or the most, each tile being at the corner of its range that gives it."""
    shown = np.broadcast_to(shown, ends.shape[1:])
    exact = blended(shown, shown)
    off = np.zeros_like(exact)
    for tile in range(hextile.TILES):
        of_tile = np.zeros_like(exact)
        for components, luminous in corners:
            at, lit = shown.copy(), shown.copy()
            at[tile] = [ends[end, tile, component] for component, end in enumerate(components)]
            lit[tile] = ends[luminous, tile]
            of_tile = farther(of_tile, blended(at, lit) - exact)
        off = off + of_tile
    return np.asarray(exact + off)


def _off_by_numbers(blended: _Blended, tiles: Tiles, shown: Array, coord: Array, spread: Spread) -> Array:
    """The texture with the errors of the tiles' weights and angles."""

    def at(**ways: Array | float) -> Array:
        weights = _stacked(w * (1.0 + ways.get(f"weight_{tile}", 0.0)) for tile, w in enumerate(tiles.weights))
        angles = _stacked(a + ways.get(f"angle_{tile}", 0.0) for tile, a in enumerate(tiles.angles))
        return blended(replace(tiles, weights=weights, angles=angles), shown, shown)

    low, high = np.deg2rad(spread.rotation_range)
    # Of a number that comes out at the other end, the range.
    angle = hextile.angle_error(coord, spread) + np.abs(hextile.wrapped(coord)[:, 0] * (high - low) * spread.rotation)
    errors = {f"angle_{tile}": angle[tile] for tile in range(hextile.TILES)}
    return widened(at, **errors, **{f"weight_{tile}": hextile.WEIGHT_ERROR for tile in range(hextile.TILES)})


def _stacked(arrays: Iterable[Array]) -> Array:
    return np.stack(np.broadcast_arrays(*arrays))
