"""The contract of a lobe."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from mrm_mtlx.bsdf.quadrature import ACCURACY

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from mrm_mtlx.bsdf.arrays import Array


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
