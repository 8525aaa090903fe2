"""The expected colours of a surface, and their comparison with those of a shader; shared by all checks of surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.document_images import ImagesTooLargeError
from mrm_mtlx.engines.base import DirectionalLight, Lighting
from mrm_mtlx.engines.base import Environment as DrawnEnvironment
from mrm_mtlx.findings.rules.optics import NARROWEST_ALPHA
from mrm_mtlx.reference import Environment, Illumination, Surface, UnsupportedError
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import compare, draw, worse

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Program
    from mrm_mtlx.reference import Tolerance
    from mrm_mtlx.reference.closures import Facets
    from mrm_mtlx.reference.deviations import Deviation
    from mrm_mtlx.validation.comparison.samples import Comparison, Drawing

# An environment of one colour, no two channels alike: what a lobe shows of it is its albedo, and what it lets through.
# In ESSL, MaterialX's samplers have the language's default precision, lowp, which holds these numbers exactly.
_ENVIRONMENT = (1.0, 0.75, 0.5)
# Directions by which the light of the environment on a glossy lobe is estimated; each costs as much as a sample under
# one light, so there are as many samples fewer.
_DIRECTIONS = 16

# One sample in as many is lit from below, beginning with this one: what is translucent shows it.
_BELOW = 7


@dataclass(frozen=True)
class Verdict:
    """The outcome of a comparison.

    Attributes
    ----------
    comparison
        With the specification; where that failed and `deviations` explain it, with the reference deviating likewise, or
        of the source without them.
    deviations
        Known deviations of MaterialX without which the comparison would have failed.
    specified
        The comparison with the specification, where it failed and that with `deviations` passed.
    """

    comparison: Comparison
    deviations: frozenset[Deviation] = frozenset()
    specified: Comparison | None = None


class Expectation:
    """The reference of one surface over samples: under one light, and in an environment of one colour.

    Parameters
    ----------
    element
        As `Surface`.
    rng, samples
        Where the samples come from, and their number under the light.
    images
        As `Surface`.
    reason
        Why no reference is to be made, if so.

    Attributes
    ----------
    reason
        Why there is no reference, "" if there is one.
    surface, lobes
        The reference, or None, and the shapes of its microfacet lobes.
    """

    def __init__(
        self,
        element: Any,
        rng: np.random.Generator,
        samples: int,
        images: Callable[[str], NDArray[np.floating] | None],
        reason: str = "",
    ) -> None:
        self.reason = reason
        self.surface: Surface | None = None
        self.lobes: list[sampling.LobeShape] = []
        self._element, self._images = element, images
        self._met: set[Deviation] = set()
        kinds = {} if reason else self._prepare(rng)
        # The peak of a lobe that float32 cannot hold is not looked for; LOBE_TOO_NARROW says so.
        sharp = [lobe for lobe in self.lobes if min(lobe.alpha_x, lobe.alpha_y) >= NARROWEST_ALPHA]
        v, l = sampling.sample_local(rng, samples, sharp)
        l[_BELOW::_DIRECTIONS, 2] *= -1.0
        lit = sampling.shading_points(rng, v, l, sampling.geometric_properties(rng, kinds, samples))
        self._points = lit, lit.part(slice(0, -(-samples // _DIRECTIONS)))
        self._tolerances: dict[tuple[int, frozenset[Deviation]], Tolerance] = {}

    def _prepare(self, rng: np.random.Generator) -> Mapping[str, str]:
        """Make the reference, or find the reason why there is none; the geometric properties that it asks for."""
        try:
            surface = Surface(self._element, images=self._images)
            traits = surface.traits(sampling.shading_points(rng, *sampling.sample_local(rng, 2)))
        except (UnsupportedError, RecursionError) as error:
            self.reason = str(error)
            return {}
        except ImagesTooLargeError as error:
            self.reason = f"it has {error}"
            return {}
        self.surface = surface
        self.lobes = [shape_of(facets) for facets in traits.lobes]
        return traits.properties

    def not_finite(self) -> str:
        """Path of the node whose value in the reference is the first that is no finite number, or ""."""
        return "" if self.surface is None else self.surface.not_finite(self._points[0])

    def draw(self, program: Program, uniforms: Mapping[str, Any] | None = None) -> tuple[Drawing, ...]:
        """Colours that a shader gives for the samples: under the light and, where it takes one, in the environment."""
        pixel = np.full((1, 1, 3), _ENVIRONMENT, dtype=np.float32)
        lighting = [Lighting(DirectionalLight(sampling.LIGHT))]
        if program.capabilities.environment:
            lighting.append(Lighting(environment=DrawnEnvironment(pixel, pixel, _DIRECTIONS)))
        return tuple(draw(program, p, uniforms, at) for p, at in zip(self._points, lighting, strict=False))

    def compare(self, found: tuple[Drawing, ...]) -> Verdict:
        """Compare what was drawn with the reference, which there must be.

        Where it is not what the specification says, it may be what MaterialX is known to make of it.
        """
        true = self._compare(found, frozenset())
        known = frozenset(self._met)
        if true.passed or not known:
            return Verdict(true)
        as_known = self._compare(found, known)
        if not as_known.passed:
            return Verdict(true)
        for one in sorted(known, key=lambda deviation: deviation.value):  # what explains nothing is not named
            fewer = known - {one}
            without = self._compare(found, fewer)
            if without.passed:
                as_known, known = without, fewer
        return Verdict(as_known, known, true)

    def _compare(self, found: tuple[Drawing, ...], deviations: frozenset[Deviation]) -> Comparison:
        """The comparisons under the light and in the environment as one."""
        compared = []
        for index, drawing in enumerate(found):  # an engine without environments gave the colours under the light alone
            tolerance = drawing.allowed(self._tolerance(index, drawing, deviations))
            compared.append(compare(drawing.colors, tolerance, drawing.points))
        return reduce(worse, compared)

    def _tolerance(self, index: int, drawing: Drawing, deviations: frozenset[Deviation]) -> Tolerance:
        """What is expected at the points of a drawing, under the light, index 0, or in the environment."""
        points, version = drawing.points, drawing.capabilities.materialx
        asked_for = points is self._points[index] and not version
        if asked_for and (index, deviations) in self._tolerances:
            return self._tolerances[index, deviations]
        surface = self.surface
        if deviations or surface is None or version:
            surface = Surface(self._element, images=self._images, deviations=deviations, version=version)
        around = Illumination(light=False, environment=Environment.constant(_ENVIRONMENT, _DIRECTIONS))
        found = surface.tolerance(points, around) if index else surface.tolerance(points)
        self._met |= surface.met
        if asked_for:
            self._tolerances[index, deviations] = found
        return found


def shape_of(facets: Facets) -> sampling.LobeShape:
    """Widths of a lobe of a document, which are the same at all samples or taken as their mean."""
    widths = [np.clip(np.mean(a), 1e-6, 1.0) for a in (facets.alpha_x, facets.alpha_y)]
    return sampling.LobeShape(widths[0], widths[1], bool(np.any(facets.retroreflective)))
