"""What `mrm validate` says of documents with the nodes that have an amount of retroreflection."""

from __future__ import annotations

import pytest

SURFACE = """
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="{}"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
</materialx>
"""
HEAD = '<?xml version="1.0"?>\n<materialx version="1.39">\n'


@pytest.fixture
def findings(check, tmp_path):
    """Function from the inputs of a node to the codes of what is found about it, and the result on each target."""

    def run(node: str, *inputs: str, targets: tuple[str, ...] = ("glsl",), more: str = ""):
        path = tmp_path / "document.mtlx"
        given = "".join(f"<input {text}/>" for text in inputs)
        path.write_text(f'{HEAD}<{node} name="lobe" type="BSDF">{given}</{node}>{more}{SURFACE.format("lobe")}')
        (result,) = check(path, targets=targets)
        results = {t: r for x in result.renderables for t, r in x.targets.items()}
        return [f.code for f in result.findings], results

    return run


HALF = 'name="retroreflectivity" type="float" value="0.5"'


def test_a_partly_retroreflective_lobe_is_compared_and_nothing_is_wrong_with_it(gl, findings):
    codes, results = findings("mrm_conductor_bsdf", HALF)
    assert (codes, results["glsl"].stage, results["glsl"].status) == ([], "compare", "pass")


def test_an_amount_that_mdl_cannot_honour_is_reported(gl, findings):
    codes, _ = findings("mrm_conductor_bsdf", HALF, targets=("glsl", "mdl"))
    assert codes == ["SHADER_IGNORES_RETRO"]
    none = HALF.replace("0.5", "0.0")
    assert findings("mrm_conductor_bsdf", none, targets=("glsl", "mdl"))[0] == []


NARROW = 'name="roughness" type="vector2" value="0.000001, 0.000001"'


def test_the_checks_of_lobes_are_those_of_the_standard_nodes(gl, findings):
    assert findings("mrm_conductor_bsdf", HALF, NARROW)[0] == ["LOBE_TOO_NARROW"]
    only_transmission = 'name="scatter_mode" type="string" value="T"'
    assert "RETRO_TRANSMISSION" in findings("mrm_dielectric_bsdf", HALF, only_transmission)[0]
    assert "RETRO_INVISIBLE" in findings("mrm_dielectric_bsdf", HALF, 'name="weight" type="float" value="0.0"')[0]
    black = [f'name="{name}" type="color3" value="0, 0, 0"' for name in ("color0", "color90")]
    assert "RETRO_INVISIBLE" in findings("mrm_generalized_schlick_bsdf", HALF, *black)[0]


SHEET = '<mrm_prismatic_weight name="w" type="float">{}</mrm_prismatic_weight>'
ALONG = """<constant name="t" type="vector3"><input name="value" type="vector3" value="1, 0.3, 0.2"/></constant>"""


@pytest.mark.parametrize(("tangent", "compared"), [('<input name="tangent" type="vector3" nodename="t"/>', 1), ("", 0)])
def test_the_share_of_sheeting_is_compared_where_the_renderer_has_its_tangents(gl, cycles, findings, tangent, compared):
    # The facets that stand for a surface in Cycles have no tangents of their own.
    given = 'name="weight" type="float" nodename="w"'
    codes, results = findings(
        "oren_nayar_diffuse_bsdf", given, more=ALONG + SHEET.format(tangent), targets=("glsl", "essl", "osl")
    )
    assert codes == []
    assert {t: (r.stage, r.status) for t, r in results.items()} == {
        "glsl": ("compare", "pass"),
        "essl": ("compare", "pass"),
        "osl": ("compare" if compared else "compile", "pass"),
    }
