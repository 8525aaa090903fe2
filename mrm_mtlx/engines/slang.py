"""Checks Slang with slangc, or with the compiler that slangpy brings."""

from __future__ import annotations

import itertools
import os
import re
from functools import cache
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines import commands
from mrm_mtlx.engines.base import Availability, CompiledOnly, CompileError, Engine
from mrm_mtlx.system.console import silenced
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.shadergen import Shader

_COMMAND = "slangc"
_REMEDY = "pip install slangpy"
_SERIAL = itertools.count()


class Slang(Engine):
    """The compiler of Slang, as a command or in Python."""

    name = "slang"
    use = "compiles Slang"
    targets = ("slang",)

    def availability(self) -> Availability:
        """As `Engine.availability`."""
        return Availability(True, _COMMAND) if commands.works(_COMMAND, "-v") else _python_availability()

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> CompiledOnly:
        """As `Engine.compile`."""
        del images  # it has no textures
        source = shader.sources["pixel"]
        if commands.works(_COMMAND, "-v"):
            commands.compile_file([_COMMAND, "-o", "shader.slang-module"], source, "shader.slang")
        else:
            _compile_in_python(source)
        return CompiledOnly()


def _compile_in_python(source: str) -> None:
    # slangpy compiles for its CPU device, which refuses derivatives (fwidth) in an entry point, though they are no
    # error of the source: so the module is compiled as functions, without its entry points.
    functions = re.sub(r'\[shader\("\w+"\)\]', "", source)
    try:
        with silenced():
            _session().load_module_from_source(f"mrm_{os.getpid()}_{next(_SERIAL)}", functions)
    except Exception as error:  # slangpy raises RuntimeError, and what its bindings add
        log = str(error) or type(error).__name__
        # slangpy puts a line of its own before the source.
        raise CompileError([commands.first_message(log, source, first_line=2)]) from error


@cache
def _python_availability() -> Availability:
    try:
        _session()
    except Exception as error:  # a missing module, or a device that the bindings cannot make
        reason = "slangc and slangpy not found" if isinstance(error, ImportError) else f"slangpy: {error}"
        return Availability(False, text_lines(reason)[0], _REMEDY)
    return Availability(True, "slangpy")


@cache
def _session() -> Any:
    import slangpy

    # The device prints its own log to the process's descriptors; data is what belongs there.
    with silenced():
        return slangpy.Device(type=slangpy.DeviceType.cpu).slang_session


ENGINE = Slang()
