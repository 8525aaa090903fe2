"""Generated sources with a known deviation taken out: what is right then had no other error."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

from mrm_mtlx.reference.deviations import IN_THE_SOURCE, Deviation

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.shadergen import Shader

# The precision of floats, which generated ESSL states, and what it leaves to the language's defaults.
_STATED = "precision highp float;\n"
_LEFT_OUT = {
    Deviation.MEDIUMP_INTEGERS: "precision highp int;\n",
    Deviation.LOWP_SAMPLERS: "precision highp sampler2D;\n",
}


def mended_sources(shader: Shader) -> Iterator[tuple[frozenset[Deviation], Shader]]:
    """The shader without deviations that its target has, and these; the fewest first."""
    if shader.target != "essl":
        return
    ordered = [d for d in Deviation if d in IN_THE_SOURCE]
    for count in range(1, len(ordered) + 1):
        for deviations in combinations(ordered, count):
            lines = "".join(_LEFT_OUT[d] for d in deviations)
            pixel = shader.sources["pixel"].replace(_STATED, _STATED + lines, 1)
            yield frozenset(deviations), replace(shader, sources={**shader.sources, "pixel": pixel})
