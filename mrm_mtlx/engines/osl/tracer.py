"""Cycles as a path tracer of pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import Take
from mrm_mtlx.engines.osl import scenes
from mrm_mtlx.engines.osl.compiler import compile_for_cycles

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Scene
    from mrm_mtlx.shadergen import Shader


class CyclesTracer:
    """The path tracer; see `PathTracer`."""

    def compile(self, shader: Shader) -> Path:
        """As `PathTracer.compile`."""
        return compile_for_cycles(for_cycles(shader), shader.name)

    def render(
        self, shader: Path, scene: Scene, takes: Sequence[Take] = (Take(),), seed: int = 0
    ) -> list[NDArray[np.float32]]:
        """As `PathTracer.render`."""
        return scenes.render(shader, scene, takes, seed)


def for_cycles(shader: Shader) -> str:
    """Generated OSL with what Cycles has elsewhere: texture coordinates, and images upside down.

    The globals u and v are barycentric in Cycles; the coordinates come as an input, from the mesh. MaterialX has v grow
    upward, OSL's texture lookup downward.
    """
    source = shader.sources["pixel"]
    if "vector2(u,v)" in source:
        source = source.replace("vector2(u,v)", "vector2(mrm_uv[0],mrm_uv[1])")
        head, _, tail = source.rpartition("    output ")
        source = f"{head}    vector mrm_uv = 0,\n    output {tail}"
    return source.replace("    return texcoord;", "    return vector2(texcoord.x, 1.0 - texcoord.y);")
