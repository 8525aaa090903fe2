"""Microfacet lobes: a distribution, a masking function and a reflectance, seen from v or, retroreflective, from v'.

    f(v, l) = D(m) G2(v, l) F(v.m) / (4 |n.v| |n.l|)        m = h(v, l)        (Walter et al. 2007, eq. 20)
    f_MRM(v, l) = f(v', l)                                  m = b(v, l)        (Portsmouth et al. 2026, eq. 10)

Every occurrence of v is replaced, the Fresnel term's included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from mrm_mtlx.bsdf import albedo, fresnel, ggx, thin_film
from mrm_mtlx.bsdf.blocks import evaluate_in_blocks

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


class Rounding(NamedTuple):
    """Errors given to quantities that cancel, to see how far lower precision may be off; 0 is exact.

    `modulus` is `rounding` of `fresnel.conductor_polarized` and `thin_film.metal_substrate`, `product` that of
    `thin_film.reflectance_xyz`.
    """

    modulus: float = 0.0
    product: float = 0.0


EXACT = Rounding()


class Lobe(Protocol):
    """Anything that reflects light."""

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF for unit directions in the local frame, (..., 3) each, broadcast -> (..., 3), 1/sr, without the cosine.

        Zero where v or l is below the surface.
        """
        ...


@dataclass(frozen=True)
class Conductor:
    """Rough metal.

    Parameters
    ----------
    ior, extinction : array_like
        Real and imaginary part of the index of refraction; colours, >= 0.
    alpha : (array_like, array_like)
        Widths along the tangent and across it, in (0, 1].
    retroreflective
        Whether the lobe is seen from v' instead of v.
    thinfilm_thickness : array_like
        Thickness of a film on the metal [nm]; 0 is none.
    thinfilm_ior : array_like
        Index of refraction of the film, >= 1.
    energy_compensation
        Whether multiply scattered light is given back (Turquin 2019), for the width sqrt(alpha_x alpha_y).

    Raises
    ------
    ValueError
        If a width is not in (0, 1], or a parameter has no shape that broadcasts.

    Examples
    --------
    >>> tape = Conductor(0.2, 3.4, alpha=(0.05, 0.05), retroreflective=True)
    >>> v = np.array([0.6, 0.0, 0.8])
    >>> bool(tape.eval(v, v)[0] > 100 * tape.eval(v, v * [-1, 1, 1])[0])
    True
    """

    ior: ArrayLike
    extinction: ArrayLike
    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    retroreflective: bool = False
    thinfilm_thickness: ArrayLike = 0.0
    thinfilm_ior: ArrayLike = 1.5
    energy_compensation: bool = False

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `Lobe.eval`."""
        return _eval(self, v, l, _conductor, {}, {"ior": self.ior, "extinction": self.extinction})


@dataclass(frozen=True)
class Dielectric:
    """Reflection of a rough interface between dielectrics.

    Parameters
    ----------
    ior : array_like
        Index of refraction inside over outside, a scalar, > 0.
    alpha, retroreflective, thinfilm_thickness, thinfilm_ior, energy_compensation
        As `Conductor`.
    tint : array_like
        Colour that multiplies the reflection.
    scatter_mode
        Only "R", reflection.

    Raises
    ------
    ValueError
        As `Conductor`; also if `scatter_mode` is not "R".
    """

    ior: ArrayLike = 1.5
    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    tint: ArrayLike = 1.0
    scatter_mode: str = "R"
    retroreflective: bool = False
    thinfilm_thickness: ArrayLike = 0.0
    thinfilm_ior: ArrayLike = 1.5
    energy_compensation: bool = False

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `Lobe.eval`."""
        _require_reflection(self.scatter_mode)
        return _eval(self, v, l, _dielectric, {"ior": self.ior}, {"tint": self.tint})


