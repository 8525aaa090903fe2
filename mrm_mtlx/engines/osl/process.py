"""The process in which Blender's OSL and Cycles run, and the messages to and from it.

Blender's Python module is GPL, wants a Python and a NumPy of its own, and may crash: it is never imported here.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib.util
import io
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import Availability, EngineFailure
from mrm_mtlx.system.process_limits import cause_of_death
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

# An interpreter that has bpy, where that is not this one.
VARIABLE = "MRM_OSL_PYTHON"

# The version that the facts of this engine were measured with; the script node's interface may change with Blender 6.
REQUIREMENT = "bpy==5.0.*"
PYTHON = (3, 11)

SERVER = Path(__file__).with_name("cycles_server.py")
KEEPER = Path(__file__).with_name("keeper.py")

# Seconds in which a process that says no more must end.
_LAST_WORDS_S = 10.0
# Bytes of an answer, of which the log is the most.
_LARGEST_ANSWER = 1 << 30

# Seconds to start in: Blender loads in half a second, from a cold disk in ten.
_START_S = 120.0
# Seconds for one request, of which the longest is a picture's pass.
_REQUEST_S = 600.0


class CyclesProcess:
    """A running Cycles, and a folder that it and this process share.

    Use it as a context manager, or call `close`.

    Raises
    ------
    EngineFailure
        If it does not start.
    """

    def __init__(self, interpreter: str) -> None:
        self._folder = _new_folder()
        log = self.folder / "cycles.log"
        try:
            with (self.folder / "start.log").open("wb") as start:
                self._process = subprocess.Popen(
                    _command(interpreter, self._folder, log),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=start,
                    cwd=self.folder,
                    env={**os.environ, "TMPDIR": self._folder},  # Blender makes a folder of its own there
                    start_new_session=True,  # so that keeper and server can be ended together
                )
        except OSError as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise EngineFailure(f"{interpreter}: {error.strerror}") from error
        try:
            self.versions = self.request("versions", timeout_s=_START_S)[0]
        except EngineFailure as error:
            self.close()
            raise EngineFailure(f"{interpreter}: {error}") from error

    @property
    def folder(self) -> Path:
        """The folder in which requests find and leave files; gone after `close`."""
        return Path(self._folder)

    @property
    def alive(self) -> bool:
        """True while it can answer."""
        return self._process.poll() is None

    def request(
        self,
        operation: str,
        arrays: Mapping[str, NDArray[Any]] | None = None,
        *,
        timeout_s: float = _REQUEST_S,
        **plain: Any,
    ) -> tuple[dict[str, Any], str]:
        """Have an operation of the server done: its answer, and what Blender printed meanwhile.

        Raises
        ------
        EngineFailure
            If the operation failed, the process died, or it did not answer in time.
        """
        late = threading.Event()

        def give_up() -> None:
            late.set()
            self._kill()

        timer = threading.Timer(timeout_s, give_up)
        timer.start()
        try:
            answer = self._exchange(operation, dict(arrays or {}), plain)
        except BaseException:
            # Whatever came between request and answer, an interrupt included: the two no longer match.
            self._kill()
            self._process.wait()
            raise
        finally:
            timer.cancel()
        if answer is None:
            obituary = self._obituary(operation)
            raise EngineFailure(f"gave no answer within {timeout_s:g} s" if late.is_set() else obituary)
        log = str(answer.pop("log", ""))
        if "error" in answer:
            raise EngineFailure(f"Cycles could not {operation}: {answer['error']}")
        return answer, log

    def close(self) -> None:
        """End the process and remove its folder."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        with contextlib.suppress(OSError):  # an unsent request to a process that is gone
            stdin.close()
        # At the end of its requests it ends and tidies up by itself, even if this process is killed meanwhile.
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_LAST_WORDS_S)
        if self.alive:
            self._kill()
            self._process.wait()
        stdout.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> CyclesProcess:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def _kill(self) -> None:
        """End the server, and its keeper with it."""
        if hasattr(os, "killpg"):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
        else:
            self._process.kill()

    def _exchange(
        self, operation: str, arrays: dict[str, NDArray[Any]], plain: dict[str, Any]
    ) -> dict[str, Any] | None:
        """The answer, or None if the process ended without one."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        buffer = io.BytesIO()
        members: dict[str, Any] = {"json": np.array(json.dumps({"operation": operation, **plain})), **arrays}
        np.savez(buffer, **members)
        try:
            stdin.write(struct.pack(">Q", buffer.tell()) + buffer.getvalue())
            stdin.flush()
        except BrokenPipeError:
            return None
        head = stdout.read(8)
        size = struct.unpack(">Q", head)[0] if len(head) == 8 else 0
        if size > _LARGEST_ANSWER:
            raise EngineFailure(f"it answers with something else: {head!r}...")
        body = stdout.read(size)
        if not body:
            return None
        with np.load(io.BytesIO(body), allow_pickle=False) as archive:
            return dict(json.loads(str(archive["json"])))

    def _obituary(self, operation: str) -> str:
        try:
            status = self._process.wait(_LAST_WORDS_S)
        except subprocess.TimeoutExpired:  # it has closed its end and lives on
            self._kill()
            status = self._process.wait()
        cause = cause_of_death(status)
        words = ""
        for name in ("start.log", "cycles.log"):
            path = self.folder / name
            text = path.read_text(encoding="utf-8", errors="replace").strip() if path.is_file() else ""
            words = text_lines(text)[-1] if text else words
        return f"the OSL runtime ended with {cause} in '{operation}'" + (f": {words}" if words else "")


def _command(interpreter: str, folder: str, log: Path) -> list[str]:
    """The command that starts the server, through its keeper where processes know who started them."""
    server = [interpreter, "-I", str(SERVER), str(log)]
    return [sys.executable, "-I", str(KEEPER), str(os.getpid()), folder, *server] if os.name == "posix" else server


def interpreter() -> str | None:
    """The interpreter that runs the server: the one that MRM_OSL_PYTHON names, or this one if it has bpy."""
    named = os.environ.get(VARIABLE)
    if named:
        # As a shell finds it: on the path, or from here; the process itself starts elsewhere.
        return str(Path(shutil.which(named) or named).absolute())
    return sys.executable if importlib.util.find_spec("bpy") is not None else None


@cache
def availability() -> Availability:
    """The runtime, tried: a process was started and asked for its versions."""
    chosen = interpreter()
    if chosen is None:
        return Availability(False, _why_not(), _remedy())
    try:
        versions = _started().versions
    except (EngineFailure, OSError) as error:
        return Availability(False, f"bpy does not run: {error}", _remedy())
    if not versions["with_osl"]:
        return Availability(False, f"{chosen}: its Cycles is built without OSL", _remedy())
    osl = ".".join(re.findall(r"\d+", versions["osl"]))
    return Availability(True, f"Cycles {versions['blender']}, OSL {osl}")


def _started() -> CyclesProcess:
    """The runtime, tried twice: what ends it once as it starts is no reason to do without it for good."""
    try:
        return runtime()
    except EngineFailure:
        return runtime()


_RUNNING: list[CyclesProcess] = []


def runtime() -> CyclesProcess:
    """The one Cycles of this process; started when first asked for, and again if it died.

    Raises
    ------
    EngineFailure
        If there is none, or it does not start.
    """
    if _RUNNING and not _RUNNING[0].alive:
        _RUNNING.pop().close()
    if not _RUNNING:
        chosen = interpreter()
        if chosen is None:
            raise EngineFailure(f"{_why_not()}; {_remedy()}")
        _RUNNING.append(CyclesProcess(chosen))
        atexit.register(stop)
    return _RUNNING[0]


def stop() -> None:
    """End the Cycles of this process, if there is one."""
    while _RUNNING:
        _RUNNING.pop().close()


def _new_folder() -> str:
    try:
        return tempfile.mkdtemp(prefix="mrm-osl-")
    except OSError as error:
        raise EngineFailure(f"no temporary folder could be made: {error.strerror}") from error


def _why_not() -> str:
    if sys.version_info[:2] == PYTHON:
        return "bpy is not installed"
    here = f"{sys.version_info.major}.{sys.version_info.minor}"
    return f"bpy is not installed, and its wheel is for Python {PYTHON[0]}.{PYTHON[1]} alone (this is {here})"


def _remedy() -> str:
    if os.environ.get(VARIABLE):
        return f"set {VARIABLE} to an interpreter that has bpy, or unset it"
    if sys.version_info[:2] == PYTHON:
        return "pip install 'mrm-mtlx[osl]'"
    python = f"python{PYTHON[0]}.{PYTHON[1]}"
    return f"{python} -m venv osl && osl/bin/pip install '{REQUIREMENT}', then set {VARIABLE}=osl/bin/python"
