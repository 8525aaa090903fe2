"""What a surface is, in the inputs of gltf_pbr: read from one, or from what comes near it."""

from __future__ import annotations

from typing import Any

from mrm_mtlx.interchange.gltf.closures import surface
from mrm_mtlx.interchange.gltf.interfaces import source
from mrm_mtlx.interchange.gltf.models import model
from mrm_mtlx.interchange.gltf.placement import InexpressibleError
from mrm_mtlx.interchange.gltf.properties import NORMALS
from mrm_mtlx.interchange.gltf.terms import scalar, term

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
    if node.getCategory() != "gltf_pbr":
        return model(node)
    return {name: _input(node, name) for name in sorted(given.getName() for given in node.getInputs())}


def _input(node: Any, name: str) -> Any:
    try:
        if name in (*NO_FORM, *(name for name, _ in NORMALS)):
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
