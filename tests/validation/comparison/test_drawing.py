"""What an engine says that it can is what is asked of it: less is compared, or the reason told."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines.base import CompileError, CompileMessage, DirectionalLight, Engine, EngineFailure, Program
from mrm_mtlx.engines.gl import ENGINE, SurfaceProgram
from mrm_mtlx.shadergen import generate
from mrm_mtlx.validation.comparison.drawing import check_draws
from mrm_mtlx.validation.comparison.expectation import Expectation

if TYPE_CHECKING:
    from pathlib import Path

METAL = '<conductor_bsdf name="bsdf" type="BSDF"/>'
PRINTED = """
  <image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>
  <oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" nodename="i"/>
  </oren_nayar_diffuse_bsdf>
"""
FULL = SurfaceProgram.capabilities
SAMPLES = 40


class Lesser(Engine):
    """The OpenGL engine under another name, with less of what it can."""

    name, use, targets = "lesser", "", ("glsl",)

    def __init__(self, **less: object) -> None:
        self.capabilities = replace(FULL, **less)
        self.sizes: list[int] = []

    def availability(self):
        return ENGINE.availability()

    def compile(self, shader, images=None) -> Program:
        return Watched(self, SurfaceProgram(shader, images))


class Watched(Program):
    """A program that notes how many points it is asked for."""

    def __init__(self, engine: Lesser, behind: Program) -> None:
        self.capabilities, self._sizes, self._behind = engine.capabilities, engine.sizes, behind

    def evaluate(self, points, lighting, uniforms=None):
        assert lighting.environment is None or self.capabilities.environment
        self._sizes.append(len(points))
        return self._behind.evaluate(points, lighting, uniforms)

    def release(self) -> None:
        self._behind.release()


@pytest.fixture
def shader_of(library):
    """Function from a document to the GLSL of its material."""
    return lambda document: generate(document.getNode("m"), "glsl", library)


@pytest.fixture
def result(gl, surface_document, shader_of, rng, tmp_path: Path):
    """Function from an engine and BSDF nodes to the result of the check, and its findings."""

    def check(engine: Engine, nodes: str = METAL):
        document = surface_document(nodes)
        images = CheckedImages(Reach.only(tmp_path), "/m")
        expected = Expectation(document.getNode("m"), rng, SAMPLES, images)
        return check_draws(engine, shader_of(document), images, {"": (expected, {})}, "/m")[""]

    return check


def test_an_engine_of_full_means_compares_under_a_light_and_in_an_environment(result):
    engine = Lesser()
    found, findings = result(engine)
    assert (found.stage, found.status, findings) == ("compare", "pass", [])
    assert engine.sizes == [SAMPLES, 3]
    assert found.samples == sum(engine.sizes)


def test_without_environments_the_light_alone_is_compared(result):
    engine = Lesser(environment=False)
    found, _ = result(engine)
    assert (found.stage, found.status, found.samples) == ("compare", "pass", SAMPLES)


def test_points_come_in_batches_that_the_engine_takes(result):
    whole, parts = Lesser(), Lesser(largest_batch=16)
    assert result(parts)[0].status == "pass"
    assert parts.sizes == [16, 16, 8, 3]
    assert result(whole)[0].status == "pass"


@pytest.mark.parametrize(
    ("less", "reason"),
    [
        ({"significand_bits": 11}, "lesser computes with fewer bits than float32, for which tolerances are made"),
        ({"lights": frozenset()}, "lesser takes no directional light"),
        ({"textures": False}, "lesser looks up no images"),
    ],
)
def test_what_an_engine_lacks_is_the_reason_to_compile_alone(result, less, reason):
    engine = Lesser(**less)
    found, findings = result(engine, PRINTED)
    assert (found.stage, found.status, found.reason, findings) == ("compile", "skip", reason, [])
    assert engine.sizes == []


def test_derivatives_between_samples_are_no_derivatives_on_the_surface(result, shader_of, surface_document):
    engine = Lesser(derivatives=True)
    assert result(engine)[0].status == "pass"  # the shader asks for none
    bumped = """
      <position name="p" type="vector3"/>
      <heighttonormal name="h" type="vector3"><input name="in" type="float" nodename="x"/></heighttonormal>
      <extract name="x" type="float"><input name="in" type="vector3" nodename="p"/></extract>
      <conductor_bsdf name="bsdf" type="BSDF"><input name="normal" type="vector3" nodename="h"/></conductor_bsdf>
    """
    found, _ = result(engine, bumped)
    assert (found.stage, found.status) == ("compile", "skip")
    assert found.reason == "lesser takes derivatives between samples, which are no neighbours on the surface"


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (CompileError([CompileMessage(3, "x = y;", "y is not known")]), "glsl: y is not known at line 3: x = y;"),
        (EngineFailure("the driver is gone"), "glsl: the driver is gone"),
    ],
)
def test_an_engine_that_refuses_or_fails_is_a_finding(result, monkeypatch, error, message):
    def refuse(*_: object):
        raise error

    monkeypatch.setattr(Lesser, "compile", refuse)
    found, findings = result(Lesser())
    assert (found.stage, found.status) == ("compile", "fail")
    assert [(f.code, f.message) for f in findings] == [("SHADER_COMPILE", message)]


def test_colours_of_batches_are_those_of_all_points_at_once(gl, surface_document, shader_of, rng):
    from mrm_mtlx.engines.base import Lighting, SurfacePoints, evaluate_all

    normal = np.tile([0.0, 0.0, 1.0], (7, 1))
    points = SurfacePoints(rng.random((7, 3)), normal, np.roll(normal, 1, axis=1), rng.random((7, 2)))
    shader, lighting = shader_of(surface_document(METAL)), Lighting(DirectionalLight((0.0, 0.6, 0.8)))
    with Lesser(largest_batch=3).compile(shader) as few, ENGINE.compile(shader) as all_of_them:
        assert np.array_equal(evaluate_all(few, points, lighting), all_of_them.evaluate(points, lighting))
        assert evaluate_all(few, points.part(slice(0, 0)), lighting).shape == (0, 4)
