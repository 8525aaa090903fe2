"""Generated source goes through the compilers of its language, where they are installed."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from mrm_mtlx.shadergen import available_targets, generate
from mrm_mtlx.shadergen.undeclared_block import with_members_alone
from tests.fixtures.versions import planted

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.shadergen import Shader

NODES = ("dielectric", "conductor", "generalized_schlick")

# Targets of the installed MaterialX whose source is GLSL; those for Vulkan are checked under its rules.
VULKAN_RULES = {"glsl": False, "essl": False, "vulkan": True, "wgsl": True}
VULKAN_RULES = {target: rules for target, rules in VULKAN_RULES.items() if target in available_targets()}

TIME_LIMIT_S = 120

# A slip in the wrapper that any compiler has to see.
MISSPELT = ("mrm_mirror_view(closureData, N", "mrm_mirrored_view(closureData, N")


@pytest.fixture(scope="module")
def retroreflective(surface_document, library):
    """Function from a node and a target to the shader of the retroreflective node, optionally misspelt."""

    def make(node: str, target: str) -> Shader:
        document = surface_document(
            f'<{node}_bsdf name="bsdf" type="BSDF">'
            f'<input name="retroreflective" type="boolean" value="true"/></{node}_bsdf>'
        )
        return with_members_alone(generate(document.getNode("m"), target, library))

    return make


def misspelt(source: str) -> str:
    """The source with a call of a function that does not exist."""
    return planted(source, *MISSPELT)


@pytest.fixture(scope="module")
def glslang() -> str:
    """Path of Khronos' reference compiler."""
    path = shutil.which("glslangValidator")
    if path is None:
        pytest.skip("glslangValidator is not installed: apt-get install -y glslang-tools")
    return path


def glslang_log(glslang: str, source: str, stage: str, vulkan: bool, folder: Path) -> str:
    """The compiler's complaints; empty if it takes the source."""
    path = folder / f"shader.{stage}"
    path.write_text(source, encoding="utf-8")
    rules = ["-V", "-o", str(folder / "shader.spv")] if vulkan else []
    run = subprocess.run(
        [glslang, "-S", stage, *rules, str(path)], capture_output=True, text=True, check=False, timeout=TIME_LIMIT_S
    )
    return run.stdout + run.stderr if run.returncode else ""


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("target", VULKAN_RULES)
def test_glsl_compiles_for_every_target_that_is_glsl(retroreflective, glslang, tmp_path, node, target):
    shader = retroreflective(node, target)
    for stage, name in (("vertex", "vert"), ("pixel", "frag")):
        assert glslang_log(glslang, shader.sources[stage], name, VULKAN_RULES[target], tmp_path) == ""


@pytest.mark.parametrize("target", VULKAN_RULES)
def test_a_misspelt_wrapper_does_not_compile(retroreflective, glslang, tmp_path, target):
    source = misspelt(retroreflective("conductor", target).sources["pixel"])
    assert MISSPELT[1].partition("(")[0] in glslang_log(glslang, source, "frag", VULKAN_RULES[target], tmp_path)


# Compiles the sources of a JSON list and prints the complaint about each, empty if there is none. A process of its own,
# since it may hang or crash in native code.
SLANG_PROBE = """
import json, sys
import slangpy
device = slangpy.create_device(type=slangpy.DeviceType.cpu)
logs = []
for number, source in enumerate(json.load(sys.stdin)):
    try:
        module = device.load_module_from_source(f"shader{number}", source)
        logs.append("" if module.entry_points else "no entry point")
    except slangpy.SlangCompileError as error:
        logs.append(str(error))
print("LOGS" + json.dumps(logs))
"""


@pytest.fixture(scope="module")
def slang_logs():
    """Function from Slang sources to the compiler's complaints about each, empty where it has none."""
    pytest.importorskip("slangpy", reason="slangpy is not installed: pip install 'mrm-mtlx[test]'")

    def compile_all(sources: list[str]) -> list[str]:
        try:
            run = subprocess.run(
                [sys.executable, "-c", SLANG_PROBE], input=json.dumps(sources),
                capture_output=True, text=True, check=False, timeout=TIME_LIMIT_S,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            pytest.skip(f"slangpy's compiler did not answer within {TIME_LIMIT_S} s")
        _, found, logs = run.stdout.partition("LOGS")
        if not found:
            pytest.skip(f"slangpy has no working CPU device here: {run.stderr.strip()[-200:]}")
        return json.loads(logs)

    return compile_all


def test_slang_compiles_and_a_misspelt_wrapper_does_not(retroreflective, slang_logs):
    sources = [retroreflective(node, "slang").sources["pixel"] for node in NODES]
    *good, bad = slang_logs([*sources, misspelt(sources[0])])
    assert good == [""] * len(NODES)
    assert MISSPELT[1].partition("(")[0] in bad
