"""Runs generated GLSL and ESSL in an off-screen OpenGL context, one point per sample, with 32-bit float results."""

from mrm_mtlx.engines.compile_error import CompileError, CompileMessage
from mrm_mtlx.engines.gl.context import availability
from mrm_mtlx.engines.gl.lighting import DirectionalLight, Environment, Lighting, PointLight
from mrm_mtlx.engines.gl.program import SurfaceProgram

__all__ = [
    "CompileError",
    "CompileMessage",
    "DirectionalLight",
    "Environment",
    "Lighting",
    "PointLight",
    "SurfaceProgram",
    "availability",
]
