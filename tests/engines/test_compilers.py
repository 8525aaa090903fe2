"""The compilers of targets that cannot be run here: they take what is right and place what is wrong."""

from __future__ import annotations

import pytest

from mrm_mtlx.engines import compilers

METAL = """
<conductor_bsdf name="bsdf" type="BSDF">
  <input name="retroreflective" type="boolean" value="true"/>
</conductor_bsdf>
"""

# A call of a function that does not exist, on a line of its own.
MISSPELT = {
    "old": "ClosureData mirrored = mrm_mirror_view(closureData",
    "new": "ClosureData mirrored = mrm_mirrored_view(closureData",
}

COMPILERS = {
    "vulkan": (compilers.vulkan_availability, compilers.compile_vulkan),
    "slang": (compilers.slang_availability, compilers.compile_slang),
}


@pytest.fixture(params=COMPILERS)
def compiler(request):
    """Target and compile function; skips where the compiler is not installed."""
    availability, compile_shader = COMPILERS[request.param]
    state = availability()
    if not state.available:
        pytest.skip(f"{request.param}: {state.detail}; {state.remedy}")
    return request.param, compile_shader


def test_a_generated_shader_compiles(compiler, shader_of, surface_document):
    target, compile_shader = compiler
    assert compile_shader(shader_of(surface_document(METAL), target=target)) == ""


def test_a_misspelt_call_is_named_with_its_line(compiler, shader_of, surface_document):
    target, compile_shader = compiler
    shader = shader_of(surface_document(METAL), target=target, **MISSPELT)
    message = compile_shader(shader)
    lines = shader.sources["pixel"].split("\n")
    number = next(k for k, line in enumerate(lines, 1) if MISSPELT["new"] in line)
    assert f": {lines[number - 1].strip()}" in message
    assert "\n" not in message
    # slangpy puts a line of its own before the source.
    assert target == "slang" or f"at line {number}: " in message


def test_a_compiler_that_works_names_itself_and_needs_no_remedy(compiler):
    target, _ = compiler
    state = COMPILERS[target][0]()
    assert state.detail
    assert state.remedy == ""


def test_an_absent_compiler_is_reported_with_its_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    state = compilers.vulkan_availability()
    assert not state.available
    assert "glslangValidator not found" in state.detail
    assert "apt-get install" in state.remedy
