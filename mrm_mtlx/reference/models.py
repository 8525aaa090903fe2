"""The families of targets that the reference tells apart."""

from __future__ import annotations

from enum import Enum


class Model(Enum):
    """Whose microfacet lobes are evaluated: the two families of targets differ by more than rounding.

    `HARDWARE` is what MaterialX writes for its hardware targets, as `closures` says. `CLOSURES` are the
    closures of OSL as renderers have them: both widths in the masking, no multiply scattered light, and nothing from
    below the surface.
    """

    HARDWARE = "hardware"
    CLOSURES = "closures"


# Node definitions of BSDFs that `Model.CLOSURES` has as the same model, or puts together in the same way.
SAME_MODEL = frozenset(
    f"ND_{name}"
    for name in (
        "conductor_bsdf",
        "dielectric_bsdf",
        "generalized_schlick_bsdf",
        "oren_nayar_diffuse_bsdf",
        "layer_bsdf",
        "layer_vdf",
        "mix_bsdf",
        "add_bsdf",
        "multiply_bsdfF",
        "multiply_bsdfC",
        "dot_bsdf",
    )
)

# Node definitions of numbers that MaterialX computes in another way in OSL than on the hardware targets: OSL's own
# `blackbody` integrates the spectrum, where the others fit the chromaticity.
OTHER_NUMBERS = frozenset({"ND_blackbody"})
