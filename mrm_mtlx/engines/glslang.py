"""Checks Vulkan GLSL with glslangValidator, which compiles it to SPIR-V."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from mrm_mtlx.engines import commands
from mrm_mtlx.engines.base import Availability, CompiledOnly, CompileError, Engine

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.shadergen import Shader

_COMMAND = "glslangValidator"
_REMEDY = "apt-get install -y glslang-tools"


class Glslang(Engine):
    """The reference compiler of GLSL."""

    name = "vulkan"
    use = "compiles Vulkan GLSL"
    targets = ("vulkan",)

    def availability(self) -> Availability:
        """As `Engine.availability`."""
        if not commands.works(_COMMAND, "--version"):
            return Availability(False, f"{_COMMAND} not found", _REMEDY)
        return Availability(True, _COMMAND)

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> CompiledOnly:
        """As `Engine.compile`; both stages."""
        del images  # it has no textures
        for stage, suffix in (("vertex", "vert"), ("pixel", "frag")):
            try:
                command = [_COMMAND, "-V", "--quiet", "-o", "shader.spv"]
                commands.compile_file(command, shader.sources[stage], f"shader.{suffix}")
            except CompileError as error:
                found = [replace(m, message=f"{stage} stage: {m.message}") for m in error.messages]
                raise CompileError(found) from error
        return CompiledOnly()


ENGINE = Glslang()