@dataclass(frozen=True)
class GeneralizedSchlick:
    """Rough interface with a reflectance curve given by colours.

    Parameters
    ----------
    color0, color82, color90, exponent : array_like
        See `fresnel.generalized_schlick`; the exponent is a scalar.
    alpha, retroreflective, thinfilm_thickness, thinfilm_ior, energy_compensation
        As `Conductor`.
    scatter_mode
        Only "R", reflection.

    Raises
    ------
    ValueError
        As `Dielectric`.
    """

    color0: ArrayLike = 1.0
    color82: ArrayLike = 1.0
    color90: ArrayLike = 1.0
    exponent: ArrayLike = 5.0
    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    scatter_mode: str = "R"
    retroreflective: bool = False
    thinfilm_thickness: ArrayLike = 0.0
    thinfilm_ior: ArrayLike = 1.5
    energy_compensation: bool = False

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `Lobe.eval`."""
        _require_reflection(self.scatter_mode)
        colors = {"color0": self.color0, "color82": self.color82, "color90": self.color90}
        return _eval(self, v, l, _schlick, {"exponent": self.exponent}, colors)


def conductor_reflectance(
    cos_theta: ArrayLike,
    ior: ArrayLike,
    extinction: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    *,
    rounding: Rounding = EXACT,
) -> Array:
    """Reflectance of a metal under a film where there is one; channel first, shape (3, ...).

    `rounding`, here and below: errors given to what cancels.
    """

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        return thin_film.metal_substrate(cos_film, eta, ior, extinction, rounding=rounding.modulus)

    plain = fresnel.conductor(cos_theta, ior, extinction, rounding=rounding.modulus)
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, rounding)


def dielectric_reflectance(
    cos_theta: ArrayLike, ior: ArrayLike, thickness_nm: ArrayLike, film_ior: ArrayLike, *, rounding: Rounding = EXACT
) -> Array:
    """Reflectance of a dielectric under a film where there is one; channel first, shape (3, ...) or (1, ...)."""

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        return thin_film.metal_substrate(cos_film, eta, ior, np.zeros(()), rounding=rounding.modulus)

    plain = fresnel.dielectric(cos_theta, ior)[None]
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, rounding)


def schlick_reflectance(
    cos_theta: ArrayLike,
    color0: ArrayLike,
    color82: ArrayLike,
    color90: ArrayLike,
    exponent: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    *,
    rounding: Rounding = EXACT,
) -> Array:
    """Reflectance of generalised Schlick under a film where there is one; channel first, shape (3, ...)."""

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        seen = fresnel.generalized_schlick(cos_film, color0, color82, color90, exponent)
        return thin_film.schlick_substrate(seen, eta, color0)

    plain = fresnel.generalized_schlick(cos_theta, color0, color82, color90, exponent)
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, rounding)


def with_film(
    plain: Array,
    cos_theta: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    substrate: Callable[[Array, Array], thin_film.Substrate],
    rounding: Rounding = EXACT,
) -> Array:
    """`plain` reflectance where the film's thickness is 0, that of film and substrate elsewhere; shape (3, ...)."""
    covered = np.asarray(thickness_nm) > 0.0
    if not np.any(covered):
        return plain
    # MaterialX takes the outside as vacuum: a film thinner than that, optically, has index 1.
    eta = np.maximum(np.asarray(film_ior, dtype=float), 1.0)
    under = substrate(thin_film.cosine_in_film(cos_theta, eta), eta)
    filmed = thin_film.to_rgb(thin_film.reflectance_xyz(cos_theta, thickness_nm, eta, under, rounding=rounding.product))
    return np.where(covered, filmed, plain)


# Reflectance times colour of each lobe, as the common evaluation calls it: components first.


def _conductor(cos_theta: Array, *, ior: Array, extinction: Array, thickness: Array, film_ior: Array) -> Array:
    return conductor_reflectance(cos_theta, ior, extinction, thickness, film_ior)


def _dielectric(cos_theta: Array, *, ior: Array, tint: Array, thickness: Array, film_ior: Array) -> Array:
    del tint  # a factor outside the Fresnel term
    return dielectric_reflectance(cos_theta, ior, thickness, film_ior)


