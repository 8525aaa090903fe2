"""Samples of a surface, and the same samples through the generated shader."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.engines.base import DirectionalLight, Lighting
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import ShadingPoints
from mrm_mtlx.shadergen import generate
from tests.fixtures.versions import planted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.library import DataLibrary

# A light that is at home on no axis: no product is exact by luck.
LIGHT = np.array([2.0, 3.0, 6.0]) / 7.0


def float32(a: Array) -> Array:
    """Rounded to float32, kept in float64."""
    return np.asarray(a, dtype=np.float32).astype(float)


@pytest.fixture(scope="session")
def flat_points() -> Callable[..., ShadingPoints]:
    """Function from local directions v and l to samples of a surface that lies in the plane z = 0."""

    def make(v: Array, l: Array, **properties: Array) -> ShadingPoints:
        v, l = (np.atleast_2d(np.asarray(a, dtype=float)) for a in np.broadcast_arrays(v, l))
        frame = (np.broadcast_to(axis, v.shape).astype(float) for axis in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
        return ShadingPoints(v, l, *frame, position=-v, texcoord=np.zeros((len(v), 2)), properties=properties)

    return make


@pytest.fixture(scope="session")
def turned_points() -> Callable[..., ShadingPoints]:
    """Function from local directions v and l to samples turned at random, so that every l lies in one direction.

    One sample in sixteen has its normal turned to the back. The eye is at the origin.
    """

    def make(rng: np.random.Generator, v: Array, l: Array, properties: Mapping[str, Array] | None = None):
        spin = rng.uniform(0.0, 2.0 * np.pi, len(v))

        def frames(first: Array, angle: Array) -> Array:
            """Right-handed frames (samples, axis, component) with this first axis, spun about it."""
            helper = np.where(np.abs(first[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
            second = np.cross(first, helper)
            second /= np.linalg.norm(second, axis=-1, keepdims=True)
            third = np.cross(first, second)
            c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
            return np.stack([first, c * second + s * third, c * third - s * second], axis=1)

        turn = np.einsum("nki,nkj->nij", frames(np.tile(LIGHT, (len(v), 1)), spin), frames(l, np.zeros(len(v))))
        facing = np.where(np.arange(len(v)) % 16 == 15, -1.0, 1.0)[:, None]
        view = float32(np.einsum("nij,nj->ni", turn, v))
        return ShadingPoints(
            view=view,
            light=float32(LIGHT),
            normal=float32(turn[:, :, 2] * facing),
            tangent=float32(turn[:, :, 0]),
            position=-view,
            texcoord=np.zeros((len(v), 2)),
            properties={name: float32(value) for name, value in (properties or {}).items()},
        )

    return make


@pytest.fixture(scope="module")
def drawn(gl, library: DataLibrary) -> Iterator[Callable[..., Array]]:
    """Function from a document and samples to what the generated GLSL gives for them, (samples, 3).

    With `old` and `new`, of the pixel source damaged so; `uniforms` are those of `SurfaceProgram.draw`. A driver takes
    a second for each new source, so programs are kept for the module.
    """
    programs: dict[str, SurfaceProgram] = {}

    def draw(
        document: mx.Document,
        points: ShadingPoints,
        data: DataLibrary = library,
        old: str = "",
        new: str = "",
        uniforms: Mapping[str, object] | None = None,
    ) -> Array:
        shader = generate(document.getNode("m"), "glsl", data)
        pixel = shader.sources["pixel"]
        if old:
            pixel = planted(pixel, old, new)
        if pixel not in programs:
            programs[pixel] = SurfaceProgram(replace(shader, sources={**shader.sources, "pixel": pixel}))
        inputs = {
            "positionWorld": points.position,
            "normalWorld": points.normal,
            "tangentWorld": points.tangent,
            **{f"i_geomprop_{name}": value for name, value in points.properties.items()},
        }
        return programs[pixel].draw(inputs, Lighting(DirectionalLight(tuple(points.light))), uniforms)[:, :3]

    yield draw
    for program in programs.values():
        program.release()
