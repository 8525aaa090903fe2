"""Images as OpenGL textures, with the sampler state that the generated code leaves to its host."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.images import as_read
from mrm_mtlx.engines.gl.image_calls import Sampling

if TYPE_CHECKING:
    from numpy.typing import NDArray

# OpenGL's numbers, from its registry.
_TEXTURE_2D = 0x0DE1
_WRAP_S, _WRAP_T, _BORDER_COLOR = 0x2802, 0x2803, 0x1004
# moderngl's names of the types of texels.
_DTYPES = {"u2": "nu2", "f2": "f2", "f4": "f4"}
# Of an image on its way to the driver.
_STRIP_BYTES = 1 << 24
_WRAPS = {"constant": 0x812D, "clamp": 0x812F, "periodic": 0x2901, "mirror": 0x8370}


def upload(context: Any, pixels: NDArray[Any], sampling: Sampling | None = None, *, mipmaps: bool = True) -> Any:
    """A texture of an image, flipped so that v grows upward as MaterialX has it.

    `pixels` may be as stored: whole numbers become 16 bits, which hold those of 8 bits exactly and are not filtered in
    8 bits, float16 stays, all else is float32. `sampling` says how it is looked up and read: without, it repeats in
    both directions, filtered linearly. There is no cubic filter in OpenGL; as MaterialX's own hosts do, "cubic" is
    linear.
    """
    sampling = sampling or Sampling()
    height, width, channels = pixels.shape
    components, kind = _components(channels, sampling), _kind(pixels.dtype)
    texture = context.texture((width, height), components, dtype=_DTYPES[kind], alignment=1)
    step = max(_STRIP_BYTES // (width * channels * 4), 1)
    for row in range(0, height, step):
        strip = _texels(pixels[::-1][row : row + step], sampling, components, kind)
        texture.write(strip.tobytes(), viewport=(0, row, width, len(strip)), alignment=1)
    if components == 1:
        texture.swizzle = "RRR1"
    elif channels == 2 and sampling.components != 2 and "constant" not in (sampling.u, sampling.v):
        texture.swizzle = "RRRG"
    _set_sampler(context, texture, sampling, mipmaps)
    return texture


def texture_bytes(pixels: NDArray[Any], sampling: Sampling) -> int:
    """Bytes that the texture of an image takes, without mipmaps."""
    components, size = _components(pixels.shape[-1], sampling), np.dtype(_kind(pixels.dtype)).itemsize
    return int(pixels.shape[0] * pixels.shape[1] * (4 if components == 3 else components) * size)


def _components(channels: int, sampling: Sampling) -> int:
    """Components of a texture: no more than are read of it; a grey and its opacity go through a swizzle."""
    if "constant" in (sampling.u, sampling.v):  # the border's colour goes through the swizzle, too
        return sampling.read
    return channels if channels <= 2 else min(channels, sampling.read)


def _kind(stored: np.dtype[Any]) -> str:
    return {"uint8": "u2", "uint16": "u2", "float16": "f2"}.get(stored.name, "f4")


def _texels(rows: NDArray[Any], sampling: Sampling, components: int, kind: str) -> NDArray[Any]:
    """Some rows of an image as they go into its texture."""
    if "constant" in (sampling.u, sampling.v):
        values = as_read(rows, components)
        return np.round(65535.0 * values).astype("u2") if kind == "u2" else values.astype(kind)
    chosen = rows[..., :components]
    return chosen.astype("u2") * np.uint16(257) if chosen.dtype == np.uint8 else chosen.astype(kind)


def stand_in(sampling: Sampling) -> NDArray[np.float32]:
    """The image in the place of one that is missing or cannot be read: a pixel of the node's default."""
    return np.array(sampling.default[: sampling.components], dtype=np.float32).reshape(1, 1, -1)


def _set_sampler(context: Any, texture: Any, sampling: Sampling, mipmaps: bool) -> None:
    """Filter, address modes and border of a texture."""
    closest = sampling.filter == "closest"
    if mipmaps:
        texture.build_mipmaps()
        small = context.NEAREST_MIPMAP_NEAREST if closest else context.LINEAR_MIPMAP_LINEAR
    else:
        small = context.NEAREST if closest else context.LINEAR
    texture.filter = (small, context.NEAREST if closest else context.LINEAR)
    # moderngl knows neither mirrored repetition nor a border, so these are set past it, on the texture bound last.
    texture.use(location=0)
    set_number, set_numbers = _parameter_functions(context)
    set_number(_TEXTURE_2D, _WRAP_S, _WRAPS[sampling.u])
    set_number(_TEXTURE_2D, _WRAP_T, _WRAPS[sampling.v])
    border = (*sampling.default, 0.0, 0.0, 0.0, 0.0)[:4]
    set_numbers(_TEXTURE_2D, _BORDER_COLOR, (ctypes.c_float * 4)(*border))


@cache
def _parameter_functions(context: Any) -> tuple[Any, Any]:
    """OpenGL's glTexParameteri and glTexParameterfv, from the loader that moderngl has of them."""
    load = context.mglo._context.load
    whole = ctypes.CFUNCTYPE(None, ctypes.c_uint, ctypes.c_uint, ctypes.c_int)
    several = ctypes.CFUNCTYPE(None, ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_float))
    return whole(load("glTexParameteri")), several(load("glTexParameterfv"))
