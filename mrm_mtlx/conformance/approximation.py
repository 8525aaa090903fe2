"""The error of the aligned lobe of OSL: integrals over all directions of the light, in a renderer.

One render per angle between v and l has a facet for every width, view angle, material and azimuth of l about v; a
quadrature over the angles makes the integrals of it. So the figures are those of the renderer's closures, and not of a
copy of the formulas.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx import bsdf
from mrm_mtlx.conformance.cases import Case, case_document
from mrm_mtlx.conformance.results import Approximation
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison.sampling import perpendicular

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.lobe import Lobe
    from mrm_mtlx.engines.base import ClosureBench

ALPHAS = (0.0025, 0.01, 0.04, 0.1)
VIEWS_DEG = (0.0, 15.0, 30.0, 45.0, 60.0)

# Promised L1 error and distance of the albedo ratio from 1, by node and up to a width; incidence up to 60 degrees.
BOUNDS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "conductor_bsdf": ((0.04, 0.05, 0.01), (0.1, 0.11, 0.02)),
    "dielectric_bsdf": ((0.04, 0.08, 0.015), (0.1, 0.16, 0.03)),
    "generalized_schlick_bsdf": ((0.04, 0.08, 0.015), (0.1, 0.16, 0.03)),
}

# Quadrature: the trapezoidal rule in ln tan(angle / 2) and in the azimuth. Twice as many of both move the L1 errors and
# the albedos by less than 0.001.
_ANGLES = 96
_AZIMUTHS = 32
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
# tan(angle / 2), from a hundredth of the narrowest width, below which lies 1e-4 of a lobe, to 155 degrees.
_RANGE = (2.5e-5, 4.5)


@dataclass(frozen=True)
class Material:
    """A lobe: its node, its inputs by name, and the oracle's lobe for an array of widths."""

    name: str
    node: str
    inputs: dict[str, float | tuple[float, ...]]
    lobe: Callable[[Array], Lobe]


def _conductor(name: str, ior: tuple[float, ...], extinction: tuple[float, ...]) -> Material:
    def lobe(alpha: Array) -> Lobe:
        return bsdf.Conductor(ior, extinction, alpha=(alpha, alpha), retroreflective=True)

    return Material(name, "conductor_bsdf", {"ior": ior, "extinction": extinction}, lobe)


def _dielectric(ior: float) -> Material:
    def lobe(alpha: Array) -> Lobe:
        return bsdf.Dielectric(ior, alpha=(alpha, alpha), retroreflective=True)

    return Material(f"ior {ior:g}", "dielectric_bsdf", {"ior": ior}, lobe)


def _schlick(color0: float) -> Material:
    def lobe(alpha: Array) -> Lobe:
        return bsdf.GeneralizedSchlick(color0, alpha=(alpha, alpha), retroreflective=True)

    return Material(f"F0 {color0:g}", "generalized_schlick_bsdf", {"color0": (color0,) * 3}, lobe)


MATERIALS = (
    _conductor("gold", (0.183, 0.421, 1.373), (3.424, 2.346, 1.770)),
    _conductor("aluminium", (1.345, 0.965, 0.617), (7.475, 6.400, 5.303)),
    _dielectric(1.33),
    _dielectric(1.5),
    _dielectric(2.0),
    _schlick(0.04),
    _schlick(0.1),
    _schlick(0.5),
)


def bounds(node: str, alpha: float) -> tuple[float, float]:
    """The promised L1 error and albedo of a node at a width; infinite beyond the widths of `BOUNDS`."""
    return next(((l1, albedo) for widest, l1, albedo in BOUNDS[node] if alpha <= widest), (np.inf, np.inf))


