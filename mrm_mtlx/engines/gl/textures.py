"""Images as OpenGL textures, with the sampler state that the generated code leaves to its host."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.gl.image_calls import Sampling
from mrm_mtlx.library.images import as_read

if TYPE_CHECKING:
    from numpy.typing import NDArray

# OpenGL's numbers, from its registry.
_TEXTURE_2D = 0x0DE1
_WRAP_S, _WRAP_T, _BORDER_COLOR = 0x2802, 0x2803, 0x1004
_WRAPS = {"constant": 0x812D, "clamp": 0x812F, "periodic": 0x2901, "mirror": 0x8370}


def upload(
    context: Any, pixels: NDArray[np.floating], sampling: Sampling | None = None, *, mipmaps: bool = True
) -> Any:
    """A float texture of an image, flipped so that v grows upward as MaterialX has it.

    `sampling` says how it is looked up and read: without, it repeats in both directions, filtered linearly. There is
    no cubic filter in OpenGL; as MaterialX's own hosts do, "cubic" is linear.
    """
    sampling = sampling or Sampling()
    if "constant" in (sampling.u, sampling.v):
        pixels = as_read(pixels, sampling.components)  # the border's colour goes through the swizzle, too
    height, width, channels = pixels.shape
    components = min(channels, 4)
    data = np.ascontiguousarray(pixels[::-1, :, :components], dtype="f4")
    texture = context.texture((width, height), components, data.tobytes(), dtype="f4", alignment=4)
    if components == 1:
        texture.swizzle = "RRR1"
    elif components == 2 and sampling.components != 2:
        texture.swizzle = "RRRG"
    _set_sampler(context, texture, sampling, mipmaps)
    return texture


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
