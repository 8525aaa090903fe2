"""The error of a lobe that stands for a retroreflective one: integrals over all directions of the light.

One render per angle between v and l has a facet for every width, view angle, material and azimuth of l about v; a
quadrature over the angles makes the integrals of it. So the figures are those of what draws, the closures of a renderer
of OSL or generated code, and not of a copy of the formulas.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mrm_mtlx import bsdf
from mrm_mtlx.conformance.cases import Case, case_document, shader_parameters
from mrm_mtlx.conformance.results import Approximation
from mrm_mtlx.library import load_library
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison.sampling import perpendicular

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.lobe import Lobe
    from mrm_mtlx.engines.base import ClosureBench

ALPHAS = (0.0025, 0.01, 0.04, 0.1)
VIEWS_DEG = (0.0, 15.0, 30.0, 45.0, 60.0)

# Promised L1 error and distance of the albedo ratio from 1, by node and up to a width; incidence up to 60 degrees.
Bounds: TypeAlias = "dict[str, tuple[tuple[float, float, float], ...]]"

BOUNDS: Bounds = {
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


def bounds(promised: Bounds, node: str, alpha: float) -> tuple[float, float]:
    """The promised L1 error and albedo of a node at a width; infinite beyond the widths that are promised."""
    return next(((l1, albedo) for widest, l1, albedo in promised[node] if alpha <= widest), (np.inf, np.inf))


@dataclass(frozen=True)
class Sky:
    """Facets and suns of a measurement: every width, view angle and azimuth, each under suns at every angle from v = z.

    Attributes
    ----------
    node
        What reflects; the materials of `MATERIALS` that are of it, one after another.
    alphas, views_deg
        Widths, and angles of v from the normal.
    angles, azimuths
        How many suns, and azimuths of l about v.
    """

    node: str
    alphas: Sequence[float] = ALPHAS
    views_deg: Sequence[float] = VIEWS_DEG
    angles: int = _ANGLES
    azimuths: int = _AZIMUTHS

    @property
    def materials(self) -> list[Material]:
        """The materials of the node."""
        return [m for m in MATERIALS if m.node == self.node]

    @property
    def alpha(self) -> Array:
        """Widths of the facets of one material."""
        return self._facets()[0]

    @property
    def normals(self) -> Array:
        """Normals of the facets of all materials, (materials * facets, 3): turned from v by the view angle."""
        _, view, azimuth = self._facets()
        normal = np.stack([np.sin(view) * np.cos(azimuth), np.sin(view) * np.sin(azimuth), np.cos(view)], axis=1)
        return np.tile(normal, (len(self.materials), 1))

    def inputs(self) -> dict[str, Array]:
        """The inputs of the materials by name, per facet; the roughness is isotropic."""
        alpha = self.alpha
        each = {
            name: np.repeat([m.inputs[name] for m in self.materials], len(alpha), axis=0)
            for name in self.materials[0].inputs
        }
        return each | {"roughness": np.tile(np.stack([alpha, alpha], axis=1), (len(self.materials), 1))}

    def suns(self) -> Array:
        """Directions of the light, (angles, 3)."""
        angle = 2.0 * np.arctan(self._radius())
        # Each sun at another azimuth, so that the horizon, where the lobe ends, meets the azimuths anew.
        start = 2.0 * np.pi * (_GOLDEN * np.arange(self.angles) % 1.0)
        return np.stack([np.sin(angle) * np.cos(start), np.sin(angle) * np.sin(start), np.cos(angle)], axis=1)

    def figures(self, lit: Iterable[tuple[Array, Array]], promised: Bounds) -> Iterator[Approximation]:
        """L1 error and albedo per material, width and view angle, in this order.

        `lit` has, for each sun, what is found of all facets, f(v, l) cos(l), and what is exact, (facets, 3).
        """
        errors, found_sums, exact_sums = (np.zeros((len(self.normals), 3)) for _ in range(3))
        for r, (found, exact) in zip(self._radius(), lit, strict=True):
            weight = 4.0 * r * r / (1.0 + r * r) ** 2  # solid angle per ln r and azimuth
            errors += weight * np.abs(found - exact)
            found_sums += weight * found
            exact_sums += weight * exact
        shape = (-1, len(self.alphas), len(self.views_deg), self.azimuths, 3)
        error, total, exact_total = (a.reshape(shape).sum(axis=3) for a in (errors, found_sums, exact_sums))
        for k, i, j in np.ndindex(total.shape[:3]):
            ratios = total[k, i, j] / exact_total[k, i, j]
            l1_bound, albedo_bound = bounds(promised, self.node, self.alphas[i])
            yield Approximation(
                material=self.materials[k].name,
                alpha=float(self.alphas[i]),
                view_deg=float(self.views_deg[j]),
                l1=float(np.max(error[k, i, j] / exact_total[k, i, j])),
                albedo=float(ratios[np.argmax(np.abs(ratios - 1.0))]),
                l1_bound=l1_bound,
                albedo_bound=albedo_bound,
            )

    def _radius(self) -> Array:
        return np.geomspace(*_RANGE, self.angles)

    def _facets(self) -> tuple[Array, Array, Array]:
        turn = 2.0 * np.pi * np.arange(self.azimuths) / self.azimuths
        grid = np.meshgrid(self.alphas, np.deg2rad(self.views_deg), turn, indexing="ij")
        alpha, view, azimuth = (a.ravel() for a in grid)
        return alpha, view, azimuth


def measure_aligned(bench: ClosureBench, sky: Sky) -> Iterator[Approximation]:
    """L1 error and albedo of the aligned lobes of OSL, see `Sky.figures`.

    Raises
    ------
    EngineFailure
        If there is no renderer, or it dies.
    """
    normals, suns = sky.normals, sky.suns()
    seen = bench.true_normals(normals).astype(float).reshape(len(sky.materials), -1, 3)
    program = bench.compile(_source(sky.node, bench.target), f"aligned_{sky.node}")
    lit = program.direct_light(normals, shader_parameters(sky.inputs()), suns)

    def exact(sun: Array) -> Array:
        lobes = [m.lobe(sky.alpha) for m in sky.materials]
        return np.concatenate([_exact(lobe, n, sun) for lobe, n in zip(lobes, seen, strict=True)])

    return sky.figures(((found, exact(sun)) for found, sun in zip(lit, suns, strict=True)), BOUNDS)


def _exact(lobe: Lobe, normals: Array, light: Array) -> Array:
    """f(v', l) cos(l) of facets with these normals, for v = z."""
    n = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    # Isotropic: any tangent will do.
    x = perpendicular(n)
    frame = np.stack([x, np.cross(n, x), n], axis=1)
    v, l = frame[:, :, 2], frame @ light
    return np.asarray(lobe.eval(v, l) * np.maximum(l[:, 2:], 0.0))


def _source(node: str, target: str) -> str:
    library = load_library()
    document = measured_document(node, library.document, from_properties=False)
    return generate(renderable_elements(document)[0], target, library).sources["pixel"]


def measured_document(node: str, library_document: mx.Document, *, from_properties: bool) -> mx.Document:
    """The document of a retroreflective node whose inputs come from outside, as far as `MATERIALS` have them."""
    case = Case(node, retroreflective=True, anisotropic=False, film=False)
    document = case_document(case, library_document, from_properties=from_properties)
    # Constants take the standard values of what is not measured: white, opaque, exponent 5, the surface's own tangent.
    lobe = document.getNode("lobe")
    for name in ("weight", "tint", "color82", "color90", "exponent", "tangent"):
        if lobe.getInput(name) is not None:
            lobe.removeInput(name)
    return document