def measure_aligned(
    bench: ClosureBench,
    node: str,
    alphas: Sequence[float] = ALPHAS,
    views_deg: Sequence[float] = VIEWS_DEG,
    *,
    angles: int = _ANGLES,
    azimuths: int = _AZIMUTHS,
) -> Iterator[Approximation]:
    """L1 error and albedo of the aligned lobes of a node, per material, width and view angle, in this order.

    Raises
    ------
    EngineFailure
        If there is no renderer, or it dies.
    """
    materials = [m for m in MATERIALS if m.node == node]
    shape = (len(alphas), len(views_deg), azimuths)
    turn = 2.0 * np.pi * np.arange(azimuths) / azimuths
    alpha, view, azimuth = (a.ravel() for a in np.meshgrid(alphas, np.deg2rad(views_deg), turn, indexing="ij"))
    # v = z, and n turned from it by the view angle.
    normal = np.stack([np.sin(view) * np.cos(azimuth), np.sin(view) * np.sin(azimuth), np.cos(view)], axis=1)
    inputs = {"roughness_in1": np.tile(alpha, len(materials)), "roughness_in2": np.tile(alpha, len(materials))}
    for name in materials[0].inputs:
        inputs[f"lobe_{name}"] = np.repeat([m.inputs[name] for m in materials], len(alpha), axis=0)
    normals = np.tile(normal, (len(materials), 1))
    seen = bench.true_normals(normals).astype(float).reshape(len(materials), len(alpha), 3)
    radius = np.geomspace(*_RANGE, angles)
    angle = 2.0 * np.arctan(radius)
    # Each sun at another azimuth, so that the horizon, where the lobe ends, meets the azimuths anew.
    start = 2.0 * np.pi * (_GOLDEN * np.arange(angles) % 1.0)
    suns = np.stack([np.sin(angle) * np.cos(start), np.sin(angle) * np.sin(start), np.cos(angle)], axis=1)
    program = bench.compile(_source(node), f"aligned_{node}")
    lit = program.direct_light(normals, inputs, suns).reshape(angles, len(materials), len(alpha), 3)
    errors, found_sums, exact_sums = (np.zeros(lit.shape[1:]) for _ in range(3))
    for r, sun, found in zip(radius, suns, lit, strict=True):
        exact = np.stack([_exact(m.lobe(alpha), n, sun) for m, n in zip(materials, seen, strict=True)])
        weight = 4.0 * r * r / (1.0 + r * r) ** 2  # solid angle per ln r and azimuth
        errors += weight * np.abs(found - exact)
        found_sums += weight * found
        exact_sums += weight * exact
    error, total, exact_total = (a.reshape(-1, *shape, 3).sum(axis=3) for a in (errors, found_sums, exact_sums))
    for k, i, j in np.ndindex(total.shape[:3]):
        ratios = total[k, i, j] / exact_total[k, i, j]
        l1_bound, albedo_bound = bounds(node, alphas[i])
        yield Approximation(
            material=materials[k].name,
            alpha=float(alphas[i]),
            view_deg=float(views_deg[j]),
            l1=float(np.max(error[k, i, j] / exact_total[k, i, j])),
            albedo=float(ratios[np.argmax(np.abs(ratios - 1.0))]),
            l1_bound=l1_bound,
            albedo_bound=albedo_bound,
        )


def _exact(lobe: Lobe, normals: Array, light: Array) -> Array:
    """f(v', l) cos(l) of facets with these normals, for v = z."""
    n = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    # Isotropic: any tangent will do.
    x = perpendicular(n)
    frame = np.stack([x, np.cross(n, x), n], axis=1)
    v, l = frame[:, :, 2], frame @ light
    return np.asarray(lobe.eval(v, l) * np.maximum(l[:, 2:], 0.0))


def _source(node: str) -> str:
    library = load_library()
    document = case_document(
        Case(node, retroreflective=True, anisotropic=False, film=False), library.document, from_properties=False
    )
    # Constants take the standard values of what is not measured: white, opaque, exponent 5, the surface's own tangent.
    lobe = document.getNode("lobe")
    for name in ("weight", "tint", "color82", "color90", "exponent", "tangent"):
        if lobe.getInput(name) is not None:
            lobe.removeInput(name)
    return generate(renderable_elements(document)[0], "osl", library).sources["pixel"]
