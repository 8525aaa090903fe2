"""Documents on the target osl: the flag is honoured, sources compile, and broken ones are found with their line."""

from __future__ import annotations

import re

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.library import Origin, materials_folder
from mrm_mtlx.shadergen import OslMode, generate, renderable_elements
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.flag_use import ignores_flag
from mrm_mtlx.validation.options import Request
from tests.fixtures.material import CORPORA
from tests.fixtures.versions import own_flag

RETRO = """
<{node} name="bsdf" type="BSDF"><input name="retroreflective" type="boolean" value="true"/></{node}>
"""
NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("mode", OslMode)
@own_flag
def test_our_osl_depends_on_the_flag_in_every_mode_and_the_standard_one_does_not(
    surface_document, library, upstream_library, node, mode
):
    for data, ignored in ((library, False), (upstream_library, True)):
        document = surface_document(RETRO.format(node=node), data=data)
        shader = generate(renderable_elements(document)[0], "osl", data, mode)
        assert ignores_flag(shader, "bsdf") is ignored


@pytest.mark.parametrize(("origin", "codes"), [(Origin.MRM, []), (Origin.UPSTREAM, ["SHADER_IGNORES_RETRO"])])
@own_flag
def test_the_rule_of_ignored_flags_is_for_the_standard_library_alone(repository, origin, codes):
    path = repository / "tests" / "rules" / "SHADER_IGNORES_RETRO" / "triggers.mtlx"
    found = check_document(Request(path, Reach.beside(path), path.name, targets=("osl",), samples=16, origin=origin))
    assert [finding.code for finding in found.findings] == codes


@pytest.mark.parametrize("path", sorted(materials_folder().glob("*.mtlx")), ids=lambda path: path.stem)
def test_the_osl_of_every_material_compiles(cycles, path):
    found = check_document(Request(path, Reach.beside(path), path.name, targets=("osl",), samples=16))
    (renderable,) = found.renderables
    assert (found.findings, renderable.targets["osl"].stage, renderable.targets["osl"].status) == (
        [],
        "compile",
        "pass",
    )


@pytest.mark.parametrize(
    "corpus",
    [name if name == "own" else pytest.param(name, marks=pytest.mark.large) for name in CORPORA],
    indirect=True,
)
def test_the_osl_of_every_document_of_the_corpus_compiles(cycles, corpus):
    paths = sorted(corpus.rglob("*.mtlx"))
    results = [
        check_document(Request(path, Reach.beside(path), path.name, targets=("osl",), samples=16)) for path in paths
    ]
    outcomes = [r.targets["osl"] for result in results for r in result.renderables]
    assert len(outcomes) > len(paths) > 0
    assert {(outcome.stage, outcome.status) for outcome in outcomes} == {("compile", "pass"), ("compare", "pass")}
    # What is compiled alone has its reason: another model in the renderer, or geometry that facets do not have.
    assert all((outcome.stage == "compare") is (outcome.reason is None) for outcome in outcomes)


BROKEN = """<?xml version="1.0"?>
<materialx version="1.39">
  <nodedef name="ND_tinted" node="tinted">
    <input name="in" type="color3" value="1, 1, 1"/><output name="out" type="color3"/>
  </nodedef>
  <implementation name="IM_tinted_osl" nodedef="ND_tinted" target="genosl" sourcecode="{source}"/>
  <implementation name="IM_tinted_glsl" nodedef="ND_tinted" target="genglsl" sourcecode="{{{{in}}}}"/>
  <tinted name="tint" type="color3"/>
  <oren_nayar_diffuse_bsdf name="diffuse" type="BSDF">
    <input name="color" type="color3" nodename="tint"/>
  </oren_nayar_diffuse_bsdf>
  <surface name="surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="diffuse"/></surface>
  <surfacematerial name="material" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface"/>
  </surfacematerial>
</materialx>
"""


@pytest.mark.parametrize(("source", "status"), [("2.0 * {{in}}", "pass"), ("missing({{in}})", "fail")])
def test_broken_osl_is_found_with_file_line_and_statement(cycles, tmp_path, source, status):
    path = tmp_path / "broken.mtlx"
    path.write_text(BROKEN.format(source=source), encoding="utf-8")
    found = check_document(Request(path, Reach.beside(path), path.name, targets=("osl",), samples=16))
    assert found.renderables[0].targets["osl"].status == status
    if status == "fail":
        (finding,) = found.findings
        assert (finding.code, finding.location) == ("SHADER_COMPILE", "/material")
        assert re.search(r"material\.osl:(\d+): function 'missing' was not declared.* at line \1: ", finding.message)
        assert finding.message.endswith("color tint_out = missing(tint_in);")
    else:
        assert found.findings == []
