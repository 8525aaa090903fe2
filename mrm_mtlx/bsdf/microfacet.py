"""Reflection and transmission by facets, their densities and samples, for views from above; components first, (3, m).

    f_r(v, l) = D G2 F / (4 |n.v| |n.l|)                                            m = h_r
    f_t(v, l) = |v.m| |l.m| eta_v^2 D G2 (1 - F) / (|n.v| |n.l| (eta_v v.m + eta_l l.m)^2)    m = h_t

(Walter et al. 2007, eq. 20 and 21; Portsmouth et al. 2026, eq. 1 and 2.) Both are densities of radiance: the factor
eta_v^2 is in f_t. A lobe that is seen from v' calls these with v' for v.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import ggx
from mrm_mtlx.bsdf.masking import Smith

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.masking import Masking, Rough

_UP = np.array([[0.0], [0.0], [1.0]])
_DOWNWARDS = np.array([[1.0], [1.0], [-1.0]])


@dataclass(frozen=True)
class Facets:
    """A rough surface: its facets, and how they are hidden."""

    rough: Rough
    masking: Masking
    bounded: bool = False

    def density(self, m: Array) -> Array:
        """D(m), shape (m,)."""
        return self.rough.density(m)

    def masking_shadowing(self, v: Array, l: Array, m: Array, *, transmitted: bool = False) -> Array:
        """G2(v, l, m), shape (m,)."""
        return self.masking.masking_shadowing(self.rough, v, l, m, transmitted=transmitted)

    def visible(self, v: Array, m: Array, cos_m: Array) -> Array:
        """Density of the facets that v sees, D_v(m) = G1(v, m) <v.m> D(m) / (n.v) [1/sr], shape (m,)."""
        return np.asarray(self.masking.masking(self.rough, v, m) * cos_m * self.density(m) / v[2])

    def sample(self, v: Array, u: Array) -> tuple[Array, Array]:
        """Facets with density `visible`, (3, m), and what is left of u[2], uniform again."""
        return self.masking.sample_visible(self.rough, v, u)

    def points(self, v: Array, u: Array) -> tuple[Array, Array]:
        """Facets over the square of u[0] and u[1], (3, m), and their weight: together they have density `visible`."""
        return self.masking.points(self.rough, v, u)

    def unhidden(self, v: Array, l: Array, m: Array) -> Array:
        """Share of the facets seen from v that l reaches too, G2 / G1, shape (m,); 0 where l is the zero vector."""
        scattered, transmitted = l[2] != 0.0, l[2] < 0.0
        g1 = self.masking.masking(self.rough, v, m)
        up = np.where(scattered, np.where(transmitted, l * _DOWNWARDS, l), _UP)
        g2 = np.where(
            transmitted,
            self.masking_shadowing(v, up, m, transmitted=True),
            self.masking_shadowing(v, up, m),
        )
        return np.where(scattered & (g1 > 0.0), g2 / np.where(g1 > 0.0, g1, 1.0), 0.0)

    @property
    def has_bound(self) -> bool:
        """True if reflections are sampled on the bounded cap, which is known for GGX with Smith masking."""
        return self.bounded and self.rough.distribution is ggx and isinstance(self.masking, Smith)


@dataclass(frozen=True)
class Geometry:
    """Pairs of directions: which of them count, their facets and cosines. Where one does not count, any facet."""

    counts: Array
    v: Array
    l: Array
    m: Array
    v_m: Array
    l_m: Array
    path: Array  # |v.m + eta l.m|, which is |v + eta l|; eta is 1 for reflection


def reflecting(v: Array, l: Array) -> Geometry:
    """The facets that reflect l to v, both above; m is the half-vector."""
    counts = (v[2] > 0.0) & (l[2] > 0.0)
    if not np.all(counts):
        v, l = np.where(counts, v, _UP), np.where(counts, l, _UP)
    m = _unit(v + l)
    # v.m and l.m are one number: half the angle between v and l.
    cos_m = np.minimum(np.abs(_dot(v, m)), 1.0)
    return Geometry(counts, v, l, m, cos_m, cos_m, 2.0 * cos_m)


def refracting(v: Array, l: Array, eta: Array) -> Geometry:
    """The facets that refract l, below, to v, above; m = -(v + eta l) / |...| or its opposite, the one with mz > 0.

    `eta` is the index on the side of l over that on the side of v. No facet refracts where v.m and l.m have one sign.
    Nor where eta is 1: all facets send v to -v, and v + l there is nothing but rounding.
    """
    toward = v + eta * l
    length = np.sqrt(_dot(toward, toward))
    counts = (v[2] > 0.0) & (l[2] < 0.0) & (length > 0.0) & (eta != 1.0)
    length = np.where(counts, length, 1.0)
    m = np.where(counts, toward, _UP) / length
    m = np.where(m[2] < 0.0, -m, m)
    v_m, l_m = _dot(v, m), _dot(l, m)
    counts &= (v_m > 0.0) & (l_m < 0.0)
    return Geometry(counts, np.where(counts, v, _UP), np.where(counts, l, -_UP), m, v_m, l_m, length)


def reflection(facets: Facets, at: Geometry, reflectance: Array) -> Array:
    """f_r in 1/sr; `reflectance` is F at `at.v_m`, channels first; (channels, m), zero where nothing counts."""
    g2 = facets.masking_shadowing(at.v, at.l, at.m)
    return np.asarray(facets.density(at.m) * g2 * np.where(at.counts, 0.25, 0.0) / (at.v[2] * at.l[2]) * reflectance)


def reflection_density(facets: Facets, at: Geometry) -> Array:
    """Density of sampled reflections, D_v(m) / (4 v.m) (Portsmouth et al. 2026, eq. 4) [1/sr], shape (m,)."""
    if facets.has_bound:
        density = ggx.bounded_density(at.v, facets.density(at.m), facets.rough.alpha_x, facets.rough.alpha_y)
    else:
        density = facets.visible(at.v, at.m, at.v_m) / (4.0 * at.v_m)
    return np.where(at.counts, density, 0.0)


def transmission(facets: Facets, at: Geometry, transmittance: Array) -> Array:
    """f_t in 1/sr; `transmittance` is 1 - F at `at.v_m`, channels first; (channels, m), zero where nothing counts."""
    up = at.l * _DOWNWARDS
    g2 = facets.masking_shadowing(at.v, up, at.m, transmitted=True)
    f = facets.density(at.m) * g2 * np.abs(at.v_m * at.l_m) / (at.v[2] * up[2] * np.square(at.path))
    return np.where(at.counts, f, 0.0) * transmittance


def transmission_density(facets: Facets, at: Geometry, eta: Array) -> Array:
    """Density of sampled refractions, D_v(m) eta_l^2 |l.m| / (eta_v v.m + eta_l l.m)^2 [1/sr], shape (m,).

    The Jacobian is that of Walter et al. 2007, eq. 17, whose differential is that of the direction which is sampled:
    the index in its numerator is the one on the side of l. (Portsmouth et al. 2026, eq. 5, prints eta_v there.)
    """
    density = facets.visible(at.v, at.m, at.v_m) * np.square(eta / at.path) * np.abs(at.l_m)
    return np.where(at.counts, density, 0.0)


def sample_reflection(facets: Facets, v: Array, u: Array) -> Array:
    """Directions with `reflection_density`, (3, m); 0 where they go below the surface."""
    if facets.has_bound:
        m = ggx.sample_bounded(v, u[0], u[1], facets.rough.alpha_x, facets.rough.alpha_y)
    else:
        m, _ = facets.sample(v, u)
    return reflect(v, m)


def reflect(v: Array, m: Array) -> Array:
    """v reflected by the facet m, (3, m); 0 where that is below the surface."""
    l = 2.0 * _dot(v, m) * m - v
    return np.where(l[2] > 0.0, l, 0.0)


def refract(v: Array, m: Array, eta: Array) -> Array:
    """v refracted by the facet m into the medium of relative index `eta` (Walter et al. 2007, eq. 40), (3, m).

    0 where it is totally reflected or leaves on the wrong side.
    """
    c = _dot(v, m)
    # 1 - (1 - c^2) / eta^2, which keeps the digits of a small c.
    square = ((eta - 1.0) * (eta + 1.0) + c * c) / (eta * eta)
    l = (c / eta - np.sqrt(np.maximum(square, 0.0))) * m - v / eta
    return np.where((square > 0.0) & (c > 0.0) & (l[2] < 0.0), l, 0.0)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _unit(a: Array) -> Array:
    return np.asarray(a / np.sqrt(_dot(a, a)))
