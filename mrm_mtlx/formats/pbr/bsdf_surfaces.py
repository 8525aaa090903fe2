"""Surfaces of BSDF nodes as the inputs of gltf_pbr that come nearest.

What gltf_pbr is made of is recognised where it stands: a metal, a dielectric over a diffuse base, a clear coat or a
sheen over these, and mixtures of two that differ in one input. How near that comes is not judged here: `comparison`
compares values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.formats.pbr.placement import InexpressibleError, constant
from mrm_mtlx.formats.pbr.term import Term, blended
from mrm_mtlx.formats.pbr.terms import scalar, term
from mrm_mtlx.formats.pbr.value_sources import source
from mrm_mtlx.reference import constant_input

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

# What an input is: a term, or the path of the node that a normal comes from.
Inputs = dict[str, Any]

# Index of refraction that glTF has by default, and its reflectance at normal incidence.
_IOR = 1.5
_REFLECTANCE = ((1.0 - _IOR) / (1.0 + _IOR)) ** 2
_RETRO, _METALLIC, _WEIGHT = "retroreflectivity", "metallic", "specular"


def surface(node: Any) -> Inputs:
    """The inputs of gltf_pbr for a `surface` node.

    Raises
    ------
    InexpressibleError
        If it is made of other parts than gltf_pbr is.
    """
    bsdf = source(node, "bsdf")
    if bsdf is None:
        msg = "the surface has no BSDF"
        raise InexpressibleError(msg)
    found = _reduced(bsdf[0])
    found.pop(_LAYERS, None)
    light = source(node, "edf")
    if light is not None:
        if light[0].getCategory() != "uniform_edf":
            msg = f"it emits by {light[0].getCategory()}"
            raise InexpressibleError(msg)
        found["emissive"] = term(light[0], "color")
    return found | opacity_of(node)


def opacity_of(node: Any) -> Inputs:
    """Alpha and its mode of a `surface` node; nothing of one that is opaque.

    Raises
    ------
    InexpressibleError
        If it is no term.
    """
    opacity = term(node, "opacity")
    if opacity.value is not None and np.all(opacity.value == 1.0):
        return {}
    return {"alpha": opacity, "alpha_mode": 2}


# Which of glTF's layers lie over the base so far, outermost last: it has each once, in this order.
_LAYERS = " layers"
_ORDER = ("sheen", "clearcoat")


def _reduced(node: Any) -> Inputs:
    category = node.getCategory().removeprefix("mrm_")
    if category not in _REDUCERS:
        msg = f"{node.getCategory()} has no form in glTF"
        raise InexpressibleError(msg)
    return _REDUCERS[category](node)


def _metal_of_index(node: Any) -> Inputs:
    index, extinction = constant_input(node, "ior"), constant_input(node, "extinction")
    if not isinstance(index, np.ndarray) or not isinstance(extinction, np.ndarray):
        msg = "the index of a metal varies"
        raise InexpressibleError(msg)
    reflectance = ((index - 1.0) ** 2 + extinction**2) / ((index + 1.0) ** 2 + extinction**2)
    return _metal(node, Term.constant(reflectance))


def _metal(node: Any, color: Term) -> Inputs:
    return {"base_color": _weighted(node, color), _METALLIC: Term.constant(1.0), **_lobe(node)}


def _schlick_metal(node: Any) -> Inputs:
    _only_reflects(node)
    return _metal(node, term(node, "color0"))


def _diffuse(node: Any) -> Inputs:
    dark = {_WEIGHT: Term.constant(0.0), "roughness": Term.constant(1.0)}
    return {"base_color": _weighted(node, term(node, "color")), _METALLIC: Term.constant(0.0), **dark, **_normal(node)}


def _layer(node: Any) -> Inputs:
    top, base = source(node, "top"), source(node, "base")
    if top is None or base is None:
        msg = "a layer without top or base"
        raise InexpressibleError(msg)
    below = _reduced(base[0])
    category = top[0].getCategory().removeprefix("mrm_")
    if category == "sheen_bsdf":
        return _over(below, "sheen", _sheen(top[0]))
    weight = below[_WEIGHT].value if _WEIGHT in below else None
    if _LAYERS not in below and _same(below[_METALLIC], 0.0) and weight is not None and np.all(weight == 0.0):
        return below | _dielectric(top[0])
    return _over(below, "clearcoat", _coat(top[0]))


def _over(below: Inputs, layer: str, inputs: Inputs) -> Inputs:
    layers = (*below.get(_LAYERS, ()), layer)
    if list(layers) != [name for name in _ORDER if name in layers]:
        msg = f"glTF has no {layer} over {layers[-2]}"
        raise InexpressibleError(msg)
    return below | inputs | {_LAYERS: layers}


def _dielectric(node: Any) -> Inputs:
    """Reflection over a diffuse base: a lobe, or a mixture of an ordinary and a retroreflective one."""
    if node.getCategory() == "mix":
        return _mixed(node, _dielectric)
    _refuse_others(node)
    inputs = _lobe(node)
    weight = term(node, "weight")
    if node.getCategory().endswith("dielectric_bsdf"):
        inputs |= {"ior": Term.constant(scalar(node, "ior")), "specular_color": term(node, "tint")}
    else:
        color, edge = term(node, "color0"), _grey(constant(node, "color90"))
        # glTF's reflectance does not fall toward grazing incidence: nearest to one that does is a constant one.
        edge = max(edge, 0.0 if color.value is None else float(color.value.max())) or 1.0
        inputs |= {"ior": Term.constant(_IOR), "specular_color": color * (1.0 / (_REFLECTANCE * edge))}
        weight = weight * edge
    return inputs | {_WEIGHT: weight}


def _coat(node: Any) -> Inputs:
    """Ordinary reflection over what has reflection of its own."""
    _refuse_others(node)
    if not _same(_amount(node), 0.0):
        msg = "a retroreflective lobe over another: glTF's clear coat is ordinary"
        raise InexpressibleError(msg)
    weight = term(node, "weight")
    if not node.getCategory().endswith("dielectric_bsdf"):
        weight = weight * _grey(constant(node, "color90"))
    inputs = {"clearcoat": weight, "clearcoat_roughness": _roughness(node)}
    normal = _normal(node)
    return inputs | ({"clearcoat_normal": normal["normal"]} if normal else {})


def _sheen(node: Any) -> Inputs:
    if node.getInputValue("mode") not in (None, "conty_kulla"):
        msg = f"sheen of mode {node.getInputValue('mode')}"
        raise InexpressibleError(msg)
    roughness = Term.constant(np.sqrt(scalar(node, "roughness")))
    return {"sheen_color": _weighted(node, term(node, "color")), "sheen_roughness": roughness}


def _mixture(node: Any) -> Inputs:
    return _mixed(node, _reduced)


def _mixed(node: Any, reduced: Callable[[Any], Inputs]) -> Inputs:
    """Two sides that differ in one input alone."""
    sides = source(node, "bg"), source(node, "fg")
    if sides[0] is None or sides[1] is None:
        msg = "a mixture with one side"
        raise InexpressibleError(msg)
    low, high = (reduced(side[0]) for side in sides if side is not None)
    amount = term(node, "mix")
    if all(_METALLIC in side for side in (low, high)) and _same(low[_METALLIC], 0.0) and _same(high[_METALLIC], 1.0):
        # What a metal has no say in.
        high = {**{name: value for name, value in low.items() if name in ("ior", "specular_color", _WEIGHT)}, **high}
    different = [name for name in sorted(low.keys() | high.keys()) if not _equal(low.get(name), high.get(name))]
    if not different:
        return low
    if different not in ([_RETRO], [_METALLIC]):
        msg = f"its sides differ in {', '.join(different)}; in glTF, in metallic or in retroreflectivity alone"
        raise InexpressibleError(msg)
    (name,) = different
    return low | {name: blended(low[name], high[name], amount)}


def _lobe(node: Any) -> Inputs:
    """Roughness, retroreflectivity, thin film and normal of a microfacet lobe."""
    inputs = {"roughness": _roughness(node), _RETRO: _amount(node), **_normal(node)}
    thickness = term(node, "thinfilm_thickness")
    if not _same(thickness, 0.0):
        film = {"iridescence_ior": term(node, "thinfilm_ior"), "iridescence_thickness": thickness}
        inputs |= {"iridescence": Term.constant(1.0), **film}
    return inputs


def _roughness(node: Any) -> Term:
    """The artist's roughness, whose square is the width."""
    upstream = source(node, "roughness")
    category = "" if upstream is None else upstream[0].getCategory()
    if upstream is not None and category == "roughness_anisotropy" and scalar(upstream[0], "anisotropy") == 0.0:
        return term(upstream[0], "roughness")
    width = constant_input(node, "roughness")
    if not isinstance(width, np.ndarray):
        msg = "its roughness varies otherwise than by roughness_anisotropy"
        raise InexpressibleError(msg)
    if width[0] != width[1]:
        msg = "its roughness is anisotropic; glTF has that in gltf_pbr's form alone"
        raise InexpressibleError(msg)
    return Term.constant(np.sqrt(width[0]))


