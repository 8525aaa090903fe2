"""A material as it looks by day, in the inputs of UsdPreviewSurface: for hosts that have no other.

A surface in the inputs of gltf_pbr (`inputs`) has all that UsdPreviewSurface has, and one thing more, light that
returns, which is left out. Under a film that shines, what returns is not seen by day; so the film becomes the lobe.
What else the lobes take from the colour is in the reference's values: the diffuse colour is such that the look has the
material's reflectance viewed along the normal and lit at 45 degrees, by which standards measure daytime colours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.graph import shader_node
from mrm_mtlx.formats.pbr.directions import DAY, points
from mrm_mtlx.formats.pbr.inputs import UNLIT, inputs_of
from mrm_mtlx.formats.pbr.model_nodes import MODEL, model_document
from mrm_mtlx.formats.pbr.model_values import ModelValues
from mrm_mtlx.formats.pbr.normals import normal_map
from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.replaced import Replaced, replaced
from mrm_mtlx.formats.pbr.term import Term
from mrm_mtlx.formats.pbr.terms import term
from mrm_mtlx.reference import Surface

if TYPE_CHECKING:
    from collections.abc import Callable

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.formats.pbr.nearest import Pixels

# The surface model.
PREVIEW, _GLTF = "UsdPreviewSurface", "gltf_pbr"
# Inputs that other than numbers and colours have no place for: modes, and what hosts disagree about.
_LEFT = ("useSpecularWorkflow", "specularColor", "opacityMode", "displacement")
# The reflectance at normal incidence of a film or of gltf_pbr by default, and the largest that an index is written for.
_FILM, _LARGEST = 0.04, 0.36
_PLACES, _SEED = 64, 7
# What white has to add to what is seen by day, for a colour to be found by it: of what is transparent, it does not.
_SEEN = 1e-3
# What is more of a metal than this has the colour of its lobe, which is not seen from aside.
_METAL = 0.5


@dataclass(frozen=True)
class Look:
    """A look.

    Attributes
    ----------
    inputs
        Of UsdPreviewSurface; a colour's image is read by its first three channels.
    losses
        Inputs of the material that it has no form for: the place, "/input", and why.
    """

    inputs: dict[str, Term]
    losses: list[tuple[str, str]]

    def document(self, library: mx.Document) -> mx.Document:
        """It as a document for the reference to evaluate, see `model_nodes`."""
        return model_document(library, PREVIEW, self.inputs)


def daylight(element: Any, images: Pixels) -> Look:
    """The look by day of a renderable element.

    Parameters
    ----------
    element
        In a document that is `value_sources.resolved`.
    images
        As `reference.Surface`.

    Raises
    ------
    InexpressibleError
        If nothing comes near to it.
    UnsupportedError, RecursionError, ImagesTooLargeError
        If the reference cannot evaluate it.
    """
    node = shader_node(element)
    if node is not None and node.getCategory() == PREVIEW:
        return _own(node)
    found = inputs_of(element, images)
    values = ModelValues(found.values, images)
    is_unlit = node.getCategory() == UNLIT
    look = {name: _sayable(value, values) for name, value in _look(values, is_unlit).items()}
    losses = list(found.losses)
    if "normal" in found.values:
        try:
            look["normal"] = _sayable(normal_map(element.getDocument(), found.values["normal"]).vector, values)
        except InexpressibleError as error:
            losses.append(("/normal", str(error)))
    if not is_unlit:
        look["diffuseColor"] = _calibrated(element, images, values, look)
    return _checked(Look(look, losses))


def _checked(look: Look) -> Look:
    """The look itself.

    Raises
    ------
    InexpressibleError
        If one of its numbers is not finite.
    """
    for name, value in look.inputs.items():
        if not np.all(np.isfinite(value.offset) & np.isfinite(value.scale)):
            msg = f"its {name} would be no finite number"
            raise InexpressibleError(msg)
    return look


def _own(node: Any) -> Look:
    """That of a node of the model itself."""
    found, losses = {}, []
    for name in (given.getName() for given in node.getInputs() if given.getName() not in _LEFT):
        try:
            found[name] = term(node, name)
        except InexpressibleError as error:
            instead: Replaced = replaced(node, name, error)
            losses.append((f"/{name}", instead.reason))
            if instead.value is not None:
                found[name] = instead.value
    return _checked(Look(found, losses))


def _sayable(value: Term, values: ModelValues) -> Term:
    """The term itself, or the mean of a colour that is made of other channels than an image's colours."""
    if value.lookup is None or len(value.channels) == 1 or value.channels == (0, 1, 2):
        return value
    return Term.constant(values.mean(value))


