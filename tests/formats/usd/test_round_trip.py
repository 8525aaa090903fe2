"""Documents mean the same after they went through USD: by the values of their surfaces, not by their text."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.shadergen.usd import values
from tests.fixtures.material import CORPORA

REPOSITORY = Path(__file__).parents[3]
# Between them: graphs, the place on the surface, partial nodes, a mix, layers.
MATERIALS = ("licence_plate", "embossed_foil", "hi_vis_tape_silver", "traffic_cone_collar")
# Between them: shares, an index that varies, light, coats, films, anisotropy, other models, patterns, images.
CORPUS = {
    "own": (
        "arithmetic", "own_surface", "lamps", "open_pbr_lacquer", "open_pbr_soap_film",
        "standard_surface_brushed_brass", "usd_preview_copper", "procedural", "textured", "colour_spaces", "looks",
    ),
    "shared": (
        "bsdf/mix_bsdf", "bsdf/varying_ior", "bsdf/blackbody", "open_pbr/open_pbr_lightbulb", "open_pbr/open_pbr_pearl",
        "standard_surface/standard_surface_metal_brushed",
    ),
}  # fmt: skip

# Everything that has another form in USD: files' prefix, colour spaces, units, interface, several outputs, a definition
# of the document's own within a graph, geometry as a default, matrices, integers, emission.
FEATURES = """
  <nodedef name="ND_own" node="own">
    <input name="amount" type="float" value="0.25" unittype="distance" unit="meter" />
    <input name="normal" type="vector3" defaultgeomprop="Nworld" />
    <output name="out" type="color3" />
  </nodedef>
  <nodegraph name="NG_own" nodedef="ND_own">
    <constant name="c" type="color3">
      <input name="value" type="color3" value="0.1, 0.2, 0.3" colorspace="srgb_texture" />
    </constant>
    <dotproduct name="d" type="float">
      <input name="in1" type="vector3" interfacename="normal" />
      <input name="in2" type="vector3" value="0, 0.5, 1" />
    </dotproduct>
    <multiply name="m" type="color3">
      <input name="in1" type="color3" nodename="c" />
      <input name="in2" type="float" interfacename="amount" />
    </multiply>
    <multiply name="n" type="color3">
      <input name="in1" type="color3" nodename="m" />
      <input name="in2" type="float" nodename="d" />
    </multiply>
    <output name="out" type="color3" nodename="n" />
  </nodegraph>
  <nodegraph name="G">
    <input name="gain" type="float" value="0.5" />
    <input name="file" type="filename" value="a.ppm" colorspace="srgb_texture" />
    <image name="im" type="color3">
      <input name="file" type="filename" interfacename="file" colorspace="{inner}" />
    </image>
    <separate3 name="sep" type="multioutput"><input name="in" type="color3" nodename="im" /></separate3>
    <combine3 name="comb" type="color3">
      <input name="in1" type="float" nodename="sep" output="outr" />
      <input name="in2" type="float" nodename="sep" output="outg" />
      <input name="in3" type="float" interfacename="gain" />
    </combine3>
    {within}
    <output name="out" type="color3" nodename="comb" />
  </nodegraph>
  <own name="mine" type="color3">
    <input name="amount" type="float" value="3" unittype="distance" unit="inch" />
  </own>
  <transformmatrix name="turned" type="vector3">
    <input name="in" type="vector3" value="0.1, 0.2, 0.7" />
    <input name="mat" type="matrix33" value="0.5, 0.25, 0, 0, 0.5, 0.125, 0.25, 0, 0.5" />
  </transformmatrix>
  <extract name="third" type="float">
    <input name="in" type="vector3" nodename="turned" />
    <input name="index" type="integer" value="2" />
  </extract>
  <standard_surface name="ss" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="G" output="out" />
    <input name="coat_color" type="color3" nodename="mine" />
    <input name="coat" type="float" value="0.333333333" />
    <input name="emission" type="float" nodename="third" />
    <input name="specular_color" type="color3" value="1, 0.5, 0.2" colorspace="srgb_texture" />
    <input name="subsurface" type="float" value="0.25" />
    <input name="thin_walled" type="boolean" value="true" />
  </standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="ss" />
  </surfacematerial>
