"""Compilers that are commands, each run over a source in a folder of its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import CompileError, CompileMessage, EngineFailure
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Sequence

# A compiler that takes longer than this on one shader hangs; they take well under a second.
TIMEOUT_S = 60.0


def works(command: str, option: str) -> bool:
    """True if a command of this name is on the path and runs, with an option that has it say something."""
    path = shutil.which(command)
    return path is not None and _runs(path, option)


@cache
def _runs(path: str, option: str) -> bool:
    try:
        subprocess.run([path, option], capture_output=True, timeout=TIMEOUT_S, check=False)
    except OSError:
        return False
    except subprocess.TimeoutExpired:
        pass  # it runs; that it does not end is for its first shader to say
    return True


def compile_file(command: Sequence[str], source: str, name: str) -> None:
    """Have a command compile a source, in a folder of its own that is dropped.

    Parameters
    ----------
    command
        The compiler and its options; the name of the source comes last.
    source, name
        The text, and the name of its file.

    Raises
    ------
    CompileError
        If it refuses the source: the first error.
    EngineFailure
        If it does not run or does not end.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / name).write_text(source, encoding="utf-8")
        log = _log([*command, name], folder)
    if log:
        raise CompileError([first_message(log, source)])


def run(command: list[str], folder: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a compiler in a folder; its exit status and what it said.

    Raises
    ------
    EngineFailure
        If it does not run or does not end.
    """
    try:
        return subprocess.run(
            command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise EngineFailure(f"{command[0]} did not finish within {TIMEOUT_S:g} s") from error
    except OSError as error:
        raise EngineFailure(f"{command[0]} does not run: {error.strerror}") from error


def _log(command: list[str], folder: str) -> str:
    """The words of a compiler on a source that it refuses; "" if it takes it."""
    done = run(command, folder)
    if done.returncode == 0:
        return ""
    log = (done.stdout + done.stderr).replace(f"{folder}{os.sep}", "").strip()
    return log or f"{command[0]} failed with exit status {done.returncode} and said nothing"


def first_message(log: str, source: str, first_line: int = 1) -> CompileMessage:
    """The first error of a log, with the number and text of the source line that it names.

    `first_line` is the number that the compiler gives to the source's first line.
    """
    match = re.search(r"^.*\berror\b.*$", log, re.MULTILINE | re.IGNORECASE)
    message = match[0] if match else text_lines(log)[0]
    # glslang puts the place before the message, `ERROR: shader.frag:12: ...`; slang on the next line, `--> name:12:5`.
    place = re.search(r":(\d+)(?::|$)", log[match.start() if match else 0 :], re.MULTILINE)
    number, lines = int(place[1]) - first_line + 1 if place else 0, source.split("\n")
    known = 0 < number <= len(lines)
    message = re.sub(r"^ERROR: \S+?:\d+: ", "", message.strip())
    return CompileMessage(number if known else 0, lines[number - 1].strip() if known else "", message)
