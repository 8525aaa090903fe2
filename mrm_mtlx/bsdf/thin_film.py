"""Interference in a thin film over an interface, in the form that renderers have it.

Airy's series over the film, integrated against Gaussian fits of the colour-matching functions in the Fourier domain
(Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence"). The
series ends after two terms and the colour is clamped to [0, 1]: MaterialX defines its nodes so, and a lobe with a film
is to be the same in both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel
from mrm_mtlx.bsdf.intermediates import EXACT

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.intermediates import Intermediates

# Terms of Airy's series beyond the constant one.
SERIES_TERMS = 2

# Gaussian fits of the colour-matching functions (Belcour and Barla 2017, supplemental code): amplitude, position and
# variance for X, Y, Z, and X's second lobe. Positions in 1/m, for phases in m.
_AMPLITUDE = np.array([5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14])
_POSITION = np.array([1.6810e06, 1.7953e06, 2.2084e06, 2.2399e06])
_VARIANCE = np.array([4.3278e09, 9.3046e09, 6.6121e09, 4.5282e09])
_NORMALISATION = 1.0685e-7

# CIE XYZ to linear RGB for illuminant E.
XYZ_TO_RGB = np.array(
    [
        [2.3706743, -0.9000405, -0.4706338],
        [-0.5138850, 1.4253036, 0.0885814],
        [0.0052982, -0.0146949, 1.0093968],
    ]
)


@dataclass(frozen=True)
class Substrate:
    """Interface under the film, per colour channel; arrays with the channel first, shape (3, ...).

    Attributes
    ----------
    cos_theta
        Cosine inside the film at which the substrate is seen, shape (...).
    parallel, perpendicular
        Reflectances of the film-substrate interface.
    phase_parallel, phase_perpendicular
        Phase shifts on reflection there [rad].
    """

    parallel: Array
    perpendicular: Array
    phase_parallel: Array
    phase_perpendicular: Array


def cosine_in_film(cos_theta: ArrayLike, film_ior: ArrayLike) -> Array:
    """Cosine of the refracted ray in the film (Snell), shape (...)."""
    sin2 = 1.0 - np.square(np.asarray(cos_theta, dtype=float))
    return np.asarray(np.sqrt(1.0 - sin2 / np.square(film_ior)))


def metal_substrate(
    cos_film: ArrayLike,
    film_ior: ArrayLike,
    ior: ArrayLike,
    extinction: ArrayLike,
    *,
    intermediates: Intermediates = EXACT,
) -> Substrate:
    """A metal or, with extinction 0, a dielectric under the film; `ior` and `extinction` relative to the outside.

    Phases by Belcour and Barla 2017 (from Born and Wolf, section 14.4.1), with U + iV the root of the complex index
    squared minus (film_ior sin)^2. `intermediates` have its modulus, and that of `fresnel.conductor_polarized`.
    """
    c, eta1 = np.asarray(cos_film, dtype=float), np.asarray(film_ior, dtype=float)
    eta, kappa = np.asarray(ior, dtype=float), np.asarray(extinction, dtype=float)
    parallel, perpendicular = fresnel.conductor_polarized(c, eta / eta1, kappa / eta1, intermediates=intermediates)
    real = eta**2 - kappa**2 - eta1**2 * (1.0 - c * c)
    modulus = intermediates.modulus(np.hypot(real, 2.0 * eta * kappa))
    u = np.sqrt(np.maximum(0.5 * (modulus + real), 0.0))
    v = np.sqrt(np.maximum(0.5 * (modulus - real), 0.0))
    phase_s = np.arctan2(2.0 * eta1 * v * c, u * u + v * v - np.square(eta1 * c))
    phase_p = np.arctan2(
        2.0 * eta1 * c * (2.0 * eta * kappa * u - (eta**2 - kappa**2) * v),
        np.square((eta**2 + kappa**2) * c) - eta1**2 * (u * u + v * v),
    )
    return Substrate(parallel, perpendicular, phase_p, phase_s)


def schlick_substrate(reflectance: ArrayLike, film_ior: ArrayLike, color0: ArrayLike) -> Substrate:
    """A substrate given by its reflectance in the film and its `color0`.

    MaterialX gives half of the reflectance to each polarisation, so that a film over generalised Schlick is darker than
    one over the same dielectric; kept as its closures have it. The phase is 0 or pi, by which side is denser.
    """
    half = 0.5 * np.asarray(reflectance, dtype=float)
    phase = np.where(fresnel.schlick_ior(color0) < np.asarray(film_ior), np.pi, 0.0)
    return Substrate(half, half, phase, phase)


def reflectance_xyz(
    cos_theta: ArrayLike,
    thickness_nm: ArrayLike,
    film_ior: ArrayLike,
    substrate: Substrate,
    *,
    intermediates: Intermediates = EXACT,
) -> Array:
    """Reflectance of film and substrate in CIE XYZ for illuminant E, shape (3, ...), unclamped.

    Parameters
    ----------
    cos_theta : array_like, shape (...)
        Cosine of incidence outside, in [0, 1].
    thickness_nm : array_like, shape (...)
        Film thickness [nm], > 0.
    film_ior : array_like, shape (...)
        Index of refraction of the film relative to the outside, >= 1.
    substrate
        What lies under the film.
    intermediates
        Have the sum up to the first bounce in the film.
    """
    c, eta = np.asarray(cos_theta, dtype=float), np.asarray(film_ior, dtype=float)
    # Optical path difference of neighbouring terms [m].
    path = 2.0 * eta * cosine_in_film(c, eta) * np.asarray(thickness_nm) * 1e-9
    top_parallel, top_perpendicular = fresnel.dielectric_polarized(c, eta)
    brewster = 1.0 / np.sqrt(1.0 + eta * eta)  # cos(atan(eta))
    phase_top_parallel = np.where(c < brewster, 0.0, np.pi)
    omega = 2.0 * np.pi * path
    envelopes = _envelopes(omega)

    def reflected(top: Array, base: Array, phase: Array) -> Array:
        return _airy(top, base, list(zip(envelopes, _cosines(omega, phase), strict=False)), intermediates)

    parallel = reflected(top_parallel, substrate.parallel, phase_top_parallel + substrate.phase_parallel)
    perpendicular = reflected(top_perpendicular, substrate.perpendicular, np.pi + substrate.phase_perpendicular)
    return np.asarray(0.5 * (parallel + perpendicular))


def to_rgb(xyz: Array) -> Array:
    """Linear RGB of an XYZ reflectance, shape (3, ...), clamped to [0, 1] as MaterialX does."""
    return np.asarray(np.clip(np.einsum("ij,j...->i...", XYZ_TO_RGB, xyz), 0.0, 1.0))


def _airy(top: Array, base: Array, series: Sequence[tuple[Array, Array]], intermediates: Intermediates) -> Array:
    """Sum over the reflections in the film for one polarisation (Belcour and Barla 2017, eq. 10)."""
    transmitted = 1.0 - top
    direct = transmitted**2 * base / (1.0 - top * base)
    amplitude = direct - transmitted
    round_trip = np.sqrt(np.maximum(top * base, 0.0))
    total = intermediates.first_bounce(top + direct, amplitude, top, base)
    for envelope, cosine in series:
        amplitude = amplitude * round_trip
        total = total + amplitude * 2.0 * _sensitivity(envelope, cosine)
    return np.asarray(total)


def _sensitivity(envelope: Array, cosine: Array) -> Array:
    """Fourier transform of the colour-matching functions, shape (3, ...), from its four lobes."""
    lobes = envelope * cosine
    lobes[0] += lobes[3]
    return np.asarray(lobes[:3])


def _envelopes(omega: Array) -> list[Array]:
    """Envelopes of the transform's lobes at multiples of a path difference, one per term of the series, (4, ...)."""
    variance = _lobes(_VARIANCE, omega)
    scale = _lobes(_AMPLITUDE * np.sqrt(2.0 * np.pi * _VARIANCE) / _NORMALISATION, omega)
    return [scale * np.exp(-variance * np.square(term * omega)) for term in range(1, SERIES_TERMS + 1)]


def _cosines(omega: Array, phase: Array) -> Iterator[Array]:
    """Cosines of the transform's lobes at multiples of a path difference and phase, from the first on, (4, ...).

    Those of multiples come from that of the angle, cos(k x) = 2 cos(x) cos((k - 1) x) - cos((k - 2) x): NumPy's own
    takes longer than all the rest.
    """
    angle = _lobes(_POSITION, omega) * omega
    shape = np.broadcast_shapes((3, *angle.shape[1:]), np.shape(phase))
    once = np.cos(angle + np.broadcast_to(phase, shape)[[0, 1, 2, 0]])  # X has two lobes
    before, cosine = np.ones(()), once
    while True:
        yield cosine
        before, cosine = cosine, 2.0 * once * cosine - before


def _lobes(numbers: Array, omega: Array) -> Array:
    """Numbers of the transform's lobes, to be broadcast over path differences."""
    return numbers.reshape(-1, *(1,) * np.ndim(omega))
