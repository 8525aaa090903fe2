"""Runs generated GLSL and ESSL in an off-screen OpenGL context, one point per sample, with 32-bit float results."""

from mrm_mtlx.engines.gl.context import availability
from mrm_mtlx.engines.gl.engine import ENGINE
from mrm_mtlx.engines.gl.program import SurfaceProgram

__all__ = ["ENGINE", "SurfaceProgram", "availability"]
