"""Options of OpenMATERIAL from Python: paths as text, the element of an open document, and what is refused."""

from __future__ import annotations

import json

import pytest

import mrm_mtlx as mrm

MATERIAL = """  <conductor_bsdf name="{0}_lobe" type="BSDF">
    <input name="roughness" type="vector2" value="{1}, {1}"/>
    <input name="retroreflective" type="boolean" value="true"/>
  </conductor_bsdf>
  <surface name="{0}_surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="{0}_lobe"/></surface>
  <surfacematerial name="{0}" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="{0}_surface"/>
  </surfacematerial>
"""


@pytest.fixture
def pair(tmp_path):
    """A document of two materials, the second of which returns more light."""
    path = tmp_path / "pair.mtlx"
    body = MATERIAL.format("dull", 0.2) + MATERIAL.format("bright", 0.05)
    path.write_text(f'<?xml version="1.0"?>\n<materialx version="1.39">\n{body}</materialx>\n', encoding="utf-8")
    return path


def test_the_element_of_an_open_document_is_the_one_that_was_chosen(pair, tmp_path):
    def written(document, **options):
        assert mrm.convert(document, tmp_path / "out.json", **options).complete
        data = json.loads((tmp_path / "out.json").read_text())
        return data["retroreflectivityData"]["coefficientOfRetroreflection"]

    dull, bright = (written(pair, element=name) for name in ("dull", "bright"))
    assert bright > 2.0 * dull
    assert (written(pair), written(mrm.open_document(pair, element="bright"))) == (dull, bright)
    assert written(mrm.open_document(pair, element="bright"), element="dull") == dull
    assert mrm.compare(mrm.open_document(pair, element="bright"), tmp_path / "out.json").equal is False
    with pytest.raises(mrm.ArgumentError, match=r"element: other: expected one of dull, bright"):
        written(pair, element="other")


def test_a_path_may_be_text_and_what_is_no_option_is_named(pair, tmp_path):
    (tmp_path / "old.json").write_text('{"name": "sign"}')
    mrm.convert(str(pair), str(tmp_path / "new.json"), into=str(tmp_path / "old.json"))
    assert list(json.loads((tmp_path / "new.json").read_text())) == ["name", "retroreflectivityData"]
    for options, message in (
        ({"angle": 1.0}, "angle: there is no such option"),
        ({"at": "/a"}, "at: only with `into`"),
        ({"observation": 91.0}, "observation: 91: expected 0 to 90 degrees"),
        ({"to": "usd"}, "to: 'usd': expected one of openmaterial"),
        ({"force": True}, "force: this format has no files beside OUTPUT"),
    ):
        with pytest.raises(mrm.ArgumentError, match=message):
            mrm.convert(pair, tmp_path / "a.json", **options)
    for options, message in (({"into": "a.json"}, "into: only where"), ({"element": "dull"}, "element: only where")):
        with pytest.raises(mrm.ArgumentError, match=message):
            mrm.convert(tmp_path / "new.json", tmp_path / "a.mtlx", **options)
    with pytest.raises(mrm.ArgumentError, match="into: only where a file of this format is written"):
        mrm.compare(pair, tmp_path / "new.json", into="a.json")
    assert not (tmp_path / "a.json").exists()