def _amount(node: Any) -> Term:
    if node.getCategory().startswith("mrm_"):
        return term(node, _RETRO)
    flag = constant_input(node, "retroreflective")
    if not isinstance(flag, np.ndarray):
        msg = "its flag retroreflective varies"
        raise InexpressibleError(msg)
    return Term.constant(float(flag))


def _normal(node: Any) -> Inputs:
    upstream = source(node, "normal")
    return {} if upstream is None else {"normal": str(upstream[0].getNamePath())}


def _weighted(node: Any, color: Term) -> Term:
    weight = term(node, "weight")
    if color.value is not None:
        return weight * color.value if weight.value is None else color * weight.value
    if weight.value is None:
        msg = "its weight and its colour are images"
        raise InexpressibleError(msg)
    return color * weight.value


def _refuse_others(node: Any) -> None:
    if node.getCategory().removeprefix("mrm_") not in ("dielectric_bsdf", "generalized_schlick_bsdf"):
        msg = f"{node.getCategory()} as the top of a layer has no form in glTF"
        raise InexpressibleError(msg)
    _only_reflects(node)


def _only_reflects(node: Any) -> None:
    mode = constant_input(node, "scatter_mode")
    if mode != "R":
        msg = f"{node.getCategory()} with scatter_mode {mode} has no form in glTF"
        raise InexpressibleError(msg)


def _grey(color: Array) -> float:
    return float(np.mean(color))


def _same(value: Term, number: float) -> bool:
    return value.value is not None and bool(np.all(value.value == number))


def _equal(first: Any, second: Any) -> bool:
    if not isinstance(first, Term) or not isinstance(second, Term):
        return bool(first == second)
    if first.lookup != second.lookup or (first.lookup is not None and first.channels != second.channels):
        return False
    return np.array_equal(first.offset, second.offset) and np.array_equal(first.scale, second.scale)


_REDUCERS: dict[str, Callable[[Any], Inputs]] = {
    "conductor_bsdf": _metal_of_index,
    "generalized_schlick_bsdf": _schlick_metal,
    "oren_nayar_diffuse_bsdf": _diffuse,
    "burley_diffuse_bsdf": _diffuse,
    "layer": _layer,
    "mix": _mixture,
}
