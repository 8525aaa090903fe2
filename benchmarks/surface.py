"""Evaluation of a whole surface model.

Seconds and memory that the reference takes for 100,000 samples of open_pbr_surface, on one processor; best of 3.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np

from benchmarks import surfaces
from benchmarks.timing import REPOSITORY, Table, best_time, run
from mrm_mtlx.reference import Surface
from mrm_mtlx.validation.comparison import sampling

if TYPE_CHECKING:
    from collections.abc import Iterator

COUNT = 100_000


def measure() -> Table:
    """The model as it is by default, and with every lobe on."""
    return Table(("open_pbr_surface", "s", "MB in all", "MB before"), _rows(), ("numpy", "MaterialX"))


def _rows() -> Iterator[tuple[str, ...]]:
    for name, every_lobe in (("as it is by default", False), ("every lobe on", True)):
        code = f"from benchmarks import surface; surface.print_figures({every_lobe})"
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, check=True, cwd=REPOSITORY, env=environment, capture_output=True, text=True)
        yield name, *json.loads(done.stdout)


def print_figures(every_lobe: bool) -> None:
    """Print the figures of this process, which evaluates nothing else."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    lines = surfaces.OPEN_PBR.splitlines()
    document = surfaces.document("".join(line for line in lines if every_lobe or "value=" not in line))
    points = sampling.shading_points(*_drawn())
    model = Surface(document.getNode("m"))
    before = _megabytes()
    seconds = best_time(lambda: model.shade(points), 3)
    print(json.dumps([f"{seconds:.2f}", f"{_megabytes():.0f}", f"{before:.0f}"]))


def _drawn() -> tuple[np.random.Generator, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng, *sampling.sample_local(rng, COUNT)


def _megabytes() -> float:
    """The most memory that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    run(__doc__, measure, __file__)
