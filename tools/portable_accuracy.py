"""Measures how near the portable form is: `python -m tools.portable_accuracy > docs/portable-accuracy.md`.

In generated GLSL, in the OpenGL driver; a quarter of a minute on two processors.
"""

from __future__ import annotations

from functools import partial

from mrm_mtlx.conformance.portable import QUADRATURE, measure_portable
from mrm_mtlx.engines import gl
from mrm_mtlx.library import materialx_version
from tools.lobe_accuracy import print_page


def main() -> None:
    """Print the tables."""
    where = f"GLSL as MaterialX {materialx_version()} generates it"
    measure = partial(measure_portable, gl.ENGINE, "glsl")
    print_page("portable_accuracy", "portable", "Accuracy of the portable form", where, measure, **QUADRATURE)


if __name__ == "__main__":
    main()
