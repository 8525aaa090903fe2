"""Cycles as a path tracer of pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import Take
from mrm_mtlx.engines.osl import scenes
from mrm_mtlx.engines.osl.compiler import compile_for_cycles
from mrm_mtlx.shadergen import with_mesh_inputs

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Scene
    from mrm_mtlx.shadergen import Shader


class CyclesRenderer:
    """The renderer; see `SceneRenderer`."""

    traces_paths = True

    def __init__(self, target: str) -> None:
        self.target = target

    def compile(self, shader: Shader) -> Path:
        """As `SceneRenderer.compile`."""
        return compile_for_cycles(with_mesh_inputs(shader.sources["pixel"]), shader.name)

    def render(
        self, shader: Path, scene: Scene, takes: Sequence[Take] = (Take(),), seed: int = 0
    ) -> list[NDArray[np.float32]]:
        """As `SceneRenderer.render`."""
        return scenes.render(shader, scene, takes, seed)
