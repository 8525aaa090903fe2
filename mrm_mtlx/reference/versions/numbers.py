"""The numbers and forms that a version of MaterialX gives the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.reference.versions.combination import Throughputs
    from mrm_mtlx.reference.versions.fits import (
        BurleyAlbedo,
        ClothCosine,
        FibreAlbedo,
        MicrofacetAlbedo,
        OrenNayarAlbedo,
    )
    from mrm_mtlx.reference.versions.fresnel_average import MeanReflectance


@dataclass(frozen=True)
class Numbers:
    """What a version's shaders have.

    Attributes
    ----------
    microfacet_albedo, fibre_albedo, cloth_cosine, oren_nayar_albedo, burley_albedo
        Its fits; the forms are those of `fits`.
    mean_reflectance
        The form by which its energy compensation has a colour.
    throughputs
        Of BSDFs that are put together (`Deviation.COMBINED_THROUGHPUT`, where they are not the specified ones).
    hair_rest_azimuthal
        Azimuthal constant of hair's rest lobe as the code has it (`Deviation.HAIR_CONSTANTS`).
    blackbody_lowest
        Lowest temperature of `blackbody` [K]; below, it stays.
    deviations
        The known deviations that the version has.
    """

    microfacet_albedo: MicrofacetAlbedo
    fibre_albedo: FibreAlbedo
    cloth_cosine: ClothCosine
    oren_nayar_albedo: OrenNayarAlbedo
    burley_albedo: BurleyAlbedo
    mean_reflectance: MeanReflectance
    throughputs: Throughputs
    hair_rest_azimuthal: float
    blackbody_lowest: float
    deviations: frozenset[Deviation]
