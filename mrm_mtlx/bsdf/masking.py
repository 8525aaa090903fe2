"""Masking and shadowing of facets, and which facets a direction sees.

All functions take directions components first, (3, m), with z > 0 (mirrored to the upper side where they point down:
masking is the same on both sides), and the `Rough` facets.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from mrm_mtlx.bsdf import beckmann, ggx, phong

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


class Distribution(Protocol):
    """A distribution of facet normals: the modules `ggx`, `beckmann` and `phong`, or one's own.

    `distribution` is D(m); `smith_lambda` is asked for by Smith masking alone. Retroreflection is reciprocal only where
    D is reflection-symmetric, D(mx, my, mz) = D(-mx, -my, mz) (Portsmouth et al. 2026, section 3.1).
    """

    def distribution(
        self, mx: ArrayLike, my: ArrayLike, mz: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike
    ) -> Array:
        """D(m) [1/sr], shape (...), with integral of D(m) mz = 1; see `ggx.distribution`."""
        ...

    def smith_lambda(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
        """Smith's Lambda of a direction, shape (...), >= 0; see `ggx.smith_lambda`."""
        ...

    def sample_normal(self, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
        """Normals with density D(m) mz, shape (3, ...); see `ggx.sample_normal`."""
        ...

    def sample_visible(self, v: Array, u1: ArrayLike, u2: ArrayLike, alpha_x: ArrayLike, alpha_y: ArrayLike) -> Array:
        """Normals that v sees under Smith masking, shape (3, ...); see `ggx.sample_visible`."""
        ...


class Rough(NamedTuple):
    """Facets without what hides them: their distribution and its widths, shape (...)."""

    distribution: Distribution
    alpha_x: Array
    alpha_y: Array

    def density(self, m: Array) -> Array:
        """D(m) [1/sr], shape (m,)."""
        return self.distribution.distribution(m[0], m[1], m[2], self.alpha_x, self.alpha_y)

    def smith_lambda(self, w: Array) -> Array:
        """Smith's Lambda of a direction, shape (m,)."""
        return self.distribution.smith_lambda(w[0], w[1], w[2], self.alpha_x, self.alpha_y)

    def sample_normal(self, u: Array) -> Array:
        """Normals with density D(m) mz, (3, m)."""
        return self.distribution.sample_normal(u[0], u[1], self.alpha_x, self.alpha_y)

    def sample_visible(self, v: Array, u: Array) -> Array:
        """Normals that v sees under Smith masking, (3, m)."""
        return self.distribution.sample_visible(v, u[0], u[1], self.alpha_x, self.alpha_y)


class Masking(Protocol):
    """A model of how facets are hidden, from v and from l."""

    def masking(self, rough: Rough, w: Array, m: Array) -> Array:
        """G1(w, m): share of the facets with normal m that are seen from w, shape (m,), in [0, 1]."""
        ...

    def masking_shadowing(self, rough: Rough, v: Array, l: Array, m: Array, *, transmitted: bool) -> Array:
        """G2(v, l, m): share seen from v and lit from l, shape (m,), at most G1 of either.

        `transmitted`: l is on the other side; it is given mirrored to the upper one.
        """
        ...

    def sample_visible(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """Normals with density D_v(m) = G1(v, m) <v.m> D(m) / (n.v), (3, m), and the rest of u[2], uniform."""
        ...

    def points(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """Normals over the square of u[0] and u[1], (3, m), and weights (m,) that make their density D_v(m)."""
        ...


class Smith:
    """Smith masking (Portsmouth et al. 2026, eq. 8): facets hide each other at random.

    Height-correlated, reflection has G2 = 1 / (1 + Lv + Ll) (Heitz 2014, eq. 99) and transmission
    G2 = B(1 + Lv, 1 + Ll), B being Euler's beta function (Heitz et al. 2016): of facets at the height that a
    share h of the surface lies below, h^Lv are seen from above and (1 - h)^Ll from below; over all heights, that is B.
    Separable, both have G2 = G1(v) G1(l) (Walter et al. 2007, eq. 23).
    """

    def __init__(self, *, correlated: bool) -> None:
        self.correlated = correlated

    def masking(self, rough: Rough, w: Array, m: Array) -> Array:
        """G1 = 1 / (1 + Lambda) wherever w.m > 0."""
        seen = w[0] * m[0] + w[1] * m[1] + w[2] * m[2] > 0.0
        return np.asarray(seen / (1.0 + rough.smith_lambda(w)))

    def masking_shadowing(self, rough: Rough, v: Array, l: Array, m: Array, *, transmitted: bool) -> Array:
        """G2, see the class; whether v.m and l.m have the right sign is the caller's to see."""
        del m
        lambda_v, lambda_l = (rough.smith_lambda(w) for w in (v, l))
        if not self.correlated:
            return np.asarray(1.0 / ((1.0 + lambda_v) * (1.0 + lambda_l)))
        if not transmitted:
            return ggx.masking_shadowing(lambda_v, lambda_l)
        from scipy import special

        return np.asarray(special.beta(1.0 + lambda_v, 1.0 + lambda_l))

    def sample_visible(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """The distribution's own."""
        return rough.sample_visible(v, u), u[2]

    def points(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """Visible normals, all of one weight."""
        return rough.sample_visible(v, u), np.ones(())


class VCavity:
    """V-cavity masking (Portsmouth et al. 2026, eq. 9): each facet stands opposite its mirror image.

    G2 is min(G1(v), G1(l)) for reflection and max(G1(v) + G1(l) - 1, 0) for transmission, where what is seen and what
    is lit start from opposite edges (Heitz and d'Eon 2014).
    """

    def masking(self, rough: Rough, w: Array, m: Array) -> Array:
        """G1 = min(2 (n.w) (n.m) / (w.m), 1) wherever w.m > 0."""
        del rough
        return self._g1(w, m, w[0] * m[0] + w[1] * m[1] + w[2] * m[2])

    def masking_shadowing(self, rough: Rough, v: Array, l: Array, m: Array, *, transmitted: bool) -> Array:
        """G2, see the class."""
        del rough
        seen = self._g1(v, m, v[0] * m[0] + v[1] * m[1] + v[2] * m[2])
        side = -1.0 if transmitted else 1.0  # l was mirrored up: its own cosine with m is that of the mirrored m
        lit = self._g1(l, m, np.abs(l[0] * m[0] + l[1] * m[1] + side * l[2] * m[2]))
        return np.maximum(seen + lit - 1.0, 0.0) if transmitted else np.minimum(seen, lit)

    def sample_visible(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """A facet of the distribution, or its mirror image, in proportion to how v sees them (Heitz and d'Eon 2014)."""
        m = rough.sample_normal(u)
        across, along = v[0] * m[0] + v[1] * m[1], v[2] * m[2]
        here, there = np.maximum(along + across, 0.0), np.maximum(along - across, 0.0)
        share = here / np.maximum(here + there, np.finfo(float).tiny)
        kept = u[2] < share
        # The share of u[2] inside the chosen part is uniform again.
        with np.errstate(divide="ignore", invalid="ignore"):
            rest = np.where(kept, u[2] / share, (u[2] - share) / (1.0 - share))
        sign = np.where(kept, 1.0, -1.0)
        return np.stack([sign * m[0], sign * m[1], m[2]]), rest

    def points(self, rough: Rough, v: Array, u: Array) -> tuple[Array, Array]:
        """All normals with density D(m) mz; their weight, G1 <v.m> / ((n.v) mz), is at most 2."""
        m = rough.sample_normal(u)
        cos_m = v[0] * m[0] + v[1] * m[1] + v[2] * m[2]
        return m, self._g1(v, m, cos_m) * cos_m / (v[2] * m[2])

    @staticmethod
    def _g1(w: Array, m: Array, cos_m: Array) -> Array:
        safe = np.where(cos_m > 0.0, cos_m, 1.0)
        return np.where(cos_m > 0.0, np.minimum(2.0 * w[2] * m[2] / safe, 1.0), 0.0)


DISTRIBUTIONS: dict[str, Distribution] = {"ggx": ggx, "beckmann": beckmann, "phong": phong}
MASKINGS: dict[str, Masking] = {
    "smith": Smith(correlated=True),
    "smith_separable": Smith(correlated=False),
    "v_cavity": VCavity(),
}
