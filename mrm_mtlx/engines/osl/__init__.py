"""Compiles OSL, and runs it in Cycles: Blender's Python module, in a process of its own, is compiler and renderer."""

from mrm_mtlx.engines.compile_error import CompileError, CompileMessage
from mrm_mtlx.engines.osl.compiler import availability as compiler_availability
from mrm_mtlx.engines.osl.compiler import check, compile_for_cycles
from mrm_mtlx.engines.osl.measure import direct_light, direct_light_by_groups, evaluate, furnace, true_normals
from mrm_mtlx.engines.osl.process import RuntimeFailure, availability, stop
from mrm_mtlx.engines.osl.scenes import Scene, Take, looking_along, point, render, sun

__all__ = [
    "CompileError",
    "CompileMessage",
    "RuntimeFailure",
    "Scene",
    "Take",
    "availability",
    "check",
    "compile_for_cycles",
    "compiler_availability",
    "direct_light",
    "direct_light_by_groups",
    "evaluate",
    "furnace",
    "looking_along",
    "point",
    "render",
    "stop",
    "sun",
    "true_normals",
]
