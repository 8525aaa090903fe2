"""The process in which Blender's module runs, and the messages to and from it.

Blender's Python module is GPL, wants a Python and a NumPy of its own, and may crash: it is never imported here.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import EngineFailure
from mrm_mtlx.system.process_limits import cause_of_death
from mrm_mtlx.system.text import text_lines

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

SERVER = Path(__file__).with_name("blender_server.py")
KEEPER = Path(__file__).with_name("keeper.py")
# The log of what Blender prints, in the folder of a process.
LOG = "blender.log"

# Seconds in which a process that says no more must end.
_LAST_WORDS_S = 10.0
# Bytes of an answer, of which the log is the most.
_LARGEST_ANSWER = 1 << 30

# Seconds to start in: Blender loads in half a second, from a cold disk in ten.
_START_S = 120.0
# Seconds for one request, of which the longest is a picture's pass.
_REQUEST_S = 600.0


@dataclass(frozen=True)
class Server:
    """What a process is started for.

    Attributes
    ----------
    name
        What messages call it, such as "Cycles".
    operations
        The file of its operations, see `blender_server`; one of them is "versions".
    prefix
        Beginning of the names of its folders.
    variables
        Variables of its environment; "{folder}" in a value stands for the folder of the process.
    """

    name: str
    operations: Path
    prefix: str
    variables: Mapping[str, str] = field(default_factory=dict)


class BlenderProcess:
    """A running server, and a folder that it and this process share.

    Use it as a context manager, or call `close`.

    Raises
    ------
    EngineFailure
        If it does not start.
    """

    def __init__(self, interpreter: str, server: Server) -> None:
        self._name = server.name
        if shutil.which(interpreter) is None:  # else it is the keeper that does not find it
            reason = "not a program" if Path(interpreter).exists() else "No such file or directory"
            raise EngineFailure(f"{interpreter}: {reason}")
        self._folder = _new_folder(server.prefix)
        variables = {name: value.format(folder=self._folder) for name, value in server.variables.items()}
        try:
            with (self.folder / "start.log").open("wb") as start:
                self._process = subprocess.Popen(
                    _command(interpreter, self._folder, server.operations),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=start,
                    cwd=self.folder,
                    env={**os.environ, **variables, "TMPDIR": self._folder},  # Blender makes a folder of its own there
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
            raise EngineFailure(f"{self._name} could not {operation}: {answer['error']}")
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

    def __enter__(self) -> BlenderProcess:
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
        for name in ("start.log", LOG):
            path = self.folder / name
            text = path.read_text(encoding="utf-8", errors="replace").strip() if path.is_file() else ""
            words = text_lines(text)[-1] if text else words
        return f"{self._name} ended with {cause} in '{operation}'" + (f": {words}" if words else "")


def _command(interpreter: str, folder: str, operations: Path) -> list[str]:
    """The command that starts the server, through its keeper where processes know who started them."""
    server = [interpreter, "-I", str(SERVER), str(operations), str(Path(folder, LOG))]
    return [sys.executable, "-I", str(KEEPER), str(os.getpid()), folder, *server] if os.name == "posix" else server


def _new_folder(prefix: str) -> str:
    try:
        return tempfile.mkdtemp(prefix=prefix)
    except OSError as error:
        raise EngineFailure(f"no temporary folder could be made: {error.strerror}") from error
