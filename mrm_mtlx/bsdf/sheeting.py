"""Prismatic sheeting as a BRDF: a rough front plane, cube corners behind it, a diffuse substrate behind these.

    f(v, l) = f_surface(v, l)
            + (1 - F(v)) (1 - F(l)) sqrt(w(v) w(l)) tint f_returned(v, l)
            + (1 - F(v)) (1 - F(l)) (1 - w(v)) (1 - w(l)) substrate / pi

the three terms of Guo, Guo and Pan (2018), with w the share that the corners send back (`prismatic`), F the reflectance
of the smooth plane, and f_returned a white retroreflective Beckmann lobe, of the width that two refractions through the
plane give it. Toward l = v the second term has (1 - F)^2 w, the share that enters, comes back and leaves; what the
corners miss falls on the substrate, and reaches the viewer where corners miss his direction.

Every factor is symmetric in v and l, and so is the width, the smaller of those at v and l: f is reciprocal. A mean of
both would do as well for light near the peak, but samples are drawn with the width at v, and a lobe that is wider than
its samples has no bounded weight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf import fresnel
from mrm_mtlx.bsdf.diffuse_lobes import Lambert
from mrm_mtlx.bsdf.lobes import Dielectric, GeneralizedSchlick
from mrm_mtlx.bsdf.prismatic import retroreflected_share, retroreflective_width
from mrm_mtlx.bsdf.quadrature import ACCURACY, albedo_by_sampling
from mrm_mtlx.bsdf.vectors import color, components, direction

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.quadrature import Sampled


@dataclass(frozen=True)
class PrismaticSheeting:
    """Sheet of cube corners with a rough front plane, on a diffuse substrate. Nothing is seen from below.

    Parameters
    ----------
    ior : array_like, shape (...)
        Index of refraction of the sheet, > 1.
    alpha : (array_like, array_like)
        Beckmann widths of the front plane along the tangent and across it, in (0, 1].
    backing : {"air", "metal"}
        What is behind the corners, see `prismatic.face_reflectance`.
    rotation : array_like, shape (...), or None
        Azimuth of the corners' edges from the tangent [rad]; None averages over all, which takes some 500 times longer.
    substrate : array_like
        Diffuse colour behind the sheet, in [0, 1].
    tint : array_like
        Colour of the sheet's body, a factor on what comes back, in [0, 1].

    Raises
    ------
    ValueError
        By the methods: if a parameter is out of its range or has no shape that broadcasts.

    Examples
    --------
    >>> sheet, v = PrismaticSheeting(1.5, alpha=(0.05, 0.05)), np.array([0.1, 0.0, 0.995])
    >>> bool(sheet.eval(v, v)[0] > 100 * sheet.eval(v, [0.0, 0.5, 0.866])[0])
    True
    """

    ior: ArrayLike = 1.5
    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    backing: str = "air"
    rotation: ArrayLike | None = 0.0
    substrate: ArrayLike = 0.5
    tint: ArrayLike = 1.0

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""
        v, l = direction("v", v), direction("l", l)
        f = sum(part.eval(v, l) for part in self._parts())
        return np.where(v[..., 2:] > 0.0, f, 0.0)

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density of `sample`: those of the three terms, weighted by their shares for a smooth plane at v."""
        v, l = direction("v", v), direction("l", l)
        density = sum(p * part.pdf(v, l) for p, part in zip(self._choice(v), self._parts(), strict=True))
        return np.where(v[..., 2] > 0.0, density, 0.0)

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions of light, see `lobe.Lobe.sample`: the third number chooses the term."""
        v, u = direction("v", v), components("u", u)
        l = np.zeros(np.broadcast_shapes(v.shape, u.shape))
        start: Array | float = 0.0
        for p, part in zip(self._choice(v), self._parts(), strict=True):
            # Inside its part of the interval, the number is uniform again.
            with np.errstate(divide="ignore", invalid="ignore"):
                rest = np.where(p > 0.0, (u[..., 2] - start) / p, -1.0)
            chosen = (rest >= 0.0) & (rest < 1.0)
            inner = np.stack([*np.broadcast_arrays(u[..., 0], u[..., 1], np.where(chosen, rest, 0.5))], axis=-1)
            l = np.where(chosen[..., None], part.sample(v, inner), l)
            start = start + p
        return np.where(v[..., 2:] > 0.0, l, 0.0)

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Directional albedo, see `lobe.Lobe.albedo`: the sum of the terms', each by quadrature.

        Raises
        ------
        ArithmeticError
            If the absolute `accuracy` is not reached.
        """
        v = direction("v", v)
        total = sum(albedo_by_sampling(part, v, accuracy=accuracy / 3.0) for part in self._parts())
        return np.where(v[..., 2:] > 0.0, total, 0.0)

    def share(self, v: ArrayLike) -> Array:
        """Share of the light inside that comes back, w(v), (...)."""
        return retroreflected_share(v, self.ior, self.backing, self.rotation)

    def transmittance(self, v: ArrayLike) -> Array:
        """Share that enters through the smooth plane, 1 - F(v), (...); 0 from below."""
        z = direction("v", v)[..., 2]
        return np.where(z > 0.0, 1.0 - fresnel.dielectric(np.clip(z, 0.0, 1.0), self.ior), 0.0)

    def _parts(self) -> tuple[Sampled, Sampled, Sampled]:
        if not np.all(np.asarray(self.ior) > 1.0):
            msg = f"ior must be > 1, got {np.min(self.ior):g}; a sheet of the index of air has no corners"
            raise ValueError(msg)
        return Dielectric(self.ior, alpha=self.alpha, distribution="beckmann"), _Returned(self), _Substrate(self)

    def _choice(self, v: Array) -> list[Array]:
        """Probabilities of the three terms, (...) each."""
        entered, share = self.transmittance(v), self.share(v)
        tint, substrate = (np.mean(color(name, getattr(self, name)), axis=-1) for name in ("tint", "substrate"))
        shares = np.broadcast_arrays(1.0 - entered, entered**2 * share * tint, entered * (1.0 - share) * substrate)
        return [part / sum(shares) for part in shares]  # 1 - entered is above 0: the index is above 1


