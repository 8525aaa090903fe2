"""A renderable element of a document, ready to be evaluated."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, is_dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx
import numpy as np

from mrm_mtlx.bsdf.blocks import BLOCK, processors
from mrm_mtlx.documents.graph import Scope, shown
from mrm_mtlx.reference import versions
from mrm_mtlx.reference.closures import Facets, Model
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.display import CHANNELS, SHADERS, displayed
from mrm_mtlx.reference.evaluation import Evaluation
from mrm_mtlx.reference.float32.rounding import (
    EXACT,
    OUTPUT_ROUNDINGS,
    SMALLEST,
    UNIT,
    Perturbation,
    Quantity,
    Tolerance,
    channel_perturbations,
    farthest,
    on_the_way,
    opposite_perturbations,
    perturbations,
    range_perturbations,
)
from mrm_mtlx.reference.models import Contents
from mrm_mtlx.reference.nodes import ShaderValue
from mrm_mtlx.reference.points import ShadingPoints
from mrm_mtlx.reference.state import LIGHT, Illumination
from mrm_mtlx.reference.survey import Survey, UnsupportedError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.reference.nodes import Value


@dataclass(frozen=True)
class Traits:
    """Lobes, geometry and other contents of a surface.

    Attributes
    ----------
    lobes
        Its microfacet lobes, with their parameters; in the graph's order.
    contents
        Those of its response; nothing for `Model.HARDWARE`.
    geometry
        What of the shading frame (see `nodes.Inputs.frame`) it depends on.
    properties
        The geometric properties that it depends on, and their types.
    """

    lobes: list[Facets]
    contents: Contents
    geometry: frozenset[str]
    properties: Mapping[str, str]


class Surface:
    """A renderable element, ready to be evaluated.

    Parameters
    ----------
    element
        A material, a node of type surfaceshader, or an output, in a document whose data library is set. An output that
        is no shader (a number, a colour, a vector) shows its value, whatever the light.
    model
        Whose microfacet lobes: those of the hardware targets, or of OSL's closures.
    deviations
        Known deviations of MaterialX's code from its specification that are to be followed; by default, none is.
    images
        Function from a file's name, as the document resolves it, to its pixels, shape (height, width, channels), row 0
        at the top; None where there is no such image.
    version
        Of the MaterialX whose shaders are evaluated; by default, of the one that is installed.

    Attributes
    ----------
    met
        Where MaterialX's code may deviate from the specification, of everything that `tolerance` has evaluated so far.
    is_pattern
        Whether it is such an output: there are no lobes, and no light is reflected.

    Raises
    ------
    UnsupportedError
        If the graph uses what the reference does not know; all of it is named at once.
    RecursionError
        If the graph is deeper than `survey.MAXIMUM_DEPTH` nodes, or cyclic.
    """

    def __init__(
        self,
        element: Any,
        model: Model = Model.HARDWARE,
        images: Callable[[str], NDArray[np.floating] | None] = lambda _name: None,
        deviations: frozenset[Deviation] = frozenset(),
        version: str = "",
    ) -> None:
        if not isinstance(element, mx.Element):
            msg = f"element is of type {type(element).__name__}, expected an element of MaterialX"
            raise TypeError(msg + "; `open_document(path).surfaces()` gives those of a file")
        self._element = element
        self._model = model
        self._images = images
        self._deviations = deviations
        self._numbers = versions.of(version) if version else versions.installed()
        self.met: set[Deviation] = set()
        self._document = element.getDocument()  # elements do not keep their document alive
        self._root = shown(element)
        self._scope = Scope(shown=element.getParent() if element.isA(mx.Output) else None)
        self._kind = str(element.getType())
        self.is_pattern = self._kind not in SHADERS
        survey = Survey()
        if self.is_pattern and self._kind not in CHANNELS:
            survey.unknown.add(f"outputs of type {self._kind}, which shaders show as black")
        if self._root is not None:
            survey.visit(self._root[0])
        if survey.unknown:
            raise UnsupportedError(sorted(survey.unknown))

    def __repr__(self) -> str:
        """The path of its element."""
        return f"<Surface {self._element.getNamePath()}>"

    def response(self, points: ShadingPoints, perturbation: Perturbation = EXACT) -> Array:
        """Radiance per unit irradiance of one light, the cosine of l included, shape (samples, 3), float64.

        Emission is left out. `perturbation` is one of the evaluation by a rounding error; see `float32.rounding`.
        """

        def reflected(part: ShadingPoints) -> Array:
            dark = Illumination(light=False)
            return self._color(part, LIGHT, perturbation) - self._color(part, dark, perturbation)

        return _in_blocks(reflected, points)

    def shade(
        self, points: ShadingPoints, illumination: Illumination = LIGHT, perturbation: Perturbation = EXACT
    ) -> Array:
        """Colour that hardware shaders write: reflected, transmitted and emitted light times the opacity, (samples, 3).

        Of an output that is no shader, its value as a colour; (samples, 4) if that has an alpha.
        """
        return _in_blocks(lambda part: self._color(part, illumination, perturbation), points)

    def traits(self, points: ShadingPoints) -> Traits:
        """The traits that are met while these points are evaluated under a light."""
        evaluation = self._evaluation(points, LIGHT, EXACT)
        value = self._value(evaluation)
        contents = value.contents if isinstance(value, ShaderValue) else Contents()
        return Traits(
            evaluation.lobes,
            contents | Contents(nodes=frozenset(evaluation.other_numbers)),
            frozenset(evaluation.used),
            evaluation.asked,
        )

    def not_finite(self, points: ShadingPoints) -> str:
        """Path of the first node that gives what is no finite number while these points are evaluated, or ""."""
        found: list[str] = []

        def watch(path: str, value: Any) -> None:
            if not found and not all(np.all(np.isfinite(array)) for array in _arrays(value)):
                found.append(path)

        evaluation = self._evaluation(points, LIGHT, EXACT)
        evaluation.watch = watch
        self._value(evaluation)
        return "".join(found)

    def tolerance(self, points: ShadingPoints, illumination: Illumination = LIGHT) -> Tolerance:
        """The expected colour, `shade`, and by how much a float32 evaluation may miss it.

        allowed = sum over the perturbations of factor * |shade(perturbed) - shade| + OUTPUT_ROUNDINGS units of the
        magnitudes; of the places in a range, the farthest one.
        """

        def both(part: ShadingPoints) -> Array:
            return np.concatenate(self._tolerance(part, illumination), axis=1)

        found = _in_blocks(both, points)
        return Tolerance(*np.split(found, 2, axis=1))

    def _tolerance(self, points: ShadingPoints, illumination: Illumination) -> tuple[Array, Array]:
        exact = self._evaluation(points, illumination, EXACT)
        expected = self._result(exact)
        allowed = OUTPUT_ROUNDINGS * UNIT * np.abs(expected) + SMALLEST
        self.met |= exact.met
        is_lit = illumination.light and not self.is_pattern
        chosen = [one for one in perturbations(self._model) if is_lit or np.ndim(one.light) == 0]
        if exact.discrete.varying:  # a comparison or a floor: roundings may tip it to either side
            chosen += opposite_perturbations()

        def off_by(perturbation: Perturbation) -> Array:
            perturbed = self._color(points, illumination, perturbation, exact)
            with np.errstate(invalid="ignore"):
                by = np.where(perturbed == expected, 0.0, perturbed - expected)
            # What a rounding makes undefined may be anything.
            return perturbation.factor * np.where(np.isnan(by), np.inf, by)

        def size(perturbation: Perturbation) -> Array:
            return np.abs(off_by(perturbation))

        for perturbation in chosen:
            by = size(perturbation)
            if perturbation.quantity is Quantity.FUNCTIONS:
                by = np.maximum.reduce([by, *(size(pattern) for pattern in channel_perturbations())])
            allowed = allowed + by
        least, most = range_perturbations()
        if np.any(size(least)):
            ends = [farthest(np.stack([off_by(place) for place in on_the_way(end)])) for end in (least, most)]
        else:  # what is off to one side alone enters in proportion
            ends = [size(most)]
        return expected, allowed + np.maximum.reduce(ends)

    def _evaluation(
        self,
        points: ShadingPoints,
        illumination: Illumination,
        perturbation: Perturbation,
        exact: Evaluation | None = None,
    ) -> Evaluation:
        points = points.perturbed(perturbation.view, perturbation.light)
        return Evaluation(
            points, perturbation, self._model, illumination, self._images, self._deviations, exact,
            numbers=self._numbers,
        )  # fmt: skip

    def _color(
        self,
        points: ShadingPoints,
        illumination: Illumination,
        perturbation: Perturbation,
        exact: Evaluation | None = None,
    ) -> Array:
        return self._result(self._evaluation(points, illumination, perturbation, exact))

    def _result(self, evaluation: Evaluation) -> Array:
        """The colour that is shown, shape (samples, channels)."""
        color = displayed(self._value(evaluation), self._kind)
        if self._kind == "boolean" and evaluation.deviates(Deviation.BLACK_BOOLEANS):
            color = np.zeros_like(color)
        return np.ascontiguousarray(np.broadcast_to(color, (len(color), len(evaluation.points))).T)

    def _value(self, evaluation: Evaluation) -> Value | None:
        if self._root is None or self._is_black(evaluation):
            return None
        with np.errstate(all="ignore"):  # 0/0 of degenerate input is what the shader has, too
            return evaluation.node_value(*self._root, self._scope, evaluation.light)

    def _is_black(self, evaluation: Evaluation) -> bool:
        """True for a material of a definition of its own, which hardware targets show as black."""
        node = None if self._root is None else self._root[0]
        if node is None or node.getType() != "material" or node.getCategory() == "surfacematerial":
            return False
        return evaluation.deviates(Deviation.BLACK_MATERIALS)


def _arrays(value: Any) -> list[Array]:
    """The numbers that a node's value consists of."""
    if isinstance(value, dict):
        return [array for part in value.values() for array in _arrays(part)]
    if isinstance(value, np.ndarray):
        return [value]
    return [part for part in vars(value).values() if isinstance(part, np.ndarray)] if is_dataclass(value) else []


def _in_blocks(function: Callable[[ShadingPoints], Array], points: ShadingPoints) -> Array:
    """The function's results for blocks of the samples, one after the other, evaluated on all processors."""
    starts = range(0, len(points), BLOCK)
    if len(starts) < 2:
        return _of_one(function, points) if len(points) == 1 else function(points)
    parts = [points.part(slice(start, start + BLOCK)) for start in starts]
    if len(parts[-1]) == 1:  # see _of_one
        parts[-2:] = [points.part(slice(starts[-2], None))]
    with ThreadPoolExecutor(min(processors(), len(parts))) as pool:
        return np.concatenate(list(pool.map(function, parts)))


def _of_one(function: Callable[[ShadingPoints], Array], point: ShadingPoints) -> Array:
    """The function's result for one sample, evaluated as two: else what varies would be taken for a constant."""
    return function(ShadingPoints.joined([point, point]))[:1]
