"""A surface in the inputs of gltf_pbr: read from one, or from what comes near it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import ImagesTooLargeError
from mrm_mtlx.documents.graph import shader_node
from mrm_mtlx.formats.pbr.bsdf_surfaces import opacity_of, surface
from mrm_mtlx.formats.pbr.nearest import nearest
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.replaced import Replaced, replaced
from mrm_mtlx.formats.pbr.surface_models import model
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.formats.pbr.terms import scalar, term
from mrm_mtlx.formats.pbr.value_sources import source
from mrm_mtlx.reference import UnsupportedError

if TYPE_CHECKING:
    from mrm_mtlx.formats.pbr.nearest import Pixels

# The surface that is the same in any light.
UNLIT = "surface_unlit"
# The model whose inputs they are.
GLTF = "gltf_pbr"
# What readers that do not know KHR_materials_unlit are to show, as it recommends.
_FALLBACK = {"metallic": Term.constant(0.0), "roughness": Term.constant(0.9)}
# Inputs of gltf_pbr that are normals.
NORMALS = ("normal", "clearcoat_normal")
# Inputs of gltf_pbr without a form in glTF.
NO_FORM = ("tangent",)


@dataclass(frozen=True)
class Inputs:
    """A surface in the inputs of gltf_pbr.

    Attributes
    ----------
    values
        By input: a term, the mode of alpha, the path of the node that a normal comes from, or the node of an anisotropy
        image.
    losses
        Inputs that have no form as they are: the place, "/input", and why.
    approximated
        Why the whole is no more than what comes nearest to the surface's values, "" if it is read from its nodes.
    """

    values: dict[str, Any]
    losses: list[tuple[str, str]] = field(default_factory=list)
    approximated: str = ""


def inputs_of(element: Any, images: Pixels, *, exact: bool = False) -> Inputs:
    """A renderable element in the inputs of gltf_pbr.

    Parameters
    ----------
    element
        In a document that is `value_sources.resolved`.
    images
        As `reference.Surface`.
    exact
        Whether a surface of other parts than gltf_pbr has is refused, and not approximated.

    Raises
    ------
    InexpressibleError
        If the surface as a whole has no form.
    """
    node = shader_node(element)
    try:
        return _settled(_read(node))
    except InexpressibleError as error:
        if exact or node is None or node.getCategory() in (GLTF, UNLIT):
            raise
        return _nearest(element, node, images, str(error))


def _read(node: Any) -> dict[str, Any]:
    """The inputs of gltf_pbr as a surface's nodes have them; of those without a form, the errors or what is there."""
    if node is None:
        msg = "it has no surface shader"
        raise InexpressibleError(msg)
    if node.getCategory() == "surface":
        return surface(node)
    if node.getCategory() == UNLIT:
        return _unlit(node)
    if node.getCategory() != GLTF:
        return model(node)
    return {name: _input(node, name) for name in sorted(given.getName() for given in node.getInputs())}


def _settled(read: dict[str, Any]) -> Inputs:
    """What can be said of inputs that were read, and what cannot."""
    found = Inputs({})
    for name, value in read.items():
        said = value.value if isinstance(value, Replaced) else value
        if isinstance(value, Replaced):
            found.losses.append((f"/{name}", value.reason))
        elif name in NO_FORM and value is not None:
            found.losses.append((f"/{name}", "glTF takes it from the geometry"))
        if said is not None:
            found.values[name] = said
    return found


def _nearest(element: Any, node: Any, images: Pixels, reason: str) -> Inputs:
    """The inputs whose values come nearest to those of an element that was refused for a reason."""
    try:
        opacity = opacity_of(node) if node.getCategory() == "surface" else {}
        alpha = opacity["alpha"].value if opacity else np.ones(1)
        if alpha is None or alpha[0] <= 0.0:
            msg = "its opacity is an image or 0"
            raise InexpressibleError(msg)
        return Inputs({**nearest(element, images, float(alpha[0])), **opacity}, approximated=reason)
    except (InexpressibleError, UnsupportedError, RecursionError, ImagesTooLargeError) as error:
        msg = f"{reason}; nor has it a nearest base: {error}"
        raise InexpressibleError(msg) from error


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
        return replaced(node, name, error)
