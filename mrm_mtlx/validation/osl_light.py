"""A document's OSL in Cycles: what its closures reflect of a light, where they are the reference's models."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.engines import osl
from mrm_mtlx.reference import Model, ShadingPoints, Surface, UnsupportedError
from mrm_mtlx.reference.closures import ORDINARY, RETROREFLECTIVE
from mrm_mtlx.shadergen import OslMode, generate
from mrm_mtlx.validation import sampling
from mrm_mtlx.validation.comparison import compare
from mrm_mtlx.validation.expectation import shape_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.validation.comparison import Comparison

# Angles between v and l of the suns that closures are measured under: from well inside the narrowest lobe to grazing.
ANGLES_DEG = (0.05, 0.15, 0.4, 1.0, 2.5, 6.0, 12.0, 25.0, 45.0, 70.0, 100.0, 140.0)

# The portal's step in a cloud of facets, which lie a unit apart at coordinates up to 200: 10^3 times their rounding.
PORTAL_STEP = 0.02

# Samples whose shading is measured, as a share of those of a comparison: a renderer starts for them.
_SHARE = 8

# Renderers take the slope of a facet from 1 - cos^2, whose 24 roundings of 2^-24 are a quarter of this width's square.
NARROWEST = 0.0025

# What a cloud of facets has as the reference has it; where it lies and its texture coordinates are its own.
_GEOMETRY = {"Nworld", "Nobject", "Tworld", "Vworld"}


def compare_in_osl(element: Any, library: DataLibrary, samples: int, rng: np.random.Generator) -> Comparison | str:
    """Compare the direct light response of an element's OSL closures with the reference's, or say why not.

    Where the flag is on, the surface is met again from v' through a portal (`OslMode.CYCLES`): the exact one of the
    library's ways.

    Raises
    ------
    RuntimeFailure
        If Cycles refuses or dies.
    """
    try:
        surface = Surface(element, Model.CLOSURES)
    except (UnsupportedError, RecursionError) as error:
        return str(error)
    if surface.is_pattern:
        return "it is no shader, and a renderer of OSL shows closures alone"
    traits = surface.traits(sampling.shading_points(rng, *sampling.sample_local(rng, 64)))
    lobes = [shape_of(facets) for facets in traits.lobes if not facets.off]
    kinds = traits.foreign & {ORDINARY, RETROREFLECTIVE}
    other = sorted(traits.foreign - kinds)
    if other:
        return f"its {' and '.join(other)} {'are' if other[1:] else 'is'} another model in OSL's renderers"
    if len(kinds) > 1:
        return "its ordinary lobes are seen from the wrong side where the retroreflective ones are exact in OSL"
    turns = any(lobe.alpha_x != lobe.alpha_y for lobe in lobes) or _depends_on_tangents(surface, rng, lobes)
    if turns or traits.properties or not traits.geometry <= _GEOMETRY:
        return "facets for the measurement have no tangents, positions or texture coordinates of their own"
    if any(min(lobe.alpha_x, lobe.alpha_y) < NARROWEST for lobe in lobes):
        return f"a lobe is narrower than {NARROWEST}, which renderers of OSL cannot hold in float32"
    points = sun_points(rng, -(-samples // (_SHARE * len(ANGLES_DEG))), lobes)
    together = ShadingPoints.joined(points)
    mode = OslMode.CYCLES if RETROREFLECTIVE in kinds else OslMode.ALIGNED
    source = generate(element, "osl", library, mode).sources["pixel"]
    shader = osl.compile_for_cycles(f"#define MRM_PORTAL_STEP {PORTAL_STEP}\n{source}", "document")
    seen = replace(together, normal=osl.true_normals(together.normal).astype(float))
    found = osl.direct_light_by_groups(shader, together.normal, {}, [group.light for group in points])
    return compare(found, surface.tolerance(seen), seen)


def _depends_on_tangents(surface: Surface, rng: np.random.Generator, lobes: Sequence[sampling.LobeShape]) -> bool:
    """Whether a turn of the tangents changes the response: equal widths ask for them too, and do not depend on them."""
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
