"""The registry of engines: which serves a target, and one of another package that all commands use without a change."""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.conformance import Case
from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines import registry
from mrm_mtlx.engines.base import Availability, CompiledOnly, Engine
from mrm_mtlx.shadergen import HOST_TARGETS, TARGETS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import ModuleType

TOY = Path(__file__).with_name("toy_engine.py").read_text(encoding="utf-8")
SAMPLES = 64


@pytest.fixture
def others(installed: Callable[..., dict[str, str]], monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., str]]:
    """Function that installs a module with an engine, for this process and those that it starts."""

    def install(module: str, source: str, **entries: str) -> None:
        path = installed(module, source, registry.GROUP, **entries)["PYTHONPATH"]
        monkeypatch.setenv("PYTHONPATH", path)
        monkeypatch.syspath_prepend(path.split(os.pathsep)[0])
        registry.engines.cache_clear()

    yield install
    monkeypatch.undo()
    registry.engines.cache_clear()


@pytest.fixture
def mrm(mrm: Callable) -> Callable:
    """The command in a process of its own, which finds what this one finds."""
    return lambda *arguments: mrm(*arguments, PYTHONPATH=os.environ.get("PYTHONPATH", ""))


@pytest.fixture
def toy(gl, others, monkeypatch) -> ModuleType:
    """The module of the toy engine, registered."""
    monkeypatch.delitem(sys.modules, "toy_engine", raising=False)
    others("toy_engine", TOY, toy="toy_engine:ENGINE")
    return import_module("toy_engine")


# The package's own ----------------------------------------------------------------------------------------------------


def test_the_package_has_six_in_the_order_of_reports():
    assert list(registry.engines()) == ["gl", "vulkan", "slang", "osl", "cycles", "storm"]
    for name, engine in registry.engines().items():
        assert engine.name == name
        assert engine.use
        assert set(engine.targets) <= {*TARGETS, *HOST_TARGETS}


def test_engines_that_run_come_first_and_all_else_is_asked_by_what_it_can():
    assert [e.name for e in registry.engines_for("osl")] == ["osl", "cycles"]
    assert registry.targets(registry.runs) == {"glsl", "essl", "storm"}
    assert registry.targets(registry.measures_closures) == {"osl"}
    assert registry.targets(registry.renders) == {"glsl", "essl", "osl", "storm"}
    assert registry.engine_for("glsl", registry.measures_closures) is None
    assert registry.engine_for("osl", registry.measures_closures).name == "cycles"


def test_a_target_that_nothing_takes_has_a_reason():
    assert registry.engine_for("mdl") is None
    assert registry.unserved("mdl") == "no MDL compiler"
    assert registry.unserved("another") == "no engine takes another"


def test_a_program_that_was_only_compiled_says_so_and_does_not_run():
    with CompiledOnly() as program:
        assert not program.capabilities.runs
        with pytest.raises(TypeError, match="not to be run"):
            program.evaluate(None, None)


# One of another package -----------------------------------------------------------------------------------------------


def test_doctor_lists_it_after_the_others(toy, mrm, gl):
    done = mrm("doctor")
    assert done.returncode == 0
    last = " ".join(done.stdout.partition("\ntoy ")[2].split())  # the detail has a line of its own where it is long
    assert last.startswith(f"ok {toy.ENGINE.use} ")
    assert last.endswith(f"by way of {gl.detail}")
    listed = json.loads(mrm("doctor", "--format", "json").stdout)["engines"]
    assert list(listed) == ["gl", "vulkan", "slang", "osl", "cycles", "storm", "toy"]


def test_validate_compares_its_target_in_worker_processes(toy, mrm, documents):
    paths = [documents / "SHADER_IGNORES_RETRO" / f"{name}.mtlx" for name in ("passes", "triggers")]
    arguments = ("--target", "glsl", "--target", "wgsl", "--samples", SAMPLES, "--format", "json", "-j", 2)
    report = json.loads(mrm("validate", *paths, *arguments).stdout)
    assert list(report["engines"]) == ["gl", "toy"]
    assert report["engines"]["toy"] == {"available": True, "renderer": toy.ENGINE.availability().detail}
    results = [r["targets"] for d in report["documents"] for r in d["renderables"]]
    assert len(results) == 2
    for result in results:
        assert (result["wgsl"]["stage"], result["wgsl"]["status"]) == ("compare", "pass")
        assert result["wgsl"]["samples"] == result["glsl"]["samples"]
        assert 0.0 < result["wgsl"]["max_error"] < 1e-3


def test_a_wrong_shader_fails_in_it(toy, check, documents, monkeypatch):
    wrong = (r"reflect\(-closureData\.V, N\)", "closureData.V")
    monkeypatch.setattr(toy, "_WORDS", (*toy._WORDS, wrong))
    (result,) = check(documents / "SHADER_IGNORES_RETRO" / "triggers.mtlx", targets=("wgsl",), samples=SAMPLES)
    assert "SHADER_DIFFERS" in [found.code for found in result.findings]


def test_a_shader_that_it_refuses_is_a_finding(toy, check, documents, monkeypatch):
    monkeypatch.setattr(toy, "_WORDS", (*toy._WORDS, (r"mrm_mirror_view\(closureData, N", "nowhere(closureData, N")))
    (result,) = check(documents / "SHADER_IGNORES_RETRO" / "triggers.mtlx", targets=("wgsl",), samples=SAMPLES)
    (refused,) = [found for found in result.findings if found.code == "SHADER_COMPILE"]
    assert refused.message.startswith("wgsl: ")


