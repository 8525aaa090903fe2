"""Surface models with an amount: which nodes of the installed graphs change, which definition a document gets."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.library import Origin, load_library, node_library_folder, surface_models
from mrm_mtlx.library.surface_models import PARTIAL_NODES, SURFACE_MODELS, SurfaceModel, amount_input, extend

# What the base's specular lobes are called in MaterialX 1.39.5, read in its graphs: what the search has to find.
BASE = {
    "open_pbr_surface": {"dielectric_reflection", "dielectric_reflection_tf", "metal_bsdf", "metal_bsdf_tf"},
    "standard_surface": {"specular_bsdf", "metal_bsdf"},
    "gltf_pbr": {"reflection_bsdf", "tf_reflection_bsdf", "metal_bsdf", "tf_metal_bsdf"},
}
MODELS = pytest.mark.parametrize("model", SURFACE_MODELS, ids=lambda model: model.node)


def written(element: mx.Element) -> str:
    """An element and what is in it, as text."""
    document = mx.createDocument()
    document.addChildOfCategory(element.getCategory(), "x").copyContentFrom(element)
    options = mx.XmlWriteOptions()
    options.writeXIncludeEnable = False
    return str(mx.writeToXmlString(document, options))


@MODELS
def test_the_lobes_of_the_base_and_no_others_are_partial(library, model):
    graph = library.document.getNodeGraph(model.graph)
    partial = {n.getName(): n for n in graph.getNodes() if n.getCategory() in PARTIAL_NODES}
    assert partial.keys() == BASE[model.node]
    assert {n.getInput("retroreflectivity").getInterfaceName() for n in partial.values()} == {model.amount}


@MODELS
def test_a_search_that_takes_transmission_for_reflection_would_be_seen(monkeypatch, library, model):
    monkeypatch.setattr(surface_models, "_reflects", lambda _node: True)
    stock = library.document.getNodeDef(f"ND_{model.node}_surfaceshader").getImplementation("")
    found = {node.getName() for node in surface_models._base_lobes(stock, model.roughness)}
    assert found > BASE[model.node]


@MODELS
def test_nothing_else_of_the_graph_and_of_the_definition_is_changed(library, upstream_library, model):
    stock = upstream_library.document.getNodeDef(f"ND_{model.node}_surfaceshader")
    copy = library.document.copy()
    graph, definition = copy.getNodeGraph(model.graph), copy.getNodeDef(model.definition)
    for name in BASE[model.node]:
        node = graph.getNode(name)
        node.removeInput("retroreflectivity")
        node.setCategory(node.getCategory().removeprefix("mrm_"))
    original = stock.getImplementation("")
    graph.setNodeDefString(original.getNodeDefString())
    if not original.getNodeDefString():
        graph.removeAttribute("nodedef")
    assert written(graph) == written(original)
    definition.removeInput(model.amount)
    definition.setDocString(stock.getDocString())
    assert written(definition) == written(stock)


@MODELS
def test_the_new_input_is_documented_bounded_off_and_can_be_connected(library, model):
    given = library.document.getNodeDef(model.definition).getActiveInput(model.amount)
    assert (given.getType(), given.getValue(), given.getIsUniform()) == ("float", 0.0, False)
    assert [given.getAttribute(name) for name in ("uimin", "uimax", "uiname")] == ["0.0", "1.0", "Retroreflectivity"]
    roughness = library.document.getNodeDef(model.definition).getActiveInput(model.roughness)
    assert given.getAttribute("uifolder") == roughness.getAttribute("uifolder") != ""
    assert "coat" in given.getDocString()


# Which definition a document's node gets.


@pytest.fixture
def found(make_document):
    """Function from a library, a model and a node's inputs to the name of its definition and that of its amount."""

    def find(data, model, attributes="", **inputs):
        given = "".join(f'<input name="{name}" type="float" value="{value}"/>' for name, value in inputs.items())
        text = f'<{model.node} name="s" type="surfaceshader" {attributes}>{given}</{model.node}>'
        document = make_document(text, data)
        definition = document.getNode("s").getNodeDef()
        return None if definition is None else definition.getName(), amount_input(document.getNode("s"))

    return find


@MODELS
def test_a_document_gets_the_extended_definition_if_it_uses_the_input(found, library, upstream_library, model):
    stock, amount = f"ND_{model.node}_surfaceshader", {model.amount: 0.0}
    assert found(library, model) == (stock, "")
    assert found(library, model, **{model.roughness: 0.4}) == (stock, "")
    assert found(library, model, **amount) == (model.definition, model.amount)
    assert found(upstream_library, model, **amount) == (None, "")


