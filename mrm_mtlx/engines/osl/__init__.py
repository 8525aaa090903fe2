"""Compiles OSL, and runs it in Cycles: Blender's Python module, in a process of its own, is compiler and renderer."""

from mrm_mtlx.engines.osl.compiler import availability as compiler_availability
from mrm_mtlx.engines.osl.compiler import check, compile_for_cycles
from mrm_mtlx.engines.osl.engine import COMPILER, CYCLES
from mrm_mtlx.engines.osl.measure import direct_light, direct_light_by_groups, evaluate, furnace, true_normals
from mrm_mtlx.engines.osl.process import availability, stop
from mrm_mtlx.engines.osl.scenes import render

__all__ = [
    "COMPILER",
    "CYCLES",
    "availability",
    "check",
    "compile_for_cycles",
    "compiler_availability",
    "direct_light",
    "direct_light_by_groups",
    "evaluate",
    "furnace",
    "render",
    "stop",
    "true_normals",
]