def test_images_are_not_asked_of_an_engine_without_textures(toy, check, documents):
    (result,) = check(documents / "DOC_FILE" / "passes.mtlx", targets=("glsl", "wgsl"), samples=SAMPLES)
    (renderable,) = result.renderables
    assert renderable.targets["glsl"].status == "pass"
    skipped = renderable.targets["wgsl"]
    assert (skipped.stage, skipped.status, skipped.reason) == ("compile", "skip", "toy looks up no images")


def test_conformance_runs_its_target(toy, in_process, monkeypatch):
    case = Case("conductor_bsdf", retroreflective=True, anisotropic=True, film=False)
    room = import_module("mrm_mtlx.conformance")  # of the package, the name is the function
    monkeypatch.setattr(room, "cases", lambda: [case])
    monkeypatch.setattr(room, "new_cases", list)
    done = in_process("conformance", "--target", "wgsl", "--samples", SAMPLES, "--format", "json")
    report = json.loads(done.stdout)
    (found,) = report["cases"]
    assert (found["target"], found["engine"], found["status"]) == ("wgsl", "toy", "pass")
    assert found["samples"] == SAMPLES
    assert list(report["engines"]) == ["gl", "toy"]
    assert "glsl, essl, wgsl, osl" in " ".join(in_process("conformance", "--target", "mdl").stderr.split())


def test_conformance_says_in_a_line_what_it_refuses(toy, in_process, monkeypatch):
    monkeypatch.setattr(toy, "_WORDS", (*toy._WORDS, (r"mrm_mirror_view\(closureData, N", "nowhere(closureData, N")))
    done = in_process("conformance", "--target", "wgsl", "--samples", 16)
    assert done.exit_code == 2
    assert done.stderr.startswith("mrm: ")
    assert "nowhere" in done.stderr


def test_render_takes_it_and_its_picture_is_that_of_the_engine_behind_it(toy, mrm, documents, tmp_path):
    path = documents / "SHADER_IGNORES_RETRO" / "triggers.mtlx"
    for name in ("toy", "gl"):
        done = mrm("render", path, "-o", f"{name}.exr", "--engine", name, "--size", 16)
        assert done.returncode == 0, done.stderr
    first, second = (read_image(tmp_path / f"{name}.exr") for name in ("toy", "gl"))
    # The two sources have the same arithmetic, and differ in declarations alone; a compiler may still order sums in
    # another way, by a few roundings of 2^-24.
    np.testing.assert_allclose(first, second, rtol=2.0**-20, atol=2.0**-24)
    assert np.ptp(first) > 0.1
    refused = mrm("render", path, "-o", "x.exr", "--engine", "another")
    assert refused.returncode == 2
    assert "'another': expected one of gl, cycles, storm, toy" in " ".join(refused.stderr.split())


def test_a_picture_that_it_cannot_make_is_refused(toy, in_process, documents):
    done = in_process("render", documents / "DOC_FILE" / "passes.mtlx", "-o", "x.png", "--engine", "toy", "--size", 16)
    assert done.exit_code == 2
    assert "toy looks up no images" in done.stderr


def test_the_example_of_the_documentation_is_an_engine(others, mrm, repository):
    page = (repository / "docs" / "engines.md").read_text(encoding="utf-8")
    others("my_metal", page.split("```python\n")[1].split("```")[0], metal="my_metal:ENGINE")
    metal = registry.engine_for("msl")
    assert metal.name == "metal"
    assert f"  {metal.use}" in mrm("doctor").stdout
    if not metal.availability().available:
        assert metal.availability().remedy == "xcode-select --install"
    for name, engine in registry.engines().items():
        assert name == "metal" or f"| `{name}` | {', '.join(engine.targets)} |" in page


# What is wrong with others --------------------------------------------------------------------------------------------


def test_a_module_that_does_not_load_is_named_with_the_reason_and_disturbs_nothing(others, mrm, gl):
    others("broken_engine", "raise ValueError('a bad day')", broken="broken_engine:ENGINE")
    done = mrm("doctor")
    assert done.returncode == 0
    *_, line, detail, remedy = done.stdout.splitlines()
    assert line.split()[:2] == ["broken_engine:ENGINE", "missing"]
    assert "it does not load: ValueError: a bad day" in detail
    assert "upgrade or remove the package" in remedy
    assert registry.engine_for("glsl").name == "gl"


def test_what_is_no_engine_is_none(others):
    others("no_engine", "ENGINE = 'gl'", some="no_engine:ENGINE")
    assert registry.engines()["no_engine:ENGINE"].availability().detail == "no_engine:ENGINE is no Engine"


def test_an_engine_cannot_take_the_name_of_another(others):
    others("second_toy", TOY.replace('name = "toy"', 'name = "gl"'), second="second_toy:ENGINE")
    taken = registry.engines()["second_toy:ENGINE"].availability()
    assert taken.detail == "there is another engine of the name gl"
    assert [engine.name for engine in registry.engines_for("wgsl")] == []


class Second(Engine):
    """Another engine for Slang, that works or not."""

    name, use, targets = "second", "compiles Slang", ("slang",)

    def __init__(self, available: bool) -> None:
        self.state = Availability(available, "second")

    def availability(self) -> Availability:
        return self.state

    def compile(self, *_: object) -> CompiledOnly:
        return CompiledOnly()


@pytest.mark.parametrize(
    ("works", "chosen"), [((True, True), 0), ((True, False), 0), ((False, True), 1), ((False, False), 0)]
)
def test_of_several_engines_the_first_that_works_is_used(monkeypatch, works, chosen):
    several = [Second(work) for work in works]
    monkeypatch.setattr(registry, "engines", lambda: dict(enumerate(several)))
    assert registry.engine_for("slang") is several[chosen]
