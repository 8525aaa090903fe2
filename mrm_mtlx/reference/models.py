"""The families of targets that the reference tells apart, and what of a surface they have as different models."""

from __future__ import annotations

from dataclasses import dataclass
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


class LobeKind(Enum):
    """Kinds of microfacet lobes: OSL's renderers have each as the same model, not both in one surface."""

    ORDINARY = "ordinary"
    RETROREFLECTIVE = "retroreflective"


class Feature(Enum):
    """A feature of a surface that OSL's renderers have as another model; the value is its name in messages."""

    COLOR82 = "color82"
    EMISSION = "emission"
    LAYER = "layer"
    ROUGH_DIFFUSE = "rough oren_nayar_diffuse_bsdf"
    THIN_FILM = "thin film"
    TRANSMISSION = "transmission"


@dataclass(frozen=True)
class Contents:
    """Contents of a response, as far as `Model.CLOSURES` has to know them; nothing for `Model.HARDWARE`.

    Attributes
    ----------
    lobes
        Kinds of its microfacet lobes.
    features
        Features that are another model there, for which the response is no reference.
    nodes
        Categories of nodes that are another model as a whole.
    """

    lobes: frozenset[LobeKind] = frozenset()
    features: frozenset[Feature] = frozenset()
    nodes: frozenset[str] = frozenset()

    def __or__(self, other: Contents) -> Contents:
        """The contents of both."""
        return Contents(self.lobes | other.lobes, self.features | other.features, self.nodes | other.nodes)

    @property
    def unsupported(self) -> list[str]:
        """Names of all that is another model, sorted."""
        return sorted({feature.value for feature in self.features} | self.nodes)


NOTHING = Contents()
