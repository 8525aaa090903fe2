"""The same lobes here and in Mitsuba 3.

Millions of values, densities and samples per second by arrays of 2^20, best of 5: `mrm_mtlx.bsdf` in float64, and
Mitsuba's LLVM variant, which compiles all of a function into one vector loop in single precision (its first call, with
compilation, takes 0.02 to 0.1 s, not counted); NumPy passes over the array once per operation, in double. The reference
is to be read and trusted; where speed decides, a renderer's own code is the place.

Mitsuba 3.9 needs an LLVM newer than 15: `DRJIT_LIBLLVM_PATH` names it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.lobes import COLUMNS, COUNT, GOLD, directions, timed
from benchmarks.timing import REPOSITORY, Table, per_second, run
from mrm_mtlx import bsdf

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Mitsuba's descriptions beside the lobes of the same facets.
FACETS: dict[str, Any] = {"alpha": (0.1, 0.2), "masking": "smith_separable"}
IN_MITSUBA: dict[str, Any] = {
    "conductor": {
        "type": "roughconductor",
        "eta": {"type": "rgb", "value": GOLD["ior"]},
        "k": {"type": "rgb", "value": GOLD["extinction"]},
    },
    "dielectric": {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0},
}


def measure() -> Table:
    """Each lobe here, then in Mitsuba."""
    return Table(("separable Smith masking, alpha 0.1 and 0.2", *COLUMNS), _rows(), ("numpy", "mitsuba", "drjit"))


def _rows() -> Iterator[tuple[str, ...]]:
    for distribution in ("ggx", "beckmann"):
        facets = {**FACETS, "distribution": distribution}
        lobes = {
            "conductor": bsdf.Conductor(**GOLD, **facets),
            "dielectric": bsdf.Dielectric(1.5, **facets, scatter_mode="RT"),
        }
        for kind, lobe in lobes.items():
            yield f"{kind}, {distribution}: here, float64", *per_second(COUNT, timed(lobe, *_directions_for(kind)))
            yield "Mitsuba, float32", *_in_a_process(kind, distribution)


def _directions_for(kind: str) -> tuple[Any, Any, Any]:
    """As `directions`; for an interface, half of l below."""
    v, l, u = directions()
    if kind == "dielectric":
        l[::2, 2] *= -1.0
    return v, l, u


def _in_a_process(kind: str, distribution: str) -> tuple[str, ...]:
    """Mitsuba's cells, or why there are none. An LLVM that is too old for it ends the process."""
    code = f"from benchmarks import mitsuba; mitsuba.print_rates({kind!r}, {distribution!r})"
    with tempfile.TemporaryDirectory() as home:  # where compiled kernels are kept
        environment = {**os.environ, "HOME": home}
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, cwd=REPOSITORY, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line.lower()] or [f"status {done.returncode}"]
        return f"does not run here: {lines[0].strip()}", "", ""
    return tuple(json.loads(done.stdout))


def print_rates(kind: str, distribution: str) -> None:
    """Print the figures of this process: Mitsuba's, directions and random numbers being in its arrays."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    v, l, u = (mi.Vector3f(a.T.astype(np.float32)) for a in _directions_for(kind))
    lobe = mi.load_dict(
        {**IN_MITSUBA[kind], "distribution": distribution, "alpha_u": FACETS["alpha"][0], "alpha_v": FACETS["alpha"][1]}
    )
    context, at = mi.BSDFContext(), dr.zeros(mi.SurfaceInteraction3f, COUNT)
    at.wi = v
    dr.eval(at, l, u)
    dr.sync_thread()

    def finished(function: Callable[[], object]) -> Callable[[], None]:
        def call() -> None:  # Mitsuba records operations; they run when their result is asked for
            dr.eval(function())
            dr.sync_thread()

        return call

    functions = (
        finished(lambda: lobe.eval(context, at, l)),
        finished(lambda: lobe.pdf(context, at, l)),
        finished(lambda: lobe.sample(context, at, u.z, mi.Point2f(u.x, u.y))[0].wo),
    )
    for function in functions:  # with compilation
        function()
    print(json.dumps(per_second(COUNT, functions)))


if __name__ == "__main__":
    run(__doc__, measure, __file__)
