"""The microfacet lobe: facets and a reflectance, seen from v or, retroreflective, from v'.

    f_MRM(v, l) = f(v', l)        v' = mirror(v)        (Portsmouth et al. 2026, eq. 10)

Every occurrence of v is replaced, the Fresnel term's included. Reflection and transmission choose between v and v' each
for itself: the albedos are the same, so all combinations conserve energy (Portsmouth et al. 2026, section 5, Figure 6).

Both sides: a view from below (n.v < 0) sees the interface from inside. Point inversion, (v, l) -> (-v, -l), brings it
above; the index becomes its inverse, and the Fresnel term is that of the refracted cosine outside, which is the same
number, or 1 where light is totally reflected. A metal is black from below.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from mrm_mtlx.bsdf import ggx, microfacet
from mrm_mtlx.bsdf.blocks import evaluate_in_blocks
from mrm_mtlx.bsdf.compensation import compensation
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS, Rough, Smith
from mrm_mtlx.bsdf.quadrature import ACCURACY, over_unit_square
from mrm_mtlx.bsdf.ranges import NOT_NEGATIVE, Range
from mrm_mtlx.bsdf.vectors import DIRECTIONS, check_unit, color, components, direction

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.compensation import WhiteAlbedo
    from mrm_mtlx.bsdf.masking import Distribution, Masking

SCATTER_MODES = ("R", "T", "RT")
SAMPLINGS = ("bounded", "visible")
_ALPHA = Range(0.0, 1.0, above=True, reason="it is the square of a roughness")


@dataclass(frozen=True, kw_only=True)
class Microfacet(ABC):
    """Common part of the three microfacet lobes.

    Parameters
    ----------
    alpha : (array_like, array_like)
        Widths along the tangent and across it, in (0, 1].
    distribution
        "ggx", "beckmann" or "phong", or a `masking.Distribution` of one's own; samples of scatter mode "RT" are right
        for reflection-symmetric ones alone.
    masking
        "smith" (height-correlated), "smith_separable" or "v_cavity"; see `masking`.
    retroreflective
        Whether reflection is seen from v' instead of v.
    sampling
        "bounded" samples reflections on the bounded cap of Eto and Tokuyoshi (2023) where that is known (GGX, Smith,
        scatter mode "R"); "visible" all visible normals (Heitz and d'Eon 2014).
    thinfilm_thickness : array_like
        Thickness of a film on the facets [nm]; 0 is none.
    thinfilm_ior : array_like
        Index of refraction of the film, >= 1.
    energy_compensation : function, optional
        Albedo of the white lobe, by which multiply scattered reflection is given back (Turquin 2019), see
        `compensation.WhiteAlbedo`; for GGX with Smith masking, and taken at the width sqrt(alpha_x alpha_y). None
        leaves single scattering. It knows v alone: such a lobe is not reciprocal.

    Raises
    ------
    ValueError
        If a parameter is out of its range, a name is none of those above, or `energy_compensation` is no function or is
        given for other facets. By the methods: if shapes do not broadcast, or a direction is not unit.
    """

    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    distribution: str | Distribution = "ggx"
    masking: str = "smith"
    retroreflective: bool = False
    sampling: str = "bounded"
    thinfilm_thickness: ArrayLike = 0.0
    thinfilm_ior: ArrayLike = 1.5
    energy_compensation: WhiteAlbedo | None = None

    # Of an interface, a subclass says more.
    scatter_mode: ClassVar[str] = "R"
    retroreflective_btdf: ClassVar[bool] = False
    two_sided: ClassVar[bool] = False

    # Names of the parameters besides the widths, by what they are.
    _SCALARS: ClassVar[tuple[str, ...]] = ("thinfilm_thickness", "thinfilm_ior")
    _COLORS: ClassVar[tuple[str, ...]] = ()
    _RANGES: ClassVar[dict[str, Range]] = {"thinfilm_thickness": NOT_NEGATIVE, "thinfilm_ior": Range(1.0)}

    def __post_init__(self) -> None:
        """Raise `ValueError` for what is wrong with the parameters, their shapes aside."""
        for alpha in self.alpha:
            _ALPHA.check("alpha", alpha)
        for name, allowed in self._RANGES.items():
            allowed.check(name, getattr(self, name))
        distribution, masking = self._parts()
        _one_of("sampling", self.sampling, SAMPLINGS)
        _one_of("scatter_mode", self.scatter_mode, SCATTER_MODES)
        if self.energy_compensation is None:
            return
        if not callable(self.energy_compensation):
            msg = f"energy_compensation must be a function of n.v and alpha, got {self.energy_compensation!r}"
            raise ValueError(msg)
        if not (distribution is ggx and isinstance(masking, Smith)):
            msg = "energy_compensation is known for distribution 'ggx' with masking 'smith' or 'smith_separable' alone"
            raise ValueError(msg)

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `lobe.Lobe.eval`."""
        return self._over_blocks(type(self)._eval, 3, {"v": v, "l": l})

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density of `sample`, see `lobe.Lobe.pdf`.

        Reflection is chosen over transmission with the mean of its channels.
        """
        return self._over_blocks(type(self)._pdf, 1, {"v": v, "l": l})[..., 0]

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions of light, see `lobe.Lobe.sample`.

        The ordinary model is sampled from v' in the place of v (Portsmouth et al. 2026, section 4).
        """
        return self._over_blocks(type(self)._sample, 3, {"v": v, "u": u})

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Directional albedo, see `lobe.Lobe.albedo`, by quadrature to the absolute `accuracy`.

        A retroreflective lobe has that of the ordinary one (Portsmouth et al. 2026, eq. 18).

        Raises
        ------
        ArithmeticError
            If the accuracy is not reached.
        """
        v = direction("v", v)

        def integrand(u: Array) -> Array:
            return self._over_blocks(type(self)._scattered, 3, {"v": v, "u": u})

        return over_unit_square(integrand, v.shape[:-1], accuracy)

    # The methods below are those of one block: its parameters and directions have the components first, (3, m).

    @abstractmethod
    def _reflectance(self, cos_theta: Array) -> Array:
        """F of a facet, channels first, for cosines outside."""

    def _index(self) -> Array:
        """Index inside over outside, shape (m,); 1 where there is no inside."""
        return np.ones(())

    def _tinted(self, f: Array | float) -> Array:
        return np.asarray(f)

    def _eval(self, v: Array, l: Array) -> Array:
        v, l, side = self._from_above(v, l)
        facets = self._facets()
        f: Array | float = 0.0
        if "R" in self.scatter_mode:
            at = microfacet.reflecting(_seen(v, self.retroreflective), l)
            reflectance = self._reflectance_from(side, at.v_m)
            f = self._compensated(microfacet.reflection(facets, at, reflectance), at.v[2], reflectance)
        if "T" in self.scatter_mode:
            at = microfacet.refracting(_seen(v, self.retroreflective_btdf), l, side.eta)
            transmittance = 1.0 - self._reflectance_from(side, np.clip(at.v_m, 0.0, 1.0))
            f = f + microfacet.transmission(facets, at, transmittance)
        return self._tinted(f)

    def _pdf(self, v: Array, l: Array) -> Array:
        v, l, side = self._from_above(v, l)
        facets = self._facets()
        density: Array | float = 0.0
        if "R" in self.scatter_mode:
            at = microfacet.reflecting(_seen(v, self.retroreflective), l)
            density = microfacet.reflection_density(facets, at)
            if "T" in self.scatter_mode:
                density = density * self._choice(side, at.v_m)
        if "T" in self.scatter_mode:
            at = microfacet.refracting(_seen(v, self.retroreflective_btdf), l, side.eta)
            refracted = microfacet.transmission_density(facets, at, side.eta)
            if "R" in self.scatter_mode:
                refracted = refracted * (1.0 - self._choice(side, np.clip(at.v_m, 0.0, 1.0)))
            density = density + refracted
        return np.asarray(density)[None]

    def _sample(self, v: Array, u: Array) -> Array:
        seen_below = v[2] < 0.0
        v, _, side = self._from_above(v, v)
        facets = self._facets()
        above = v[2] > 0.0
        v = np.where(above, v, np.array([[0.0], [0.0], [1.0]]))
        if self.scatter_mode == "R":
            l = microfacet.sample_reflection(facets, _seen(v, self.retroreflective), u)
        elif self.scatter_mode == "T":
            seen = _seen(v, self.retroreflective_btdf)
            l = microfacet.refract(seen, facets.sample(seen, u)[0], side.eta)
        else:
            # One facet for both: D is reflection-symmetric, so a facet that v sees, mirrored, is one that v' sees, at
            # the same angle; and reflecting or refracting mirrored directions gives the mirrored direction.
            m, choice = facets.sample(v, u)
            is_reflected = choice < self._choice(side, np.clip(np.sum(v * m, axis=0), 0.0, 1.0))
            up, down = microfacet.reflect(v, m), microfacet.refract(v, m, side.eta)
            l = np.where(is_reflected, _seen(up, self.retroreflective), _seen(down, self.retroreflective_btdf))
        return np.where(above, np.where(seen_below, -l, l), 0.0)

    def _scattered(self, v: Array, u: Array) -> Array:
        """Share of what arrives along v that a facet drawn with u scatters: the integrand of the albedo.

        Of facets that v sees, F G2 / G1 is reflected to above, (1 - F) G2 / G1 refracted to below (Walter et al. 2007,
        eq. 41, with visible normals).
        """
        v, _, side = self._from_above(v, v)
        facets = self._facets()
        above = v[2] > 0.0
        v = np.where(above, v, np.array([[0.0], [0.0], [1.0]]))
        share: Array | float = 0.0
        for mode, mirrored in (("R", self.retroreflective), ("T", self.retroreflective_btdf)):
            if mode not in self.scatter_mode:
                continue
            seen = _seen(v, mirrored)
            m, weight = facets.points(seen, u)
            reflectance = self._reflectance_from(side, np.clip(np.sum(seen * m, axis=0), 0.0, 1.0))
            if mode == "R":
                kept = weight * facets.unhidden(seen, microfacet.reflect(seen, m), m)
                share = share + kept * self._compensated(reflectance, v[2], reflectance)
            else:
                kept = weight * facets.unhidden(seen, microfacet.refract(seen, m, side.eta), m)
                share = share + kept * (1.0 - reflectance)
        return np.where(above, self._tinted(share), 0.0)

    def _facets(self) -> microfacet.Facets:
        distribution, masking = self._parts()
        bounded = self.sampling == "bounded" and self.scatter_mode == "R"
        return microfacet.Facets(Rough(distribution, *map(np.asarray, self.alpha)), masking, bounded)

    def _compensated(self, value: Array, cos_v: Array, reflectance: Array) -> Array:
        """Reflected light, with that which is scattered more than once."""
        if self.energy_compensation is None:
            return value
        white = self.energy_compensation(cos_v, np.sqrt(np.multiply(*self.alpha)))
        return value * compensation(reflectance, white)

    def _from_above(self, v: Array, l: Array) -> tuple[Array, Array, _Side]:
        """Directions with v above, and the side that they were on."""
        index, below = self._index(), v[2] < 0.0
        if not self.two_sided or not np.any(below):
            return v, l, _Side(index)
        sign = np.where(below, -1.0, 1.0)
        return v * sign, l * sign, _Side(np.where(below, 1.0 / index, index), below)

    def _reflectance_from(self, side: _Side, cos_m: Array) -> Array:
        """F for a cosine on the side of v."""
        if side.inside is None:
            return self._reflectance(cos_m)
        # Snell: sin outside = sin inside / eta, eta being outside over inside.
        square = 1.0 - (1.0 - cos_m * cos_m) / np.square(side.eta)
        cosine = np.where(side.inside, np.sqrt(np.maximum(square, 0.0)), cos_m)
        return np.where(side.inside & (square <= 0.0), 1.0, self._reflectance(cosine))

    def _choice(self, side: _Side, cos_m: Array) -> Array:
        """Probability of reflection at a facet, where both reflection and transmission are sampled."""
        return np.asarray(np.clip(np.mean(self._reflectance_from(side, cos_m), axis=0), 0.0, 1.0))

    # From here on, the parameters are as the user gave them.

    def _over_blocks(
        self, function: Callable[[Self, Array, Array], Array], components_out: int, vectors: dict[str, ArrayLike]
    ) -> Array:
        """The function of every block, of the lobe with the block's parameters and of the block's two directions."""

        def block(first: Array, second: Array, alpha_x: Array, alpha_y: Array, **parameters: Any) -> Array:
            for name, vector in zip(vectors, (first, second), strict=True):
                if name in DIRECTIONS:
                    check_unit(name, vector, axis=0)
            part = copy(self)  # of a lobe that was checked: `replace` would check each block's parameters again
            vars(part).update(alpha=(alpha_x, alpha_y), **parameters)
            return function(part, first, second)

        scalars = {"alpha_x": self.alpha[0], "alpha_y": self.alpha[1]}
        scalars |= {name: getattr(self, name) for name in self._SCALARS}
        return evaluate_in_blocks(
            block,
            {name: np.asarray(value, dtype=float) for name, value in scalars.items()},
            {name: color(name, getattr(self, name)) for name in self._COLORS},
            tuple(components(name, value) for name, value in vectors.items()),
            components_out,
        )

    def _parts(self) -> tuple[Distribution, Masking]:
        """Distribution and masking by their names."""
        distribution = self.distribution
        if isinstance(distribution, str):
            distribution = DISTRIBUTIONS[_one_of("distribution", distribution, tuple(DISTRIBUTIONS))]
        return distribution, MASKINGS[_one_of("masking", self.masking, tuple(MASKINGS))]


class _Side(NamedTuple):
    """The side of an interface that v is on: the index beyond over its own, and which v are inside (None: no v is)."""

    eta: Array
    inside: NDArray[np.bool_] | None = None


def _seen(v: Array, mirrored: bool) -> Array:
    return v * np.array([[-1.0], [-1.0], [1.0]]) if mirrored else v  # v', see vectors.mirror


def _one_of(name: str, value: str, choices: tuple[str, ...]) -> str:
    if value not in choices:
        msg = f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}"
        raise ValueError(msg)
    return value
