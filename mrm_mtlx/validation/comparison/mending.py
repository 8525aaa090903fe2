"""Generated shaders with a known deviation taken out: what is right then had no other error."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeAlias

from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.shadergen import GenerationError, generate, precision
from mrm_mtlx.validation.comparison.document_mends import MENDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.shadergen import Shader

# What to replace in a source, and by what, in this order. Precisions that ESSL leaves to the language's defaults come
# after that of floats, which it states.
_SOURCES = {
    Deviation.MEDIUMP_FLOATS: (precision.MEDIUM, precision.HIGH),
    Deviation.MEDIUMP_INTEGERS: (precision.HIGH, f"{precision.HIGH}precision highp int;\n"),
    Deviation.LOWP_SAMPLERS: (precision.HIGH, f"{precision.HIGH}precision highp sampler2D;\n"),
    Deviation.HEXAGON_ROOT: ("sqrt(p3_sum_out)", "sqrt(max(p3_sum_out, 0.0))"),
}

# A function from a shader to it without deviations, and these.
Mended: TypeAlias = "Callable[[Shader], Iterator[tuple[frozenset[Deviation], Shader]]]"


def mended_sources(shader: Shader) -> Iterator[tuple[frozenset[Deviation], Shader]]:
    """The shader without deviations that its source has, and these; the fewest first."""
    for deviations in _some(_SOURCES):
        mended = shader.sources["pixel"]
        for old, new in (_SOURCES[deviation] for deviation in deviations):
            if old not in mended:
                break
            mended = mended.replace(old, new)
        else:
            yield frozenset(deviations), replace(shader, sources={**shader.sources, "pixel": mended})


def mended_shaders(element: Any, library: DataLibrary, shader: Shader) -> Iterator[tuple[frozenset[Deviation], Shader]]:
    """The shader of an element without deviations: of its source, or of what is generated from the document."""
    yield from mended_sources(shader)
    for deviations in _some(MENDS):
        document = element.getDocument().copy()
        for deviation in deviations:
            MENDS[deviation](document)
        try:
            mended = generate(document.getDescendant(element.getNamePath()), shader.target, library)
        except GenerationError:
            continue
        if mended.sources == shader.sources:
            continue  # the document has nothing of the kind
        yield frozenset(deviations), mended
        yield from ((more.union(deviations), source) for more, source in mended_sources(mended))


def _some(deviations: Iterable[Deviation]) -> Iterator[tuple[Deviation, ...]]:
    """Each alone, each pair of them, and so on."""
    every = tuple(deviations)
    for size in range(1, len(every) + 1):
        yield from combinations(every, size)
