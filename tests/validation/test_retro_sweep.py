"""The retroreflective sweep: which nodes it switches, and that it sees what the flag breaks."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation import element as element_module
from mrm_mtlx.validation.element import ElementSweep
from mrm_mtlx.validation.options import Request
from mrm_mtlx.validation.retro_sweep import flattened, variants
from mrm_mtlx.validation.steps import Steps

COATED = """
  <nodegraph name="g">
    <conductor_bsdf name="metal" type="BSDF">
      <input name="retroreflective" type="boolean" value="true"/>
    </conductor_bsdf>
    <dielectric_bsdf name="coat" type="BSDF">
      <input name="weight" type="float" value="0.6"/>
      <input name="retroreflective" type="boolean" value="false"/>
    </dielectric_bsdf>
    <generalized_schlick_bsdf name="unused" type="BSDF"/>
    <layer name="both" type="BSDF">
      <input name="top" type="BSDF" nodename="coat"/>
      <input name="base" type="BSDF" nodename="metal"/>
    </layer>
    <output name="out" type="BSDF" nodename="both"/>
  </nodegraph>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodegraph="g" output="out"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
"""

MODEL = """
  <standard_surface name="car" type="surfaceshader">
    <input name="base_color" type="color3" value="0.2, 0.05, 0.1"/>
    <input name="coat" type="float" value="0.8"/>
    <input name="specular_roughness" type="float" value="0.4"/>
  </standard_surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="car"/>
  </surfacematerial>
"""


@pytest.fixture
def request_for(tmp_path):
    return Request(tmp_path / "x.mtlx", Reach.only(tmp_path), "x.mtlx", targets=("glsl", "osl"), samples=512)


def names(document: mx.Document) -> list[str]:
    return [v.name for v in variants(renderable_elements(document)[0])]


def test_nodes_whose_flag_is_on_and_nodes_that_nothing_uses_are_left_alone(make_document):
    document = make_document(COATED)
    copy = flattened(document)
    assert names(copy) == ["g/coat"]


def test_a_flag_that_is_connected_is_left_alone(make_document):
    text = COATED.replace(
        'name="retroreflective" type="boolean" value="false"', 'name="retroreflective" type="boolean" nodename="flag"'
    )
    document = make_document(
        text.replace(
            '<conductor_bsdf name="metal"', '<constant name="flag" type="boolean"/><conductor_bsdf name="metal"'
        )
    )
    assert names(flattened(document)) == []


def test_the_nodes_inside_a_surface_model_are_found_and_the_document_stays_as_it_is(make_document, library):
    document = make_document(MODEL)
    before = mx.writeToXmlString(document)
    copy = flattened(document)
    assert names(copy) == ["transmission_bsdf", "specular_bsdf", "metal_bsdf", "coat_bsdf"]
    assert mx.writeToXmlString(document) == before
    shader = generate(renderable_elements(copy)[0], "glsl", library)
    uniforms = [v.uniform(shader) for v in variants(renderable_elements(copy)[0])]
    assert uniforms == [f"{name}_retroreflective" for name in names(copy)]


@pytest.mark.parametrize("text", [COATED, MODEL])
def test_every_variant_compares_and_shows_the_flag(gl, make_document, request_for, text):
    copy = flattened(make_document(text))
    expected = names(copy)
    results, findings = ElementSweep(request_for, renderable_elements(copy)[0], Steps()).run()
    assert findings == []
    assert [r.name for r in results] == [f"m + retroreflective {name}" for name in expected]
    assert all(list(r.targets) == ["glsl"] and r.targets["glsl"].status == "pass" for r in results)
    # A surface without metal and transmission has these lobes off; the others look different with the flag.
    worst = {r.name.split()[-1]: r.targets["glsl"].worst for r in results}
    assert len({str(w) for w in worst.values()}) == len(worst)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        pytest.param("reflect(-closureData.V, N)", "closureData.V", id="the flag does nothing"),
        pytest.param(
            "closureType == CLOSURE_TYPE_INDIRECT", "closureType == CLOSURE_TYPE_TRANSMISSION", id="the wrong mode"
        ),
    ],
)
def test_an_error_that_shows_with_the_flag_alone_is_seen(
    gl, make_document, request_for, changed_library, monkeypatch, old, new
):
    wrong, _ = changed_library("genglsl/lib/mrm_retroreflection.glsl", old, new)
    monkeypatch.setattr(element_module, "load_library", lambda _origin: wrong)
    copy = flattened(make_document(MODEL, wrong))
    results, findings = ElementSweep(request_for, renderable_elements(copy)[0], Steps()).run()
    failed = [r.name.split()[-1] for r in results if r.targets["glsl"].status == "fail"]
    assert "coat_bsdf" in failed
    assert "specular_bsdf" in failed
    assert all(f.code == "SHADER_DIFFERS" and f.message.startswith("with the flag of ") for f in findings)


def test_the_command_reports_a_row_for_each_node(gl, check, tmp_path):
    (tmp_path / "coated.mtlx").write_text(f'<?xml version="1.0"?><materialx version="1.39">{COATED}</materialx>')
    plain, swept = (check(tmp_path, retro_sweep=on)[0] for on in (False, True))
    assert [r.name for r in plain.renderables] == ["m"]
    assert [r.name for r in swept.renderables] == ["m", "m + retroreflective g/coat"]
    assert plain.renderables[0] == swept.renderables[0]
