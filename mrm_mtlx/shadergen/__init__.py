"""A renderable element and a target give shader source code."""

from mrm_mtlx.shadergen.generate import (
    GenerationError,
    MissingCodeError,
    OslMode,
    Port,
    Shader,
    renderable_elements,
)
from mrm_mtlx.shadergen.script_node import ScriptNode, script_node, with_mesh_inputs
from mrm_mtlx.shadergen.self_contained import header_folder, self_contained
from mrm_mtlx.shadergen.sockets import Socket
from mrm_mtlx.shadergen.source import generate
from mrm_mtlx.shadergen.targets import (
    HOST_TARGETS,
    TARGETS,
    HostTarget,
    Target,
    all_targets,
    available_targets,
    closure_targets,
    lacking_targets,
    suffixes_of,
)

__all__ = [
    "HOST_TARGETS",
    "TARGETS",
    "GenerationError",
    "HostTarget",
    "MissingCodeError",
    "OslMode",
    "Port",
    "ScriptNode",
    "Shader",
    "Socket",
    "Target",
    "all_targets",
    "available_targets",
    "closure_targets",
    "generate",
    "header_folder",
    "lacking_targets",
    "renderable_elements",
    "script_node",
    "self_contained",
    "suffixes_of",
    "with_mesh_inputs",
]
