"""The registry: node definition name to the function that evaluates it, and what such a function may ask for.

A value is a `Closure`, a `ShaderValue`, a string, or an array with the component first: scalars () or (samples,);
vectors and colours (components, 1) or (components, samples); matrices (rows, columns, 1) or (rows, columns, samples),
where row i is what MaterialX writes i-th. Booleans are arrays of bool, integers arrays of whole floats.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

from mrm_mtlx.reference.models import NOTHING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.closures import Closure, Facets, Light
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.reference.models import Contents


@dataclass(frozen=True)
class ShaderValue:
    """Value of a surface shader node: the colour it shows and its transparency, shape (3, samples) or (3, 1).

    `contents`: see `Closure`.
    """

    color: Array
    transparency: Array
    contents: Contents = NOTHING


Value: TypeAlias = "Closure | ShaderValue | str | Array"


class Inputs(Protocol):
    """A node as the function sees it that evaluates it."""

    @property
    def light(self) -> Light:
        """Directions of the evaluation, and which of the closures' modes it is."""
        ...

    @property
    def lights(self) -> list[Light]:
        """The lights that a surface adds up: its light, its environment in two modes, or none."""
        ...

    def under(self, light: Light) -> Inputs:
        """The same inputs as they are under another light."""
        ...

    @property
    def frame(self) -> Mapping[str, Array]:
        """The shading frame: Nworld, Tworld, Bworld (unit), Pworld, UV0, Vworld (from the eye to the surface).

        Object and model space are world space: Nobject, Tobject, Bobject, Pobject are the same.
        """
        ...

    def geometric_property(self, name: str, default: Array) -> Array:
        """A geometric property of the samples, component first; the default where they do not have it."""
        ...

    def array(self, name: str) -> Array:
        """A numeric input."""
        ...

    def stored(self, name: str) -> Array:
        """A colour as it stands in the document, not taken from its space to linear Rec.709."""
        ...

    def text(self, name: str) -> str:
        """A string input."""
        ...

    def image(self, name: str) -> NDArray[np.floating] | None:
        """Pixels of a file input, shape (height, width, channels), row 0 at the top; None if there is no such image."""
        ...

    def closure(self, name: str) -> Closure:
        """A BSDF or VDF input; nothing connected is the closure of nothing."""
        ...

    def emission(self, name: str) -> Array:
        """An EDF input, a colour; nothing connected is black."""
        ...

    def shader(self, name: str) -> ShaderValue:
        """A surface shader input; nothing connected is black and opaque."""
        ...

    def discrete(self, value: Array) -> Array:
        """A discrete intermediate result (a comparison, a floor): where it is the same at all samples, it is settled.

        Settled means that no rounding error changes it; where it varies, errors may tip it at the samples near a step.
        """
        ...

    def skipped(self, value: Array) -> Array:
        """True where the last discrete result, a whole number, is off by more than one: others are passed by."""
        ...

    @property
    def level(self) -> float:
        """A number in [0, 1], another one in each perturbation of the numbers."""
        ...

    def is_defined(self, name: str) -> bool:
        """True if the definition of the node has an input; earlier versions of MaterialX lack some."""
        ...

    def is_connected(self, name: str) -> bool:
        """True if an input takes its value from a node or an interface; constants are numbers to generators."""
        ...

    def is_weighted(self, name: str) -> bool:
        """True if the node that a BSDF input is connected to has a weight."""
        ...

    def deviates(self, deviation: Deviation) -> bool:
        """True if the node is to deviate from the specification so; that it can is noted, if the version does."""
        ...

    def note(self, facets: Facets) -> None:
        """Tell the evaluation of a microfacet lobe that it met."""
        ...


NodeFunction: TypeAlias = "Callable[[Inputs], Value | dict[str, Value]]"
NODES: dict[str, NodeFunction] = {}


def node(*definitions: str) -> Callable[[NodeFunction], NodeFunction]:
    """Register the function of these node definitions. Nodes with several outputs return a value per output name.

    Raises
    ------
    ValueError
        If a definition has a function already.
    """

    def register(function: NodeFunction) -> NodeFunction:
        twice = [name for name in definitions if name in NODES]
        if twice:
            msg = f"{', '.join(twice)}: registered twice"
            raise ValueError(msg)
        NODES.update(dict.fromkeys(definitions, function))
        return function

    return register
