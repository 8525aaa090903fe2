"""Compilers that check generated source without running it."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines.availability import Availability
from mrm_mtlx.system.console import silenced
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from mrm_mtlx.shadergen import Shader

# A compiler that takes longer than this on one shader hangs; they take well under a second.
_TIMEOUT_S = 60
_SERIAL = itertools.count()

GLSLANG_REMEDY = "apt-get install -y glslang-tools"
SLANG_REMEDY = "pip install slangpy"


def vulkan_availability() -> Availability:
    """Whether Vulkan GLSL can be compiled: by glslangValidator."""
    path = shutil.which("glslangValidator")
    if path is None:
        return Availability(False, "glslangValidator not found", GLSLANG_REMEDY)
    return Availability(True, "glslangValidator")


@cache
def slang_availability() -> Availability:
    """Whether Slang can be compiled: by slangc, or by the compiler that slangpy brings."""
    if shutil.which("slangc"):
        return Availability(True, "slangc")
    try:
        _slang_session()
    except Exception as error:  # a missing module, or a device that the bindings cannot make
        reason = "slangc and slangpy not found" if isinstance(error, ImportError) else f"slangpy: {error}"
        return Availability(False, text_lines(reason)[0], SLANG_REMEDY)
    return Availability(True, "slangpy")


def compile_vulkan(shader: Shader) -> str:
    """Compile both stages to SPIR-V; the compiler's messages with their source lines, or "" if it accepts them."""
    for stage, suffix in (("vertex", "vert"), ("pixel", "frag")):
        with tempfile.TemporaryDirectory() as folder:
            source, result = Path(folder) / f"shader.{suffix}", Path(folder) / "shader.spv"
            source.write_text(shader.sources[stage], encoding="utf-8")
            log = _run(["glslangValidator", "-V", "--quiet", "-o", str(result), str(source)], folder)
        if log:
            return f"{stage} stage: {_with_source(log, shader.sources[stage])}"
    return ""


def compile_slang(shader: Shader) -> str:
    """Compile a Slang module; the compiler's messages, or "" if it accepts it."""
    source = shader.sources["pixel"]
    if shutil.which("slangc"):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "shader.slang"
            path.write_text(source, encoding="utf-8")
            command = ["slangc", str(path), "-o", str(Path(folder) / "shader.slang-module")]
            return _with_source(_run(command, folder), source)
    # slangpy compiles for its CPU device, which refuses derivatives (fwidth) in an entry point, though they are no
    # error of the source: so the module is compiled as functions, without its entry points.
    functions = re.sub(r'\[shader\("\w+"\)\]', "", source)
    try:
        with silenced():
            _slang_session().load_module_from_source(f"mrm_{os.getpid()}_{next(_SERIAL)}", functions)
    except Exception as error:  # slangpy raises RuntimeError, and what its bindings add
        return _with_source(str(error), source, first_line=2)  # slangpy puts a line of its own before the source
    return ""


@cache
def _slang_session() -> Any:
    import slangpy

    # The device prints its own log to the process's descriptors; data is what belongs there.
    with silenced():
        return slangpy.Device(type=slangpy.DeviceType.cpu).slang_session


def _run(command: list[str], folder: str) -> str:
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, errors="replace", timeout=_TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return f"{command[0]} did not finish within {_TIMEOUT_S} s"
    if done.returncode == 0:
        return ""
    log = (done.stdout + done.stderr).replace(f"{folder}{os.sep}", "").strip()
    return log or f"{command[0]} failed with exit status {done.returncode} and said nothing"


def _with_source(log: str, source: str, first_line: int = 1) -> str:
    """The first error of a log on one line, with the number and text of the source line that it names.

    `first_line` is the number that the compiler gives to the source's first line.
    """
    if not log:
        return ""
    match = re.search(r"^.*\berror\b.*$", log, re.MULTILINE | re.IGNORECASE)
    message = match[0] if match else text_lines(log)[0]
    # glslang puts the place before the message, `ERROR: shader.frag:12: ...`; slang on the next line, `--> name:12:5`.
    place = re.search(r":(\d+)(?::|$)", log[match.start() if match else 0 :], re.MULTILINE)
    number, lines = int(place[1]) - first_line + 1 if place else 0, source.split("\n")
    where = f" at line {number}: {lines[number - 1].strip()}" if 0 < number <= len(lines) else ""
    message = re.sub(r"^ERROR: \S+?:\d+: ", "", message.strip())
    return f"{message}{where}"