def _schlick(
    cos_theta: Array,
    *,
    color0: Array,
    color82: Array,
    color90: Array,
    exponent: Array,
    thickness: Array,
    film_ior: Array,
) -> Array:
    return schlick_reflectance(cos_theta, color0, color82, color90, exponent, thickness, film_ior)


def _require_reflection(scatter_mode: str) -> None:
    if scatter_mode != "R":
        msg = f"scatter_mode must be 'R', the reflected part, got {scatter_mode!r}"
        raise ValueError(msg)


def _eval(
    lobe: Any,
    v: ArrayLike,
    l: ArrayLike,
    reflectance: Callable[..., Array],
    scalars: dict[str, ArrayLike],
    colors: dict[str, ArrayLike],
) -> Array:
    alpha_x, alpha_y = (np.asarray(a, dtype=float) for a in lobe.alpha)
    for alpha in (alpha_x, alpha_y):
        if np.any(~((alpha > 0.0) & (alpha <= 1.0))):
            msg = f"alpha must be in (0, 1], got {alpha.min():g} to {alpha.max():g}; it is the square of a roughness"
            raise ValueError(msg)
    named = {
        "alpha_x": alpha_x,
        "alpha_y": alpha_y,
        "thickness": lobe.thinfilm_thickness,
        "film_ior": lobe.thinfilm_ior,
        **scalars,
    }

    def block(v: Array, l: Array, *, alpha_x: Array, alpha_y: Array, **parameters: Array) -> Array:
        if lobe.retroreflective:
            v = v * np.array([[-1.0], [-1.0], [1.0]])  # v', see vectors.mirror
        return _microfacet(v, l, alpha_x, alpha_y, lambda c: reflectance(c, **parameters), lobe.energy_compensation) * (
            parameters.get("tint", 1.0)
        )

    return evaluate_in_blocks(
        block,
        {name: np.asarray(value, dtype=float) for name, value in named.items()},
        {name: _color(name, value) for name, value in colors.items()},
        (_vectors("v", v), _vectors("l", l)),
    )


def _microfacet(
    v: Array, l: Array, alpha_x: Array, alpha_y: Array, reflectance: Callable[[Array], Array], compensated: bool
) -> Array:
    """Walter et al. 2007, eq. 20, for components first, (3, m) -> (3, m); zero below the surface."""
    above = (v[2] > 0.0) & (l[2] > 0.0)
    cos_v, cos_l = np.where(above, v[2], 1.0), np.where(above, l[2], 1.0)
    # Where there is nothing to evaluate, any facet will do; v + l may vanish there.
    m = np.where(above, v + l, np.array([[0.0], [0.0], [1.0]]))
    m /= np.sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
    cos_m = np.minimum(np.abs(v[0] * m[0] + v[1] * m[1] + v[2] * m[2]), 1.0)
    lambda_v = ggx.smith_lambda(v[0], v[1], cos_v, alpha_x, alpha_y)
    lambda_l = ggx.smith_lambda(l[0], l[1], cos_l, alpha_x, alpha_y)
    lobe = ggx.distribution(m[0], m[1], m[2], alpha_x, alpha_y) * ggx.masking_shadowing(lambda_v, lambda_l)
    lobe *= np.where(above, 0.25, 0.0) / (cos_v * cos_l)
    f = reflectance(cos_m)
    if compensated:
        f = f * albedo.compensation(f, albedo.white_albedo(cos_v, np.sqrt(alpha_x * alpha_y)))
    return f * lobe


def _vectors(name: str, value: ArrayLike) -> Array:
    array = np.asarray(value, dtype=float)
    if array.shape[-1:] != (3,):
        msg = f"{name} must have shape (..., 3), got {array.shape}"
        raise ValueError(msg)
    return array


def _color(name: str, value: ArrayLike) -> Array:
    array = np.asarray(value, dtype=float)
    if array.ndim == 0:
        return np.full(3, array)
    if array.shape[-1] != 3:
        msg = f"{name} must be a scalar or have shape (..., 3), got {array.shape}"
        raise ValueError(msg)
    return array
