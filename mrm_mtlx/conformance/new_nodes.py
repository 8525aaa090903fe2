"""The cases of the nodes that MaterialX lacks, and what they are compared with.

The tolerance of a sample is the one of the reference, which evaluates the node's own graph; the expected value is not:

* partial retroreflection is `(1 - w)` times the standard node with the flag off and `w` times it with the flag on, both
  over the same paint, so that a wrong throughput shows;
* the share of prismatic sheeting is `bsdf.prismatic`, as the weight of a white Lambertian.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx
import numpy as np

from mrm_mtlx.bsdf import prismatic
from mrm_mtlx.conformance.cases import (
    MATERIAL,
    NODES,
    Case,
    case_document,
    case_points,
    draw_properties,
    source_node,
)
from mrm_mtlx.library.load import set_data_library
from mrm_mtlx.reference import Surface
from mrm_mtlx.reference.float32.rounding import Tolerance
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.validation.comparison import sampling

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference import ShadingPoints

WEIGHT_NODE = "mrm_prismatic_weight"
AMOUNT = "retroreflectivity"

# Indices of sheets, from nearly that of air, where the corners' faces let light out, to flint glass; rotations [deg].
_INDICES, _ROTATIONS = (1.05, 2.0), (-180.0, 180.0)


@dataclass(frozen=True)
class NewCase(Case):
    """One configuration of a node that MaterialX lacks; `metallised` is that of `mrm_prismatic_weight`."""

    metallised: bool = False

    @property
    def name(self) -> str:
        """The name in reports; also seeds the random numbers."""
        if self.node == WEIGHT_NODE:
            return f"{self.node} {'metallised' if self.metallised else 'backed by air'}"
        return super().name.replace(" retroreflective", " partly retroreflective")

    @property
    def standard(self) -> Case:
        """The case of the standard node with the same parameters."""
        return Case(self.node.removeprefix("mrm_"), self.retroreflective, self.anisotropic, self.film)


def new_cases() -> list[NewCase]:
    """All of them, in the order of the report."""
    partial = [NewCase(f"mrm_{node}", True, shaped, shaped) for node in NODES for shaped in (False, True)]
    return partial + [NewCase(WEIGHT_NODE, False, False, False, metallised) for metallised in (False, True)]


def document_of(case: Case, library_document: mx.Document, *, from_properties: bool = True) -> mx.Document:
    """The document of any case."""
    if isinstance(case, NewCase):
        return new_document(case, library_document, from_properties=from_properties)
    return case_document(case, library_document, from_properties=from_properties)


def points_of(case: Case, count: int, rng: np.random.Generator) -> ShadingPoints:
    """The samples of any case."""
    return new_points(case, count, rng) if isinstance(case, NewCase) else case_points(case, count, rng)


def properties_of(case: Case, count: int, rng: np.random.Generator) -> dict[str, Array]:
    """The random inputs of any case."""
    return new_properties(case, count, rng) if isinstance(case, NewCase) else draw_properties(case, count, rng)


def new_document(case: NewCase, library_document: mx.Document, *, from_properties: bool = True) -> mx.Document:
    """The document of a case, see `case_document`; BSDFs lie over white paint where parameters are properties."""
    if case.node == WEIGHT_NODE:
        return _weight_document(case, library_document, from_properties)
    document = case_document(case.standard, library_document, from_properties=from_properties)
    lobe = document.getNode("lobe")
    lobe.removeInput("retroreflective")
    lobe.setCategory(case.node)
    lobe.addInput(AMOUNT, "float").setNodeName(source_node(document, AMOUNT, "float", from_properties))
    if from_properties:
        document.addNode("oren_nayar_diffuse_bsdf", "paint", "BSDF").setInputValue("color", mx.Color3(0.9, 0.9, 0.9))
        layer = document.addNode("layer", "painted", "BSDF")
        layer.addInput("top", "BSDF").setNodeName("lobe")
        layer.addInput("base", "BSDF").setNodeName("paint")
        document.getNode("surface").getInput("bsdf").setNodeName("painted")
    return document


def standard_document(
    case: NewCase, flag: bool, library_document: mx.Document, *, from_properties: bool = True
) -> mx.Document:
    """The document of a partial case with the standard node in its place, its flag as told."""
    document = new_document(case, library_document, from_properties=from_properties)
    lobe = document.getNode("lobe")
    lobe.removeInput(AMOUNT)
    lobe.setCategory(case.standard.node)
    lobe.setInputValue("retroreflective", flag)
    return document


def new_points(case: NewCase, count: int, rng: np.random.Generator) -> ShadingPoints:
    """Samples of a case, see `case_points`; of a partial lobe in and about both its parts."""
    properties = new_properties(case, count, rng)
    if case.node == WEIGHT_NODE:
        return sampling.shading_points(rng, *sampling.sample_local(rng, count), properties)
    alpha_x, alpha_y = properties["roughness"].T
    shapes = [sampling.LobeShape(alpha_x, alpha_y, flag) for flag in (False, True)]
    return sampling.shading_points(rng, *sampling.sample_local(rng, count, shapes), properties)


def new_properties(case: NewCase, count: int, rng: np.random.Generator) -> dict[str, Array]:
    """Random inputs of a case, drawn per sample; one amount in four is 0 or 1."""
    if case.node == WEIGHT_NODE:
        return {"ior": rng.uniform(*_INDICES, count), "rotation": rng.uniform(*_ROTATIONS, count)}
    amount = rng.random(count)
    ends = np.where(rng.random(count) < 0.25, np.round(amount), amount)
    return draw_properties(case.standard, count, rng) | {AMOUNT: ends}


def expected(case: Case, points: ShadingPoints, found: Tolerance, library_document: mx.Document) -> Tolerance:
    """The reference's tolerance, `found`, with the expected values of the independent oracle where there is one."""
    if not isinstance(case, NewCase):
        return found
    if case.node == WEIGHT_NODE:
        return Tolerance(_expected_share(case, points), found.allowed)
    amount = points.properties[AMOUNT].astype(float)[:, None]
    documents = [standard_document(case, flag, library_document) for flag in (False, True)]  # kept: surfaces need them
    ordinary, retroreflective = (Surface(renderable_elements(d)[0]).shade(points) for d in documents)
    return Tolerance((1.0 - amount) * ordinary + amount * retroreflective, found.allowed)


