"""The light that a closure is evaluated under: directions, mode, environment; and the value of a closure."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from mrm_mtlx.reference import versions
from mrm_mtlx.reference.models import NOTHING, Contents, Model

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.float32.rounding import Quantity

_Result = TypeVar("_Result")

# MaterialX's M_FLOAT_EPS.
EPSILON = 1e-8


class Mode(Enum):
    """The light that a BSDF is evaluated for; MaterialX's hardware shaders evaluate it once per mode and add up.

    `REFLECTION` is one light at `l`; `INDIRECT` the environment, as reflected; `TRANSMISSION` the environment, as seen
    through the surface along the view direction.
    """

    REFLECTION = "reflection"
    INDIRECT = "indirect"
    TRANSMISSION = "transmission"


@dataclass(frozen=True)
class Closure:
    """A BSDF node's value: what it reflects of the light, and what it lets through to the layer below.

    `response` and `throughput` have shape (3, samples) or broadcast to it. `contents` are those of the response.
    """

    response: Array
    throughput: Array
    contents: Contents = NOTHING


@dataclass(frozen=True)
class Environment:
    """Light from all around.

    Attributes
    ----------
    radiance
        Radiance that arrives from directions, world space, shape (3, n) to (3, n) or (3, 1).
    irradiance
        Irradiance over pi at surfaces with these normals, shapes as above.
    samples
        Number of directions by which a glossy lobe's share is estimated (the shader's `u_envRadianceSamples`).
    """

    radiance: Callable[[Array], Array]
    irradiance: Callable[[Array], Array]
    samples: int = 16

    @staticmethod
    def constant(color: tuple[float, float, float], samples: int = 16) -> Environment:
        """The same radiance from every direction."""
        same = np.array([[c] for c in color])
        return Environment(lambda _: same, lambda _: same, samples)


@dataclass(frozen=True)
class Light:
    """The directions of an evaluation, `v` and `l`, shape (3, samples), and what else it is made under.

    `quantity` and `share`: see `rounding.Perturbation`.

    `numbers` are those of the MaterialX whose shaders are evaluated.

    `environment` is given in the modes INDIRECT and TRANSMISSION, where `l` has no meaning.
    """

    v: Array
    l: Array
    quantity: Quantity | None = None
    model: Model = Model.HARDWARE
    mode: Mode = Mode.REFLECTION
    environment: Environment | None = None
    share: float = 1.0
    numbers: versions.Numbers = field(default_factory=versions.installed)

    def perturbs(self, quantity: Quantity) -> bool:
        """True if this quantity is to be taken at the edge of its error."""
        return self.quantity is quantity

    def kept(self, _name: str, function: Callable[[], _Result]) -> _Result:
        """The function's result, an intermediate one that is kept by this name, one of its own in the closure.

        A perturbed evaluation takes it from the exact one where the perturbation does not touch what it is made of,
        which is what the closure has asked for before, and what the function asks for.
        """
        return function()


def nothing() -> Closure:
    """The closure of nothing: no response, and everything below shows."""
    return Closure(np.zeros((3, 1)), np.ones((3, 1)))


def opaque(response: Array) -> Closure:
    """A closure that lets nothing through; MaterialX gives it this throughput at any weight."""
    return Closure(response, np.zeros((3, 1)))


def dot(a: Array, b: Array) -> Array:
    """Scalar product, shape (samples,)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def unit(a: Array) -> Array:
    """Unit vectors along these, shape (3, samples)."""
    return np.asarray(a / np.sqrt(dot(a, a)))


def cosine(a: Array, b: Array) -> Array:
    """Scalar product clamped to [EPSILON, 1], as the shaders have it."""
    return np.clip(dot(a, b), EPSILON, 1.0)


def facing(n: Array, v: Array) -> Array:
    """The normal, turned to the side of v."""
    return np.where(dot(n, v) < 0.0, -n, n)


def environment(light: Light) -> Environment:
    """The environment of an evaluation that asks for it.

    Raises
    ------
    ValueError
        In the mode REFLECTION, which has none.
    """
    if light.environment is None:
        msg = f"{light.mode.value} is evaluated with an environment"
        raise ValueError(msg)
    return light.environment