"""


def same(before, after):
    """Whether all values are the same to the last bit."""
    return len(before) == len(after) and all(
        a == b if isinstance(a, str) else np.array_equal(a, b, equal_nan=True)
        for a, b in zip(before, after, strict=True)
    )


@pytest.mark.parametrize("name", MATERIALS)
def test_a_material_keeps_its_values_to_the_last_bit(name, imported, round_trip, shades, rng):
    source = imported(REPOSITORY / "materials" / f"{name}.mtlx")
    before = shades(source, rng)
    # Float32 values in, float32 values out, and the reference is the same function of them.
    assert same(before, shades(round_trip(source), rng))
    assert max(np.max(a) for a in before) > 0.01


@pytest.mark.parametrize(
    "path", [CORPORA[which] / f"{name}.mtlx" for which in CORPORA for name in CORPUS[which]], ids=lambda path: path.stem
)
def test_a_document_of_the_corpus_keeps_its_values(path, imported, round_trip, shades, rng):
    source = imported(path)
    assert same(shades(source, rng), shades(round_trip(source), rng))


@pytest.fixture
def featured(tmp_path):
    """Function from the colour space of a reader, and more nodes of its graph, to a document with all of `FEATURES`."""

    def make(inner="srgb_texture", within=""):
        folder = tmp_path / "documents"
        (folder / "tex").mkdir(parents=True)
        (folder / "tex" / "a.ppm").write_bytes(b"P6\n2 2\n255\n" + bytes(range(20, 140, 10)))
        text = FEATURES.format(inner=inner, within=within)
        path = folder / "features.mtlx"
        path.write_text(f'<materialx version="1.39" colorspace="lin_rec709" fileprefix="tex/">{text}</materialx>')
        return path

    return make


@pytest.mark.parametrize("inner", ["srgb_texture", "lin_rec709"])
# A node of the document's own makes a graph within the graph, which comes back without it.
@pytest.mark.parametrize("within", ["", '<own name="unused" type="color3" />'])
def test_what_has_another_form_in_usd_keeps_its_values(featured, inner, within, imported, round_trip, shades, rng):
    source = imported(featured(inner, within))
    back = round_trip(source)
    assert same(shades(source, rng), shades(back, rng))
    assert (back.materialx.getNodeGraph("G") is None) == bool(within)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('bool inputs:thin_walled = 1', 'bool inputs:thin_walled = 0'),
        ('float inputs:amount = 0.0762', 'float inputs:amount = 0.0763'),
        ('(0.1, 0.2, 0.3) (\n                    colorSpace = "srgb_texture"\n                )', '(0.1, 0.2, 0.3)'),
        ('sep.outputs:outg', 'sep.outputs:outb'),
        ('float inputs:gain = 0.5', 'float inputs:gain = 0.4'),
        ('int inputs:index = 2', 'int inputs:index = 1'),
        ('(0, 0.5, 0.125)', '(0, 0.125, 0.5)'),
    ],
    ids=["flag", "unit", "colour space", "output", "interface", "integer", "matrix"],
)  # fmt: skip
def test_a_wrong_value_in_the_stage_is_seen(featured, old, new, imported, written, stage_of, shades, rng):
    source = imported(featured())
    path = written(source, lost=[])
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")
    assert not same(shades(source, rng), shades(stage_of(path), rng))


def test_numbers_are_written_in_the_fewest_digits_that_give_them_back(rng):
    numbers = np.concatenate([rng.normal(size=200), rng.normal(size=200) * 1e-30]).astype(np.float32)
    texts = [values.to_text(float(x)) for x in numbers]
    assert [np.float32(text) for text in texts] == list(numbers)
    assert values.to_text(float(np.float32(0.1))) == "0.1"
    assert all(re.fullmatch(r"-?[\d.]+(e[+-]?\d+)?", text) for text in texts)


@pytest.mark.parametrize("given", ["true", "false", None])
def test_booleans_survive_set_and_unset(given, surface_document, written, stage_of):
    value = f'<input name="retroreflective" type="boolean" value="{given}" />' if given else ""
    document = surface_document(f'<conductor_bsdf name="bsdf" type="BSDF">{value}</conductor_bsdf>')
    back = stage_of(written(document)).materialx.getNode("bsdf").getInput("retroreflective")
    assert (back and back.getValueString()) == given
