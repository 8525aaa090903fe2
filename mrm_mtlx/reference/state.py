"""State of an evaluation: the samples, the light on them, and what the walk over the graph has met so far."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.reference.closures import Environment, Facets, Light, Mode, Model
from mrm_mtlx.reference.closures.light import unit
from mrm_mtlx.reference.float32.rounding import EXACT, Direction, Perturbation, value_sign
from mrm_mtlx.reference.sharing import NotingLight, Values
from mrm_mtlx.reference.versions import Numbers, installed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.reference.points import ShadingPoints


@dataclass(frozen=True)
class Illumination:
    """The light on a surface: one light of unit irradiance at each sample's l, or none, and its environment."""

    light: bool = True
    environment: Environment | None = None


LIGHT = Illumination()


@dataclass
class Discrete:
    """Discrete intermediate results (a comparison, a floor) of an exact evaluation.

    A result that is the same at all samples is a property of the document and no matter of rounding: perturbed
    evaluations take it from here. `varying` are those that are not.
    """

    settled: dict[tuple[str, str, int], Array] = field(default_factory=dict)
    varying: dict[tuple[str, str, int], Array] = field(default_factory=dict)


@dataclass
class State:
    """State of one evaluation: the samples and the light, and what has been met; values by node, scope and mode.

    `images` gives the pixels of a file by its name in the document; `exact` is that of the exact evaluation of the same
    samples: what it decided, and its values that the perturbation does not touch, are taken from there. `watch` is told
    the path of each node that is evaluated, those that it depends on first, and its value. `numbers` are those of the
    MaterialX whose shaders are evaluated.
    """

    points: ShadingPoints
    perturbation: Perturbation = EXACT
    model: Model = Model.HARDWARE
    illumination: Illumination = LIGHT
    images: Callable[[str], NDArray[np.floating] | None] = lambda _name: None
    deviations: frozenset[Deviation] = frozenset()
    exact: State | None = None
    discrete: Discrete = field(default_factory=Discrete)
    lobes: list[Facets] = field(default_factory=list)
    used: set[str] = field(default_factory=set)  # geometry, by the names of `frame`
    asked: dict[str, str] = field(default_factory=dict)  # geometric properties and their types
    other_numbers: set[str] = field(default_factory=set)  # nodes whose numbers OSL has otherwise
    met: set[Deviation] = field(default_factory=set)  # where MaterialX's code may deviate
    watch: Callable[[str, Any], None] = lambda _path, _value: None
    numbers: Numbers = field(default_factory=installed)

    def __post_init__(self) -> None:
        """Prepare the shading frame as the generated vertex stage and `main` do."""
        # The generated shader normalises what it interpolates, and takes the light's direction as it is.
        view, light = unit(self.points.view.T), np.atleast_2d(self.points.light).T
        by = self.perturbation
        self.values: Values = Values(by, None if self.exact is None else self.exact.values)
        at = NotingLight(view, light, by.quantity, self.model, share=by.share, values=self.values, numbers=self.numbers)
        self.light: Light = at
        environment = self.illumination.environment
        modes = [] if environment is None else [Mode.INDIRECT, Mode.TRANSMISSION]
        around = [replace(at, mode=m, environment=environment) for m in modes]
        self.lights: list[Light] = [*[at] * self.illumination.light, *around]
        normal, tangent = self.points.normal.T, self.points.tangent.T
        frame = {"N": unit(normal), "T": unit(tangent), "B": unit(np.cross(normal, tangent, axis=0))}
        frame["P"] = self.points.position.T
        named = {f"{name}{space}": value for name, value in frame.items() for space in ("world", "object")}
        self.frame = _Noting(named | {"UV0": self.points.texcoord.T, "Vworld": -view}, self.used, self.values)
        self.definitions: dict[tuple[str, str], Any] = {} if self.exact is None else self.exact.definitions
        self._numbers = 0  # rounded so far
        properties = self.points.properties
        self.properties = {name: self.rounded(np.asarray(v, dtype=float).T) for name, v in properties.items()}

    def rounded(self, value: Array) -> Array:
        """A number of the document or of a node, rounded where the perturbation says so."""
        by = self.perturbation
        if not by.values:
            return value
        self._numbers += 1
        return value * (1.0 + by.step * value_sign(by.values, self._numbers))

    def deviates(self, deviation: Deviation) -> bool:
        """True if the evaluation is to deviate from the specification so; that it can is noted, if the version does."""
        if deviation not in self.light.numbers.deviations:
            return False
        self.met.add(deviation)
        return deviation in self.deviations

    def settle(self, key: tuple[str, str, int], value: Array) -> Array:
        """A discrete result; see `Discrete`."""
        if value.ndim == 0 or value.shape[-1] == 1:
            if self.exact is not None:
                return self.exact.discrete.settled.get(key, value)
            self.discrete.settled[key] = value
        else:
            self.discrete.varying[key] = value
        return value


class _Noting(dict[str, "Array"]):
    """A dictionary that notes which of its entries were asked for."""

    def __init__(self, entries: Mapping[str, Array], asked: set[str], values: Values) -> None:
        super().__init__(entries)
        self._asked, self._values = asked, values

    def __getitem__(self, name: str) -> Array:
        self._asked.add(name)
        if name == "Vworld":
            self._values.note((Direction.VIEW,))
        return super().__getitem__(name)
