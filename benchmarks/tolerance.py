"""The tolerances of surfaces.

Processor seconds that the reference takes for 16,384 samples under a light, for their tolerances, and for those of
1,024 samples in an environment of 16 directions, as a validation asks for them; best of 5.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from benchmarks import surfaces
from benchmarks.timing import Table, best_time, run
from mrm_mtlx.reference import Environment, Illumination, Surface
from mrm_mtlx.validation.comparison import sampling

if TYPE_CHECKING:
    from collections.abc import Iterator

LIT, FEW = 16384, 1024
MODELS = {
    "open_pbr_surface": surfaces.OPEN_PBR,
    "standard_surface": surfaces.STANDARD,
    "conductor_bsdf": surfaces.METAL,
}


def measure() -> Table:
    """Each model: evaluated, and its tolerances."""
    columns = ("surface", "evaluated, s", "tolerance, s", "tolerance in an environment, s")
    return Table(columns, _rows(), ("numpy", "MaterialX"))


def _rows() -> Iterator[tuple[str, ...]]:
    rng = np.random.default_rng(0)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, LIT))
    part = points.part(slice(0, FEW))
    around = Illumination(light=False, environment=Environment.constant((1.0, 0.75, 0.5), samples=16))
    for name, text in MODELS.items():
        document = surfaces.document(text)
        model = Surface(document.getNode("s"))
        calls = (
            lambda m=model: m.shade(points),
            lambda m=model: m.tolerance(points),
            lambda m=model: m.tolerance(part, around),
        )
        yield name, *(f"{best_time(call, clock=time.process_time):.3f}" for call in calls)


if __name__ == "__main__":
    run(__doc__, measure, __file__)
