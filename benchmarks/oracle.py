"""Speed of the optics.

Millions of values, densities and samples per second of the lobes of `mrm_mtlx.bsdf`, in float64, by arrays of 2^20;
best of 5. It takes large arrays in blocks, one thread per processor; the last rows are the conductor by the size of a
block.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from benchmarks.lobes import COLUMNS, COUNT, GOLD, directions, timed
from benchmarks.timing import Table, per_second, run
from mrm_mtlx import bsdf
from mrm_mtlx.bsdf import blocks
from mrm_mtlx.reference import versions

if TYPE_CHECKING:
    from collections.abc import Iterator


def measure() -> Table:
    """The lobes, then sizes of blocks."""
    return Table(("retroreflective, alpha 0.1 and 0.2", *COLUMNS), _rows(), ("numpy", "scipy"))


def _rows() -> Iterator[tuple[str, ...]]:
    v, l, u = directions()
    gold: dict[str, Any] = {**GOLD, "alpha": (0.1, 0.2), "retroreflective": True}
    interface: dict[str, Any] = {"alpha": (0.1, 0.2), "retroreflective": True}
    conductor = bsdf.Conductor(**gold)
    lobes = {
        "conductor": conductor,
        "conductor, energy compensation": bsdf.Conductor(
            **gold, energy_compensation=versions.installed().microfacet_albedo.white
        ),
        "conductor, thin film": bsdf.Conductor(**gold, thinfilm_thickness=400.0),
        "conductor, V-cavities": bsdf.Conductor(**gold, masking="v_cavity"),
        "conductor, Beckmann": bsdf.Conductor(**gold, distribution="beckmann"),
        "conductor, Phong": bsdf.Conductor(**gold, distribution="phong"),
        "dielectric": bsdf.Dielectric(1.5, **interface),
        "dielectric, transmission": bsdf.Dielectric(1.5, **interface, scatter_mode="T"),
        "dielectric, both": bsdf.Dielectric(1.5, **interface, scatter_mode="RT"),
        "generalised Schlick": bsdf.GeneralizedSchlick(0.2, **interface),
        "conductor, half retroreflective": bsdf.partially_retroreflective(conductor, 0.5),
    }
    for name, lobe in lobes.items():
        yield name, *per_second(COUNT, timed(lobe, v, l, u))
    chosen = blocks.BLOCK
    for exponent in range(10, 19, 2):
        blocks.BLOCK = 1 << exponent
        yield f"conductor, blocks of 2^{exponent}", *per_second(COUNT, [lambda: conductor.eval(v, l)]), "", ""
    blocks.BLOCK = chosen


if __name__ == "__main__":
    run(__doc__, measure, __file__)
