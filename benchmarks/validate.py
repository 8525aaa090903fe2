"""A validation run over many documents.

Seconds by the wall's clock and of processors, and how many times the latter are what generator and driver alone take
for the same documents: generating, linking and one draw of the GLSL and ESSL of every renderable element. The driver's
cache is empty in each run.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np

from benchmarks.timing import REPOSITORY, Table, run
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import draw

if TYPE_CHECKING:
    from collections.abc import Iterator

MATERIALS = REPOSITORY / "materials"


def measure() -> Table:
    """The floor, then `mrm validate` with one and two jobs."""
    count = len(list(MATERIALS.rglob("*.mtlx")))
    columns = (f"{MATERIALS.name}, {count} documents", "s", "processor s", "times the floor")
    return Table(columns, _rows(), ("MaterialX", "numpy"))


def _rows() -> Iterator[tuple[str, ...]]:
    command = [sys.executable, "-c", "from benchmarks import validate; validate.draw_all()"]
    wall, floor = _seconds(command, statuses=(0,))
    yield "generate, link, first draw", f"{wall:.1f}", f"{floor:.1f}", "1"
    for jobs in (1, 2):
        command = [sys.executable, "-m", "mrm_mtlx.cli.main", "validate", str(MATERIALS), "-j", str(jobs)]
        wall, taken = _seconds([*command, "--format", "json", "--output", os.devnull], statuses=(0, 1))
        yield f"mrm validate -j {jobs}", f"{wall:.1f}", f"{taken:.1f}", f"{taken / floor:.2f}"


def draw_all() -> None:
    """Generate, link and first draw the GLSL and ESSL of every renderable element, and nothing else."""
    library = load_library()
    rng = np.random.default_rng(0)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, 16384))
    for path in sorted(MATERIALS.rglob("*.mtlx")):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(path))
        document.setDataLibrary(library.document)
        for element in renderable_elements(document):
            for target in ("glsl", "essl"):
                with SurfaceProgram(generate(element, target, library)) as program:
                    draw(program, points)


def _seconds(command: list[str], statuses: tuple[int, ...]) -> tuple[float, float]:
    """Wall-clock and processor seconds of a command with a fresh, empty shader cache.

    The time of one that failed says nothing.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "MESA_SHADER_CACHE_DIR": cache}
        start, before = time.perf_counter(), _processor_seconds()
        done = subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, check=False)
        taken = time.perf_counter() - start, _processor_seconds() - before
    if done.returncode not in statuses:
        sys.exit(f"status {done.returncode}: {done.stderr}")
    return taken


def _processor_seconds() -> float:
    """Processor seconds of the processes that this one has waited for, and of theirs."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    run(__doc__, measure, __file__)
