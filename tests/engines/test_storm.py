"""OpenUSD's Storm: what it gives at points is the reference's, and a material that it cannot draw is refused."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.conformance.cases import NODES, Case, case_document
from mrm_mtlx.conformance.hardware import run_case
from mrm_mtlx.engines.base import CompileError, DirectionalLight, EngineFailure, Lighting, SurfacePoints
from mrm_mtlx.engines.storm import ENGINE, drawing, process
from mrm_mtlx.library import Origin, install
from mrm_mtlx.shadergen import MissingCodeError, generate, renderable_elements

pytestmark = pytest.mark.usefixtures("storm")

CONDUCTOR = Case("conductor_bsdf", True, False, False)
SAMPLES = 512
# Seconds that a process may take to end; on a busy machine it needs one.
END_S = 20.0


@pytest.fixture
def shader(library):
    """Function from a case to its material."""

    def make(case=CONDUCTOR):
        document = case_document(case, library.document)
        return generate(renderable_elements(document)[0], "storm", library)

    return make


@pytest.fixture
def another_library(monkeypatch):
    """Function that has Storm start anew with the files of the node library changed by a function."""
    whole = install.nodes

    def start(change):
        ENGINE.stop()
        monkeypatch.setattr(install, "nodes", lambda version, form: change(whole(version, form)))

    yield start
    ENGINE.stop()


def result(case):
    (found,) = run_case(case, ["storm"], SAMPLES, 0, Origin.MRM)
    return found


def tilted(count=64):
    """Points at the eye's distance of 1 whose normals are tilted by 0 to 85 degrees, and their properties."""
    angle = np.deg2rad(np.linspace(0.0, 85.0, count))
    normal = np.stack([np.sin(angle), np.zeros(count), np.cos(angle)], axis=1)
    position = np.tile([0.0, 0.0, -1.0], (count, 1)) + 1e-3 * np.arange(count)[:, None] * [0.0, 1.0, 0.0]
    tangent = np.tile([0.0, 1.0, 0.0], (count, 1))
    values = {"ior": np.tile([0.2, 0.4, 1.4], (count, 1)), "extinction": np.tile([3.4, 2.3, 1.8], (count, 1))}
    properties = values | {"roughness": np.full((count, 2), 0.1), "weight": np.ones(count)}
    return SurfacePoints(position, normal, tangent, np.zeros((count, 2)), properties)


HEADLIGHT = Lighting(DirectionalLight((0.0, 0.0, 1.0)))


def test_what_works_is_named(storm):
    assert re.fullmatch(r"Storm of OpenUSD \d+\.\d+ in Blender [\d.]+, MaterialX 1\.39\.\d, .+", storm.detail)
    assert storm.remedy == ""


# The figures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "case",
    [
        CONDUCTOR,
        Case("dielectric_bsdf", True, True, False),
        Case("generalized_schlick_bsdf", True, False, True),
        Case("generalized_schlick_bsdf", False, True, False),
    ],
    ids=lambda case: case.name,
)
def test_a_node_is_the_oracles_to_the_bits_of_half_floats(case):
    found = result(case).comparison
    assert found.passed, found
    assert found.median_error < 2.0**-10  # the last of eleven bits


@pytest.mark.large
def test_every_case_is_the_oracles(mrm):
    done = mrm("conformance", "--target", "storm", "--samples", "1000")
    assert done.returncode == 0, done.stdout
    assert re.search(r"PASSED  \d\d passed, 0 failed, 0 skipped", done.stdout)


def test_the_retroreflective_lobe_stays_bright_over_all_tilts(shader):
    with ENGINE.compile(shader()) as program:
        bright = program.evaluate(tilted(), HEADLIGHT)[:, 0]
    with ENGINE.compile(shader(replace(CONDUCTOR, retroreflective=False))) as program:
        dark = program.evaluate(tilted(), HEADLIGHT)[:, 0]
    assert dark[0] == pytest.approx(bright[0], rel=2.0**-9)  # half floats, of eleven bits, on both sides
    # Cosine and masking leave at least 0.039 of the lobe; at 85 degrees the ordinary one has 0.015 of what is left.
    assert bright.min() > 0.02 * bright.max()
    assert dark[-1] < 0.02 * bright[-1]


