"""Checks Vulkan GLSL with glslangValidator, which compiles it to SPIR-V."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
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
            with tempfile.TemporaryDirectory() as folder:
                source, result = Path(folder) / f"shader.{suffix}", Path(folder) / "shader.spv"
                source.write_text(shader.sources[stage], encoding="utf-8")
                log = commands.log_of([_COMMAND, "-V", "--quiet", "-o", str(result), str(source)], folder)
            if log:
                message = commands.first_message(log, shader.sources[stage])
                raise CompileError([replace(message, message=f"{stage} stage: {message.message}")])
        return CompiledOnly()


ENGINE = Glslang()
