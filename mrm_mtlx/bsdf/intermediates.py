"""Intermediate results of the optics that cancellation or a coarse function makes delicate.

A formula that has one hands it to the `Intermediates` it is given and goes on with what comes back, which here is the
same. An analysis of another precision hands back perturbed ones (`mrm_mtlx.reference.float32.intermediates`): how far
they may be off is no part of the optics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


class Intermediates:
    """Intermediate results as they are."""

    def modulus(self, modulus: Array) -> Array:
        """Modulus of a complex number from which its real part is subtracted."""
        return modulus

    def arc_cosine(self, angle: Array) -> Array:
        """Angle from its cosine [rad]."""
        return angle

    def first_bounce(self, total: Array, amplitude: Array, top: Array, base: Array) -> Array:
        """Sum of the terms of Airy's series without a phase.

        `amplitude` times the root of the product of the reflectances `top` and `base` is the amplitude of the next, of
        whose phase nothing is known where a reflectance is left by cancellation.
        """
        del amplitude, top, base
        return total


EXACT = Intermediates()
