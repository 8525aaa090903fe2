"""What is read from stages, and what is said of those that are wrong."""

from __future__ import annotations

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.formats.usd.importer import stage_materials, validators
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request

# A material, whose inputs and shaders are to be filled in.
MATERIAL = """
def Material "M"
{{
    {inputs}
    token outputs:mtlx:surface.connect = </M/s.outputs:out>
    def Shader "s"
    {{
        uniform token info:id = "ND_surface"
        token inputs:bsdf.connect = </M/c.outputs:out>
        {surface}
        token outputs:out
    }}
    def Shader "c"
    {{
        uniform token info:id = "{identifier}"
        {conductor}
        token outputs:out
    }}
    {more}
}}
"""
BARE = {"inputs": "", "surface": "", "identifier": "ND_conductor_bsdf", "conductor": "", "more": ""}
IMAGE = """def Shader "i"
    {{
        uniform token info:id = "ND_image_color3"
        {0}
        color3f outputs:out
    }}
"""


@pytest.fixture
def material(stage_of):
    """Function from what fills `MATERIAL` to what is read from the stage."""
    return lambda **parts: stage_of(MATERIAL.format(**BARE | parts))


def value(imported, node, name):
    """Type, value and colour space of an input."""
    given = imported.materialx.getDescendant(node).getInput(name)
    return given.getType(), given.getValueString(), given.getColorSpace()


def test_a_document_says_where_its_elements_come_from(material):
    read = material(conductor="float2 inputs:roughness = (0.1, 0.2)")
    assert read.findings == []
    assert read.materialx.validate()[0]
    assert value(read, "c", "roughness") == ("vector2", "0.1, 0.2", "")
    assert read.source_locations == {
        "M": "/M",
        "M/surfaceshader": "/M.outputs:mtlx:surface",
        "s": "/M/s",
        "s/bsdf": "/M/s.inputs:bsdf",
        "c": "/M/c",
        "c/roughness": "/M/c.inputs:roughness",
    }
    assert read.source_location("/c/roughness") == "/M/c.inputs:roughness"
    assert read.source_location("/c/absent") == "/M/c/absent"


def test_values_come_through_the_interface_of_a_material(material):
    read = material(
        inputs='color3f inputs:tint = (0.5, 0.25, 0.125) (colorSpace = "srgb_rec709_scene")\n    bool inputs:flag = 1',
        conductor="color3f inputs:ior.connect = </M.inputs:tint>\n"
        "bool inputs:retroreflective.connect = </M.inputs:flag>",
    )
    assert value(read, "c", "ior") == ("color3", "0.5, 0.25, 0.125", "srgb_texture")
    assert value(read, "c", "retroreflective") == ("boolean", "true", "")
    assert read.findings == []


@pytest.mark.parametrize(
    ("kind", "node", "name", "text", "expected"),
    [
        ("normal3f", "c", "normal", "(0, 0, 1)", ("vector3", "0.0, 0.0, 1.0", "")),  # roles do not count
        ("token", "c", "distribution", '"ggx"', ("string", "ggx", "")),
        ("matrix3d", "t", "mat", "((1, 2, 3), (4, 5, 6), (7, 8, 9))",
         ("matrix33", "1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0", "")),
        ("int", "e", "index", "2", ("integer", "2", "")),
    ],
    ids=str,
)  # fmt: skip
def test_values_keep_type_and_number(material, kind, node, name, text, expected):
    shaders = '    def Shader "{}"\n    {{\n        uniform token info:id = "{}"\n        {}\n    }}\n'
    line = f"{kind} inputs:{name} = {text}"
    ids = {"t": "ND_transformmatrix_vector3", "e": "ND_extract_vector3"}
    parts = {"conductor": line} if node == "c" else {"more": shaders.format(node, ids[node], line)}
    read = material(**parts)
    assert value(read, node, name) == expected
    assert read.findings == []


