"""Nodes of the physically based library: BSDFs and VDFs, how they are put together, and surface shaders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.library.surface_models import FLAG
from mrm_mtlx.reference import closures
from mrm_mtlx.reference.closures import Facets
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.models import NOTHING, Contents, Feature
from mrm_mtlx.reference.nodes.registry import ShaderValue, node
from mrm_mtlx.reference.versions.combination import SPECIFIED

if TYPE_CHECKING:
    from mrm_mtlx.reference.nodes.registry import Inputs, Value
    from mrm_mtlx.reference.versions.combination import Throughputs


def _facets(inputs: Inputs, *, scatters: bool) -> Facets:
    width = inputs.array("roughness")  # a BSDF node's roughness is the microfacet width
    facets = Facets(
        weight=inputs.array("weight"),
        alpha_x=width[0],
        alpha_y=width[1],
        retroreflective=inputs.array(FLAG) if inputs.is_defined(FLAG) else np.asarray(False),
        thinfilm_thickness=inputs.array("thinfilm_thickness"),
        thinfilm_ior=inputs.array("thinfilm_ior"),
        normal=inputs.array("normal"),
        tangent=inputs.array("tangent"),
        scatter_mode=inputs.text("scatter_mode") if scatters else "R",
    )
    inputs.note(facets)
    return facets


@node("ND_conductor_bsdf")
def _conductor(inputs: Inputs) -> Value:
    facets = _facets(inputs, scatters=False)
    return closures.conductor(inputs.light, facets, inputs.array("ior"), inputs.array("extinction"))


@node("ND_dielectric_bsdf")
def _dielectric(inputs: Inputs) -> Value:
    facets = _facets(inputs, scatters=True)
    return closures.dielectric(inputs.light, facets, inputs.array("tint"), inputs.array("ior"))


@node("ND_generalized_schlick_bsdf")
def _generalized_schlick(inputs: Inputs) -> Value:
    facets = _facets(inputs, scatters=True)
    color0, color82, color90 = (inputs.array(name) for name in ("color0", "color82", "color90"))
    return closures.generalized_schlick(inputs.light, facets, color0, color82, color90, inputs.array("exponent"))


@node("ND_oren_nayar_diffuse_bsdf")
def _oren_nayar(inputs: Inputs) -> Value:
    names = ("weight", "color", "roughness", "normal", "energy_compensation")
    return closures.oren_nayar(inputs.light, *(inputs.array(name) for name in names))


@node("ND_burley_diffuse_bsdf")
def _burley(inputs: Inputs) -> Value:
    return closures.burley(inputs.light, *(inputs.array(name) for name in ("weight", "color", "roughness", "normal")))


@node("ND_translucent_bsdf")
def _translucent(inputs: Inputs) -> Value:
    return closures.translucent(inputs.light, *(inputs.array(name) for name in ("weight", "color", "normal")))


@node("ND_subsurface_bsdf")
def _subsurface(inputs: Inputs) -> Value:
    """The anisotropy is ignored by the hardware targets."""
    return closures.subsurface(inputs.light, *(inputs.array(name) for name in ("weight", "color", "radius", "normal")))


@node("ND_sheen_bsdf")
def _sheen(inputs: Inputs) -> Value:
    numbers = (inputs.array(name) for name in ("weight", "color", "roughness", "normal"))
    return closures.sheen(inputs.light, inputs.text("mode"), *numbers)


@node("ND_chiang_hair_bsdf")
def _hair(inputs: Inputs) -> Value:
    fibre = closures.Fibre(
        tint_r=inputs.array("tint_R"),
        tint_tt=inputs.array("tint_TT"),
        tint_trt=inputs.array("tint_TRT"),
        ior=inputs.array("ior"),
        roughness_r=inputs.array("roughness_R"),
        roughness_tt=inputs.array("roughness_TT"),
        roughness_trt=inputs.array("roughness_TRT"),
        cuticle_angle=inputs.array("cuticle_angle"),
        absorption=inputs.array("absorption_coefficient"),
        normal=inputs.array("normal"),
        direction=inputs.array("curve_direction"),
        as_written=inputs.deviates(Deviation.HAIR_CONSTANTS),
    )
    return closures.chiang_hair(inputs.light, fibre)


@node("ND_anisotropic_vdf")
def _medium(inputs: Inputs) -> Value:
    """The hardware targets ignore how much it scatters, and in which directions."""
    if inputs.deviates(Deviation.IGNORED_MEDIA):
        return closures.nothing()
    return closures.absorbing(inputs.light, inputs.array("absorption"))


@node("ND_layer_bsdf")
def _layer(inputs: Inputs) -> Value:
    return closures.layer(inputs.closure("top"), inputs.closure("base"), inputs.light.model, _throughputs(inputs))


@node("ND_layer_vdf")
def _layer_medium(inputs: Inputs) -> Value:
    top, medium = inputs.closure("top"), inputs.closure("base")
    return closures.layer_medium(top, medium, inputs.light.model, _throughputs(inputs))


@node("ND_mix_bsdf")
def _mix(inputs: Inputs) -> Value:
    front, back, amount = inputs.closure("fg"), inputs.closure("bg"), inputs.array("mix")
    mixed = closures.mix(front, back, amount)
    if not inputs.is_connected("mix"):
        return mixed
    weighted = inputs.is_weighted("fg"), inputs.is_weighted("bg")
    multiplied = closures.premultiplied_mix(front, back, amount, weighted)
    if np.all((amount >= 0.0) & (amount <= 1.0)) and np.allclose(mixed.throughput, multiplied.throughput):
        return mixed
    return multiplied if inputs.deviates(Deviation.PREMULTIPLIED_MIX) else mixed


@node("ND_add_bsdf")
def _add(inputs: Inputs) -> Value:
    return closures.add(inputs.closure("in1"), inputs.closure("in2"), _throughputs(inputs))


@node("ND_multiply_bsdfF", "ND_multiply_bsdfC")
def _multiply(inputs: Inputs) -> Value:
    return closures.multiply(inputs.closure("in1"), inputs.array("in2"), _throughputs(inputs))


def _throughputs(inputs: Inputs) -> Throughputs:
    """How throughputs are combined: as specified, or as the version's shaders do where that is asked for."""
    return inputs.light.numbers.throughputs if inputs.deviates(Deviation.COMBINED_THROUGHPUT) else SPECIFIED