@dataclass(frozen=True)
class _Returned:
    """Light that the corners send back."""

    sheet: PrismaticSheeting

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        v, l = np.broadcast_arrays(direction("v", v), direction("l", l))
        w = np.sqrt(self.sheet.share(v) * self.sheet.share(l))
        factor = self.sheet.transmittance(v) * self.sheet.transmittance(l) * w
        return factor[..., None] * color("tint", self.sheet.tint) * self._lobe(v, l).eval(v, l)

    # Samples have the width at v, as l is not known before.

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        v, l = np.broadcast_arrays(direction("v", v), direction("l", l))
        return self._lobe(v, v).pdf(v, l)

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        v, u = np.broadcast_arrays(direction("v", v), components("u", u))
        return self._lobe(v, v).sample(v, u)

    def _lobe(self, v: Array, l: Array) -> GeneralizedSchlick:
        """White, of the smaller of the widths at v and l, none of them above 1."""
        cosine = np.maximum(*(np.where(x[..., 2] > 0.0, x[..., 2], 1.0) for x in (v, l)))  # the width falls with it
        alpha_x, alpha_y = (np.minimum(retroreflective_width(a, cosine, self.sheet.ior), 1.0) for a in self.sheet.alpha)
        return GeneralizedSchlick(1.0, alpha=(alpha_x, alpha_y), distribution="beckmann", retroreflective=True)


@dataclass(frozen=True)
class _Substrate:
    """Light that the corners miss and the substrate reflects."""

    sheet: PrismaticSheeting

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        missed = [self.sheet.transmittance(x) * (1.0 - self.sheet.share(x)) for x in (v, l)]
        return (missed[0] * missed[1])[..., None] * Lambert(self.sheet.substrate).eval(v, l)

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        return Lambert().pdf(v, l)

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        return Lambert().sample(v, u)