GRAPH = """
def Material "M"
{{
    token outputs:mtlx:surface.connect = </M/s.outputs:surface>
    def Shader "s"
    {{
        uniform token info:id = "ND_surface"
        float inputs:opacity.connect = </M/g.outputs:out>
        token outputs:surface
    }}
    def NodeGraph "g"
    {{
        float inputs:gain = 0.25
        float outputs:out.connect = <{source}.outputs:out>
        {inside}
    }}
}}
"""
CONSTANT = """def Shader "k"
        {{
            uniform token info:id = "ND_constant_float"
            float inputs:value.connect = <{}>
            float outputs:out
        }}
"""
NESTED = """def NodeGraph "h"
        {{
            float inputs:up.connect = </M/g.inputs:gain>
            float outputs:out.connect = </M/g/h/k.outputs:out>
            {}
        }}
"""


def test_a_graph_stays_a_graph(stage_of):
    document = stage_of(GRAPH.format(source="/M/g/k", inside=CONSTANT.format("/M/g.inputs:gain"))).materialx
    assert document.getNodeGraph("g").getNode("k").getInput("value").getInterfaceName() == "gain"
    assert document.getNode("s").getInput("opacity").getNodeGraphString() == "g"


def test_a_shader_may_have_the_name_of_an_input_or_an_output_of_its_graph(stage_of):
    prims = GRAPH.format(source="/M/g/out", inside=CONSTANT.format("/M/g.inputs:gain").replace('"k"', '"out"'))
    read = stage_of(
        prims + prims.replace("/M", "/N").replace('"M"', '"N"').replace("gain", "out").replace("0.25", "0.5")
    )
    assert read.materialx.validate() == (True, "")
    graph = read.materialx.getNodeGraph("g2")
    (node,) = graph.getNodes()
    assert graph.getInput(node.getInput("value").getInterfaceName()).getValueString() == "0.5"
    assert graph.getOutputs()[0].getConnectedNode().getName() == node.getName()


def test_graphs_within_graphs_are_dissolved(stage_of):
    nested = NESTED.format(CONSTANT.format("/M/g/h.inputs:up"))
    read = stage_of(GRAPH.format(source="/M/g/h", inside=nested))
    assert read.materialx.getNodeGraph("g") is None
    assert value(read, "k", "value") == ("float", "0.25", "")
    assert read.source_locations["k/value"] == "/M/g/h/k.inputs:value"


def test_a_definition_is_named_only_where_another_would_be_found(material):
    other = 'def Shader "{}" {{\n uniform token info:id = "ND_multiply_color3FA"\n {}\n }}\n'
    other = other.format("m", "") + other.format("n", "float inputs:in2 = 0.5")
    read = material(more=other)
    # Without inputs, ND_multiply_color3 fits as well, and comes first; with a number for in2, it does not.
    assert read.materialx.getNode("m").getNodeDefString() == "ND_multiply_color3FA"
    assert read.materialx.getNode("n").getNodeDefString() == ""
    assert [read.materialx.getNode(name).getNodeDefString() for name in ("s", "c")] == ["", ""]


def test_a_stage_without_a_network_of_materialx_has_no_material(stage_of):
    preview = 'def Shader "p" {\n uniform token info:id = "UsdPreviewSurface"\n token outputs:surface\n }'
    read = stage_of(f'def Material "M" {{\n token outputs:surface.connect = </M/p.outputs:surface>\n {preview}\n }}\n')
    assert (read.materialx.getChildren(), read.findings) == ([], [])


def test_a_network_may_stand_in_the_universal_output(stage_of):
    shader = 'def Shader "s" {\n uniform token info:id = "ND_surface"\n token outputs:surface\n }'
    read = stage_of(f'def Material "M" {{\n token outputs:surface.connect = </M/s.outputs:surface>\n {shader}\n }}\n')
    assert read.source_locations["M/surfaceshader"] == "/M.outputs:surface"