def _look(values: ModelValues, is_unlit: bool) -> dict[str, Term]:
    """What is the same in both models."""
    if is_unlit:
        black = Term.constant((0.0, 0.0, 0.0))
        return {
            "diffuseColor": black, "emissiveColor": values.term("base_color"), "ior": Term.constant(1.0),
            "roughness": Term.constant(1.0), **_opacity(values),
        }  # fmt: skip
    look: dict[str, Term] = {}
    if np.any(values.mean(values.term("emissive"))):
        look["emissiveColor"] = values.term("emissive") * values.number("emissive_strength")
    if "occlusion" in values.given:
        look["occlusion"] = values.term("occlusion")
    return {**look, **_base(values), **_opacity(values)}


def _base(values: ModelValues) -> dict[str, Term]:
    """The base and what shines over it: that of a metal, if most of it is one or mirrors and returns as much as one."""
    metallic, base = values.term("metallic"), values.term("base_color")
    look = {"roughness": values.term("roughness"), "metallic": metallic, "diffuseColor": base}
    share = values.number("metallic")
    if metallic.value is None or share > _METAL:
        return {**look, **_gloss(values, _FILM)}
    # A share of metal is as much more reflectance: hosts differ in what it leaves of the diffuse colour.
    reflectance = (1.0 - share) * _reflectance(values) + share * values.mean(base)
    mean = float(np.mean(reflectance))
    if mean > _LARGEST:
        return {**look, "metallic": Term.constant(1.0), "diffuseColor": Term.constant(reflectance)}
    return {**look, "metallic": Term.constant(0.0), **_gloss(values, mean)}


def _reflectance(values: ModelValues) -> Array:
    """The reflectance of the dielectric's lobe at normal incidence, (3,), whether it returns light or mirrors it."""
    index = values.number("ior")
    normal = values.mean(values.term("specular_color")) * ((index - 1.0) / (index + 1.0)) ** 2
    return np.asarray(np.minimum(normal, 1.0) * values.number("specular"))


def _gloss(values: ModelValues, reflectance: float) -> dict[str, Term]:
    """Index, roughness and coat of what shines; of two lobes, what returns gives its place to the other."""
    returned = float(np.clip(values.number("retroreflectivity"), 0.0, 1.0))
    reflectance *= 1.0 - returned
    weight, roughness = values.number("clearcoat"), values.term("clearcoat_roughness")
    if weight == 0.0:
        return {"ior": _index(reflectance)}
    if returned > 0.5 and values.number("metallic") <= _METAL:
        return {"ior": _index(reflectance + _FILM * weight), "roughness": roughness}
    return {"ior": _index(reflectance), "clearcoat": values.term("clearcoat"), "clearcoatRoughness": roughness}


def _index(reflectance: float) -> Term:
    """The index of refraction that has a reflectance at normal incidence."""
    amplitude = np.sqrt(np.clip(reflectance, 0.0, _LARGEST))
    return Term.constant(float(f"{(1.0 + amplitude) / (1.0 - amplitude):.4g}"))


def _opacity(values: ModelValues) -> dict[str, Term]:
    mode = values.given.get("alpha_mode", 0)
    through = values.number("transmission")
    if mode == 0:
        return {"opacity": Term.constant(1.0 - through)} if through else {}
    return {"opacity": values.term("alpha"), **({"opacityThreshold": values.term("alpha_cutoff")} if mode == 1 else {})}


def _calibrated(element: Any, images: Pixels, values: ModelValues, look: dict[str, Term]) -> Term:
    """The diffuse colour by which a look has the daytime colour of the material."""
    library = element.getDocument().getDataLibrary()
    color = look["diffuseColor"]
    if look["metallic"].value is None or np.any(look["metallic"].value > _METAL):
        return color
    plain = {name: Term.constant(values.mean(value)) for name, value in look.items() if name != "normal"}
    dark, change = _linear(lambda c: model_document(library, PREVIEW, {**plain, "diffuseColor": c}))
    if not np.all(change > _SEEN):
        return color
    if color.lookup is None:
        wanted = _by_day(Surface(element, images=images))
        return Term.constant(_rounded(np.clip((wanted - dark) / change, 0.0, 1.0)))
    theirs = _linear(lambda c: model_document(library, _GLTF, values.means(base_color=c)))
    return color * _rounded(theirs[1] / change) + _rounded((theirs[0] - dark) / change)


def _linear(model: Callable[[Term], mx.Document]) -> tuple[Array, Array]:
    """What is seen by day of a surface model with a black colour, and what a white one adds."""

    def seen(number: float) -> Array:
        document = model(Term.constant((number, number, number)))
        return _by_day(Surface(document.getNode(MODEL)))

    black = seen(0.0)
    return black, seen(1.0) - black


def _by_day(surface: Surface) -> Array:
    """The reflectance factor of each channel by day, in the mean over places."""
    found = surface.response(points(DAY[0][None], DAY[1][None], _PLACES, _SEED)).mean(axis=0)
    return np.asarray(np.pi * found / DAY[1][2])


def _rounded(values: Array) -> Array:
    return np.array([float(f"{x:.4g}") for x in values])
