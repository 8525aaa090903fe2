"""The one Blender of an engine: found, tried, started when it is asked for, and ended."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines.base import Availability, EngineFailure
from mrm_mtlx.engines.blender.process import BlenderProcess, Server

if TYPE_CHECKING:
    from collections.abc import Callable

# The wheel for each Python that there is one for. The facts of the engines were measured with the first; the script
# node's interface may change with Blender 6.
WHEELS = {(3, 11): "bpy==5.0.*", (3, 13): "bpy==5.1.*"}


def _as_it_is(process: BlenderProcess) -> None:
    """Leave a server as it is."""
    del process


@dataclass
class Runtime:
    """A server in Blender, of which this process has one at most.

    Attributes
    ----------
    server
        What it is started for.
    variables
        Names of environment variables that may name an interpreter with bpy, where that is not this one; the first that
        is set counts, and the first is what messages say is to be set.
    describe
        Function from the server's versions to the state of the engine; without a remedy of its own, that of a missing
        bpy is given.
    prepare
        What is done with a server that has started, before anything else is asked of it; may raise an EngineFailure.
    """

    server: Server
    variables: tuple[str, ...]
    describe: Callable[[dict[str, Any]], Availability]
    prepare: Callable[[BlenderProcess], None] = _as_it_is
    _running: list[BlenderProcess] = field(default_factory=list, repr=False)
    _state: Availability | None = field(default=None, repr=False)

    def interpreter(self) -> str | None:
        """The interpreter that runs the server: the one that a variable names, or this one if it has bpy."""
        named = next((os.environ[name] for name in self.variables if os.environ.get(name)), None)
        if named:
            # As a shell finds it: on the path, or from here; the process itself starts elsewhere.
            return str(Path(shutil.which(named) or named).absolute())
        return sys.executable if importlib.util.find_spec("bpy") is not None else None

    def availability(self) -> Availability:
        """The state of the server, remembered: a process was started and asked for its versions."""
        if self._state is None:
            self._state = self.tried()
        return self._state

    def tried(self) -> Availability:
        """The state of this moment."""
        chosen = self.interpreter()
        if chosen is None:
            return Availability(False, _why_not(), self._remedy())
        try:
            versions = self._started().versions
        except (EngineFailure, OSError) as error:
            return Availability(False, f"bpy does not run: {error}", self._remedy())
        state = self.describe(versions)
        if state.available:
            return state
        return Availability(False, f"{chosen}: {state.detail}", state.remedy or self._remedy())

    def process(self) -> BlenderProcess:
        """The running server; started when first asked for, and again if it died.

        Raises
        ------
        EngineFailure
            If there is none, or it does not start.
        """
        if self._running and not self._running[0].alive:
            self._running.pop().close()
        if not self._running:
            chosen = self.interpreter()
            if chosen is None:
                raise EngineFailure(f"{_why_not()}; {self._remedy()}")
            started = BlenderProcess(chosen, self.server)
            try:
                self.prepare(started)
            except BaseException:
                started.close()
                raise
            self._running.append(started)
            atexit.register(self.stop)
        return self._running[0]

    def stop(self) -> None:
        """End the server, if it runs."""
        while self._running:
            self._running.pop().close()

    def _started(self) -> BlenderProcess:
        """The server, tried twice: what ends it once as it starts is no reason to do without it for good."""
        try:
            return self.process()
        except EngineFailure:
            return self.process()

    def _remedy(self) -> str:
        named = next((name for name in self.variables if os.environ.get(name)), None)
        if named:
            return f"set {named} to an interpreter that has bpy, or unset it"
        if sys.version_info[:2] in WHEELS:
            return "pip install 'mrm-mtlx[osl]'"
        version, wheel = next(iter(WHEELS.items()))
        python = f"python{_dotted(version)}"
        return f"{python} -m venv osl && osl/bin/pip install '{wheel}', then set {self.variables[0]}=osl/bin/python"


def _why_not() -> str:
    here = sys.version_info[:2]
    if here in WHEELS:
        return "bpy is not installed"
    served = " and ".join(map(_dotted, WHEELS))
    return f"bpy is not installed, and its wheels are for Python {served} (this is {_dotted(here)})"


def _dotted(version: tuple[int, int]) -> str:
    return ".".join(map(str, version))
