"""Targets that end at the compiler here, or before it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines import compilers, osl
from mrm_mtlx.findings import rules
from mrm_mtlx.validation.results import TargetResult

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.engines.availability import Availability
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.shadergen import Shader

# Why targets end at the source: no compiler for them runs here.
_NO_COMPILER = {
    "msl": "no Metal compiler: Apple's tools only",
    "wgsl": "no WGSL compiler: MaterialX writes GLSL to be transpiled",
    "mdl": "no MDL compiler",
}


def check_compiles(shader: Shader, place: str) -> tuple[TargetResult, list[Finding]]:
    """Compile a shader, if there is a compiler for its target; `place` is the element's path in findings."""
    if shader.target in _NO_COMPILER:
        return TargetResult("generate", "skip", _NO_COMPILER[shader.target]), []
    find, compiler = _COMPILERS[shader.target]
    available = find()
    if not available.available:
        return TargetResult("generate", "skip", available.reason), []
    message = compiler(shader)
    if message:
        return TargetResult("compile", "fail"), [rules.SHADER_COMPILE.at(place, f"{shader.target}: {message}")]
    return TargetResult("compile", "pass"), []


def _compile_osl(shader: Shader) -> str:
    """The OSL compiler's first error with its source line, or "" if it accepts the source."""
    try:
        osl.check(shader.sources["pixel"], shader.name)
    except osl.CompileError as error:
        return str(error.messages[0])
    except osl.RuntimeFailure as error:
        return str(error)
    return ""


# How targets that do not run here are compiled: whether they can be, and the compiler's message, "" for none.
_COMPILERS: dict[str, tuple[Callable[[], Availability], Callable[[Shader], str]]] = {
    "vulkan": (compilers.vulkan_availability, compilers.compile_vulkan),
    "slang": (compilers.slang_availability, compilers.compile_slang),
    "osl": (osl.compiler_availability, _compile_osl),
}
