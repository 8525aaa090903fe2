"""The light that a document's OSL closures reflect in a renderer, where they are the reference's models."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.reference import Model, ShadingPoints, Surface, UnsupportedError
from mrm_mtlx.reference.models import LobeKind
from mrm_mtlx.shadergen import OslMode, generate
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.expectation import shape_of
from mrm_mtlx.validation.comparison.samples import compare

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.engines.base import ClosureBench
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.validation.comparison.samples import Comparison

# Angles between v and l of the suns that closures are measured under: from well inside the narrowest lobe to grazing.
ANGLES_DEG = (0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 12.0, 25.0, 45.0, 70.0, 100.0, 140.0)

# Samples whose shading is measured, as a share of those of a comparison: a renderer starts for them.
_SHARE = 8


def compare_closures(
    element: Any, library: DataLibrary, samples: int, rng: np.random.Generator, bench: ClosureBench
) -> Comparison | str:
    """Compare the direct light response of an element's closures on a bench with the reference's, or say why not.

    Where the flag is on, the lobe is made in the way of the library that is exact on the bench.

    Raises
    ------
    EngineFailure
        If the renderer refuses or dies.
    """
    try:
        surface = Surface(element, Model.CLOSURES)
    except (UnsupportedError, RecursionError) as error:
        return str(error)
    if surface.is_pattern:
        return "it is no shader, and a renderer of OSL shows closures alone"
    traits = surface.traits(sampling.shading_points(rng, *sampling.sample_local(rng, 64)))
    lobes = [shape_of(facets) for facets in traits.lobes if not facets.off]
    kinds, other = traits.contents.lobes, traits.contents.unsupported
    if other:
        return f"its {' and '.join(other)} {'are' if other[1:] else 'is'} another model in OSL's renderers"
    if len(kinds) > 1:
        return "its ordinary lobes are seen from the wrong side where the retroreflective ones are exact in OSL"
    turns = any(lobe.alpha_x != lobe.alpha_y for lobe in lobes) or _depends_on_tangents(surface, rng, lobes)
    if turns or traits.properties or not traits.geometry <= bench.geometry:
        return "facets for the measurement have no tangents, positions or texture coordinates of their own"
    if any(min(lobe.alpha_x, lobe.alpha_y) < bench.narrowest_alpha for lobe in lobes):
        return f"a lobe is narrower than {bench.narrowest_alpha}, which renderers of OSL cannot hold in float32"
    points = sun_points(rng, -(-samples // (_SHARE * len(ANGLES_DEG))), lobes)
    together = ShadingPoints.joined(points)
    mode = bench.exact_mode if LobeKind.RETROREFLECTIVE in kinds else OslMode.ALIGNED
    program = bench.compile(generate(element, bench.target, library, mode).sources["pixel"], "document")
    seen = replace(together, normal=bench.true_normals(together.normal).astype(float))
    found = program.direct_light_by_groups(together.normal, {}, [group.light for group in points])
    return compare(found, surface.tolerance(seen), seen)


def _depends_on_tangents(surface: Surface, rng: np.random.Generator, lobes: Sequence[sampling.LobeShape]) -> bool:
    """True if a turn of the tangents changes the response: equal widths ask for them too, and do not depend on them."""
    points = sampling.shading_points(rng, *sampling.sample_local(rng, 256, lobes))
    turned = replace(points, tangent=np.cross(points.normal, points.tangent) + 0.5 * points.tangent)
    before, after = surface.response(points), surface.response(turned)
    # A turn moves the last digits of the facet's slopes, whose error narrow lobes multiply.
    return bool(np.any(np.abs(after - before) > 1e-6 * np.maximum(before, after)))


def sun_points(rng: np.random.Generator, count: int, lobes: Sequence[sampling.LobeShape]) -> list[ShadingPoints]:
    """Samples with v = z, a group of `count` for each sun, in the xz-plane; v and l above every surface.

    Half of the normals lie anywhere, the others so that the facet halfway between v and l is one of a lobe's own.
    """
    return [_at_angle(rng, count, float(angle), lobes) for angle in np.deg2rad(ANGLES_DEG)]


def _at_angle(rng: np.random.Generator, count: int, angle: float, lobes: Sequence[sampling.LobeShape]) -> ShadingPoints:
    view, light = np.array([0.0, 0.0, 1.0]), np.array([np.sin(angle), 0.0, np.cos(angle)])
    halfway = np.broadcast_to([np.sin(angle / 2.0), 0.0, np.cos(angle / 2.0)], (count, 3))
    tilt = np.arccos(rng.random(count))
    if lobes:
        u = rng.random(count)
        widths = np.array([lobe.alpha_x for lobe in lobes])[rng.integers(0, len(lobes), count)]
        tilt = np.where(rng.random(count) < 0.5, np.arctan(widths * np.sqrt(u / (1.0 - u))), tilt)
    normal = sampling.rotated(halfway, tilt, 2.0 * np.pi * rng.random(count))
    above = np.minimum(normal @ view, normal @ light) > 1e-3
    normal = np.where(above[:, None], normal, halfway)
    return ShadingPoints(
        view=np.broadcast_to(view, (count, 3)),
        light=sampling.float32(light),
        normal=normal,
        tangent=sampling.perpendicular(normal),
        position=np.zeros((count, 3)),
        texcoord=np.zeros((count, 2)),
    )
