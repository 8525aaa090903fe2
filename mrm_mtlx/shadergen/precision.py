"""The precision that generated ESSL states of its floats: mediump before MaterialX 1.39.5.

A driver may take 16 bits for mediump (GLSL ES 3.00, section 4.5.4): no narrow lobe is left in them, and most give NaN.
Mesa does, and so do the drivers of mobile devices.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.shadergen.generate import Shader

# The lines of a source that state it.
MEDIUM, HIGH = "precision mediump float;\n", "precision highp float;\n"


def states_mediump(shader: Shader) -> bool:
    """True if the floats of a shader's pixel stage are mediump."""
    return shader.target == "essl" and MEDIUM in shader.sources["pixel"]


def with_highp(shader: Shader) -> Shader:
    """The shader with highp floats in both stages, where it is one that states mediump."""
    if not states_mediump(shader):
        return shader
    return replace(shader, sources={stage: code.replace(MEDIUM, HIGH, 1) for stage, code in shader.sources.items()})
