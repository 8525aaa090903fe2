"""Cycles as a bench for closures: facets under suns."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.engines.osl import measure, process
from mrm_mtlx.engines.osl.compiler import compile_for_cycles
from mrm_mtlx.shadergen import OslMode

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from mrm_mtlx.bsdf.arrays import Array

# The portal's step in a cloud of facets, which lie a unit apart at coordinates up to 200: 10^3 times their rounding.
PORTAL_STEP = 0.02


class CyclesBench:
    """The bench; see `ClosureBench`."""

    # The surface is met again from v' through a portal.
    exact_mode = OslMode.CYCLES
    # It takes the slope of a facet from 1 - cos^2, whose 24 roundings of 2^-24 are a quarter of this width's square.
    narrowest_alpha = 0.0025
    smallest_weight = 1e-5
    geometry = frozenset({"Nworld", "Nobject", "Tworld", "Vworld"})

    def __init__(self, name: str, target: str) -> None:
        self.name, self.target = name, target

    def compile(self, source: str, name: str, headers: Sequence[Path] = ()) -> CyclesProgram:
        """As `ClosureBench.compile`."""
        folder = process.runtime().folder
        for header in headers:
            shutil.copy(header, folder)
        return CyclesProgram(compile_for_cycles(f"#define MRM_PORTAL_STEP {PORTAL_STEP}\n{source}", name))

    def true_normals(self, normals: Array) -> NDArray[np.float32]:
        """As `ClosureBench.true_normals`."""
        return measure.true_normals(normals)


@dataclass(frozen=True)
class CyclesProgram:
    """A compiled shader, in the runtime's folder; see `ClosureProgram`."""

    shader: Path

    def emitted(self, inputs: Mapping[str, Array]) -> NDArray[np.float32]:
        """As `ClosureProgram.emitted`."""
        return measure.evaluate(self.shader, inputs)

    def direct_light(self, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike) -> NDArray[np.float32]:
        """As `ClosureProgram.direct_light`."""
        return measure.direct_light(self.shader, normals, inputs, to_light)

    def direct_light_by_groups(
        self, normals: Array, inputs: Mapping[str, Array], to_light: ArrayLike
    ) -> NDArray[np.float32]:
        """As `ClosureProgram.direct_light_by_groups`."""
        return measure.direct_light_by_groups(self.shader, normals, inputs, to_light)
