"""Measures how near the aligned lobe of OSL is to the exact one: `python -m tools.osl_accuracy > docs/osl-accuracy.md`.

Needs Cycles, see `mrm doctor`; a minute on two processors.
"""

from __future__ import annotations

from functools import partial

from mrm_mtlx.conformance.approximation import measure_aligned
from mrm_mtlx.engines import osl
from tools.lobe_accuracy import print_page


def main() -> None:
    """Print the tables."""
    measure = partial(measure_aligned, osl.CYCLES.bench)
    print_page("osl_accuracy", "osl", "Accuracy of the aligned lobe", osl.availability().detail, measure)


if __name__ == "__main__":
    main()