def test_an_input_is_set_for_one_evaluation(shader):
    flagged = shader()
    (flag,) = [port.variable for port in flagged.uniforms if port.path == "lobe/retroreflective"]
    with ENGINE.compile(flagged) as program:
        before, off, after = (program.evaluate(tilted(), HEADLIGHT, u) for u in (None, {flag: False}, None))
        with pytest.raises(KeyError, match="nothing"):
            program.evaluate(tilted(), HEADLIGHT, {"nothing": 1.0})
    np.testing.assert_array_equal(before, after)
    assert off[-1, 0] < 0.02 * before[-1, 0]


def test_what_shines_by_itself_shines_once_and_is_not_exposed_with_the_light(surface_document, library):
    document = surface_document(
        '<uniform_edf name="e" type="EDF"><input name="color" type="color3" value="0.25,0.5,2"/></uniform_edf>'
        '<surface name="s" type="surfaceshader"><input name="edf" type="EDF" nodename="e"/></surface>'
        '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>'
        "</surfacematerial>"
    )
    with ENGINE.compile(generate(document.getNode("m"), "storm", library)) as program:
        found = program.evaluate(tilted(4), HEADLIGHT)[:, :3]
        assert program.capabilities.color_step == 2.0**-24
    np.testing.assert_allclose(found, np.tile([0.25, 0.5, 2.0], (4, 1)), rtol=2.0**-10)  # half floats


# Planted errors -------------------------------------------------------------------------------------------------------


def of_conductor(old: bytes, new: bytes):
    """Function that changes the wrapper of the conductor in a node library."""
    name = "genglsl/mrm_conductor_bsdf.glsl"

    def change(files):
        assert old in files[name]
        return files | {name: files[name].replace(old, new)}

    return change


def test_a_library_that_ignores_the_flag_fails_where_the_flag_is_on(another_library):
    another_library(of_conductor(b"N, retroreflective)", b"N, false)"))
    assert result(CONDUCTOR).status == "fail"
    assert result(replace(CONDUCTOR, retroreflective=False)).status == "pass"


def test_a_host_without_the_node_library_ignores_the_flag_and_fails(another_library):
    another_library(lambda _files: {})
    assert result(CONDUCTOR).status == "fail"


def test_an_error_of_a_few_thousandths_fails(another_library):
    another_library(of_conductor(b", weight, ", b", 1.003 * weight, "))
    assert result(CONDUCTOR).status == "fail"


def test_a_shader_that_does_not_compile_is_refused_as_often_as_it_is_asked_for(another_library, shader):
    another_library(of_conductor(b", weight, ", b", wait, "))
    for _ in range(2):
        with pytest.raises(CompileError, match=r"error: `wait' undeclared.*Failed to compile shader"):
            ENGINE.compile(shader())


def test_a_missing_source_is_named(another_library, shader):
    another_library(lambda files: {name: files[name] for name in files if "conductor" not in name})
    with pytest.raises(CompileError, match=r"Failed to get source code from file 'mrm_conductor_bsdf\.glsl'"):
        ENGINE.compile(shader())


def test_a_material_that_is_drawn_in_grey_is_refused(shader):
    made = shader()
    source = made.sources["pixel"].replace("outputs:mtlx:surface.connect", "outputs:mtlx:other.connect")
    assert source != made.sources["pixel"]
    with pytest.raises(CompileError, match="grey of a mesh without a material"):
        ENGINE.compile(replace(made, sources={"pixel": source}))
    ENGINE.compile(made).release()  # what was refused does not stick


def test_an_unknown_node_is_named(shader):
    made = shader()
    source = made.sources["pixel"].replace("ND_conductor_bsdf", "ND_nothing_bsdf")
    with pytest.raises(CompileError, match="NodeDef not found for Node 'ND_nothing_bsdf'"):
        ENGINE.compile(replace(made, sources={"pixel": source}))


def test_a_pattern_is_no_material(make_document, library):
    document = make_document('<constant name="c" type="color3"/><output name="o" type="color3" nodename="c"/>')
    with pytest.raises(MissingCodeError, match="shows no pattern by itself"):
        generate(document.getOutput("o"), "storm", library)


# The process ----------------------------------------------------------------------------------------------------------


def test_a_runtime_without_egl_is_said_in_one_line(monkeypatch, tmp_path):
    ENGINE.stop()
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_DIRS", str(tmp_path))
    state = process.RUNTIME.tried()
    assert not state.available
    assert "\n" not in state.detail
    assert re.search("egl", state.detail, re.IGNORECASE)
    assert state.remedy.startswith("apt-get install")


