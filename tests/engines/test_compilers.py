"""The compilers of targets that cannot be run here: they take what is right and place what is wrong."""

from __future__ import annotations

import pytest

from mrm_mtlx.engines import glslang, slang
from mrm_mtlx.engines.base import CompileError

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

COMPILERS = {engine.name: engine for engine in (glslang.ENGINE, slang.ENGINE)}


@pytest.fixture(params=COMPILERS)
def compiler(request):
    """The engine of a target; skips where the compiler is not installed."""
    engine = COMPILERS[request.param]
    state = engine.availability()
    if not state.available:
        pytest.skip(f"{request.param}: {state.detail}; {state.remedy}")
    return engine


def test_a_generated_shader_compiles(compiler, shader_of, surface_document):
    program = compiler.compile(shader_of(surface_document(METAL), target=compiler.targets[0]))
    assert not program.capabilities.runs


def test_a_misspelt_call_is_named_with_its_line(compiler, shader_of, surface_document):
    target = compiler.targets[0]
    shader = shader_of(surface_document(METAL), target=target, **MISSPELT)
    with pytest.raises(CompileError) as refused:
        compiler.compile(shader)
    message = str(refused.value.messages[0])
    lines = shader.sources["pixel"].split("\n")
    number = next(k for k, line in enumerate(lines, 1) if MISSPELT["new"] in line)
    assert f": {lines[number - 1].strip()}" in message
    assert "\n" not in message
    # slangpy puts a line of its own before the source.
    assert target == "slang" or f"at line {number}: " in message


def test_a_compiler_that_works_names_itself_and_needs_no_remedy(compiler):
    state = compiler.availability()
    assert state.detail
    assert state.remedy == ""


def test_an_absent_compiler_is_reported_with_its_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    state = glslang.ENGINE.availability()
    assert not state.available
    assert "glslangValidator not found" in state.detail
    assert "apt-get install" in state.remedy
