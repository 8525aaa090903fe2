"""An engine as another package may bring it: it runs the GLSL that MaterialX writes for WGSL, in the words of OpenGL.

`test_registry.py` installs it beside an entry point, for this process and for those that it starts.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from mrm_mtlx.engines import registry
from mrm_mtlx.engines.base import (
    Availability,
    Capabilities,
    CompileError,
    CompileMessage,
    DirectionalLight,
    Engine,
    PointLight,
)

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Program
    from mrm_mtlx.shadergen import Shader

# Vulkan's words for what OpenGL has as well, and OpenGL's.
_WORDS = (
    (r"#version 450", "#version 430"),
    (r"#pragma shader_stage\(fragment\)", ""),
    (r"layout \(location = 0\) ", ""),
    (r"layout \(binding=\d+\) uniform texture2D (\w+)_texture;", r"uniform sampler2D \1;"),
    (r"layout \(binding=\d+\) uniform sampler \w+;", ""),
    (r"texture2D (\w+)_texture, sampler \1_sampler", r"sampler2D \1"),
    (r"sampler2D\((\w+)_texture, \1_sampler\)", r"\1"),
    (r"(\w+)_texture, \1_sampler", r"\1"),
    (r"\blight_type\b", "type"),
)
_BLOCK = re.compile(r"layout \(std140, binding=\d+\) uniform \w+\n\{\n(.*?)\n\};", re.DOTALL)


class Toy(Engine):
    """Runs what is meant for WGSL in the engine that runs GLSL."""

    name = "toy"
    use = "runs WGSL by way of GLSL"
    targets = ("wgsl",)
    capabilities = Capabilities(runs=True, lights=frozenset({DirectionalLight, PointLight}), environment=True)

    def availability(self) -> Availability:
        """As `Engine.availability`: that of the engine behind it."""
        state = _behind().availability()
        return Availability(state.available, f"by way of {state.detail}", state.remedy)

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> Program:
        """As `Engine.compile`."""
        assert not images, "it has no textures, and says so"
        if "void main()" not in shader.sources["pixel"]:
            raise CompileError([CompileMessage(0, "", "there is no main")])
        return _behind().compile(replace(shader, sources={"pixel": translated(shader.sources["pixel"])}))


def _behind() -> Engine:
    engine = registry.engine_for("glsl", registry.runs)
    assert engine is not None
    return engine


def translated(source: str) -> str:
    """GLSL of Vulkan as GLSL of OpenGL."""
    for vulkan, opengl in _WORDS:
        source = re.sub(vulkan, opengl, source)
    return _BLOCK.sub(lambda block: re.sub(r"^    (?=\w)", "uniform ", block[1], flags=re.MULTILINE), source)


ENGINE = Toy()
