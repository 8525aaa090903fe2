"""The microfacet lobes of a metal, of a dielectric, and of reflectance that is given by colours.

Each is a `Microfacet` with parameters and a reflectance of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from mrm_mtlx.bsdf import fresnel
from mrm_mtlx.bsdf.microfacet_lobe import Microfacet
from mrm_mtlx.bsdf.ranges import NOT_NEGATIVE, POSITIVE, Range
from mrm_mtlx.bsdf.reflectance import conductor_reflectance, dielectric_reflectance, schlick_reflectance

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


@dataclass(frozen=True)
class Conductor(Microfacet):
    """Rough metal.

    Parameters
    ----------
    ior, extinction : array_like
        Real and imaginary part of the index of refraction; colours, >= 0.
    alpha, distribution, masking, retroreflective, sampling, thinfilm_thickness, thinfilm_ior, energy_compensation
        See `Microfacet`.

    Examples
    --------
    >>> tape = Conductor(0.2, 3.4, alpha=(0.05, 0.05), retroreflective=True)
    >>> v = np.array([0.6, 0.0, 0.8])
    >>> bool(tape.eval(v, v)[0] > 100 * tape.eval(v, v * [-1, 1, 1])[0])
    True
    """

    ior: ArrayLike
    extinction: ArrayLike

    _COLORS: ClassVar[tuple[str, ...]] = ("ior", "extinction")
    _RANGES: ClassVar[dict[str, Range]] = {**Microfacet._RANGES, "ior": NOT_NEGATIVE, "extinction": NOT_NEGATIVE}

    def _reflectance(self, cos_theta: Array) -> Array:
        return conductor_reflectance(cos_theta, self.ior, self.extinction, self.thinfilm_thickness, self.thinfilm_ior)


@dataclass(frozen=True, kw_only=True)
class Interface(Microfacet):
    """A lobe with an inside: what `Dielectric` and `GeneralizedSchlick` share beyond `Microfacet`.

    Parameters
    ----------
    scatter_mode
        "R", reflection; "T", transmission; "RT", both.
    retroreflective_btdf
        Whether transmission is seen from v' as well. The standards leave it ordinary: at an index near 1 a
        retroreflective one bends what is behind (Portsmouth et al. 2026, Figure 6).

    At an index of exactly 1 transmission is a delta at -v, which has no density: `sample` gives it and `albedo` counts
    it, `eval` and `pdf` are 0.
    """

    scatter_mode: str = "R"  # type: ignore[misc]  # of the class where there is no choice, of the object here
    retroreflective_btdf: bool = False  # type: ignore[misc]
    two_sided: ClassVar[bool] = True


@dataclass(frozen=True)
class Dielectric(Interface):
    """Rough interface between dielectrics.

    Parameters
    ----------
    ior : array_like
        Index of refraction inside over outside, a scalar, > 0.
    tint : array_like
        Colour that multiplies reflection and transmission.
    scatter_mode, retroreflective_btdf
        See `Interface`.
    alpha, distribution, masking, retroreflective, sampling, thinfilm_thickness, thinfilm_ior, energy_compensation
        See `Microfacet`.

    Examples
    --------
    >>> glass = Dielectric(1.5, alpha=(0.3, 0.3), scatter_mode="RT")
    >>> from_inside, from_outside = glass.eval([0, 0, -1.0], [0.3, 0, 0.954]), glass.eval([0.3, 0, 0.954], [0, 0, -1.0])
    >>> bool(np.allclose(from_inside, 1.5**2 * from_outside))  # Portsmouth et al. 2026, eq. 11
    True
    """

    ior: ArrayLike = 1.5
    tint: ArrayLike = 1.0

    _SCALARS: ClassVar[tuple[str, ...]] = (*Interface._SCALARS, "ior")
    _COLORS: ClassVar[tuple[str, ...]] = ("tint",)
    _RANGES: ClassVar[dict[str, Range]] = {**Interface._RANGES, "ior": POSITIVE, "tint": NOT_NEGATIVE}

    def _index(self) -> Array:
        return np.asarray(self.ior)

    def _tinted(self, f: Array | float) -> Array:
        return np.asarray(f * np.asarray(self.tint))

    def _reflectance(self, cos_theta: Array) -> Array:
        return dielectric_reflectance(cos_theta, self.ior, self.thinfilm_thickness, self.thinfilm_ior)


@dataclass(frozen=True)
class GeneralizedSchlick(Interface):
    """Rough interface with a reflectance curve given by colours.

    Its index, which transmission needs, is the one whose reflectance at normal incidence is the mean of `color0`.

    Parameters
    ----------
    color0, color82, color90, exponent : array_like
        See `fresnel.generalized_schlick`; the exponent is a scalar.
    scatter_mode, retroreflective_btdf
        See `Interface`.
    alpha, distribution, masking, retroreflective, sampling, thinfilm_thickness, thinfilm_ior, energy_compensation
        See `Microfacet`.
    """

    color0: ArrayLike = 1.0
    color82: ArrayLike = 1.0
    color90: ArrayLike = 1.0
    exponent: ArrayLike = 5.0

    _SCALARS: ClassVar[tuple[str, ...]] = (*Interface._SCALARS, "exponent")
    _COLORS: ClassVar[tuple[str, ...]] = ("color0", "color82", "color90")
    _RANGES: ClassVar[dict[str, Range]] = {
        **Interface._RANGES,
        **dict.fromkeys(_COLORS, NOT_NEGATIVE),
        "exponent": NOT_NEGATIVE,
    }

    def _index(self) -> Array:
        return fresnel.schlick_ior(np.mean(np.asarray(self.color0), axis=0))

    def _reflectance(self, cos_theta: Array) -> Array:
        return schlick_reflectance(
            cos_theta,
            self.color0,
            self.color82,
            self.color90,
            self.exponent,
            self.thinfilm_thickness,
            self.thinfilm_ior,
        )
