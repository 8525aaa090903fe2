"""What a surface is expected to show, and how what a shader shows compares: shared by all checks of surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines.gl import DirectionalLight, Lighting
from mrm_mtlx.engines.gl import Environment as DrawnEnvironment
from mrm_mtlx.reference import Environment, Illumination, Surface, UnsupportedError
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.catalogue import NARROWEST_ALPHA
from mrm_mtlx.validation.comparison import compare, draw, worse

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from mrm_mtlx.engines.gl import SurfaceProgram
    from mrm_mtlx.reference import Tolerance
    from mrm_mtlx.reference.closures import Facets
    from mrm_mtlx.validation.comparison import Comparison

# Surroundings of one colour, no two channels alike: what a lobe shows of them is its albedo, and what it lets through.
# In ESSL, MaterialX's samplers have the language's default precision, lowp, which holds these numbers exactly.
_SURROUNDINGS = (1.0, 0.75, 0.5)
# Directions by which the light of the surroundings on a glossy lobe is estimated; each costs as much as a sample under
# one light, so there are as many samples fewer.
_DIRECTIONS = 16


class Expectation:
    """The reference of one surface over samples: under one light, and in surroundings of one colour.

    Parameters
    ----------
    element
        As `Surface`.
    rng, samples
        Where the samples come from, and their number under the light.
    images
        As `Surface`.

    Attributes
    ----------
    reason
        Why there is no reference, "" if there is one.
    surface, lobes
        The reference, or None, and the shapes of its microfacet lobes.
    """

    def __init__(
        self, element: Any, rng: np.random.Generator, samples: int, images: Callable[[str], NDArray[np.floating] | None]
    ) -> None:
        self.reason = ""
        self.surface: Surface | None = None
        self.lobes: list[sampling.LobeShape] = []
        try:
            self.surface = Surface(element, images=images)
        except (UnsupportedError, RecursionError) as error:
            self.reason = str(error)
        else:
            probe = sampling.shading_points(rng, *sampling.sample_local(rng, 2))
            self.lobes = [shape_of(facets) for facets in self.surface.traits(probe).lobes]
        # The peak of a lobe that float32 cannot hold is not looked for; LOBE_TOO_NARROW says so.
        sharp = [lobe for lobe in self.lobes if min(lobe.alpha_x, lobe.alpha_y) >= NARROWEST_ALPHA]
        lit = sampling.shading_points(rng, *sampling.sample_local(rng, samples, sharp))
        self._points = lit, lit.part(slice(0, -(-samples // _DIRECTIONS)))
        self._tolerances: tuple[Tolerance, ...] | None = None

    def prepare(self) -> None:
        """Evaluate the reference now and not when it is first compared: its element may change after this."""
        self._expected()

    def draw(
        self, program: SurfaceProgram, uniforms: Mapping[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], ...]:
        """Colours that a shader gives for the samples, under the light and in the surroundings."""
        pixel = np.full((1, 1, 3), _SURROUNDINGS, dtype=np.float32)
        lighting = (
            Lighting(DirectionalLight(sampling.LIGHT)),
            Lighting(environment=DrawnEnvironment(pixel, pixel, _DIRECTIONS)),
        )
        return tuple(draw(program, p, uniforms, at) for p, at in zip(self._points, lighting, strict=True))

    def compare(self, found: tuple[NDArray[np.floating], ...]) -> Comparison:
        """Compare what was drawn with the reference, which there must be; both comparisons as one."""
        comparisons = [
            compare(colors, tolerance, points)
            for colors, tolerance, points in zip(found, self._expected(), self._points, strict=True)
        ]
        return worse(*comparisons)

    def _expected(self) -> tuple[Tolerance, ...]:
        if self._tolerances is None and self.surface is not None:
            around = Illumination(light=False, environment=Environment.constant(_SURROUNDINGS, _DIRECTIONS))
            lit, few = self._points
            self._tolerances = self.surface.tolerance(lit), self.surface.tolerance(few, around)
        return self._tolerances or ()


def shape_of(facets: Facets) -> sampling.LobeShape:
    """Widths of a lobe of a document, which are the same at all samples or taken as their mean."""
    widths = [np.clip(np.mean(a), 1e-6, 1.0) for a in (facets.alpha_x, facets.alpha_y)]
    return sampling.LobeShape(widths[0], widths[1], bool(np.any(facets.retroreflective)))
