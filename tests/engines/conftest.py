"""Programs and environments for the OpenGL engine."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.engines.base import Environment
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import materialx_version
from mrm_mtlx.shadergen import available_targets, generate
from mrm_mtlx.shadergen.precision import with_highp
from mrm_mtlx.shadergen.undeclared_block import with_members_alone
from tests.fixtures.versions import planted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.shadergen import Shader


@pytest.fixture(scope="session")
def shader_of(library: DataLibrary) -> Callable[..., Shader]:
    """Function from a document to the shader of its element; with `old` and `new`, the pixel source damaged so."""

    def make(
        document: mx.Document, *, element: str = "m", target: str = "glsl", old: str = "", new: str = ""
    ) -> Shader:
        if target not in available_targets():
            pytest.skip(f"MaterialX {materialx_version()} has no generator for {target}")
        shader = with_members_alone(with_highp(generate(document.getChild(element), target, library)))
        if not old:
            return shader
        return replace(shader, sources={**shader.sources, "pixel": planted(shader.sources["pixel"], old, new)})

    return make


@pytest.fixture(scope="session")
def programs() -> Iterator[dict[str, SurfaceProgram]]:
    """Programs by pixel source, kept for the session: a driver takes a second for each new one."""
    kept: dict[str, SurfaceProgram] = {}
    yield kept
    for each in kept.values():
        each.release()


@pytest.fixture
def program(
    gl_clean, shader_of: Callable[..., Shader], programs: dict[str, SurfaceProgram]
) -> Iterator[Callable[..., SurfaceProgram]]:
    """Function from a document, as for `shader_of`, to its program."""
    textured: list[SurfaceProgram] = []

    def link(document: mx.Document, textures: dict[str, Array] | None = None, **options: str) -> SurfaceProgram:
        shader = shader_of(document, **options)
        if textures is not None:
            textured.append(SurfaceProgram(shader, textures))
            return textured[-1]
        source = shader.sources["pixel"]
        if source not in programs:
            programs[source] = SurfaceProgram(shader)
        return programs[source]

    yield link
    for each in textured:
        each.release()


@pytest.fixture(scope="session")
def surface_inputs() -> Callable[..., dict[str, Array]]:
    """Function from view directions (samples, 3), seen from the origin, to the inputs of a flat surface."""

    def make(v: Array, normal: Array = (0.0, 0.0, 1.0), tangent: Array = (1.0, 0.0, 0.0)) -> dict[str, Array]:
        v = np.atleast_2d(v)
        frame = {"normalWorld": normal, "tangentWorld": tangent}
        return {"positionWorld": -v, **{name: np.broadcast_to(a, v.shape) for name, a in frame.items()}}

    return make


@pytest.fixture(scope="session")
def spot() -> Callable[..., Environment]:
    """Function from a direction to a black environment with a white disc of 10 degrees around it."""

    def make(direction: Array, height: int = 64) -> Environment:
        # Row 0 at +y, the centre column at -z, the quarter to its right at +x.
        latitude = np.pi * (0.5 - (np.arange(height) + 0.5) / height)[:, None]
        longitude = 2.0 * np.pi * ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5)
        towards = np.stack(
            np.broadcast_arrays(
                np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)
            ),
            axis=-1,
        )
        radiance = np.where(towards @ np.asarray(direction) > np.cos(np.deg2rad(10.0)), 1.0, 0.0)[..., None]
        return Environment(radiance * np.ones(3), np.zeros((1, 1, 3)))

    return make
