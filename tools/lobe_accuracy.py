"""Tables of how near a lobe that stands for a retroreflective one is to it, for the pages of the accuracy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.conformance.approximation import Sky
from mrm_mtlx.conformance.cases import NODES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from mrm_mtlx.conformance.results import Approximation

ALPHAS = (0.0025, 0.01, 0.04, 0.1, 0.16, 0.25, 0.36, 0.49, 0.64, 1.0)
VIEWS_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0)


def print_page(
    tool: str,
    page: str,
    title: str,
    measured_in: str,
    measure: Callable[[Sky], Iterable[Approximation]],
    **quadrature: int,
) -> None:
    """Print a page of tables, one per node and material.

    Parameters
    ----------
    tool
        Name of the module that makes the page.
    page
        Name of the page, without ending, that says what is measured.
    title, measured_in
        The heading, and where the figures are measured.
    measure
        Function from what is to be measured to its figures.
    **quadrature
        Of `Sky`, where it is not the one by default.
    """
    print(f"<!-- Made by: python -m tools.{tool} > docs/{page}-accuracy.md -->\n# {title}\n")
    print(f"Measured in {measured_in}, against the oracle; see [{page}.md]({page}.md). Each cell: L1 error, then")
    print("the ratio of the albedos, over the width alpha and the angle of the view direction from the normal.")
    for node in NODES:
        sky = Sky(node, ALPHAS, VIEWS_DEG, **quadrature)
        found = {(a.material, a.alpha, a.view_deg): a for a in measure(sky)}
        for material in (m.name for m in sky.materials):
            print(f"\n## {node}, {material}\n")
            print(f"| alpha | {' | '.join(f'{view:g}°' for view in VIEWS_DEG)} |\n|{'---|' * (len(VIEWS_DEG) + 1)}")
            for alpha in ALPHAS:
                cells = (found[material, alpha, view] for view in VIEWS_DEG)
                print(f"| {alpha:g} | {' | '.join(f'{a.l1:.3f} {a.albedo:.3f}' for a in cells)} |")