def _expected_share(case: NewCase, points: ShadingPoints) -> Array:
    """w(v) cos(l) / pi, alike on both sides."""
    v, l, normal = points.view, np.broadcast_to(points.light, points.view.shape), points.normal
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.cross(normal, points.tangent)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    frame = np.stack([np.cross(across, normal), across, normal], axis=1)
    local = np.einsum("nij,nj->ni", frame, v / np.linalg.norm(v, axis=1, keepdims=True))
    cosine = np.maximum(np.sum(l * normal, axis=1) * np.sign(local[:, 2]), 0.0)
    local[:, 2] = np.abs(local[:, 2])
    ior, rotation = (points.properties[name].astype(float) for name in ("ior", "rotation"))
    backing = "metal" if case.metallised else "air"
    share = prismatic.retroreflected_share(local, ior, backing, np.deg2rad(rotation))
    return np.repeat((share * cosine / np.pi)[:, None], 3, axis=1)


def _weight_document(case: NewCase, library_document: mx.Document, from_properties: bool) -> mx.Document:
    document = mx.createDocument()
    set_data_library(document, library_document)
    weight = document.addNode(WEIGHT_NODE, "lobe", "float")
    for name in ("ior", "rotation"):
        weight.addInput(name, "float").setNodeName(source_node(document, name, "float", from_properties))
    if not from_properties:
        weight.addInput("tangent", "vector3").setNodeName(source_node(document, "tangent", "vector3", False))
    weight.setInputValue("metallised", case.metallised)
    diffuse = document.addNode("oren_nayar_diffuse_bsdf", "diffuse", "BSDF")
    diffuse.addInput("weight", "float").setNodeName("lobe")
    diffuse.setInputValue("color", mx.Color3(1.0, 1.0, 1.0))
    surface: Any = document.addNode("surface", "surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setNodeName("diffuse")
    document.addMaterialNode(MATERIAL, surface)
    return document
