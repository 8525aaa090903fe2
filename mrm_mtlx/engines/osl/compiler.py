"""The OSL compiler: `oslc` where it is on the path, else the one that Cycles has."""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import MaterialX as mx

from mrm_mtlx.engines.availability import Availability
from mrm_mtlx.engines.compile_error import CompileError, CompileMessage
from mrm_mtlx.engines.osl import process
from mrm_mtlx.engines.osl.process import RuntimeFailure

_TIMEOUT_S = 60.0
_SERIAL = itertools.count()

# The folder, below a MaterialX root, of the headers that generated OSL includes.
_HEADERS = "libraries/stdlib/genosl/include"


def availability() -> Availability:
    """Whether OSL can be compiled here, by oslc or by Cycles."""
    path = shutil.which("oslc")
    return Availability(True, "oslc") if path else process.availability()


def check(source: str, name: str) -> None:
    """Compile a shader and drop the result.

    Raises
    ------
    CompileError
        If the compiler refuses the source.
    RuntimeFailure
        If there is no compiler, or it died.
    """
    if not shutil.which("oslc"):
        compile_for_cycles(source, name).unlink(missing_ok=True)
        return
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder)
        _write(target, source, name)
        command = ["oslc", "-q", "-o", f"{name}.oso", f"{name}.osl"]
        try:
            done = subprocess.run(
                command, cwd=target, capture_output=True, text=True, errors="replace", timeout=_TIMEOUT_S, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise RuntimeFailure(f"oslc did not finish within {_TIMEOUT_S:g} s") from error
        if done.returncode:
            raise CompileError(parse_log(done.stdout + done.stderr, source, name))


def compile_for_cycles(source: str, name: str) -> Path:
    """Compile a shader in the running Cycles; the compiled file, in the runtime's folder.

    Raises
    ------
    CompileError
        If the compiler refuses the source.
    RuntimeFailure
        If there is no runtime, it died, or its folder cannot be written.
    """
    runtime = process.runtime()
    target = runtime.folder / f"{name}_{next(_SERIAL)}.oso"
    written = _write(runtime.folder, source, name)
    answer, log = runtime.request("compile", timeout_s=_TIMEOUT_S, source=str(written), target=str(target))
    if not answer["ok"]:
        raise CompileError(parse_log(log, source, name))
    if not target.is_file() or not target.stat().st_size:
        raise RuntimeFailure("the compiled shader could not be written; is the disk of temporary files full?")
    return target


def parse_log(log: str, source: str, name: str) -> list[CompileMessage]:
    """The compiler's errors with source lines: `ERROR: name.osl:12: error: ...`, of oslc without the first word."""
    lines = source.split("\n")
    messages = []
    for match in re.finditer(r"^(?:ERROR: )?(?:(\S+):(\d+): )?error: (.+)$", log, re.MULTILINE):
        file, number = Path(match[1] or "").name, int(match[2] or 0)
        # A line of a header, or of what a macro made, is not a line of the source.
        own = file == f"{name}.osl" and number <= len(lines)
        # OSL names the line of the token after the statement: the statement is quoted with it.
        text = _excerpt(lines, number) if own and number else ""
        place = f"{file}:{number}: " if file else ""
        messages.append(CompileMessage(number if own else 0, text, f"{place}{match[3].strip()}"))
    if not messages:
        words = " ".join(line.strip() for line in log.splitlines() if line.strip())
        messages.append(CompileMessage(0, "", words or "the compiler gave no reason"))
    return messages


def _excerpt(lines: list[str], number: int) -> str:
    before = next((line for line in reversed(lines[: number - 1]) if line.strip()), "")
    return f"{before.strip()} {lines[number - 1].strip()}".strip()


def _write(folder: Path, source: str, name: str) -> Path:
    """The source beside the headers that it includes."""
    path = folder / f"{name}.osl"
    try:
        if not (folder / "mx_funcs.h").is_file():
            for header in Path(mx.getDefaultDataSearchPath().find(_HEADERS).asString()).glob("*.h"):
                shutil.copy(header, folder)
        path.write_text(source, encoding="utf-8")
    except OSError as error:
        raise RuntimeFailure(f"the shader could not be written for the compiler: {error.strerror}") from error
    return path
