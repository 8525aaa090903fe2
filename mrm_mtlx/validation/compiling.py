"""A shader in an engine that compiles it and does not run it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import CompileError, EngineFailure
from mrm_mtlx.findings import rules
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen.undeclared_block import names_undeclared_block, with_members_alone
from mrm_mtlx.validation.results import Stage, Status, TargetResult

if TYPE_CHECKING:
    from mrm_mtlx.engines.base import Engine
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.shadergen import Shader


def check_compiles(engine: Engine, shader: Shader, place: str) -> tuple[TargetResult, list[Finding]]:
    """Compile a shader, if the engine works here; `place` is the element's path in findings."""
    available = engine.availability()
    if not available.available:
        return TargetResult(Stage.GENERATE, Status.SKIP, available.reason), []
    try:
        engine.compile(shader).release()
    except CompileError as error:
        if not names_undeclared_block(shader):
            return refused(shader.target, error.messages[0], place)
        result, findings = check_compiles(engine, with_members_alone(shader), place)
        known = f"{shader.target}: it deviates as known ({Deviation.UNDECLARED_BLOCK.value}): {error.messages[0]}"
        return result, findings or [rules.UPSTREAM_DEVIATION.at(place, known)]
    except EngineFailure as error:
        return refused(shader.target, error, place)
    return TargetResult(Stage.COMPILE, Status.PASS), []


def refused(target: str, reason: object, place: str) -> tuple[TargetResult, list[Finding]]:
    """The result of a shader that an engine refuses."""
    return TargetResult(Stage.COMPILE, Status.FAIL), [rules.SHADER_COMPILE.at(place, f"{target}: {reason}")]