@node("ND_surface")
def _surface(inputs: Inputs) -> Value:
    """Light of all modes, and emission, each times the opacity; the rest of what is behind shows through."""
    opacity = inputs.array("opacity")
    color = inputs.emission("edf")
    contents = Contents(features=frozenset({Feature.EMISSION})) if np.any(color != 0.0) else NOTHING
    for light in inputs.lights:
        closure = inputs.under(light).closure("bsdf")
        color, contents = color + closure.response, contents | closure.contents
    return ShaderValue(color * opacity, np.ones((3, 1)) * (1.0 - opacity), contents)


@node("ND_surface_unlit")
def _surface_unlit(inputs: Inputs) -> Value:
    opacity = inputs.array("opacity")
    through = inputs.array("transmission") * inputs.array("transmission_color")
    return ShaderValue(
        inputs.array("emission") * inputs.array("emission_color") * opacity, 1.0 - opacity + through * opacity
    )


@node("ND_surfacematerial")
def _material(inputs: Inputs) -> Value:
    """The front of the surface; displacement, which is done before it is shaded, is left out."""
    return inputs.shader("surfaceshader")


@node("ND_mix_surfaceshader")
def _mix_shader(inputs: Inputs) -> Value:
    amount, front, back = inputs.array("mix"), inputs.shader("fg"), inputs.shader("bg")
    return ShaderValue(
        back.color * (1.0 - amount) + front.color * amount,
        back.transparency * (1.0 - amount) + front.transparency * amount,
        back.contents | front.contents,
    )
