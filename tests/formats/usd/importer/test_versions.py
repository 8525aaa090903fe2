"""Networks of an earlier MaterialX are upgraded as MaterialX upgrades its documents, each with its places."""

from __future__ import annotations

import MaterialX as mx
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request

# A material whose colour or normal comes from what is to be filled in.
MATERIAL = """
def Material "{name}" (
    prepend apiSchemas = ["MaterialXConfigAPI"]
)
{{
    {version}
    token outputs:mtlx:surface.connect = </{name}/s.outputs:out>
    def Shader "s"
    {{
        uniform token info:id = "ND_surface"
        token inputs:bsdf.connect = </{name}/c.outputs:out>
        token outputs:out
    }}
    def Shader "c"
    {{
        uniform token info:id = "ND_oren_nayar_diffuse_bsdf"
        {given}
        token outputs:out
    }}
    {shaders}
}}
"""
STATED = 'string config:mtlx:version = "{}"'
SHADER = 'def Shader "{}"\n    {{\n        uniform token info:id = "{}"\n        {}\n    }}\n    '
IMAGE = SHADER.format("i", "ND_image_color3", "color3f outputs:out")
COLOR = "color3f inputs:color.connect = </M/w.outputs:out>"
NORMAL = "vector3f inputs:normal.connect = </M/w.outputs:out>"
FROM_IMAGE = "color3f inputs:in.connect = </M/i.outputs:out>\n "


@pytest.fixture
def network(stage_of):
    """Function from shaders and how they are connected to what is read of the material."""

    def run(given, shaders, version=""):
        return stage_of(MATERIAL.format(name="M", version=version, given=given, shaders=shaders))

    return run


def by_name(read):
    return {node.getName(): node for node in read.materialx.getNodes()}


UPGRADED = {
    "a normal map": (
        NORMAL, SHADER.format("w", "ND_normalmap", 'vector3f inputs:in = (0, 0, 1)\nstring inputs:space = "tangent"'),
        {"w": ("normalmap", {"in"})},
    ),
    "a normal map in object space": (
        NORMAL, SHADER.format("w", "ND_normalmap", 'vector3f inputs:in = (0, 0, 1)\nstring inputs:space = "object"'),
        {
            "w": ("normalize", {"in"}),
            "multiply": ("multiply", {"in1", "in2"}),
            "subtract": ("subtract", {"in1", "in2"}),
        },
    ),
    "a swizzle to one channel": (
        "float inputs:roughness.connect = </M/w.outputs:out>",
        IMAGE + SHADER.format("w", "ND_swizzle_color3_float", FROM_IMAGE + 'string inputs:channels = "g"'),
        {"w": ("extract", {"in", "index"})},
    ),
    "a swizzle of channels": (
        COLOR, IMAGE + SHADER.format("w", "ND_swizzle_color3_color3", FROM_IMAGE + 'string inputs:channels = "bgr"'),
        {"w": ("combine3", {"in1", "in2", "in3"}), "separate": ("separate3", {"in"})},
    ),
    "an arc tangent": (
        "float inputs:roughness.connect = </M/w.outputs:out>",
        SHADER.format("w", "ND_atan2_float", "float inputs:in1 = 1\nfloat inputs:in2 = 2"),
        {"w": ("atan2", {"iny", "inx"})},
    ),
}  # fmt: skip


@pytest.mark.parametrize("version", ["", STATED.format("1.38")], ids=["unstated", "1.38"])
@pytest.mark.parametrize("case", UPGRADED.values(), ids=UPGRADED.keys())
def test_nodes_of_1_38_become_those_of_today(network, case, version):
    given, shaders, expected = case
    read = network(given, shaders, version)
    nodes = by_name(read)
    for name, (category, inputs) in expected.items():
        assert nodes[name].getCategory() == category
        assert {given.getName() for given in nodes[name].getInputs()} == inputs
        assert read.source_locations[name] == "/M/w"  # also of what is new
    assert read.materialx.validate() == (True, "")
    assert read.findings == []


@pytest.mark.parametrize("case", UPGRADED.values(), ids=UPGRADED.keys())
def test_the_upgrade_is_that_of_materialx(network, case, library):
    """The same network as a document of 1.38, which MaterialX upgrades as it reads it."""
    given, shaders, _ = case
    read = network(given, shaders)
    document = mx.createDocument()
    image = '<image name="i" type="color3"/>'
    first = next(iter(by_name(read)["c"].getInputs()))
    kind = {"normal": "vector3", "color": "color3", "roughness": "float"}[first.getName()]
    identifier = shaders.split('info:id = "')[-1].split('"')[0]
    inputs = {
        "ND_normalmap": '<input name="in" type="vector3" value="0.0, 0.0, 1.0"/><input name="space" type="string" '
        f'value="{"object" if "object" in shaders else "tangent"}"/>',
        "ND_atan2_float": '<input name="in1" type="float" value="1.0"/><input name="in2" type="float" value="2.0"/>',
    }
    channels = "bgr" if "bgr" in shaders else "g"
    swizzle = '<input name="in" type="color3" nodename="i"/>'
    swizzle += f'<input name="channels" type="string" value="{channels}"/>'
    category = identifier.split("_")[1]
    text = f'<materialx version="1.38">{image if "swizzle" in identifier else ""}<{category} name="w" type="{kind}">'
    text += f"{inputs.get(identifier, swizzle)}</{category}></materialx>"
    mx.readFromXmlString(document, text)
    for node in document.getNodes():
        mine = by_name(read)[node.getName()]
        assert mine.getCategory() == node.getCategory()
        assert {(i.getName(), i.getValueString(), i.getNodeName(), i.getOutputString()) for i in mine.getInputs()} == {
            (i.getName(), i.getValueString(), i.getNodeName(), i.getOutputString()) for i in node.getInputs()
        }


