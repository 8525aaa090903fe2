"""The process in which Blender's OSL and Cycles run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines.base import Availability
from mrm_mtlx.engines.blender.process import Server
from mrm_mtlx.engines.blender.runtime import Runtime

if TYPE_CHECKING:
    from mrm_mtlx.engines.blender.process import BlenderProcess

# An interpreter that has bpy, where that is not this one.
VARIABLE = "MRM_OSL_PYTHON"


def _describe(versions: dict[str, Any]) -> Availability:
    if not versions["with_osl"]:
        return Availability(False, "its Cycles is built without OSL")
    osl = ".".join(re.findall(r"\d+", versions["osl"]))
    return Availability(True, f"Cycles {versions['blender']}, OSL {osl}")


SERVER = Server("Cycles", Path(__file__).with_name("cycles_server.py"), "mrm-osl-")
RUNTIME = Runtime(SERVER, (VARIABLE,), _describe)


def availability() -> Availability:
    """The runtime, tried: a process was started and asked for its versions."""
    return RUNTIME.availability()


def runtime() -> BlenderProcess:
    """The one Cycles of this process; started when first asked for, and again if it died.

    Raises
    ------
    EngineFailure
        If there is none, or it does not start.
    """
    return RUNTIME.process()


def stop() -> None:
    """End the Cycles of this process, if there is one."""
    RUNTIME.stop()
