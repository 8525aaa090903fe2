"""OpenUSD's Storm as an engine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import Engine
from mrm_mtlx.engines.storm import process
from mrm_mtlx.engines.storm.program import CAPABILITIES, StormProgram
from mrm_mtlx.engines.storm.renderer import StormRenderer

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Availability
    from mrm_mtlx.shadergen import Shader


class Storm(Engine):
    """The rasteriser of OpenUSD, which takes materials and generates their shaders with its own MaterialX."""

    name = "storm"
    use = "draws materials in OpenUSD's Storm"
    targets = ("storm",)
    capabilities = CAPABILITIES
    scene_renderer = StormRenderer(*targets)

    def availability(self) -> Availability:
        """As `Engine.availability`; the detail names the versions of Storm, Blender and MaterialX."""
        return process.RUNTIME.availability()

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> StormProgram:
        """As `Engine.compile`: Storm has drawn the material once."""
        del images  # it has no textures
        return StormProgram.compiled(shader)

    def stop(self) -> None:
        """As `Engine.stop`."""
        process.RUNTIME.stop()


ENGINE = Storm()
