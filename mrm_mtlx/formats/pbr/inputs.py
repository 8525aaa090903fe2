"""A surface in the inputs of gltf_pbr: read from one, or from what comes near it."""

from __future__ import annotations

from typing import Any

import numpy as np

from mrm_mtlx.formats.pbr.bsdf_surfaces import surface
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.surface_models import model
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.formats.pbr.terms import scalar, term
from mrm_mtlx.formats.pbr.value_sources import source

# The surface that is the same in any light.
UNLIT = "surface_unlit"
# What readers that do not know KHR_materials_unlit are to show, as it recommends.
_FALLBACK = {"metallic": Term.constant(0.0), "roughness": Term.constant(0.9)}
# Inputs of gltf_pbr that are normals.
NORMALS = ("normal", "clearcoat_normal")
# Inputs of gltf_pbr without a form in glTF.
NO_FORM = ("tangent",)


def inputs_of(node: Any) -> dict[str, Any]:
    """The inputs of gltf_pbr for a surface; what of them has no form in glTF is the error itself.

    Raises
    ------
    InexpressibleError
        If the surface as a whole has none.
    """
    if node is None:
        msg = "it has no surface shader"
        raise InexpressibleError(msg)
    if node.getCategory() == "surface":
        return surface(node)
    if node.getCategory() == UNLIT:
        return _unlit(node)
    if node.getCategory() != "gltf_pbr":
        return model(node)
    return {name: _input(node, name) for name in sorted(given.getName() for given in node.getInputs())}


def _unlit(node: Any) -> dict[str, Any]:
    """The inputs of gltf_pbr that an unlit surface has: a base colour, and an alpha."""
    color, strength = term(node, "emission_color"), term(node, "emission")
    through = term(node, "transmission")
    if through.value is None or np.any(through.value != 0.0):
        msg = "it is unlit and lets light through"
        raise InexpressibleError(msg)
    if strength.value is not None:
        color *= strength.value
    elif color.value is not None:
        color = strength * color.value
    else:
        msg = "its colour is an image times an image"
        raise InexpressibleError(msg)
    return {"base_color": color, **_opacity(node), **_FALLBACK}


def _opacity(node: Any) -> dict[str, Any]:
    """Alpha and its mode of an unlit surface: a number or an image, or one that reaches a number."""
    upstream = source(node, "opacity")
    if upstream is not None and upstream[0].getCategory() == "ifgreatereq":
        mask = upstream[0]
        if (scalar(mask, "in1"), scalar(mask, "in2")) == (1.0, 0.0):
            cutoff = Term.constant(scalar(mask, "value2"))
            return {"alpha": term(mask, "value1"), "alpha_cutoff": cutoff, "alpha_mode": 1}
    opacity = term(node, "opacity")
    if opacity.value is not None and np.all(opacity.value == 1.0):
        return {}
    return {"alpha": opacity, "alpha_mode": 2}


def _input(node: Any, name: str) -> Any:
    try:
        if name in (*NO_FORM, *NORMALS):
            upstream = source(node, name)
            return None if upstream is None else str(upstream[0].getNamePath())
        if name == "alpha_mode":
            return int(scalar(node, name))
        if name.startswith("anisotropy_"):
            upstream = source(node, name)
            if upstream is not None and upstream[0].getCategory() == "gltf_anisotropy_image":
                return upstream[0]
        return term(node, name)
    except InexpressibleError as error:
        return error
