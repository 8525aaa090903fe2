"""Samples through the OpenGL engine.

Millions of samples per second of each node's shader in a draw of so many points, best of 5; also of its portable form.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from benchmarks.timing import Table, best_time, run
from mrm_mtlx.conformance.cases import NODES, Case, case_document, case_points
from mrm_mtlx.documents.portable import portable
from mrm_mtlx.engines import gl as engine
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import draw

if TYPE_CHECKING:
    from collections.abc import Iterator

COUNTS = (1 << 14, 1 << 18)


def measure() -> Table:
    """A draw of each node, by number of points."""
    return Table((engine.availability().detail, *map(str, COUNTS)), _rows(), ("MaterialX", "moderngl"))


def _rows() -> Iterator[tuple[str, ...]]:
    library = load_library()
    for node in NODES:
        case = Case(node, True, True, False)
        exact = case_document(case, library.document)
        for name, document in ((node, exact), (f"{node}, portable", portable(exact)[0])):
            with engine.SurfaceProgram(generate(renderable_elements(document)[0], "glsl", library)) as program:
                rates = []
                for count in COUNTS:
                    points = case_points(case, count, sampling.generator(0, case.name))
                    rates.append(f"{count / best_time(partial(draw, program, points)) / 1e6:.2f}")
            yield name, *rates


if __name__ == "__main__":
    run(__doc__, measure, __file__)
