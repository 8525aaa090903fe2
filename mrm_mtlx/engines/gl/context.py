"""One off-screen OpenGL context per process, through EGL on Linux: no display, no window."""

from __future__ import annotations

import sys
from functools import cache
from typing import Any

from mrm_mtlx.engines.base import Availability

# Uniform blocks, float targets and `#version 300 es` sources in a desktop context (ARB_ES3_compatibility).
MINIMUM_VERSION = 430

DEBIAN_REMEDY = "apt-get install -y libegl1 libegl-mesa0 libgl1-mesa-dri"


@cache
def context() -> Any:
    """The moderngl context of this process.

    Raises
    ------
    RuntimeError
        If there is no usable OpenGL driver; the message says what is missing.
    """
    try:
        import moderngl

        if sys.platform.startswith("linux"):
            return moderngl.create_context(standalone=True, require=MINIMUM_VERSION, backend="egl")  # type: ignore[arg-type]
        return moderngl.create_context(standalone=True, require=MINIMUM_VERSION)
    except Exception as error:  # glcontext and the loader raise whatever the platform gives them
        msg = f"no OpenGL 4.3 context could be made: {error}"
        raise RuntimeError(msg) from error


@cache
def parking_target() -> Any:
    """A framebuffer to bind when a target is released: drivers reject going back to one that no longer exists."""
    return context().framebuffer(color_attachments=[context().texture((1, 1), 4, dtype="f4")])


def free_textures() -> None:
    """Have the driver give the memory of released textures back: it keeps those of the last draw until the next."""
    parking_target().use()
    _point().render(context().POINTS, vertices=1)
    context().finish()


@cache
def _point() -> Any:
    """Vertices of a draw that has no textures."""
    vertex = "#version 430\nvoid main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }"
    pixel = "#version 430\nout vec4 color;\nvoid main() { color = vec4(0.0); }"
    return context().vertex_array(context().program(vertex_shader=vertex, fragment_shader=pixel), [])


@cache
def availability() -> Availability:
    """The driver, tried; the detail names it."""
    try:
        info = context().info
    except RuntimeError as error:
        return Availability(False, str(error), DEBIAN_REMEDY)
    return Availability(True, f"{info['GL_RENDERER']}, OpenGL {info['GL_VERSION']}")
