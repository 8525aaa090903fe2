"""Reflectance of a facet, with a thin film where there is one; channels first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel, thin_film
from mrm_mtlx.bsdf.intermediates import EXACT

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.intermediates import Intermediates


def conductor_reflectance(
    cos_theta: ArrayLike,
    ior: ArrayLike,
    extinction: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    *,
    intermediates: Intermediates = EXACT,
) -> Array:
    """Reflectance of a metal under a film where there is one; channel first, shape (3, ...)."""

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        return thin_film.metal_substrate(cos_film, eta, ior, extinction, intermediates=intermediates)

    plain = fresnel.conductor(cos_theta, ior, extinction, intermediates=intermediates)
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, intermediates)


def dielectric_reflectance(
    cos_theta: ArrayLike,
    ior: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    *,
    intermediates: Intermediates = EXACT,
) -> Array:
    """Reflectance of a dielectric under a film where there is one; channel first, shape (3, ...) or (1, ...)."""

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        return thin_film.metal_substrate(cos_film, eta, ior, np.zeros(()), intermediates=intermediates)

    plain = fresnel.dielectric(cos_theta, ior)[None]
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, intermediates)


def schlick_reflectance(
    cos_theta: ArrayLike,
    color0: ArrayLike,
    color82: ArrayLike,
    color90: ArrayLike,
    exponent: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    *,
    intermediates: Intermediates = EXACT,
) -> Array:
    """Reflectance of generalised Schlick under a film where there is one; channel first, shape (3, ...)."""

    def substrate(cos_film: Array, eta: Array) -> thin_film.Substrate:
        seen = fresnel.generalized_schlick(cos_film, color0, color82, color90, exponent)
        return thin_film.schlick_substrate(seen, eta, color0)

    plain = fresnel.generalized_schlick(cos_theta, color0, color82, color90, exponent)
    return with_film(plain, cos_theta, thickness_nm, film_ior, substrate, intermediates)


def with_film(
    plain: Array,
    cos_theta: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    substrate: Callable[[Array, Array], thin_film.Substrate],
    intermediates: Intermediates = EXACT,
) -> Array:
    """`plain` reflectance where the film's thickness is 0, that of film and substrate elsewhere; shape (3, ...)."""
    covered = np.asarray(thickness_nm) > 0.0
    if not np.any(covered):
        return plain
    # MaterialX takes the outside as vacuum: a film thinner than that, optically, has index 1.
    eta = np.maximum(np.asarray(film_ior, dtype=float), 1.0)
    under = substrate(thin_film.cosine_in_film(cos_theta, eta), eta)
    filmed = thin_film.to_rgb(
        thin_film.reflectance_xyz(cos_theta, thickness_nm, eta, under, intermediates=intermediates)
    )
    return np.where(covered, filmed, plain)
