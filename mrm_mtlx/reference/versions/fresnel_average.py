"""The reflectance by which energy compensation colours what is scattered more than once.

Of the two forms, each takes what the interface reflects at the facet, a function of no arguments to what it reflects at
normal incidence, and what at grazing incidence; all broadcast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

MeanReflectance: TypeAlias = "Callable[[Array, Callable[[], Array], Array | float], Array]"


def of_the_facet(at_facet: Array, _at_normal: Callable[[], Array], _at_grazing: Array | float) -> Array:
    """That of the facet which the light meets (MaterialX to 1.39.5)."""
    return at_facet


def of_schlick(_at_facet: Array, at_normal: Callable[[], Array], at_grazing: Array | float) -> Array:
    """The mean over the hemisphere, weighted by the cosine, of Schlick's curve: F0 + (F90 - F0) / 21 (Kulla 2017)."""
    f0 = at_normal()
    return np.asarray(f0 + (at_grazing - f0) / 21.0)
