"""Other surface models as inputs of gltf_pbr, by the translation graphs that MaterialX has for them.

The graphs are MaterialX's own approximations; how near they come is measured by `comparison`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.flattening import flatten
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.replaced import replaced
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.formats.pbr.terms import scalar, term
from mrm_mtlx.formats.pbr.value_sources import source

if TYPE_CHECKING:
    import MaterialX as mx

_STANDARD, _GLTF = "standard_surface", "gltf_pbr"
# By surface model: the translation graphs on the way, each with the model that it leads to.
TRANSLATIONS = {
    _STANDARD: (("standard_surface_to_gltf_pbr", _GLTF),),
    "open_pbr_surface": (
        ("open_pbr_surface_to_standard_surface", _STANDARD),
        ("standard_surface_to_gltf_pbr", _GLTF),
    ),
}
# What the graphs leave as it is, or take a detour with that no term can follow: gltf_pbr's input, and by surface model
# the input that it is, and another that has to be 0 for that.
_SAME = {
    "roughness": {
        _STANDARD: ("specular_roughness", "specular_anisotropy"),
        "open_pbr_surface": ("specular_roughness", "specular_roughness_anisotropy"),
    },
    "retroreflectivity": {
        _STANDARD: ("retroreflectivity", ""),
        "open_pbr_surface": ("specular_retroreflectivity", ""),
    },
}
_ROUNDED = 1e-6
# Inputs of gltf_pbr that mean something where light is transmitted, and there alone.
_OF_VOLUMES = ("thickness", "attenuation_color", "attenuation_distance", "dispersion")
# Where the graphs do not reach: the input of gltf_pbr that a connection is of, by surface model.
_FRAMES = {
    _STANDARD: {"normal": "normal", "coat_normal": "clearcoat_normal", "tangent": "tangent"},
    "open_pbr_surface": {
        "geometry_normal": "normal",
        "geometry_coat_normal": "clearcoat_normal",
        "geometry_tangent": "tangent",
    },
}


def model(node: Any) -> dict[str, Any]:
    """The inputs of gltf_pbr for a node of another surface model; of those that are no terms, what stands for them.

    Raises
    ------
    InexpressibleError
        If MaterialX has no translation of it.
    """
    category = node.getCategory()
    if category not in TRANSLATIONS:
        msg = f"{category} is another surface model, of which MaterialX has no translation to gltf_pbr"
        raise InexpressibleError(msg)
    document = node.getDocument()
    copy = document.copy()
    copy.setDataLibrary(document.getDataLibrary())
    translated = copy.getDescendant(node.getNamePath())
    for graph, target in TRANSLATIONS[category]:
        translated = _translated(copy, translated, graph, target)
    names = [given.getName() for given in translated.getInputs()]
    found = {name: _of(translated, name) for name in names if name not in _FRAMES[_STANDARD]}
    transmission = found.get("transmission")
    if isinstance(transmission, Term) and transmission.value is not None and not transmission.value.any():
        found = {name: value for name, value in found.items() if name not in _OF_VOLUMES}
    for name, models in _SAME.items():
        theirs, other = models[category]
        if node.getNodeDef().getActiveInput(theirs) is not None and (not other or scalar(node, other) == 0.0):
            found[name] = _of(node, theirs)
            if other:
                found.pop("anisotropy_strength", None)
    alpha = found.get("alpha")
    if isinstance(alpha, Term) and alpha.value is not None and abs(float(alpha.value[0]) - 1.0) < _ROUNDED:
        # The graph compares the luminance of white with 1, which it misses by a rounding.
        found = {name: value for name, value in found.items() if name not in ("alpha", "alpha_mode")}
    for theirs, name in _FRAMES[category].items():
        upstream = source(node, theirs)
        if upstream is not None:
            found[name] = str(upstream[0].getNamePath())
    return found


def _translated(document: mx.Document, node: Any, graph: str, target: str) -> Any:
    """A node of another model whose inputs are what a translation graph makes of the node's."""
    definition = document.getNodeDef(f"ND_{graph}")
    if definition is None:
        msg = f"MaterialX has no {graph}"
        raise InexpressibleError(msg)
    parent = node.getParent()
    between = parent.addNode(graph, parent.createValidChildName(graph), "multioutput")
    for given in node.getInputs():
        if definition.getActiveInput(given.getName()) is not None:
            between.addInput(given.getName(), given.getType()).copyContentFrom(given)
    made = parent.addNode(target, parent.createValidChildName(target), "surfaceshader")
    known = {given.getName() for given in document.getNodeDef(f"ND_{target}_surfaceshader").getActiveInputs()}
    for output in definition.getActiveOutputs():
        name = output.getName().removesuffix("_out")
        if name in known:
            given = made.addInput(name, output.getType())
            given.setNodeName(between.getName())
            given.setOutputString(output.getName())
    path = between.getNamePath()
    try:
        flatten(parent, lambda inner: inner.getNamePath() == path)
    except ValueError as error:
        msg = f"{graph} cannot be flattened: {error}"
        raise InexpressibleError(msg) from error
    return made


def _of(node: Any, name: str) -> Any:
    try:
        if name == "alpha_mode":
            return int(scalar(node, name))
        value = term(node, name)
    except InexpressibleError as error:
        return replaced(node, name, error)
    # 0/0 of a translation graph stands where its result is not used.
    return value if np.all(np.isfinite(value.offset)) else Term.constant(0.0)
