"""The OSL compiler: `oslc` where it is on the path, else the one that Cycles has."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import signal
import tempfile
from pathlib import Path
from typing import NoReturn

from mrm_mtlx.engines import commands
from mrm_mtlx.engines.base import Availability, CompileError, CompileMessage, EngineFailure
from mrm_mtlx.engines.osl import process
from mrm_mtlx.shadergen import header_folder
from mrm_mtlx.system.writing import replacing

_SERIAL = itertools.count()


def availability() -> Availability:
    """The compiler that is used here: oslc, or that of Cycles."""
    return Availability(True, "oslc") if _has_oslc() else process.availability()


def _has_oslc() -> bool:
    """True if an oslc is on the path and runs."""
    return commands.works("oslc", "--help")


def check(source: str, name: str) -> None:
    """Compile a shader and drop the result.

    Raises
    ------
    CompileError
        If the compiler refuses the source.
    EngineFailure
        If there is no compiler, or it died.
    """
    if not _has_oslc():
        compile_for_cycles(source, name).unlink(missing_ok=True)
        return
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder)
        _write(target, source, name)
        command = ["oslc", "-q", "-o", f"{name}.oso", f"{name}.osl"]
        done = commands.run(command, target)
        if done.returncode < 0:
            raise EngineFailure(f"oslc ended with signal {signal.Signals(-done.returncode).name}")
        if done.returncode:
            _refuse(done.stdout + done.stderr, target, source, name)


def compile_for_cycles(source: str, name: str) -> Path:
    """Compile a shader in the running Cycles; the compiled file, in the runtime's folder.

    Raises
    ------
    CompileError
        If the compiler refuses the source.
    EngineFailure
        If there is no runtime, it died, or its folder cannot be written.
    """
    runtime = process.runtime()
    target = runtime.folder / f"{name}_{next(_SERIAL)}.oso"
    written = _write(runtime.folder, source, name)
    answer, log = runtime.request("compile", timeout_s=commands.TIMEOUT_S, source=str(written), target=str(target))
    if not answer["ok"] and "error:" in log and "Failed to write" not in log:
        _refuse(log, runtime.folder, source, name)
    # What the compiler wrote ends with a line of its own; on a full disk it is cut off, or not there.
    if not answer["ok"] or not target.is_file() or not target.read_bytes().endswith(b"\n"):
        raise EngineFailure("the compiled shader could not be written; is the disk of temporary files full?")
    return target


def _refuse(log: str, folder: Path, source: str, name: str) -> NoReturn:
    """Raise what the compiler has against the source, without the name of the folder it lay in."""
    raise CompileError(parse_log(log.replace(f"{folder}{os.sep}", ""), source, name))


def parse_log(log: str, source: str, name: str) -> list[CompileMessage]:
    """The compiler's errors with source lines: `ERROR: name.osl:12: error: ...`, of oslc without the first word."""
    lines = source.split("\n")
    messages = []
    for match in re.finditer(r"^(?:ERROR: )?(?:(\S+?):(\d+)(?::\d+)?: )?(?:fatal )?error: (.+)$", log, re.MULTILINE):
        file, number = Path(match[1] or "").name, int(match[2] or 0)
        # A line of a header is not a line of the source; the compiler puts one of its own before the source's first.
        own = file == f"{name}.osl" and 1 < number <= len(lines) + 1
        number -= own
        text = lines[number - 1].strip() if own else ""
        place = f"{file}:{number}: " if file else ""
        messages.append(CompileMessage(number if own else 0, text, f"{place}{match[3].strip()}"))
    if not messages:
        words = " ".join(line.strip() for line in log.splitlines() if line.strip())
        messages.append(CompileMessage(0, "", words or "the compiler gave no reason"))
    return messages


def _write(folder: Path, source: str, name: str) -> Path:
    """The source beside the headers that it includes."""
    path = folder / f"{name}.osl"
    try:
        if not (folder / "mx_funcs.h").is_file():
            # The one that is looked for above comes last: without it, all are copied again.
            for header in sorted(header_folder().glob("*.h"), key=lambda path: path.name == "mx_funcs.h"):
                with replacing(folder / header.name) as unfinished:
                    shutil.copy(header, unfinished)
        path.write_text(source, encoding="utf-8")
    except OSError as error:
        raise EngineFailure(f"the shader could not be written for the compiler: {error.strerror}") from error
    return path
