"""Runs a generated shader over samples and compares it with the reference."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.base import FLOAT32_BITS, DirectionalLight, Lighting, SurfacePoints, evaluate_all
from mrm_mtlx.reference import Tolerance
from mrm_mtlx.validation.comparison.sampling import local_directions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Capabilities, Program
    from mrm_mtlx.reference import ShadingPoints


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


@dataclass(frozen=True)
class Drawing:
    """What a shader gave for samples.

    Attributes
    ----------
    colors : shape (samples, 4)
    points
        The samples where they were drawn; those that were asked for, unless the engine has places of its own.
    capabilities
        Of the program, whose colours may have fewer bits than float32.
    """

    colors: NDArray[np.floating]
    points: ShadingPoints
    capabilities: Capabilities

    def allowed(self, tolerance: Tolerance) -> Tolerance:
        """The tolerance of the reference at the points, and what the colours lose in their bits.

        Half floats may be cut off to their last bit (OpenGL leaves the rounding open), and have fewer bits in the
        range of their smallest numbers.
        """
        if self.capabilities.color_bits >= FLOAT32_BITS:
            return tolerance
        lost = 2.0 ** (1 - self.capabilities.color_bits) * np.abs(tolerance.expected) + self.capabilities.color_step
        return Tolerance(tolerance.expected, tolerance.allowed + lost)


def draw(
    program: Program,
    points: ShadingPoints,
    uniforms: Mapping[str, Any] | None = None,
    lighting: Lighting | None = None,
) -> Drawing:
    """Colours that the shader gives for the samples, and their alpha.

    Without `lighting`, under the one directional light of the samples, of unit irradiance.
    """
    at = SurfacePoints(points.position, points.normal, points.tangent, points.texcoord, points.properties)
    light = lighting or Lighting(DirectionalLight(tuple(points.light)))
    placed = program.places(at, light)
    if placed is not at:
        view = np.asarray(light.view_position) - placed.position
        view /= np.linalg.norm(view, axis=1, keepdims=True)
        position, normal, tangent = (
            np.asarray(a, dtype=float) for a in (placed.position, placed.normal, placed.tangent)
        )
        points = replace(points, view=view, position=position, normal=normal, tangent=tangent)
    return Drawing(evaluate_all(program, at, light, uniforms), points, program.capabilities)


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
