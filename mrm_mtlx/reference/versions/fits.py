"""Fitted formulas of MaterialX's shaders: what directional albedos and transformations they take in place of integrals.

Each class is the form of a fit, and its fields are the coefficients, which a version of MaterialX gives
(`mrm_mtlx.reference.versions`). Sums whose terms cancel also say what rounding of the terms does to them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array

# Coefficients of one sum, in the order of its terms.
Terms: TypeAlias = tuple[float, ...]


@dataclass(frozen=True)
class MicrofacetAlbedo:
    """Directional albedo of a GGX lobe with a Schlick curve of exponent 5, A F0 + B F90: rational in c = n.v and alpha.

    Attributes
    ----------
    factors_above, factors_below
        Numerators and denominators of A and of B, by the monomials 1, c, a, c a, c^2, a^2, c^2 a, c a^2, c^2 a^2.
    """

    factors_above: tuple[Terms, Terms]
    factors_below: tuple[Terms, Terms]

    def factors(self, cos_v: ArrayLike, alpha: ArrayLike) -> tuple[Array, Array]:
        """A and B.

        Parameters
        ----------
        cos_v : array_like, shape (...)
            n.v, in [0, 1].
        alpha : array_like, shape (...)
            Isotropic width, in [0, 1].

        Returns
        -------
        tuple of ndarray, shape (...)
            Each in [0, 1].
        """
        monomials = self._monomials(cos_v, alpha)
        a, b = (_sum(terms, monomials) for terms in self.factors_above)
        under_a, under_b = (_sum(terms, monomials) for terms in self.factors_below)
        return np.clip(a / under_a, 0.0, 1.0), np.clip(b / under_b, 0.0, 1.0)

    def white(self, cos_v: ArrayLike, alpha: ArrayLike) -> Array:
        """Share of the light that a lobe with reflectance 1 returns by single scattering, A + B; (...), in (0, 1]."""
        a, b = self.factors(cos_v, alpha)
        return a + b

    def condition(self, cos_v: ArrayLike, alpha: ArrayLike) -> Array:
        """Absolute error of A + B per unit of relative rounding of each term, shape (...), >= 0.

        The polynomials cancel (terms up to 300 add to a value near 1), so that float32 arithmetic loses digits here.
        """
        monomials = self._monomials(cos_v, alpha)
        errors = []
        for above, below in zip(self.factors_above, self.factors_below, strict=True):
            value, under = _sum(above, monomials), _sum(below, monomials)
            big, big_under = _sum(_magnitudes(above), monomials), _sum(_magnitudes(below), monomials)
            errors.append((big + np.abs(value / under) * big_under) / np.abs(under))
        return np.asarray(errors[0] + errors[1])

    @staticmethod
    def _monomials(cos_v: ArrayLike, alpha: ArrayLike) -> tuple[Array, ...]:
        x, y = np.asarray(cos_v, dtype=float), np.asarray(alpha, dtype=float)
        x2, y2 = x * x, y * y
        return (np.ones_like(x * y), x, y, x * y, x2, y2, x2 * y, x * y2, x2 * y2)


@dataclass(frozen=True)
class FibreAlbedo:
    """Directional albedo of the sheen of Conty and Kulla: rational in c = n.v and r = roughness.

    Attributes
    ----------
    above, below
        Numerator and denominator, by the monomials 1, c, r, c r, c^2, r^2.
    """

    above: Terms
    below: Terms

    def albedo(self, cos_v: ArrayLike, roughness: ArrayLike, *, rounding: float = 0.0) -> Array:
        """Of the lobe `sheen.fibre_distribution` * `sheen.fibre_visibility`, shape (...), in [0, 1].

        Below zero, which the numerator is for small roughness near n.v 0.5, it is 0. `rounding` is a relative error
        given to each term, some of which cancel, so that the result is the largest possible.
        """
        c, r = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        monomials = (np.ones(()), c, r, c * r, c * c, r * r)
        below = _sum(self.below, monomials)
        ratio = _sum(self.above, monomials) / below
        if rounding:
            big_above, big_below = (_sum(_magnitudes(terms), monomials) for terms in (self.above, self.below))
            ratio = ratio + rounding * (big_above + np.abs(ratio) * big_below) / below
        return np.clip(ratio, 0.0, 1.0)


@dataclass(frozen=True)
class ClothCosine:
    """The linearly transformed cosine of Zeltner et al. 2022 and its albedo, by x = n.v and y = roughness.

    a = (p0 x + p1 y) y / (1 + q0 x^2 + q1 x y)                                   p, q: scale_above, scale_below
    b = sqrt(1 - x) (y - 1) y^3 / (r0 + r1 x + r2 x y + r3 y^2)                   r: shear_below
    albedo = exp(-((x - m) / s)^2 / 2) / (s sqrt(2 pi)) + o
    s = y (t0 + t1 y) / (u0 + y (u1 + y))                                         t, u: width_above, width_below
    m, o = y times quotients of polynomials in y, lowest power first              mean_..., offset_...
    """

    scale_above: tuple[float, float]
    scale_below: tuple[float, float]
    shear_below: tuple[float, float, float, float]
    width_above: tuple[float, float]
    width_below: tuple[float, float]
    mean_above: Terms
    mean_below: Terms
    offset_above: Terms
    offset_below: Terms

    def scale(self, cos_v: ArrayLike, roughness: ArrayLike) -> Array:
        """Coefficient a of `sheen.ltc_density`, shape (...), > 0."""
        x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        (p0, p1), (q0, q1) = self.scale_above, self.scale_below
        return np.asarray((p0 * x + p1 * y) * y / (1.0 + q0 * x * x + q1 * x * y))

    def shear(self, cos_v: ArrayLike, roughness: ArrayLike, *, lost: ArrayLike = 0.0) -> Array:
        """Coefficient b of `sheen.ltc_density`, shape (...), <= 0.

        `lost` is added to 1 - n.v, which cancels near the normal; 0 is exact.
        """
        x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        root = np.sqrt(np.maximum(1.0 - x + np.asarray(lost), 0.0))
        r0, r1, r2, r3 = self.shear_below
        return np.asarray(root * (y - 1.0) * y**3 / (r0 + r1 * x + r2 * x * y + r3 * y * y))

    def albedo(
        self, cos_v: ArrayLike, roughness: ArrayLike, *, rounding: float = 0.0, exponential_error: float = 0.0
    ) -> Array:
        """Directional albedo of the lobe, a Gaussian in n.v, shape (...).

        The offset is below zero, to -2e-5, for roughness from 0.04 to 0.13. `rounding` is a relative error given to
        each term of the fits, `exponential_error` one given to the exponential per unit of its exponent plus one, so
        that the result is the largest possible.
        """
        x, y = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        (t0, t1), (u0, u1) = self.width_above, self.width_below
        s = y * (t0 + t1 * y) / (u0 + y * (u1 + y))
        m = _quotient(y, self.mean_above, self.mean_below)
        o = _quotient(y, self.offset_above, self.offset_below)
        exponent = 0.5 * np.square((x - m[0]) / s)
        # Of the exponent: the mean's error in units of s, and that of s, of whose terms none cancels; it is squared.
        off = rounding * (np.sqrt(2.0 * exponent) * (m[1] + np.abs(x)) / s + 2.0 * exponent)
        peak = np.exp(-exponent) / (s * np.sqrt(2.0 * np.pi))
        return np.asarray(peak * (np.exp(off) + exponential_error * (1.0 + exponent)) + o[0] + rounding * o[1])


@dataclass(frozen=True)
class OrenNayarAlbedo:
    """Directional albedo of `diffuse.oren_nayar` of unit colour: rational in c = n.v and r = roughness.

    (1 + p0 r + p1 c r + p2 r^2) / (1 + q0 r + q1 c r + q2 r^2)                           p, q: above, below
    """

    above: tuple[float, float, float]
    below: tuple[float, float, float]

    def albedo(self, cos_v: ArrayLike, roughness: ArrayLike) -> Array:
        """Shape (...), in [0, 1]."""
        c, r = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        above, below = (1.0 + k[0] * r + k[1] * c * r + k[2] * r * r for k in (self.above, self.below))
        return np.asarray(np.clip(above / below, 0.0, 1.0))


@dataclass(frozen=True)
class BurleyAlbedo:
    """Directional albedo of `diffuse.burley`: linear in the roughness between two curves in c = n.v.

    smooth: p0 + p1 (1 - c)^5        rough: q0 + c (q1 + c (q2 + q3 c))
    """

    smooth: tuple[float, float]
    rough: tuple[float, float, float, float]

    def albedo(self, cos_v: ArrayLike, roughness: ArrayLike) -> Array:
        """Shape (...)."""
        c, r = np.asarray(cos_v, dtype=float), np.asarray(roughness, dtype=float)
        (p0, p1), (q0, q1, q2, q3) = self.smooth, self.rough
        smooth = p0 + p1 * (1.0 - c) ** 5
        rough = q0 + c * (q1 + c * (q2 + q3 * c))
        return np.asarray(smooth * (1.0 - r) + rough * r)


def _sum(terms: Terms, monomials: tuple[Array, ...]) -> Array:
    # A plain sum: a product with the monomials stacked would copy them all.
    return sum((k * m for k, m in zip(terms, monomials, strict=True)), start=np.zeros(()))


def _magnitudes(terms: Terms) -> Terms:
    return tuple(map(abs, terms))


def _quotient(y: Array, above: Terms, below: Terms) -> tuple[Array, Array]:
    """y times a quotient of polynomials in y, and its absolute error per relative error of their terms."""
    p, q = (np.polynomial.polynomial.polyval(y, k) for k in (above, below))
    big_p, big_q = (np.polynomial.polynomial.polyval(y, _magnitudes(k)) for k in (above, below))
    value = y * p / q
    return np.asarray(value), np.asarray(np.abs(y * big_p / q) + np.abs(value) * big_q / np.abs(q))
