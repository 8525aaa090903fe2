"""The block of what the stages of Vulkan GLSL hand on: before MaterialX 1.39.4 it is named, and not declared.

Its members are declared, each by itself: where these are named alone the source is right.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.shadergen.generate import Shader

_NAMED = re.compile(r"\bvd\.(?=[A-Za-z])")
_DECLARED = re.compile(r"\}\s*vd;")


def names_undeclared_block(shader: Shader) -> bool:
    """True if a stage of a shader names a block that it does not declare."""
    codes = shader.sources.values() if shader.target == "vulkan" else ()
    return any(_NAMED.search(code) and not _DECLARED.search(code) for code in codes)


def with_members_alone(shader: Shader) -> Shader:
    """The shader that names the members of the block by themselves, where it is one that does not declare it."""
    if not names_undeclared_block(shader):
        return shader
    return replace(
        shader, sources={stage: _NAMED.sub("", code) for stage, code in shader.sources.items()}, input_block=""
    )
