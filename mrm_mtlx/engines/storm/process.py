"""The process in which Storm draws, and the node library in the dialect of its MaterialX."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.engines.base import Availability, EngineFailure
from mrm_mtlx.engines.blender.process import Server
from mrm_mtlx.engines.blender.runtime import Runtime
from mrm_mtlx.library.hosts import Choice, Form
from mrm_mtlx.library.install import library_for, write_library
from mrm_mtlx.library.standard_library import StandardLibraryError, given

if TYPE_CHECKING:
    from mrm_mtlx.engines.blender.process import BlenderProcess

# Interpreters that have bpy, where that is not this one; any version of it has Storm.
VARIABLES = ("MRM_STORM_PYTHON", "MRM_OSL_PYTHON")

_NODES = "nodes"

SERVER = Server(
    "Storm",
    Path(__file__).with_name("storm_server.py"),
    "mrm-storm-",
    {
        "PXR_MTLX_PLUGIN_SEARCH_PATHS": f"{{folder}}/{_NODES}",
        "HDX_MSAA_SAMPLE_COUNT": "1",  # one sample is one pixel; pictures are drawn larger
    },
)


def _describe(versions: dict[str, Any]) -> Availability:
    if versions["lacking"]:
        return Availability(
            False, versions["lacking"], "apt-get install -y libegl1 libegl-mesa0 libgl1-mesa-dri libgl1"
        )
    detail = "Storm of OpenUSD {usd} in Blender {blender}, MaterialX {materialx}, {renderer}".format(**versions)
    return Availability(True, detail)


def _install_library(process: BlenderProcess) -> None:
    """Write the node library where MaterialX looks when it is first used, as `mrm library install` does."""
    found = process.versions
    if found["lacking"]:
        return  # nothing will be drawn
    try:
        standard = given(Path(found["libraries"]), found["materialx"])
        write_library(process.folder / _NODES, library_for(standard, Form.SOURCES, Choice.NAME).files)
    except (LookupError, StandardLibraryError) as error:
        raise EngineFailure(str(error)) from error
    except OSError as error:
        raise EngineFailure(f"the node library could not be written for Storm: {error.strerror}") from error


RUNTIME = Runtime(SERVER, VARIABLES, _describe, _install_library)
