"""Intermediate results of the optics as far off as float32 may have them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.bsdf.intermediates import Intermediates

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array


@dataclass(frozen=True)
class Perturbed(Intermediates):
    """Intermediate results with these errors; 0 leaves them exact.

    Attributes
    ----------
    modulus_error
        Relative, of a modulus.
    arc_cosine_error
        Relative, of an arc cosine.
    product_error
        Of the product of a film's two reflectances before its root is taken, relative to their sum. Near Brewster's
        angle, and where film and substrate are alike, one of them is left by cancellation.
    """

    modulus_error: float = 0.0
    arc_cosine_error: float = 0.0
    product_error: float = 0.0

    def modulus(self, modulus: Array) -> Array:
        """See `Intermediates`."""
        return modulus * (1.0 + self.modulus_error)

    def arc_cosine(self, angle: Array) -> Array:
        """See `Intermediates`."""
        return angle * (1.0 + self.arc_cosine_error)

    def first_bounce(self, total: Array, amplitude: Array, top: Array, base: Array) -> Array:
        """See `Intermediates`: what the error adds to the next term's amplitude is added in whatever phase.

        Where the film's index is the substrate's, the base reflects nothing but noise, and its phase is noise too.
        """
        if not self.product_error:
            return total
        product = np.maximum(top * base, 0.0)
        slack = np.sqrt(product + self.product_error * (top + np.abs(base))) - np.sqrt(product)
        return np.asarray(total + 2.0 * np.abs(amplitude) * slack)
