"""Diffuse closures: broad lobes from the cosines of the directions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import diffuse
from mrm_mtlx.reference import precision
from mrm_mtlx.reference.closures.light import EPSILON, Closure, Light, Mode, cosine, environment, facing, opaque
from mrm_mtlx.reference.models import Model

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


def oren_nayar(
    light: Light, weight: Array, color: Array, roughness: Array, normal: Array, energy_compensation: Array
) -> Closure:
    """`oren_nayar_diffuse_bsdf`; throughput 0."""
    if light.mode is Mode.TRANSMISSION or np.all(weight < EPSILON):
        return opaque(np.zeros((3, 1)))
    n = facing(normal, light.v)
    cos_v = cosine(n, light.v)
    arccos_error = precision.ARCCOS_ERROR if light.part == "reflectance" else 0.0
    if light.mode is Mode.INDIRECT:
        compensated = diffuse.compensated_oren_nayar_albedo(cos_v, roughness, color, arccos_error=arccos_error)
        plain = color * diffuse.oren_nayar_albedo_fit(cos_v, roughness)
        seen = environment(light).irradiance(n) * np.where(energy_compensation, compensated, plain)
    else:
        cos_l, v_l = cosine(n, light.l), cosine(light.l, light.v)
        plain = color * diffuse.oren_nayar(cos_v, cos_l, v_l, roughness)
        compensated = diffuse.compensated_oren_nayar(cos_v, cos_l, v_l, roughness, color, arccos_error=arccos_error)
        seen = np.where(energy_compensation, compensated, plain) * cos_l
    # Cycles has an Oren-Nayar model of its own, neither of these two; without roughness all are Lambert's.
    other = light.model is Model.CLOSURES and np.any(roughness != 0.0)
    foreign = frozenset({"rough oren_nayar_diffuse_bsdf"} if other else ())
    return Closure(np.where(weight >= EPSILON, seen * weight, 0.0), np.zeros((3, 1)), foreign)
