"""Runs a generated shader over samples and compares it with the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.gl import DirectionalLight, Lighting, SurfaceProgram
from mrm_mtlx.validation.sampling import local_directions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.reference import ShadingPoints, Tolerance
    from mrm_mtlx.shadergen import Shader

# Components of the shader inputs that the samples do not have; they are given zeros.
_COMPONENTS = {
    "float": 1,
    "integer": 1,
    "vector2": 2,
    "vector3": 3,
    "vector4": 4,
    "color3": 3,
    "color4": 4,
}


@dataclass(frozen=True)
class Comparison:
    """What a comparison found.

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
        The sample of `excess`: `v`, `l` (local frame), `found`, `expected` (RGB), its `error` and `tolerance`.
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
        """Whether no sample is off by more than is allowed."""
        return self.differing == 0


def draw(
    program: SurfaceProgram, shader: Shader, points: ShadingPoints, uniforms: Mapping[str, Any] | None = None
) -> NDArray[np.float32]:
    """Colours that the shader gives for the samples under one directional light of unit irradiance, (samples, 3)."""
    lighting = Lighting(DirectionalLight(tuple(points.light)))
    return program.draw(shader_inputs(shader, points), lighting, uniforms)[:, :3]


def shader_inputs(shader: Shader, points: ShadingPoints) -> dict[str, NDArray[np.floating]]:
    """The samples under the names that generated shaders use; what a sample does not have is zero."""
    count = len(points)
    bitangent = np.cross(points.normal, points.tangent)
    inputs: dict[str, NDArray[np.floating]] = {}
    for space in ("World", "Object"):
        inputs |= {
            f"position{space}": points.position,
            f"normal{space}": points.normal,
            f"tangent{space}": points.tangent,
            f"bitangent{space}": bitangent,
        }
    inputs |= {f"texcoord_{i}": points.texcoord for i in range(8)}
    inputs |= {f"color_{i}": np.ones((count, 4)) for i in range(8)}
    inputs |= {f"i_geomprop_{name}": value for name, value in points.properties.items()}
    for port in shader.inputs:
        inputs.setdefault(port.variable, np.zeros((count, _COMPONENTS.get(port.type, 1))))
    return inputs


def compare(found: NDArray[np.floating], tolerance: Tolerance, points: ShadingPoints) -> Comparison:
    """Compare the shader's colours with the reference's, sample by sample."""
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
