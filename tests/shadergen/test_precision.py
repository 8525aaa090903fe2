"""The precision of floats in ESSL: highp where MaterialX states mediump, with a word on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.documents.image_checks import CheckedImages
from mrm_mtlx.engines.gl import ENGINE, SurfaceProgram
from mrm_mtlx.shadergen import generate
from mrm_mtlx.shadergen import generate as generate_shader
from mrm_mtlx.shadergen.precision import HIGH, MEDIUM, states_mediump, with_highp
from mrm_mtlx.validation.comparison.drawing import check_draws
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.sampling import generator

NARROW = """
  <conductor_bsdf name="bsdf" type="BSDF">
    <input name="roughness" type="vector2" value="0.01, 0.01"/>
    <input name="retroreflective" type="boolean" value="true"/>
  </conductor_bsdf>
"""


def with_mediump(shader):
    """The shader as MaterialX before 1.39.5 generates it."""
    return replace(shader, sources={stage: code.replace(HIGH, MEDIUM) for stage, code in shader.sources.items()})


@pytest.fixture
def narrow(surface_document):
    """The document of a narrow lobe, which elements do not keep alive."""
    return surface_document(NARROW)


def test_mediump_becomes_highp_in_both_stages(narrow, library):
    shader = generate(narrow.getNode("m"), "essl", library)
    stated = with_mediump(shader)
    assert states_mediump(stated)
    assert not any(MEDIUM in code or HIGH not in code for code in with_highp(stated).sources.values())
    assert with_highp(with_highp(stated)) == with_highp(stated)


def test_no_other_target_states_a_precision(narrow, library):
    shader = generate(narrow.getNode("m"), "glsl", library)
    assert not states_mediump(shader)
    assert with_highp(shader) is shader


def test_a_shader_with_mediump_is_told_by_name_and_not_called_broken(gl, narrow, library, tmp_path):
    images = CheckedImages(Reach.only(tmp_path), "")
    element = narrow.getNode("m")
    stated = with_mediump(generate(element, "essl", library))
    with SurfaceProgram(stated) as program:
        expectation = Expectation(element, generator(0, "precision"), 512, images)
        drawn = expectation.draw(program)
    result, findings = check_draws(ENGINE, stated, images, {"": (expectation, {})}, "")[""]
    assert result.status == "pass"
    # A driver may compute in more than it has to; Mesa does in 16 bits, in which this lobe is no number.
    assert [f.code for f in findings] == ["UPSTREAM_DEVIATION"] * ("llvmpipe" in gl.detail)
    assert all("(mediump-floats)" in f.message for f in findings)
    if "llvmpipe" in gl.detail:
        assert not all(np.isfinite(drawing.colors).all() for drawing in drawn)
        assert "are NaN or infinite" in findings[0].message


def test_another_error_beside_mediump_is_seen(gl, narrow, library, tmp_path):
    images = CheckedImages(Reach.only(tmp_path), "")
    element = narrow.getNode("m")
    stated = with_mediump(generate(element, "essl", library))
    source = stated.sources["pixel"]
    assert "/ (4.0 * NdotV)" in source
    wrong = replace(stated, sources={**stated.sources, "pixel": source.replace("/ (4.0 * NdotV)", "/ (4.1 * NdotV)")})
    expectation = Expectation(element, generator(0, "precision"), 512, images)
    result, findings = check_draws(ENGINE, wrong, images, {"": (expectation, {})}, "")[""]
    assert result.status == "fail"
    assert [f.code for f in findings] == ["SHADER_NOT_FINITE" if "llvmpipe" in gl.detail else "SHADER_DIFFERS"]


@pytest.fixture
def metal(tmp_path, narrow):
    """The file of that document."""
    import MaterialX as mx

    mx.writeToXmlFile(narrow, str(tmp_path / "metal.mtlx"))
    return tmp_path / "metal.mtlx"


@pytest.fixture
def of_an_older_version(monkeypatch):
    """Makes MaterialX generate what it did before 1.39.5."""
    monkeypatch.setattr("mrm_mtlx.shadergen.generate", lambda *given: with_mediump(generate_shader(*given)))


@pytest.mark.usefixtures("of_an_older_version")
@pytest.mark.parametrize(("stated", "kept", "word"), [(False, HIGH, "here they are highp"), (True, MEDIUM, "16 bits")])
def test_generate_mends_the_precision_and_says_so(metal, stated, kept, word):
    found = mrm.generate(metal, target="essl", stated_precision=stated)
    assert all(kept in code for code in found.files.values())
    (finding,) = found.findings
    assert finding.code == "UPSTREAM_DEVIATION"
    assert "states mediump of floats (mediump-floats)" in finding.message
    assert word in finding.message


def test_highp_that_is_stated_is_nothing_to_speak_of(metal, library):
    found = mrm.generate(metal, target="glsl")
    assert found.findings == ()
