"""The cases: every node, flag and shape of lobe, with parameters that vary per sample.

Each case is a small document whose BSDF takes its inputs from outside, so that one draw of the unmodified generated
shader covers a different set of parameters in every sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx
import numpy as np

from mrm_mtlx.library.load import set_data_library
from mrm_mtlx.validation.comparison import sampling

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference import ShadingPoints

NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")

# Name of the material of a case; a library's definitions, which may be in the document, have others.
MATERIAL = "case"

# Range of widths: from the sharpest real retroreflector to a fully rough surface.
ALPHA_RANGE = (0.0025, 1.0)


@dataclass(frozen=True)
class Case:
    """One configuration of one node.

    `anisotropic` gives the two widths apart, `film` covers the lobe with a thin film.
    """

    node: str
    retroreflective: bool
    anisotropic: bool
    film: bool

    @property
    def name(self) -> str:
        """The name in reports; also seeds the random numbers."""
        shape = "anisotropic" if self.anisotropic else "isotropic"
        flag = "retroreflective" if self.retroreflective else "ordinary"
        return " ".join((self.node, flag, shape, *(["film"] if self.film else [])))


def cases() -> list[Case]:
    """All cases, in the order of the report."""
    return [
        Case(node, retroreflective, anisotropic, film)
        for node in NODES
        for retroreflective in (False, True)
        for anisotropic in (False, True)
        for film in (False, True)
    ]


def case_document(case: Case, library_document: mx.Document, *, from_properties: bool = True) -> mx.Document:
    """The document of a case: every input but the flag comes from outside.

    From a geometric property of the same name; or, for renderers that read parameters of the shader and not properties
    of the mesh, from a node that holds the value, see `shader_parameters`.
    """
    document = mx.createDocument()
    set_data_library(document, library_document)
    lobe = document.addNode(case.node, "lobe", "BSDF")
    definition = lobe.getNodeDef()
    names = [*_RANGES[case.node], "roughness", "weight", *(_FILM if case.film else ())]
    for name in names if from_properties else [*names, "tangent"]:
        kind = definition.getActiveInput(name).getType()
        lobe.addInput(name, kind).setNodeName(source_node(document, name, kind, from_properties))
    lobe.setInputValue("retroreflective", case.retroreflective)
    surface = document.addNode("surface", "surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setNodeName("lobe")
    document.addMaterialNode(MATERIAL, surface)
    return document


def source_node(document: mx.Document, name: str, kind: str, from_properties: bool) -> str:
    """Name of a new node that brings a value from outside, see `case_document`."""
    return str((_property if from_properties else _parameter)(document, name, kind).getName())


def _property(document: mx.Document, name: str, kind: str) -> Any:
    source = document.addNode("geompropvalue", name, kind)
    source.setInputValue("geomprop", name)
    return source


def _parameter(document: mx.Document, name: str, kind: str) -> Any:
    if kind == "vector2":  # a structure in OSL, of which a script node has no socket
        source = document.addNode("combine2", name, kind)
        source.setInputValue("in1", 0.5)
        source.setInputValue("in2", 0.5)
        return source
    source = document.addNode("constant", name, kind)
    declared = source.getNodeDef().getActiveInput("value")
    source.addInput("value", kind).setValueString(declared.getValueString())
    return source


def shader_parameters(properties: Mapping[str, Array]) -> dict[str, Array]:
    """Values of a case's properties under the names that the generated OSL has for them; it folds constant nodes."""
    parameters: dict[str, Array] = {}
    for name, value in properties.items():
        if value.ndim == 2 and value.shape[1] == 2:
            parameters |= {f"{name}_in1": value[:, 0], f"{name}_in2": value[:, 1]}
        else:
            parameters[f"lobe_{name}"] = value
    return parameters


def draw_properties(case: Case, count: int, rng: np.random.Generator) -> dict[str, Array]:
    """Random inputs of a case, drawn per sample."""
    properties = {name: draw_values(rng, count) for name, draw_values in _RANGES[case.node].items()}
    low, high = np.log(ALPHA_RANGE)
    alpha_x = np.exp(rng.uniform(low, high, count))
    alpha_y = np.exp(rng.uniform(low, high, count)) if case.anisotropic else alpha_x
    properties["roughness"] = np.stack([alpha_x, alpha_y], axis=1)
    properties["weight"] = rng.uniform(0.05, 1.0, count)
    if case.film:
        properties["thinfilm_thickness"] = rng.uniform(1.0, 1200.0, count)
        properties["thinfilm_ior"] = rng.uniform(1.0, 2.5, count)
    return properties


def case_points(case: Case, count: int, rng: np.random.Generator) -> ShadingPoints:
    """Samples of a case: parameters drawn per sample, directions by `sampling.sample_local` for those widths."""
    properties = draw_properties(case, count, rng)
    alpha_x, alpha_y = properties["roughness"].T
    shape = sampling.LobeShape(alpha_x, alpha_y, case.retroreflective)
    v, l = sampling.sample_local(rng, count, [shape])
    return sampling.shading_points(rng, v, l, properties)


_FILM = ("thinfilm_thickness", "thinfilm_ior")


def _uniform(low: float, high: float, components: int = 1) -> Callable[[np.random.Generator, int], Array]:
    def values(rng: np.random.Generator, count: int) -> Array:
        return rng.uniform(low, high, (count, components) if components > 1 else count)

    return values


# What the nodes' own inputs are drawn from: metals of all kinds, dielectrics from water to diamond and, relative to a
# denser outside, below 1; all colours.
_RANGES: Mapping[str, Mapping[str, Callable[[np.random.Generator, int], Array]]] = {
    "conductor_bsdf": {"ior": _uniform(0.04, 4.0, 3), "extinction": _uniform(0.0, 8.0, 3)},
    "dielectric_bsdf": {"tint": _uniform(0.0, 1.0, 3), "ior": _uniform(0.7, 2.6)},
    "generalized_schlick_bsdf": {
        "color0": _uniform(0.0, 1.0, 3),
        "color82": _uniform(0.0, 1.0, 3),
        "color90": _uniform(0.0, 1.0, 3),
        "exponent": _uniform(1.0, 8.0),
    },
}
