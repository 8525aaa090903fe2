"""OpenGL as an engine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import Engine
from mrm_mtlx.engines.gl import context
from mrm_mtlx.engines.gl.program import SurfaceProgram

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Availability
    from mrm_mtlx.shadergen import Shader


class OpenGL(Engine):
    """The driver: it compiles and runs the unmodified pixel stage."""

    name = "gl"
    use = "compiles and runs glsl and essl"
    targets = ("glsl", "essl")
    capabilities = SurfaceProgram.capabilities

    def availability(self) -> Availability:
        """As `Engine.availability`; the detail names the driver."""
        return context.availability()

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> SurfaceProgram:
        """As `Engine.compile`."""
        return SurfaceProgram(shader, images)


ENGINE = OpenGL()
