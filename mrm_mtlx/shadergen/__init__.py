"""A renderable element and a target give shader source code."""

from mrm_mtlx.shadergen.generate import (
    GenerationError,
    MissingCodeError,
    OslMode,
    Port,
    Shader,
    generate,
    renderable_elements,
)
from mrm_mtlx.shadergen.script_node import ScriptNode, script_node, with_texture_coordinates
from mrm_mtlx.shadergen.self_contained import header_folder, self_contained
from mrm_mtlx.shadergen.sockets import Socket
from mrm_mtlx.shadergen.targets import TARGETS, Target, available_targets

__all__ = [
    "TARGETS",
    "GenerationError",
    "MissingCodeError",
    "OslMode",
    "Port",
    "ScriptNode",
    "Shader",
    "Socket",
    "Target",
    "available_targets",
    "generate",
    "header_folder",
    "renderable_elements",
    "script_node",
    "self_contained",
    "with_texture_coordinates",
]
