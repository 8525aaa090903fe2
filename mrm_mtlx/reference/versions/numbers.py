"""The numbers that a version of MaterialX gives the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.reference.versions.fits import (
        BurleyAlbedo,
        ClothCosine,
        FibreAlbedo,
        MicrofacetAlbedo,
        OrenNayarAlbedo,
    )


@dataclass(frozen=True)
class Numbers:
    """Fits of a version's shaders, one by one; the forms are those of `fits`."""

    microfacet_albedo: MicrofacetAlbedo
    fibre_albedo: FibreAlbedo
    cloth_cosine: ClothCosine
    oren_nayar_albedo: OrenNayarAlbedo
    burley_albedo: BurleyAlbedo