WRONG = {
    "unconnected terminal": (
        {"inputs": "token outputs:mtlx:displacement"},
        ("DOC_CONNECTION", "/M.outputs:mtlx:displacement", "not connected"),
    ),
    "dangling connection": (
        {"surface": "token inputs:edf.connect = </M/gone.outputs:out>"},
        ("DOC_CONNECTION", "/M/s.inputs:edf", "nothing gives a value at /M/gone.outputs:out"),
    ),
    "unknown input": (
        {"surface": "float inputs:opcity = 1"},
        ("DOC_UNKNOWN_INPUT", "/M/s.inputs:opcity", "did you mean 'opacity'?"),
    ),
    "flag on a node without it": (
        {"surface": "bool inputs:retroreflective = 1"},
        ("RETRO_UNDEFINED", "/M/s.inputs:retroreflective", "has no input 'retroreflective'"),
    ),
    "number for a flag": (
        {"conductor": "int inputs:retroreflective = 1"},
        ("DOC_INPUT_TYPE", "/M/c.inputs:retroreflective", "has type integer, expected boolean"),
    ),
    "double for a float": (
        {"surface": "double inputs:opacity = 1"},
        ("DOC_INPUT_TYPE", "/M/s.inputs:opacity", "has type double, expected float"),
    ),
    "interface of another type": (
        {"inputs": "color3f inputs:x = (1, 1, 1)", "surface": "float inputs:opacity.connect = </M.inputs:x>"},
        ("DOC_CONNECTION", "/M/s.inputs:opacity", "gives color3, expected float"),
    ),
    "animated value": (
        {"surface": "float inputs:opacity.timeSamples = {0: 0.5, 1: 0.75}"},
        ("INTERCHANGE_LOST", "/M/s.inputs:opacity", "animated"),
    ),
    "path for a number": (
        {"surface": "float inputs:opacity = </M/s>"},
        ("DOC_INPUT_VALUE", "/M/s.inputs:opacity", "no float, but a Path"),
    ),
    "shader without an id": (
        {"identifier": ""},
        ("DOC_UNKNOWN_NODE", "/M/c", "no info:id"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("parts", WRONG.values(), ids=WRONG.keys())
def test_what_is_wrong_is_told_with_its_place(material, parts):
    filled, (code, place, message) = parts
    (finding,) = [finding for finding in material(**filled).findings if not finding.code.startswith("USD_")]
    assert (finding.code, finding.location) == (code, place)
    assert message in finding.message


FOUND = {
    "unknown id": (
        {"identifier": "ND_conductr_bsdf"},
        ("DOC_UNKNOWN_NODE", "/M/c", "did you mean 'ND_conductor_bsdf'?"),
    ),
    "connection of another type": (
        {"more": IMAGE.format(""), "surface": "float inputs:opacity.connect = </M/i.outputs:out>"},
        ("DOC_CONNECTION", "/M/s.inputs:opacity", "gives color3, expected float"),
    ),
    "connection into a uniform input": (
        {"conductor": "bool inputs:retroreflective.connect = </M/b.outputs:out>",
         "more": 'def Shader "b" {\n uniform token info:id = "ND_ifgreater_boolean"\n bool outputs:out\n }'},
        ("DOC_UNIFORM_CONNECTED", "/M/c.inputs:retroreflective", "uniform"),
    ),
    "missing image": (
        {"more": IMAGE.format("asset inputs:file = @./gone.png@")},
        ("DOC_FILE", "/M/i.inputs:file", "'gone.png' does not exist"),
    ),
    "image outside": (
        {"more": IMAGE.format("asset inputs:file = @../gone.png@")},
        ("READ_OUTSIDE", "/M/i.inputs:file", "outside the folder"),
    ),
    "image whose name no folder holds": (
        {"more": IMAGE.format(f"asset inputs:file = @./{'x' * 3000}.png@")},
        ("READ_OUTSIDE", "/M/i.inputs:file", "outside the folder"),
    ),
    "no such output": (
        {"surface": "float inputs:opacity.connect = </M/p.outputs:outq>",
         "more": 'def Shader "p" {\n uniform token info:id = "ND_separate2_vector2"\n float outputs:outq\n }'},
        ("DOC_CONNECTION", "/M/s.inputs:opacity", "has no output 'outq'"),
    ),
    "value out of range": (
        {"conductor": "float inputs:weight = -1"},
        ("DOC_VALUE_RANGE", "/M/c.inputs:weight", "below"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("parts", FOUND.values(), ids=FOUND.keys())
def test_what_the_checks_of_documents_find_has_its_place_in_the_stage(usda, parts):
    filled, (code, place, message) = parts
    path = usda(MATERIAL.format(**BARE | filled))
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    (found,) = [found for found in result.findings if found.code != "USD_VALIDATOR"]
    assert (found.code, found.location) == (code, place)
    assert message in found.message


def test_materials_take_over_what_they_derive_from_and_each_variant_that_differs_is_read(stage_of):
    base = MATERIAL.format(**BARE | {"conductor": "float inputs:weight = 0.5"})
    derived = """
def Material "D" (
    prepend specializes = </M>
    variants = {
        string look = "new"
    }
    prepend variantSets = "look"
)
{
    variantSet "look" = {
        "new" {
        }
        "same" {
            over "c" {
                float inputs:weight = 0.5
            }
        }
        "worn" {
            over "c" {
                float inputs:weight = 0.25
            }
        }
    }
}
"""
    read = stage_of(base + derived)
    materials = [node.getName() for node in read.materialx.getMaterialNodes()]
    places = [read.source_locations[name] for name in materials]
    assert places == ["/M", "/D", "/D{look=worn}"]
    weights = {
        read.source_locations[n.getName()]: value(read, n.getName(), "weight")[1]
        for n in read.materialx.getNodes("conductor_bsdf")
    }
    assert weights == {"/M/c": "0.5", "/D/c": "0.5", "/D{look=worn}c": "0.25"}
    assert read.materialx.validate()[0]


ABOVE = """
def Xform "X" (
    variants = {{
        string v = "a"
    }}
    prepend variantSets = "v"
)
{{
    {material}
    variantSet "v" = {{
        "a" {{
        }}
        "b" {{
            over "M" {{
                over "c" {{
                    float inputs:weight = 0.25
                }}
            }}
        }}
        "c" {{
        }}
    }}
}}
"""


def test_a_variant_above_a_material_counts_and_their_number_is_bounded(stage_of, monkeypatch):
    prims = ABOVE.format(material=MATERIAL.format(**BARE).replace("</M/", "</X/M/"))
    read = stage_of(prims)
    assert [read.source_locations[n.getName()] for n in read.materialx.getMaterialNodes()] == ["/X/M", "/X{v=b}M"]
    assert read.source_locations["M2/surfaceshader"] == "/X{v=b}M.outputs:mtlx:surface"
    monkeypatch.setattr(stage_materials, "MAXIMUM_VARIANTS", 0)
    read = stage_of(prims)
    assert [read.source_locations[n.getName()] for n in read.materialx.getMaterialNodes()] == ["/X/M"]
    (finding,) = [finding for finding in read.findings if not finding.code.startswith("USD_")]
    assert (finding.code, finding.location) == ("INTERCHANGE_LOST", "/X")


def test_a_variant_is_looked_at_with_the_other_sets_as_they_are(stage_of):
    prims = ABOVE.format(material=MATERIAL.format(**BARE).replace("</M/", "</X/M/"))
    prims = prims.replace('        "c" {\n        }\n', "").replace('Sets = "v"', 'Sets = ["v", "w"]')
    read = stage_of(prims.rstrip()[:-1] + '    variantSet "w" = {\n        "d" {\n        }\n    }\n}\n')
    assert [read.source_locations[n.getName()] for n in read.materialx.getMaterialNodes()] == ["/X/M", "/X{v=b}M"]


def test_what_cannot_be_composed_of_a_variant_is_told_and_not_printed(stage_of, capfd):
    broken = "".join(
        f' def "{name}" (\n references = <{to}>\n ) {{\n }}\n' for name, to in (("Y", "/X/Y"), ("Z", "/no"))
    )
    variants = f'variantSet "v" = {{\n "a" {{\n }}\n "b" {{\n{broken} }}\n "c" {{\n }}\n }}\n'
    prims = 'def "X" (\n variants = {\n string v = "a"\n }\n prepend variantSets = "v"\n) {\n' + variants + "}\n"
    findings = stage_of('def "M" {\n}\n' + prims).findings
    assert sorted((r.code, r.location, r.message.split(":")[0]) for r in findings) == [
        ("READ_INCLUDE", "/X{v=b}", "/X/Y"),
        ("USD_VALIDATOR", "/X{v=b}", "/X/Z"),
    ]
    assert capfd.readouterr() == ("", "")
    # What cannot be composed without a variant is not told of each of them.
    always = stage_of('def "W" (\n references = </no>\n) {\n}\n' + prims).findings
    assert "/W" in {r.location for r in always}
    assert {r for r in always if r.location.startswith("/X")} == set(findings)


def test_variants_that_many_prims_have_from_one_place_are_tried_once(stage_of, monkeypatch):
    asset = ABOVE.format(material=MATERIAL.format(**BARE).replace("</M/", "</X/M/"))
    prims = asset + "".join(f'def "i{k}" (\n references = </X>\n)\n{{\n}}\n' for k in range(5))
    monkeypatch.setattr(stage_materials, "MAXIMUM_VARIANTS", 2)  # as many as one of them has beside the selected
    read = stage_of(prims)
    assert [finding for finding in read.findings if not finding.code.startswith("USD_")] == []
    places = [read.source_locations[n.getName()] for n in read.materialx.getMaterialNodes()]
    assert places == ["/X/M", *(f"/i{k}/M" for k in range(5)), "/X{v=b}M"]


def test_what_instances_share_is_read_once_at_the_first(stage_of):
    prims = 'class "P"\n{\n' + MATERIAL.format(**BARE).replace("</M/", "</P/M/") + "}\n"
    prims += "".join(f'def "i{k}" (\n instanceable = true\n references = </P>\n)\n{{\n}}\n' for k in range(3))
    read = stage_of(prims)
    assert [read.source_locations[n.getName()] for n in read.materialx.getMaterialNodes()] == ["/i0/M"]
    assert value(read, "s", "bsdf")[0] == "BSDF"
    assert read.source_locations["c"] == "/i0/M/c"


def test_shaders_of_one_name_are_counted_on_from_the_last(stage_of):
    prims = "".join(MATERIAL.format(**BARE).replace('"M"', f'"M{k}"').replace("</M/", f"</M{k}/") for k in range(12))
    read = stage_of(prims)
    nodes = [node.getName() for node in read.materialx.getNodes("surface")]
    assert nodes == ["s", *(f"s{k}" for k in range(2, 13))]
    assert read.source_locations["s12"] == "/M11/s"


def test_a_default_colour_space_of_the_layer_counts(usda, stage_of):
    head = '#usda 1.0\n(\n customLayerData = {\n string colorSpace = "srgb_texture"\n }\n)\n'
    read = stage_of(usda(MATERIAL.format(**BARE | {"conductor": "color3f inputs:ior = (1, 2, 3)"}), head=head))
    assert read.materialx.getNode("c").getInput("ior").getActiveColorSpace() == "srgb_texture"


def test_the_noise_of_usds_validators_is_left_out_for_known_ids_alone(stage_of, monkeypatch):
    text = MATERIAL.format(**BARE)
    assert stage_of(text).findings == []
    unknown = stage_of(text.replace("ND_conductor_bsdf", "ND_x")).findings
    assert [(r.code, r.location, r.message.split(":")[1]) for r in unknown] == [
        ("USD_VALIDATOR", "/M/c.info:id", "ShaderSdrCompliance.MissingShaderIdInRegistry")
    ]
    monkeypatch.setattr(validators, "NOISE", "")
    assert {r.location for r in stage_of(text).findings} == {"/M/s.info:id", "/M/c.info:id"}


def test_validators_findings_of_one_kind_are_bounded(stage_of):
    shaders = "".join(
        f'    def Shader "x{k}"\n    {{\n        uniform token info:id = "nobody"\n    }}\n' for k in range(30)
    )
    findings = stage_of(MATERIAL.format(**BARE | {"more": shaders})).findings
    assert len(findings) == validators.MAXIMUM_OF_A_KIND + 1
    assert findings[-1].message.endswith(": 20 more of the same")
