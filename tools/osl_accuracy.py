"""Measures how near the aligned lobe of OSL is to the exact one: `python -m tools.osl_accuracy > docs/osl-accuracy.md`.

Needs Cycles, see `mrm doctor`; a minute on two processors.
"""

from __future__ import annotations

from mrm_mtlx.conformance.approximation import MATERIALS, measure_aligned
from mrm_mtlx.conformance.cases import NODES
from mrm_mtlx.engines import osl

ALPHAS = (0.0025, 0.01, 0.04, 0.1, 0.16, 0.25, 0.36, 0.49, 0.64, 1.0)
VIEWS_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0)


def main() -> None:
    """Print the tables."""
    print("<!-- Made by: python -m tools.osl_accuracy > docs/osl-accuracy.md -->\n# Accuracy of the aligned lobe\n")
    print(
        f"Measured in {osl.availability().detail}, against the oracle; see [osl.md](osl.md). Each cell: L1 error, then"
    )
    print("the ratio of the albedos, over the width alpha and the angle of the view direction from the normal.")
    for node in NODES:
        figures = measure_aligned(osl.CYCLES.bench, node, ALPHAS, VIEWS_DEG)
        found = {(a.material, a.alpha, a.view_deg): a for a in figures}
        for material in (m.name for m in MATERIALS if m.node == node):
            print(f"\n## {node}, {material}\n")
            print(f"| alpha | {' | '.join(f'{view:g}°' for view in VIEWS_DEG)} |\n|{'---|' * (len(VIEWS_DEG) + 1)}")
            for alpha in ALPHAS:
                cells = (found[material, alpha, view] for view in VIEWS_DEG)
                print(f"| {alpha:g} | {' | '.join(f'{a.l1:.3f} {a.albedo:.3f}' for a in cells)} |")


if __name__ == "__main__":
    main()
