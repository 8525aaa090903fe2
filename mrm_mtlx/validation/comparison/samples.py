"""Runs a generated shader over samples and compares it with the reference."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import DirectionalLight, Lighting, SurfacePoints, evaluate_all
from mrm_mtlx.validation.comparison.sampling import local_directions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Program
    from mrm_mtlx.reference import ShadingPoints, Tolerance


@dataclass(frozen=True)
class Comparison:
    """The figures of a comparison.

    Attributes
    ----------
    samples
        How many were compared.
    max_error, median_error
        Relative errors, see `Tolerance.relative_errors`.
    tolerance
        What was allowed at the sample of `max_error`, on the same scale.
    excess
        Largest ratio of error to allowance; above 1 is a difference.
    differing
        How many samples are off by more than is allowed.
    worst
        The sample of `excess`: `v`, `l` (local frame), `found`, `expected` (RGB, and alpha where the reference has
        one), its `error` and `tolerance`.
    """

    samples: int
    max_error: float
    median_error: float
    tolerance: float
    excess: float
    differing: int
    worst: dict[str, Any]

    @property
    def passed(self) -> bool:
        """True if no sample is off by more than is allowed."""
        return self.differing == 0


def draw(
    program: Program,
    points: ShadingPoints,
    uniforms: Mapping[str, Any] | None = None,
    lighting: Lighting | None = None,
) -> NDArray[np.floating]:
    """Colours that the shader gives for the samples, and their alpha, (samples, 4).

    Without `lighting`, under the one directional light of the samples, of unit irradiance.
    """
    at = SurfacePoints(points.position, points.normal, points.tangent, points.texcoord, points.properties)
    return evaluate_all(program, at, lighting or Lighting(DirectionalLight(tuple(points.light))), uniforms)


def compare(found: NDArray[np.floating], tolerance: Tolerance, points: ShadingPoints) -> Comparison:
    """Compare the shader's colours with the reference's, sample by sample, in the channels that the reference has."""
    found = found[:, : tolerance.expected.shape[1]]
    errors = tolerance.relative_errors(found)
    excess = tolerance.excess(found)
    worst = int(np.argmax(excess))
    v, l = local_directions(points, worst)
    allowed = tolerance.relative_allowed()
    return Comparison(
        samples=len(points),
        max_error=float(np.max(errors)),
        median_error=float(np.median(errors)),
        tolerance=float(allowed[int(np.argmax(errors))]),
        excess=float(excess[worst]),
        differing=int(np.count_nonzero(excess > 1.0)),
        worst={
            "v": v,
            "l": l,
            "found": [float(x) for x in found[worst]],
            "expected": [float(x) for x in tolerance.expected[worst]],
            "error": float(errors[worst]),
            "tolerance": float(allowed[worst]),
        },
    )


def worse(first: Comparison, second: Comparison) -> Comparison:
    """Two comparisons of one shader as one: the worst sample of both, the larger errors, all samples."""
    worst = max(first, second, key=lambda c: c.excess)
    largest = max(first, second, key=lambda c: c.max_error)
    return replace(
        worst,
        samples=first.samples + second.samples,
        differing=first.differing + second.differing,
        max_error=largest.max_error,
        tolerance=largest.tolerance,
        median_error=max(first.median_error, second.median_error),
    )
