"""Microfacet lobes: facets and a reflectance, seen from v or, retroreflective, from v'.

    f_MRM(v, l) = f(v', l)        v' = mirror(v)        (Portsmouth et al. 2026, eq. 10)

Every occurrence of v is replaced, the Fresnel term's included. Reflection and transmission choose between v and v' each
for itself: the albedos are the same, so all combinations conserve energy (Portsmouth et al. 2026, section 5, Figure 6).

Both sides: a view from below (n.v < 0) sees the interface from inside. Point inversion, (v, l) -> (-v, -l), brings it
above; the index becomes its inverse, and the Fresnel term is that of the refracted cosine outside, which is the same
number, or 1 where light is totally reflected. A metal is black from below.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from mrm_mtlx.bsdf import albedo, fresnel, ggx, microfacet
from mrm_mtlx.bsdf.blocks import evaluate_in_blocks
from mrm_mtlx.bsdf.masking import DISTRIBUTIONS, MASKINGS, Rough, Smith
from mrm_mtlx.bsdf.quadrature import ACCURACY, over_unit_square
from mrm_mtlx.bsdf.reflectance import conductor_reflectance, dielectric_reflectance, schlick_reflectance
from mrm_mtlx.bsdf.vectors import color, components

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.bsdf.masking import Distribution

SCATTER_MODES = ("R", "T", "RT")
SAMPLINGS = ("bounded", "visible")


class Lobe(Protocol):
    """Anything that scatters light. Directions are unit, in the local frame, (..., 3), and broadcast."""

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, without the cosine of l, (..., 3).

        Transmission is that of radiance, with the factor (eta_v / eta_l)^2 (Walter et al. 2007, eq. 21).
        """
        ...

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density with which `sample` gives l [1/sr], shape (...); 0 is never.

        Its integral over l is 1 less the share of samples that are lost.
        """
        ...

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions l for random numbers u, (..., 3), uniform in [0, 1): two for the direction, one for choices.

        The zero vector where a sample is lost (reflected downwards, totally reflected): `eval` and `pdf` are 0 there.
        """
        ...

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Share of the light arriving along v that is scattered, (..., 3), to the absolute `accuracy`.

        For reflection the integral of f(v, l) |n.l| over l; for transmission of f(l, v) |n.l|, which counts energy.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Microfacet(ABC):
    """What the three microfacet lobes share.

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
    energy_compensation
        Whether multiply scattered reflection is given back (Turquin 2019), for GGX with Smith masking and the width
        sqrt(alpha_x alpha_y). It knows v alone: such a lobe is not reciprocal.

    Raises
    ------
    ValueError
        By the methods: if a width is not in (0, 1], a name is none of those above, or a parameter has no shape that
        broadcasts.
    """

    alpha: tuple[ArrayLike, ArrayLike] = (0.05, 0.05)
    distribution: str | Distribution = "ggx"
    masking: str = "smith"
    retroreflective: bool = False
    sampling: str = "bounded"
    thinfilm_thickness: ArrayLike = 0.0
    thinfilm_ior: ArrayLike = 1.5
    energy_compensation: bool = False

    # Of an interface, a subclass says more.
    scatter_mode: ClassVar[str] = "R"
    retroreflective_btdf: ClassVar[bool] = False
    two_sided: ClassVar[bool] = False

    def eval(self, v: ArrayLike, l: ArrayLike) -> Array:
        """BSDF in 1/sr, see `Lobe.eval`."""
        return self._over_blocks(self._eval, 3, {"v": v, "l": l})

    def pdf(self, v: ArrayLike, l: ArrayLike) -> Array:
        """Density of `sample`, see `Lobe.pdf`. Reflection is chosen over transmission with the mean of its channels."""
        return self._over_blocks(self._pdf, 1, {"v": v, "l": l})[..., 0]

    def sample(self, v: ArrayLike, u: ArrayLike) -> Array:
        """Directions of light, see `Lobe.sample`.

        The ordinary model is sampled from v' in the place of v (Portsmouth et al. 2026, section 4).
        """
        return self._over_blocks(self._sample, 3, {"v": v, "u": u})

    def albedo(self, v: ArrayLike, *, accuracy: float = ACCURACY) -> Array:
        """Directional albedo, see `Lobe.albedo`, by quadrature to the absolute `accuracy`.

        A retroreflective lobe has that of the ordinary one (Portsmouth et al. 2026, eq. 18).

        Raises
        ------
        ArithmeticError
            If the accuracy is not reached.
        """
        v = components("v", v)

        def integrand(u: Array) -> Array:
            return self._over_blocks(self._scattered, 3, {"v": v, "u": u})

        return over_unit_square(integrand, v.shape[:-1], accuracy)

    @abstractmethod
    def _colors(self) -> dict[str, ArrayLike]:
        """Colours that `_reflectance` takes, and `tint`."""

    @abstractmethod
    def _scalars(self) -> dict[str, ArrayLike]:
        """Scalars that `_reflectance` takes."""

    @abstractmethod
    def _reflectance(self, cos_theta: Array, **parameters: Array) -> Array:
        """F of a facet, channels first, for cosines outside."""

    def _index(self) -> Array:
        """Index inside over outside, shape (...); 1 where there is no inside."""
        return np.ones(())

    # The methods below run on blocks, components first: (3, m).

    def _eval(self, v: Array, l: Array, *, facets: microfacet.Facets, index: Array, **parameters: Array) -> Array:
        v, l, eta, inside = self._from_above(v, l, index)
        tint = parameters.pop("tint", 1.0)
        f: Array | float = 0.0
        if "R" in self.scatter_mode:
            at = microfacet.reflecting(self._seen(v, self.retroreflective), l)
            reflectance = self._seen_reflectance(at.v_m, eta, inside, parameters)
            f = microfacet.reflection(facets, at, reflectance)
            if self.energy_compensation:
                white = albedo.white_albedo(at.v[2], np.sqrt(facets.rough.alpha_x * facets.rough.alpha_y))
                f = f * albedo.compensation(reflectance, white)
        if "T" in self.scatter_mode:
            at = microfacet.refracting(self._seen(v, self.retroreflective_btdf), l, eta)
            transmittance = 1.0 - self._seen_reflectance(np.clip(at.v_m, 0.0, 1.0), eta, inside, parameters)
            f = f + microfacet.transmission(facets, at, transmittance)
        return np.asarray(f * tint)

    def _pdf(self, v: Array, l: Array, *, facets: microfacet.Facets, index: Array, **parameters: Array) -> Array:
        v, l, eta, inside = self._from_above(v, l, index)
        density: Array | float = 0.0
        if "R" in self.scatter_mode:
            at = microfacet.reflecting(self._seen(v, self.retroreflective), l)
            density = microfacet.reflection_density(facets, at)
            if "T" in self.scatter_mode:
                density = density * self._choice(at.v_m, eta, inside, parameters)
        if "T" in self.scatter_mode:
            at = microfacet.refracting(self._seen(v, self.retroreflective_btdf), l, eta)
            refracted = microfacet.transmission_density(facets, at, eta)
            if "R" in self.scatter_mode:
                refracted = refracted * (1.0 - self._choice(np.clip(at.v_m, 0.0, 1.0), eta, inside, parameters))
            density = density + refracted
        return np.asarray(density)[None]

    def _sample(self, v: Array, u: Array, *, facets: microfacet.Facets, index: Array, **parameters: Array) -> Array:
        seen_below = v[2] < 0.0
        v, _, eta, inside = self._from_above(v, v, index)
        above = v[2] > 0.0
        v = np.where(above, v, np.array([[0.0], [0.0], [1.0]]))
        if self.scatter_mode == "R":
            l = microfacet.sample_reflection(facets, self._seen(v, self.retroreflective), u)
        elif self.scatter_mode == "T":
            seen = self._seen(v, self.retroreflective_btdf)
            l = microfacet.refract(seen, facets.sample(seen, u)[0], eta)
        else:
            # One facet for both: D is reflection-symmetric, so a facet that v sees, mirrored, is one that v' sees, at
            # the same angle; and reflecting or refracting mirrored directions gives the mirrored direction.
            m, choice = facets.sample(v, u)
            cos_m = np.clip(np.sum(v * m, axis=0), 0.0, 1.0)
            is_reflected = choice < self._choice(cos_m, eta, inside, parameters)
            up, down = microfacet.reflect(v, m), microfacet.refract(v, m, eta)
            l = np.where(
                is_reflected, self._seen(up, self.retroreflective), self._seen(down, self.retroreflective_btdf)
            )
        return np.where(above, np.where(seen_below, -l, l), 0.0)

    def _scattered(self, v: Array, u: Array, *, facets: microfacet.Facets, index: Array, **parameters: Array) -> Array:
        """Share of what arrives along v that a facet drawn with u scatters: the integrand of the albedo.

        Of facets that v sees, F G2 / G1 is reflected to above, (1 - F) G2 / G1 refracted to below (Walter et al. 2007,
        eq. 41, with visible normals).
        """
        v, _, eta, inside = self._from_above(v, v, index)
        above = v[2] > 0.0
        v = np.where(above, v, np.array([[0.0], [0.0], [1.0]]))
        tint = parameters.pop("tint", 1.0)
        share: Array | float = 0.0
        for mode, mirrored in (("R", self.retroreflective), ("T", self.retroreflective_btdf)):
            if mode not in self.scatter_mode:
                continue
            seen = self._seen(v, mirrored)
            m, weight = facets.points(seen, u)
            reflectance = self._seen_reflectance(np.clip(np.sum(seen * m, axis=0), 0.0, 1.0), eta, inside, parameters)
            if mode == "R":
                kept = weight * facets.unhidden(seen, microfacet.reflect(seen, m), m)
                if self.energy_compensation:
                    white = albedo.white_albedo(v[2], np.sqrt(facets.rough.alpha_x * facets.rough.alpha_y))
                    reflectance = reflectance * albedo.compensation(reflectance, white)
                share = share + kept * reflectance
            else:
                kept = weight * facets.unhidden(seen, microfacet.refract(seen, m, eta), m)
                share = share + kept * (1.0 - reflectance)
        return np.where(above, share * tint, 0.0)

    def _seen(self, v: Array, mirrored: bool) -> Array:
        return v * np.array([[-1.0], [-1.0], [1.0]]) if mirrored else v  # v', see vectors.mirror

    def _from_above(self, v: Array, l: Array, index: Array) -> tuple[Array, Array, Array, Array | None]:
        """Directions with v above, the index on the far side over that on its own, and which v are inside."""
        below = v[2] < 0.0
        if not self.two_sided or not np.any(below):
            return v, l, index, None
        sign = np.where(below, -1.0, 1.0)
        return v * sign, l * sign, np.where(below, 1.0 / index, index), below

    def _seen_reflectance(self, cos_m: Array, eta: Array, inside: Array | None, parameters: dict[str, Array]) -> Array:
        """F for a cosine on the side of v, which is inside where `inside` says so."""
        if inside is None:
            return self._reflectance(cos_m, **parameters)
        # Snell: sin outside = sin inside / eta, eta being outside over inside.
        square = 1.0 - (1.0 - cos_m * cos_m) / np.square(eta)
        cosine = np.where(inside, np.sqrt(np.maximum(square, 0.0)), cos_m)
        reflected = np.asarray(inside, dtype=bool) & (square <= 0.0)
        return np.where(reflected, 1.0, self._reflectance(cosine, **parameters))

    def _choice(self, cos_m: Array, eta: Array, inside: Array | None, parameters: dict[str, Array]) -> Array:
        """Probability of reflection at a facet, where both reflection and transmission are sampled."""
        parameters = {name: value for name, value in parameters.items() if name != "tint"}
        mean = np.mean(self._seen_reflectance(cos_m, eta, inside, parameters), axis=0)
        return np.asarray(np.clip(mean, 0.0, 1.0))

    def _over_blocks(self, function: Any, components_out: int, vectors: dict[str, ArrayLike]) -> Array:
        distribution, masking = self._parts()
        bounded = self.sampling == "bounded" and self.scatter_mode == "R"

        def block(*vectors: Array, alpha_x: Array, alpha_y: Array, **parameters: Array) -> Array:
            facets = microfacet.Facets(Rough(distribution, alpha_x, alpha_y), masking, bounded)
            return np.asarray(function(*vectors, facets=facets, **parameters))

        scalars = {
            "alpha_x": self.alpha[0],
            "alpha_y": self.alpha[1],
            "thickness": self.thinfilm_thickness,
            "film_ior": self.thinfilm_ior,
            "index": self._index(),
            **self._scalars(),
        }
        return evaluate_in_blocks(
            block,
            {name: np.asarray(value, dtype=float) for name, value in scalars.items()},
            {name: color(name, value) for name, value in self._colors().items()},
            tuple(components(name, value) for name, value in vectors.items()),
            components_out,
        )

    def _parts(self) -> tuple[Distribution, Any]:
        """Distribution and masking by their names, once all that can be wrong has been looked at."""
        for alpha in (np.asarray(a, dtype=float) for a in self.alpha):
            if np.any(~((alpha > 0.0) & (alpha <= 1.0))):
                msg = (
                    f"alpha must be in (0, 1], got {alpha.min():g} to {alpha.max():g}; it is the square of a roughness"
                )
                raise ValueError(msg)
        distribution = self.distribution
        if isinstance(distribution, str):
            distribution = DISTRIBUTIONS[_one_of("distribution", distribution, tuple(DISTRIBUTIONS))]
        masking = MASKINGS[_one_of("masking", self.masking, tuple(MASKINGS))]
        _one_of("sampling", self.sampling, SAMPLINGS)
        _one_of("scatter_mode", self.scatter_mode, SCATTER_MODES)
        if self.energy_compensation and not (distribution is ggx and isinstance(masking, Smith)):
            msg = "energy_compensation is known for distribution 'ggx' with masking 'smith' or 'smith_separable' alone"
            raise ValueError(msg)
        return distribution, masking


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

    def _colors(self) -> dict[str, ArrayLike]:
        return {"ior": self.ior, "extinction": self.extinction}

    def _scalars(self) -> dict[str, ArrayLike]:
        return {}

    def _reflectance(self, cos_theta: Array, **parameters: Array) -> Array:
        return conductor_reflectance(
            cos_theta,
            parameters["ior"],
            parameters["extinction"],
            parameters["thickness"],
            parameters["film_ior"],
        )


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

    def _colors(self) -> dict[str, ArrayLike]:
        return {"tint": self.tint}

    def _scalars(self) -> dict[str, ArrayLike]:
        return {"ior": self.ior}

    def _index(self) -> Array:
        return np.asarray(self.ior, dtype=float)

    def _reflectance(self, cos_theta: Array, **parameters: Array) -> Array:
        return dielectric_reflectance(cos_theta, parameters["ior"], parameters["thickness"], parameters["film_ior"])


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

    def _colors(self) -> dict[str, ArrayLike]:
        return {"color0": self.color0, "color82": self.color82, "color90": self.color90}

    def _scalars(self) -> dict[str, ArrayLike]:
        return {"exponent": self.exponent}

    def _index(self) -> Array:
        return fresnel.schlick_ior(np.mean(color("color0", self.color0), axis=-1))

    def _reflectance(self, cos_theta: Array, **parameters: Array) -> Array:
        return schlick_reflectance(
            cos_theta,
            parameters["color0"],
            parameters["color82"],
            parameters["color90"],
            parameters["exponent"],
            parameters["thickness"],
            parameters["film_ior"],
        )


def _one_of(name: str, value: str, choices: tuple[str, ...]) -> str:
    if value not in choices:
        msg = f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}"
        raise ValueError(msg)
    return value