def test_thin_films_in_layers_become_inputs_of_what_they_lie_on(stage_of):
    film = SHADER.format("f", "ND_thin_film_bsdf", "float inputs:thickness = 500\ntoken outputs:out")
    metal = SHADER.format("m", "ND_conductor_bsdf", "token outputs:out")
    tops = "token inputs:top.connect = </M/f.outputs:out>\ntoken outputs:out\n"
    tops += "token inputs:base.connect = </M/m.outputs:out>"
    layer = SHADER.format("l", "ND_layer_bsdf", tops)
    prims = MATERIAL.format(name="M", version="", given="", shaders=film + metal + layer)
    read = stage_of(prims.replace("</M/c.outputs:out>", "</M/l.outputs:out>"))
    assert by_name(read)["m"].getInput("thinfilm_thickness").getValue() == 500.0
    assert by_name(read)["s"].getInput("bsdf").getNodeName() == "m"
    assert {"f", "l"}.isdisjoint(by_name(read))
    assert read.materialx.validate() == (True, "")


@pytest.mark.parametrize("version", ["1.39", "2.0"])
def test_nodes_of_1_38_are_unknown_in_a_network_of_a_later_version(usda, version):
    shader = SHADER.format("w", "ND_normalmap", "vector3f inputs:in = (0, 0, 1)")
    path = usda(MATERIAL.format(name="M", version=STATED.format(version), given=NORMAL, shaders=shader))
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    assert "DOC_UNKNOWN_NODE" in [found.code for found in result.findings]


def test_a_version_that_is_none_is_told(network):
    (finding,) = network("", "", STATED.format("latest")).findings
    assert (finding.code, finding.location) == ("INTERCHANGE_LOST", "/M")
    assert "its version of MaterialX is 'latest'" in finding.message


def test_materials_of_several_versions_are_upgraded_each_by_its_own(stage_of):
    swizzle = IMAGE + SHADER.format("w", "ND_swizzle_color3_color3", FROM_IMAGE + 'string inputs:channels = "bgr"')
    prims = "".join(
        MATERIAL.format(name=name, version=version, given=COLOR, shaders=swizzle).replace("</M/", f"</{name}/")
        for name, version in (("M", ""), ("N", STATED.format("1.38")))
    )
    named = SHADER.format("separate", "ND_image_color3", "color3f outputs:out")
    given = COLOR.replace("/w.", "/separate.").replace("</M/", "</O/")
    prims = MATERIAL.format(name="O", version=STATED.format("1.39"), given=given, shaders=named) + prims
    read = stage_of(prims)
    assert [read.source_locations[name] for name in ("separate", "separate2", "separate3")] == [
        "/O/separate",
        "/M/w",
        "/N/w",
    ]
    nodes = by_name(read)
    assert nodes["w"].getInput("in1").getNodeName() == "separate2"
    assert nodes["w2"].getInput("in1").getNodeName() == "separate3"
    assert nodes["separate3"].getInput("in").getNodeName() == "i2"
    assert nodes["s3"].getInput("bsdf").getNodeName() == "c3"
    assert read.source_locations["w2/in"] == "/N/w.inputs:in"
    assert read.materialx.validate() == (True, "")


def test_graphs_are_upgraded_inside(stage_of):
    inside = SHADER.format("i", "ND_image_color3", "color3f outputs:out")
    inside += SHADER.format(
        "w", "ND_swizzle_color3_color3",
        'color3f inputs:in.connect = </M/g/i.outputs:out>\n string inputs:channels = "bgr"\n color3f outputs:out',
    )  # fmt: skip
    graph = f'def NodeGraph "g"\n{{\ncolor3f outputs:out.connect = </M/g/w.outputs:out>\n{inside}}}\n'
    given = "color3f inputs:color.connect = </M/g.outputs:out>"
    read = stage_of(MATERIAL.format(name="M", version="", given=given, shaders=graph))
    graph = read.materialx.getNodeGraph("g")
    assert graph.getNode("w").getInput("in1").getNodeName() == "separate"
    assert graph.getNode("separate").getInput("in").getNodeName() == "i"
    assert by_name(read)["c"].getInput("color").getNodeGraphString() == "g"
    assert read.source_locations["g/separate"] == "/M/g/w"
    assert read.materialx.validate() == (True, "")


def test_what_the_validators_say_of_nodes_of_1_38_is_noise(stage_of, network):
    read = network(NORMAL, SHADER.format("w", "ND_normalmap", "vector3f inputs:in = (0, 0, 1)"))
    assert [finding for finding in read.findings if finding.code.startswith("USD_")] == []


def test_a_stage_that_is_written_states_the_version(surface_document, written, stage_of):
    text = '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"/>'
    path = written(surface_document(text))
    assert 'string config:mtlx:version = "1.39"' in path.read_text(encoding="utf-8")
