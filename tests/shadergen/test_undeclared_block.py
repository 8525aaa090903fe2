"""Vulkan GLSL before MaterialX 1.39.4: it is told by name, compiles as mended, and hides no other error."""

from __future__ import annotations

import re
from dataclasses import replace

import MaterialX as mx
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.engines import glslang
from mrm_mtlx.shadergen import generate
from mrm_mtlx.shadergen import generate as generate_shader
from mrm_mtlx.shadergen.undeclared_block import names_undeclared_block, with_members_alone
from mrm_mtlx.validation.compiling import check_compiles

METAL = '<conductor_bsdf name="bsdf" type="BSDF"/>'


def without_block(shader):
    """The shader as MaterialX before 1.39.4 generates it: its block's members declared, each by itself."""
    found = {}
    for stage, code in shader.sources.items():
        block = re.search(r"^layout \(location = 0\) (in|out) VertexData\s*{([^}]*)} vd;$", code, re.MULTILINE)
        members = enumerate(re.findall(r"\w+ \w+;", block[2])) if block else ()
        declared = "\n".join(f"layout (location = {k}) {block[1]} {member}" for k, member in members)
        found[stage] = code.replace(block[0], declared) if block else code
    return replace(shader, sources=found)


@pytest.fixture
def shader(surface_document, library):
    document = surface_document(METAL)  # which an element does not keep alive
    return without_block(generate(document.getNode("m"), "vulkan", library))


@pytest.fixture
def compiler():
    if not glslang.ENGINE.availability().available:
        pytest.skip(f"vulkan: {glslang.ENGINE.availability().reason}")
    return glslang.ENGINE


def test_a_block_that_is_not_declared_is_seen_in_vulkan_alone(surface_document, library, shader):
    assert names_undeclared_block(shader)
    assert not names_undeclared_block(with_members_alone(shader))
    document = surface_document(METAL)
    for target in ("glsl", "essl", "msl"):
        other = generate(document.getNode("m"), target, library)
        assert not names_undeclared_block(other)
        assert with_members_alone(other) is other


def test_a_source_without_its_block_is_told_by_name_and_compiles_as_mended(compiler, shader):
    result, findings = check_compiles(compiler, shader, "/m")
    assert result.status == "pass"
    (finding,) = findings
    assert finding.code == "UPSTREAM_DEVIATION"
    assert "vulkan: it deviates as known (undeclared-block): vertex stage: 'vd' : undeclared" in finding.message


def test_another_error_beside_it_is_seen(compiler, shader):
    wrong = replace(shader, sources={**shader.sources, "pixel": shader.sources["pixel"] + "\nvoid f() { return 1; }\n"})
    result, findings = check_compiles(compiler, wrong, "/m")
    assert result.status == "fail"
    assert [finding.code for finding in findings] == ["SHADER_COMPILE"]
    assert "pixel stage" in findings[0].message


def test_generate_writes_what_compiles_and_says_so(compiler, surface_document, tmp_path, monkeypatch):
    mx.writeToXmlFile(surface_document(METAL), str(tmp_path / "metal.mtlx"))
    monkeypatch.setattr("mrm_mtlx.shadergen.generate", lambda *given: without_block(generate_shader(*given)))
    found = mrm.generate(tmp_path / "metal.mtlx", target="vulkan")
    (finding,) = found.findings
    assert finding.code == "UPSTREAM_DEVIATION"
    assert "(undeclared-block)" in finding.message
    compiler.compile(found.shaders["m"]).release()
