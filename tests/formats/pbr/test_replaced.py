"""What stands for an input without a form: its mean over the surface."""

from __future__ import annotations

import pytest

from mrm_mtlx.formats.pbr.placement import InexpressibleError
from mrm_mtlx.formats.pbr.replaced import replaced

STRIPES = """
<texcoord name="uv" type="vector2" />
<extract name="u" type="float"><input name="in" type="vector2" nodename="uv" /></extract>
<ifgreater name="stripe" type="float"><input name="value1" type="float" nodename="u" />
  <input name="value2" type="float" value="0.25" /><input name="in1" type="float" value="{high}" />
  <input name="in2" type="float" value="0" /></ifgreater>
<geompropvalue name="elsewhere" type="float"><input name="geomprop" type="string" value="wetness" /></geompropvalue>
<gltf_pbr name="s" type="surfaceshader"><input name="metallic" type="float" nodename="stripe" />
  <input name="roughness" type="float" nodename="elsewhere" /></gltf_pbr>
"""
# Places are 256, at random: three standard deviations of a share of three quarters are 0.08.
OFF = 0.08


def test_the_mean_of_a_pattern_stands_for_it(make_document):
    node = (document := make_document(STRIPES.format(high="0.8"))).getNode("s")
    found = replaced(node, "metallic", InexpressibleError("it has stripes"))
    assert found.value.value[0] == pytest.approx(0.75 * 0.8, abs=OFF)
    assert found.reason.startswith("it has stripes; its mean, 0.")
    other = replaced(document.getNode("s"), "metallic", InexpressibleError("it has stripes"))
    assert other.value.value[0] == found.value.value[0]


def test_another_pattern_has_another_mean(make_document):
    documents = [make_document(STRIPES.format(high=high)) for high in ("0.8", "0.4")]
    means = [replaced(d.getNode("s"), "metallic", InexpressibleError("")).value.value[0] for d in documents]
    assert means[0] == pytest.approx(2.0 * means[1], rel=1e-3)  # four digits


def test_what_the_geometry_says_has_none(make_document):
    document = make_document(STRIPES.format(high="0.8"))
    found = replaced(document.getNode("s"), "roughness", InexpressibleError("it is elsewhere"))
    assert (found.value, found.reason) == (None, "it is elsewhere")