@MODELS
def test_the_extended_definition_has_the_version_it_was_copied_from_and_no_other(found, library, model):
    version = library.document.getNodeDef(f"ND_{model.node}_surfaceshader").getVersionString()
    amount = {model.amount: 0.5}
    assert found(library, model, f'version="{version}"', **amount)[0] == model.definition
    assert found(library, model, 'version="9.9"', **amount)[0] is None


# Other libraries than the installed one.

MODEL = SurfaceModel("glossy", "retroreflectivity", "roughness", "fuzz")
LOBE = '<input name="roughness" type="vector2" nodename="{}"/>'
GLOSSY = """
  <nodedef name="ND_glossy" node="glossy">
    <input name="roughness" type="float" value="0.3"/><input name="coat_roughness" type="float" value="0.1"/>
    <output name="out" type="surfaceshader"/>
  </nodedef>
  <nodegraph name="NG_glossy" nodedef="ND_glossy">
    <multiply name="squared" type="float">
      <input name="in1" type="float" interfacename="roughness"/>
      <input name="in2" type="float" interfacename="roughness"/>
    </multiply>
    <roughness_anisotropy name="width" type="vector2">
      <input name="roughness" type="float" nodename="squared"/>
    </roughness_anisotropy>
    <roughness_anisotropy name="coat_width" type="vector2">
      <input name="roughness" type="float" interfacename="coat_roughness"/>
    </roughness_anisotropy>
    <dielectric_bsdf name="base" type="BSDF"><input name="roughness" type="vector2" nodename="width"/></dielectric_bsdf>
    <conductor_bsdf name="haze" type="BSDF"><input name="roughness" type="vector2" nodename="width"/></conductor_bsdf>
    <dielectric_bsdf name="coat" type="BSDF">
      <input name="roughness" type="vector2" nodename="coat_width"/>
    </dielectric_bsdf>
    <dielectric_bsdf name="through" type="BSDF">
      <input name="roughness" type="vector2" nodename="width"/>
      <input name="scatter_mode" type="string" value="T"/>
    </dielectric_bsdf>
    <dielectric_bsdf name="constant" type="BSDF"/>
    <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="base"/></surface>
    <output name="out" type="surfaceshader" nodename="s"/>
  </nodegraph>
"""


def extended(text: str) -> tuple[mx.Document, str]:
    """The standard library with these elements and what `extend` makes of both, and the reason it gives."""
    document = load_library(Origin.UPSTREAM).document.copy()
    mx.readFromXmlString(document, f'<?xml version="1.0"?><materialx version="1.39">{text}</materialx>')
    (extension,) = extend(document, [MODEL])
    return document, extension.reason


def test_lobes_are_found_by_what_their_width_depends_on_not_by_their_names():
    document, reason = extended(GLOSSY)
    assert reason == ""
    partial = {n.getName(): n.getCategory() for n in document.getNodeGraph(MODEL.graph).getNodes()}
    changed = {name: category for name, category in partial.items() if category in PARTIAL_NODES}
    assert changed == {"base": "mrm_dielectric_bsdf", "haze": "mrm_conductor_bsdf"}


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        pytest.param(GLOSSY, "", "this MaterialX has no 'glossy'", id="no definition"),
        pytest.param(
            'input name="roughness" type="float"', 'input name="sharpness" type="float"',
            "its definition has no input 'roughness'", id="no roughness",
        ),
        pytest.param(
            'name="NG_glossy" nodedef="ND_glossy"', 'name="NG_glossy"', "it is not defined by a graph", id="no graph"
        ),
        pytest.param(
            'nodename="squared"', 'value="0.2"',
            "no reflecting microfacet node of its graph takes its width from 'roughness'", id="no lobe",
        ),
        pytest.param(
            '<conductor_bsdf name="haze" type="BSDF">',
            '<conductor_bsdf name="haze" type="BSDF"><input name="retroreflective" type="boolean" value="true"/>',
            "its graph gives 'haze' an input 'retroreflective' already", id="flagged",
        ),
    ],
)  # fmt: skip
def test_a_model_of_another_structure_is_left_out_with_the_reason(old, new, reason):
    text = GLOSSY.replace(old, new, 1)
    assert text != GLOSSY
    document, found = extended(text)
    assert found == reason
    assert document.getNodeDef(MODEL.definition) is None
    assert document.getNodeGraph(MODEL.graph) is None


def test_a_library_that_has_the_input_itself_is_left_as_it_is():
    text = GLOSSY.replace("<output", '<input name="retroreflectivity" type="float" value="0"/><output', 1)
    document, reason = extended(text)
    assert reason == ""
    assert document.getNodeDef(MODEL.definition) is None


def test_no_model_of_materialx_is_in_the_node_library():
    texts = "".join(p.read_text(encoding="utf-8") for p in node_library_folder().rglob("*.mtlx"))
    assert not any(f'node="{model.node}"' in texts or f"<{model.node}" in texts for model in SURFACE_MODELS)