def test_an_interpreter_of_its_own_comes_before_that_of_osl(monkeypatch, tmp_path):
    ENGINE.stop()
    monkeypatch.setenv("MRM_OSL_PYTHON", str(tmp_path / "osl"))
    monkeypatch.setenv("MRM_STORM_PYTHON", str(tmp_path / "storm"))
    state = process.RUNTIME.tried()
    assert str(tmp_path / "storm") in state.detail
    assert "MRM_STORM_PYTHON" in state.remedy


def test_a_crash_is_named_and_the_next_material_has_a_process_of_its_own(shader):
    made = shader()
    with ENGINE.compile(made) as program:
        first = process.RUNTIME.process()
        folder = first.folder
        os.kill(first.versions["pid"], signal.SIGSEGV)
        with pytest.raises(EngineFailure, match="Storm ended with signal SIGSEGV in 'versions'"):
            first.request("versions")
        # The same program goes on in the next.
        assert np.any(program.evaluate(tilted(4), HEADLIGHT))
    assert process.RUNTIME.process() is not first
    assert not folder.exists()


def test_a_process_that_takes_much_memory_is_ended_and_the_next_goes_on(shader, monkeypatch):
    with ENGINE.compile(shader()) as program:
        before = program.evaluate(tilted(4), HEADLIGHT)
        first = process.RUNTIME.process()
        monkeypatch.setattr(drawing, "_MOST_MEMORY", 0)
        found = [program.evaluate(tilted(4), HEADLIGHT) for _ in range(2)]
    assert not first.alive
    for after in found:
        np.testing.assert_array_equal(after, before)


# A process that uses the engine: says which server it has, then waits, or draws without end.
USER = """
import sys, time
from mrm_mtlx.engines.storm import drawing, process
from mrm_mtlx.engines.storm.material import Material
print(process.RUNTIME.process().versions["pid"], flush=True)
if sys.argv[1] == "idle":
    time.sleep(3600)
material = Material(sys.stdin.read())
while True:
    drawing.emission(material)
"""


@pytest.mark.parametrize(
    ("work", "ending"), [("idle", signal.SIGKILL), ("busy", signal.SIGKILL), ("busy", signal.SIGINT)]
)
def test_a_user_that_ends_leaves_no_process_and_no_folder(shader, tmp_path, work, ending):
    user = subprocess.Popen(
        [sys.executable, "-c", USER, work], env={**os.environ, "TMPDIR": str(tmp_path)}, start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    server = int(user.stdout.readline())
    try:
        user.stdin.write(shader().sources["pixel"])
        user.stdin.close()
        time.sleep(1.5)  # into the midst of it
        assert user.poll() is None
        assert list(tmp_path.glob("mrm-storm-*"))
        os.killpg(user.pid, ending)
        user.wait(END_S)
        limit = time.monotonic() + END_S
        while (Path(f"/proc/{server}").exists() or list(tmp_path.iterdir())) and time.monotonic() < limit:
            time.sleep(0.05)
        assert not Path(f"/proc/{server}").exists()
        assert list(tmp_path.iterdir()) == []
    finally:
        for pid in (user.pid, server):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        user.stdout.close()
        user.stderr.close()
        user.wait(END_S)


# Other Blenders -------------------------------------------------------------------------------------------------------

# Interpreters that have other versions of bpy, separated as paths are.
BLENDERS = "MRM_BLENDER_PYTHONS"


@pytest.mark.large
def test_other_versions_of_blender_are_the_oracles_too(monkeypatch):
    if not os.environ.get(BLENDERS):
        pytest.skip(f"{BLENDERS} names no interpreters that have other versions of bpy")
    for interpreter in os.environ[BLENDERS].split(os.pathsep):
        ENGINE.stop()
        monkeypatch.setenv("MRM_STORM_PYTHON", interpreter)
        for node in NODES:
            for flag in (False, True):
                assert result(Case(node, flag, False, False)).status == "pass", (interpreter, node, flag)
    ENGINE.stop()


@pytest.mark.large
def test_every_ready_material_is_drawn_as_the_reference_has_it(mrm, repository):
    done = mrm("validate", str(repository / "materials"), "--target", "storm", "--samples", "1024", "--jobs", "1")
    assert done.returncode == 0, done.stdout
    assert "16 checked, 0 skipped" in done.stdout
