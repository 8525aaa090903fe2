"""Rough diffuse reflection (Oren and Nayar; Burley), in 1/sr without the cosine.

Directions enter by their cosines alone: n.v, n.l, l.v and l.h, each in (0, 1].
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.intermediates import EXACT

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.intermediates import Intermediates

# Constants of Fujii's variant: 1/2 - 2/(3 pi) and 2/3 - 28/(15 pi).
_FUJII_1 = 0.5 - 2.0 / (3.0 * np.pi)
_FUJII_2 = 2.0 / 3.0 - 28.0 / (15.0 * np.pi)
_EPSILON = 1e-8


def oren_nayar(cos_v: ArrayLike, cos_l: ArrayLike, v_l: ArrayLike, roughness: ArrayLike) -> Array:
    """Qualitative model (Oren and Nayar 1994, eq. 30) of unit albedo, shape (...); `roughness` is sigma.

    At roughness 0 it is 1/pi.
    """
    cos_v, cos_l = np.asarray(cos_v, dtype=float), np.asarray(cos_l, dtype=float)
    s = np.asarray(v_l) - cos_l * cos_v
    t = np.where(s > 0.0, s / np.maximum(cos_l, cos_v), 0.0)
    squared = np.square(np.asarray(roughness, dtype=float))
    a = 1.0 - 0.5 * squared / (squared + 0.33)
    b = 0.45 * squared / (squared + 0.09)
    return np.asarray((a + b * t) / np.pi)


def compensated_oren_nayar(
    cos_v: ArrayLike,
    cos_l: ArrayLike,
    v_l: ArrayLike,
    roughness: ArrayLike,
    color: ArrayLike,
    *,
    intermediates: Intermediates = EXACT,
) -> Array:
    """Energy-preserving model (EON: Portsmouth, Kutz and Hill 2025), shape of `color` with the samples.

    Fujii's single-scattering lobe plus a multiple-scattering lobe from its albedo, whose `intermediates` they are.
    """
    cos_v, cos_l, color = (np.asarray(x, dtype=float) for x in (cos_v, cos_l, color))
    r = np.asarray(roughness, dtype=float)
    s = np.asarray(v_l) - cos_l * cos_v
    t = np.where(s > 0.0, s / np.maximum(cos_l, cos_v), s)
    a = 1.0 / (1.0 + _FUJII_1 * r)
    single = color * a * (1.0 + r * t)
    mean = fujii_mean_albedo(r)
    lost_v, lost_l = (
        np.maximum(1.0 - fujii_albedo(c, r, intermediates=intermediates), _EPSILON) for c in (cos_v, cos_l)
    )
    tint = _multiple_scattering_tint(color, mean)
    return np.asarray((single + tint * lost_v * lost_l / np.maximum(1.0 - mean, _EPSILON)) / np.pi)


def compensated_oren_nayar_albedo(
    cos_v: ArrayLike, roughness: ArrayLike, color: ArrayLike, *, intermediates: Intermediates = EXACT
) -> Array:
    """Directional albedo of `compensated_oren_nayar`, shape of `color` with the samples.

    `color` for the singly scattered part, its multiply scattered tint for the rest.
    """
    color, r = np.asarray(color, dtype=float), np.asarray(roughness, dtype=float)
    single = fujii_albedo(cos_v, r, intermediates=intermediates)
    return np.asarray(_multiple_scattering_tint(color, fujii_mean_albedo(r)) * (1.0 - single) + color * single)


def fujii_mean_albedo(roughness: ArrayLike) -> Array:
    """Mean of `fujii_albedo` over the hemisphere (Portsmouth et al. 2025), shape (...)."""
    r = np.asarray(roughness, dtype=float)
    return np.asarray((1.0 + _FUJII_2 * r) / (1.0 + _FUJII_1 * r))


def _multiple_scattering_tint(color: Array, mean: Array) -> Array:
    return np.asarray(color * color * mean / (1.0 - color * np.maximum(1.0 - mean, 0.0)))


def fujii_albedo(cos_theta: ArrayLike, roughness: ArrayLike, *, intermediates: Intermediates = EXACT) -> Array:
    """Directional albedo of Fujii's lobe of unit colour (Portsmouth et al. 2025, eq. 14), shape (...).

    `intermediates` have the arc cosine, which hardware evaluates coarsely.
    """
    c, r = np.asarray(cos_theta, dtype=float), np.asarray(roughness, dtype=float)
    a = 1.0 / (1.0 + _FUJII_1 * r)
    sine = np.sqrt(np.maximum(1.0 - c * c, 0.0))
    angle = intermediates.arc_cosine(np.arccos(np.clip(c, -1.0, 1.0)))
    g = sine * (angle - sine * c) + 2.0 * (sine / c * (1.0 - sine**3) - sine) / 3.0
    return np.asarray(a * (1.0 + r * g / np.pi))


def burley(cos_v: ArrayLike, cos_l: ArrayLike, l_h: ArrayLike, roughness: ArrayLike) -> Array:
    """Diffuse model of unit colour (Burley 2012, section 5.3), shape (...).

        f = (1 + (F90 - 1) (1 - n.l)^5) (1 + (F90 - 1) (1 - n.v)^5) / pi        F90 = 1/2 + 2 roughness (l.h)^2

    Reflects more than it receives at grazing incidence of a rough surface, as published.

    Examples
    --------
    >>> round(float(burley(1.0, 1.0, 1.0, 0.5) * np.pi), 12)
    1.0
    """
    rise = 2.0 * np.asarray(roughness, dtype=float) * np.square(np.asarray(l_h, dtype=float)) - 0.5
    towards_l, towards_v = (1.0 + rise * (1.0 - np.asarray(c, dtype=float)) ** 5 for c in (cos_l, cos_v))
    return np.asarray(towards_l * towards_v / np.pi)
