"""What is found in a document's structure, and where; and documents that are stranger than wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings.finding import MAXIMUM_OF_A_RULE
from mrm_mtlx.validation.checks.cycles import MAXIMUM_CHAIN
from mrm_mtlx.validation.checks.files import check_files
from mrm_mtlx.validation.checks.graph import check_graph
from mrm_mtlx.validation.checks.nodes import Spelling
from mrm_mtlx.validation.checks.retroreflection import check_retroreflection
from mrm_mtlx.validation.checks.scope import nothing_to_render

SHOWN = (
    '<surface name="surface" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="metal"/></surface>'
    '<surfacematerial name="material" type="material">'
    '<input name="surfaceshader" type="surfaceshader" nodename="surface"/></surfacematerial>'
)


def metal(inputs: str = "", category: str = "conductor_bsdf", name: str = "metal") -> str:
    return f'<{category} name="{name}" type="BSDF">{inputs}</{category}>'


def given(name: str, kind: str, **attributes: str) -> str:
    more = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f'<input name="{name}" type="{kind}" {more}/>'


@pytest.fixture
def found(make_document, library, tmp_path):
    """Function from elements, as text, to (code, location, message) of the structure's findings."""
    for name in ("here.png", "tiles.1001.png"):
        (tmp_path / name).write_bytes(b"")

    def check(elements: str) -> list[tuple[str, str, str]]:
        document = make_document(elements)
        findings = check_graph(document) + check_files(document, Reach.only(tmp_path), library)
        return [(f.code, f.location, f.message) for f in findings]

    return check


VARYING = (
    '<noise2d name="n" type="float"/><ifgreater name="v" type="boolean">'
    '<input name="value1" type="float" nodename="n"/></ifgreater>'
)

# A node with two outputs, a struct, and a graph with two outputs.
TWO = '<artistic_ior name="a" type="multioutput"/>'
STRUCT = '<typedef name="s"><member name="x" type="float"/><member name="y" type="color3"/></typedef>'
NESTED = STRUCT + '<typedef name="t"><member name="p" type="s"/><member name="q" type="integer"/></typedef>'
TWO_OF_A_GRAPH = (
    f'<nodegraph name="g">{TWO}<output name="o" type="color3" nodename="a" output="ior"/>'
    '<output name="p" type="color3" nodename="a" output="extinction"/></nodegraph>'
)


def takes(kind: str, value: str) -> str:
    """A node of the document's own whose input of a type has a value."""
    return (
        f'<nodedef name="ND_a" node="a"><input name="in" type="{kind}"/><output name="out" type="float"/></nodedef>'
        f'<a name="x" type="float"><input name="in" type="{kind}" value="{value}"/></a>'
    )


OUT = '<output name="out" type="float"/></nodedef>'
DEFINED = f'<nodedef name="ND_a" node="a">{OUT}'
TWO_DEFINED = '<nodedef name="ND_a" node="b"><output name="o" type="color3"/><output name="p" type="color3"/></nodedef>'

# Two materials with a displacement, one with a back surface.
BESIDE = '<displacement name="d" type="displacementshader"/><surface name="s" type="surfaceshader"/>' + "".join(
    f'<surfacematerial name="{name}" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>'
    f'<input name="displacementshader" type="displacementshader" nodename="d"/>{more}</surfacematerial>'
    for name, more in (("m", given("backsurfaceshader", "surfaceshader", nodename="s")), ("n", ""))
)

# A document's elements; code, place and some words of each finding.
CASES = {
    "nothing wrong": (metal(given("weight", "float", value="0.5")), []),
    "an unknown node far from any other": (
        metal(category="qqqqqqqq"),
        [("DOC_UNKNOWN_NODE", "/metal", "no node 'qqqqqqqq'")],
    ),
    "an unknown node near another": (
        metal(category="conductor_bsd"),
        [("DOC_UNKNOWN_NODE", "/metal", "did you mean 'conductor_bsdf'?")],
    ),
    "a node of another type": (
        '<noise2d name="n" type="boolean"/>',
        [("DOC_UNKNOWN_NODE", "/n", "'noise2d' of type boolean is not defined; it exists for color3, ")],
    ),
    "no such combination of types": (
        '<multiply name="m" type="float"><input name="in1" type="float" value="1"/>'
        '<input name="in2" type="color3" value="1, 1, 1"/></multiply>',
        [("DOC_INPUT_TYPE", "/m/in2", "input 'in2' has type color3, expected float")],
    ),
    "inside a graph": (
        '<nodegraph name="g">' + metal(given("weigth", "float", value="1")) + "</nodegraph>",
        [("DOC_UNKNOWN_INPUT", "/g/metal/weigth", "did you mean 'weight'?")],
    ),
    "two inputs": (
        metal(given("weight", "float", value="one") + given("ior", "color3", value="1")),
        [
            ("DOC_INPUT_VALUE", "/metal/weight", "'one' is not a float (a finite number)"),
            ("DOC_INPUT_VALUE", "/metal/ior", "'1' is not a color3 (3 numbers, separated by commas)"),
        ],
    ),
    "a number that is none": (
        metal(given("weight", "float", value="nan")),
        [("DOC_INPUT_VALUE", "/metal/weight", "'nan' is not a float")],
    ),
    "an infinite number": (
        metal(given("ior", "color3", value="1, inf, 1")),
        [("DOC_INPUT_VALUE", "/metal/ior", "'1, inf, 1' is not a color3")],
    ),
    "a capital truth": (
        metal(given("retroreflective", "boolean", value="True")),
        [("DOC_INPUT_VALUE", "/metal/retroreflective", "(exactly true or false)")],
    ),
    "a choice that there is not": (
        metal(given("scatter_mode", "string", value="TR"), "dielectric_bsdf"),
        [("DOC_INPUT_VALUE", "/metal/scatter_mode", "'TR' is not one of R, T, RT")],
    ),
    "a value above its range": (
        metal(given("weight", "float", value="1.5")),
        [("DOC_VALUE_RANGE", "/metal/weight", "weight = 1.5 is above the definition's uimax of 1.0")],
    ),
    "one component below its range": (
        metal(given("ior", "color3", value="1, -0.1, 1")),
        [("DOC_VALUE_RANGE", "/metal/ior", "below the definition's uimin of 0.0, 0.0, 0.0")],
    ),
    "a connection to a node that is not there": (
        metal(given("weight", "float", nodename="nobody")),
        [("DOC_CONNECTION", "/metal/weight", "nothing is named 'nobody' there")],
    ),
    "a connection to an output that is not there": (
        TWO + metal(given("ior", "color3", nodename="a", output="second")),
        [("DOC_CONNECTION", "/metal/ior", "'a' has no output 'second'")],
    ),
    "a connection to a graph's output that is not there": (
        '<nodegraph name="g"><constant name="c" type="float"/><output name="out" type="float" nodename="c"/>'
        "</nodegraph>" + metal(given("weight", "float", nodegraph="g", output="second")),
        [("DOC_CONNECTION", "/metal/weight", "'g' has no output 'second'")],
    ),
    "a connection to the only output of a node, by its name": (
        '<constant name="c" type="float"/>' + metal(given("weight", "float", nodename="c", output="out")),
        [("DOC_OUTPUT_IGNORED", "/metal/weight", "'c' has one output, and output 'out' is named")],
    ),
    "a connection to the only output of a node, by another name": (
        '<constant name="c" type="float"/>' + metal(given("weight", "float", nodename="c", output="second")),
        [("DOC_OUTPUT_IGNORED", "/metal/weight", "'c' has one output, and output 'second' is named")],
    ),
    "a graph's output that is the only one of a node, by its name": (
        '<nodegraph name="g"><constant name="c" type="float"/>'
        '<output name="o" type="float" nodename="c" output="out"/></nodegraph>',
        [("DOC_OUTPUT_IGNORED", "/g/o", "'c' has one output, and output 'out' is named")],
    ),
    "a connection to the only output of a node, of another type": (
        '<constant name="c" type="color3"/>' + metal(given("weight", "float", nodename="c", output="out")),
        [
            ("DOC_OUTPUT_IGNORED", "/metal/weight", "'c' has one output, and output 'out' is named"),
            ("DOC_CONNECTION", "/metal/weight", "'c' gives color3, expected float"),
        ],
    ),
    "a connection to another type": (
        '<constant name="c" type="color3"/>' + metal(given("weight", "float", nodename="c")),
        [("DOC_CONNECTION", "/metal/weight", "'c' gives color3, expected float")],
    ),
    "a connection to a graph's output": (
        '<nodegraph name="g"><constant name="c" type="float"/><output name="out" type="float" nodename="c"/>'
        "</nodegraph>" + metal(given("weight", "float", nodegraph="g", output="out")),
        [],
    ),
    "a connection to one of several outputs": (
        '<artistic_ior name="a" type="multioutput"/>' + metal(given("ior", "color3", nodename="a", output="ior")),
        [],
    ),
    "a connection to a graph as if it were a node": (
        TWO_OF_A_GRAPH + metal(given("ior", "color3", nodename="g", output="o")),
        [("DOC_CONNECTION", "/metal/ior", "'g' is a graph, but connected as a node")],
    ),
    "a connection to a node that is named as a type is": (
        '<constant name="color3" type="color3"/>' + metal(given("ior", "color3", nodename="color3")),
        [
            (
                "DOC_CONNECTION",
                "/metal/ior",
                "MaterialX does not find 'color3': an element of its libraries has the same",
            )
        ],
    ),
    "a connection to several outputs": (
        TWO + metal(given("ior", "color3", nodename="a")),
        [("DOC_CONNECTION", "/metal/ior", "'a' has several outputs, and none is named")],
    ),
    "a graph's output that is connected to several": (
        f'<nodegraph name="g">{TWO}<output name="out" type="color3" nodename="a"/></nodegraph>',
        [("DOC_CONNECTION", "/g/out", "'a' has several outputs, and none is named")],
    ),
    "a connection to a graph of several outputs": (
        TWO_OF_A_GRAPH + metal(given("ior", "color3", nodegraph="g")),
        [("DOC_CONNECTION", "/metal/ior", "'g' has several outputs, and none is named")],
    ),
    "a connection to one output of several": (
        TWO_OF_A_GRAPH + metal(given("ior", "color3", nodegraph="g", output="p")),
        [],
    ),
    "a graph's output that is connected to nothing of the name": (
        '<nodegraph name="g"><output name="out" type="color3" nodename="nobody"/></nodegraph>',
        [("DOC_CONNECTION", "/g/out", "nothing is named 'nobody' there")],
    ),
    "an interface that is connected to another type": (
        '<constant name="c" type="color3"/><nodegraph name="g"><input name="i" type="float" nodename="c"/></nodegraph>',
        [("DOC_CONNECTION", "/g/i", "'c' gives color3, expected float")],
    ),
    "a uniform input that is connected": (
        VARYING + metal(given("retroreflective", "boolean", nodename="v")),
        [("DOC_UNIFORM_CONNECTED", "/metal/retroreflective", "is uniform, but connected to what may vary")],
    ),
    "a uniform input that is connected through a dot": (
        VARYING
        + '<dot name="d" type="boolean"><input name="in" type="boolean" nodename="v"/></dot>'
        + metal(given("retroreflective", "boolean", nodename="d")),
        [("DOC_UNIFORM_CONNECTED", "/metal/retroreflective", "is uniform, but connected to what may vary")],
    ),
    "a uniform input that is connected to a constant": (
        '<constant name="c" type="boolean"/>' + metal(given("retroreflective", "boolean", nodename="c")),
        [],
    ),
    "a uniform input that is connected to a constant through dots": (
        '<constant name="c" type="boolean"/>'
        '<dot name="d" type="boolean"><input name="in" type="boolean" nodename="c"/></dot>'
        '<dot name="e" type="boolean"><input name="in" type="boolean" nodename="d"/></dot>'
        + metal(given("retroreflective", "boolean", nodename="e")),
        [],
    ),
    "a uniform input that is connected to a graph's output": (
        f'<nodegraph name="g">{VARYING}<output name="out" type="boolean" nodename="v"/></nodegraph>'
        + metal(given("retroreflective", "boolean", nodegraph="g", output="out")),
        [("DOC_UNIFORM_CONNECTED", "/metal/retroreflective", "is uniform, but connected to what may vary")],
    ),
    "a uniform input that is connected to an output that is declared so": (
        f'<nodegraph name="g">{VARYING}<output name="out" type="boolean" nodename="v" uniform="true"/></nodegraph>'
        + metal(given("retroreflective", "boolean", nodegraph="g", output="out")),
        [],
    ),
    "a file that comes through a dot": (
        '<dot name="d" type="filename"><input name="in" type="filename" value="here.png"/></dot>'
        '<image name="i" type="color3"><input name="file" type="filename" nodename="d"/></image>',
        [],
    ),
    "a uniform input through an interface": (
        '<nodegraph name="g"><input name="flag" type="boolean" value="true"/>'
        + metal(given("retroreflective", "boolean", interfacename="flag"))
        + '<output name="out" type="BSDF" nodename="metal"/></nodegraph>',
        [],
    ),
    "a normal that is a number": (
        metal(given("normal", "vector3", value="0, 0, 1")),
        [("DOC_VALUE_IGNORED", "/metal/normal", "'normal' is given as 0, 0, 1, but taken from the geometry")],
    ),
    "a graph whose only output has another name than its definition's": (
        f'{DEFINED}<nodegraph name="NG_a" nodedef="ND_a"><constant name="k" type="float"/>'
        '<output name="other" type="float" nodename="k"/></nodegraph>',
        [],
    ),
    "a graph one of whose outputs has another name than its definition's": (
        TWO_DEFINED
        + f'<nodegraph name="NG_a" nodedef="ND_a">{TWO}<output name="o" type="color3" nodename="a" output="ior"/>'
        '<output name="q" type="color3" nodename="a" output="ior"/></nodegraph>',
        [("DOC_DEFINITION", "/NG_a", "it has the outputs o (color3), q (color3), expected o (color3), p (color3)")],
    ),
    "a graph with an output less than its definition": (
        TWO_DEFINED
        + f'<nodegraph name="NG_a" nodedef="ND_a">{TWO}<output name="o" type="color3" nodename="a" output="ior"/>'
        "</nodegraph>",
        [("DOC_DEFINITION", "/NG_a", "expected o (color3), p (color3) as 'ND_a' has")],
    ),
    "a graph of another type than its definition": (
        f'{DEFINED}<nodegraph name="NG_a" nodedef="ND_a"><constant name="k" type="color3"/>'
        '<output name="out" type="color3" nodename="k"/></nodegraph>',
        [("DOC_DEFINITION", "/NG_a", "it has the outputs out (color3), expected out (float)")],
    ),
    "an implementation by a graph of other outputs": (
        f'{DEFINED}<implementation name="IM_a" nodedef="ND_a" nodegraph="g"/><nodegraph name="g">'
        '<constant name="k" type="color3"/><output name="out" type="color3" nodename="k"/></nodegraph>',
        [("DOC_DEFINITION", "/g", "it has the outputs out (color3), expected out (float)")],
    ),
    "an implementation by a graph that is not there": (
        f'{DEFINED}<implementation name="IM_a" nodedef="ND_a" nodegraph="nobody"/>',
        [("DOC_DEFINITION", "/IM_a", "no graph is named 'nobody'")],
    ),
    "a definition of a node without outputs": (
        '<nodedef name="ND_a" node="a"/><a name="x" type="float"/>',
        [("DOC_UNKNOWN_NODE", "/x", "'a' has no output in its definition ND_a")],
    ),
    "a definition of an output without a type": (
        '<nodedef name="ND_a" node="a"><output name="out"/></nodedef>',
        [("DOC_DEFINITION", "/ND_a/out", "the output 'out' has no type")],
    ),
    "units by scales that are none": (
        '<unittypedef name="u"/><unitdef name="d" unittype="u"><unit name="one" scale="1"/>'
        '<unit name="zero" scale="0"/><unit name="x" scale="x"/></unitdef>',
        [
            ("DOC_DEFINITION", "/d/zero", "the scale '0' of the unit 'zero'"),
            ("DOC_DEFINITION", "/d/x", "the scale 'x' of the unit 'x'"),
        ],
    ),
    "a look of a material that is not there": (
        '<look name="l"><materialassign name="a" material="nobody" geom="/"/></look>',
        [("DOC_CONNECTION", "/l/a", "no material is named 'nobody'")],
    ),
    "a look of a surface for a material": (
        SHOWN + metal() + '<look name="l"><materialassign name="a" material="surface" geom="/"/></look>',
        [("DOC_CONNECTION", "/l/a", "'surface' is of type surfaceshader, expected a material")],
    ),
    "a look of a material": (
        SHOWN + metal() + '<look name="l"><materialassign name="a" material="material" geom="/"/></look>',
        [],
    ),
    "a look of a graph that gives a material": (
        f'<nodegraph name="g">{SHOWN}{metal()}<output name="out" type="material" nodename="material"/></nodegraph>'
        '<look name="l"><materialassign name="a" material="g" geom="/"/></look>',
        [],
    ),
    "a look of a collection that is not there": (
        SHOWN + metal() + '<look name="l"><materialassign name="a" material="material" collection="nobody"/></look>',
        [("DOC_INVALID", "/l/a", "Invalid collection string")],
    ),
    "a group of looks of which one is not there": (
        '<look name="l"/><lookgroup name="g" looks="l, m"/>',
        [("DOC_CONNECTION", "/g", "no look is named 'm'")],
    ),
    "a collection of one that is not there": (
        '<collection name="c" includecollection="d"/>',
        [("DOC_CONNECTION", "/c", "no collection is named 'd'")],
    ),
    "an interface name that is not there": (
        '<nodegraph name="g">' + metal(given("weight", "float", interfacename="nobody")) + "</nodegraph>",
        [("DOC_INVALID", "/g/metal/weight", "Interface name not found")],
    ),
    "a reader of a property without its name": (
        '<UsdPrimvarReader name="r" type="float"/>',
        [("DOC_INPUT_VALUE", "/r", "'UsdPrimvarReader' reads a geometric property, and does not say which")],
    ),
    "a reader of a property by an empty name": (
        '<geompropvalue name="r" type="float"><input name="geomprop" type="string" value=""/></geompropvalue>',
        [("DOC_INPUT_VALUE", "/r", "'geompropvalue' reads a geometric property, and does not say which")],
    ),
    "a reader of a property by its name through an interface": (
        '<nodegraph name="g"><input name="n" type="string" value="wear"/><geompropvalue name="r" type="float">'
        '<input name="geomprop" type="string" interfacename="n"/></geompropvalue></nodegraph>',
        [],
    ),
    "displacements beside surfaces": (
        metal() + BESIDE,
        [
            ("DOC_NOT_COMPARED", "/m", "the displacement of 'm' is not compared (nor that of 1 more)"),
            ("DOC_NOT_COMPARED", "/m", "the back surface of 'm' is not compared"),
        ],
    ),
    "an image that is there": (
        '<image name="i" type="color3"><input name="file" type="filename" value="here.png"/></image>',
        [],
    ),
    "a set of tiles": (
        '<image name="i" type="color3"><input name="file" type="filename" value="tiles.&lt;UDIM&gt;.png"/></image>',
        [],
    ),
    "a set without a tile": (
        '<image name="i" type="color3"><input name="file" type="filename" value="none.&lt;UDIM&gt;.png"/></image>',
        [("DOC_FILE", "/i/file", "no file of the set 'none.<UDIM>.png' exists")],
    ),
    "a set of tiles outside": (
        '<image name="i" type="color3"><input name="file" type="filename" value="../tiles.&lt;UDIM&gt;.png"/></image>',
        [("READ_OUTSIDE", "/i/file", "'../tiles.<UDIM>.png' lies outside the folder")],
    ),
    "a colour space of one input": (
        metal(given("ior", "color3", value="1, 1, 1", colorspace="rec2020")),
        [("DOC_COLOR_SPACE", "/metal/ior", "'rec2020' cannot be converted")],
    ),
    "a colour space by another of its names": (
        metal(given("ior", "color3", value="1, 1, 1", colorspace="gamma22"))
        + metal(given("ior", "color3", value="1, 1, 1", colorspace="lin_ap1"), name="b")
        + metal(given("ior", "color3", value="1, 1, 1", colorspace="lin_rec709_scene"), name="c"),
        [],
    ),
    "numbers as they are, by another name": (metal(given("ior", "color3", value="1, 1, 1", colorspace="Raw")), []),
    "a colour space by OpenColorIO's name": (
        metal(given("ior", "color3", value="1, 1, 1", colorspace="Utility - sRGB - Texture")),
        [("DOC_COLOR_SPACE", "/metal/ior", "OpenColorIO's name of srgb_texture")],
    ),
    "a colour space of OpenColorIO's in two places": (
        metal(given("ior", "color3", value="1, 1, 1", colorspace="ACES2065-1"))
        + metal(given("ior", "color3", value="1, 1, 1", colorspace="ACES2065-1"), name="b"),
        [("DOC_COLOR_SPACE", "/metal/ior", "of OpenColorIO's configurations cannot be converted to lin_rec709 (it is")],
    ),
    "a node that feeds itself": (
        '<multiply name="m" type="float"><input name="in1" type="float" nodename="m"/></multiply>',
        [("DOC_CYCLE", "/m", "the nodes feed each other: m <- m")],
    ),
    "a graph that feeds itself through its interface": (
        '<nodegraph name="g"><input name="k" type="float" nodegraph="g" output="out"/>'
        '<multiply name="m" type="float"><input name="in1" type="float" interfacename="k"/></multiply>'
        '<output name="out" type="float" nodename="m"/></nodegraph>',
        [("DOC_CYCLE", "/g/m", "the nodes feed each other: m <- m")],
    ),
    "a graph that defines its own node": (
        '<nodedef name="ND_a" node="a"><output name="out" type="float"/></nodedef>'
        '<nodegraph name="NG_a" nodedef="ND_a"><a name="i" type="float"/><output name="out" type="float" nodename="i"/>'
        "</nodegraph>",
        [("DOC_CYCLE", "/NG_a/i", "the nodes feed each other: i <- i")],
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_findings_have_their_code_place_and_words(found, name):
    elements, expected = CASES[name]
    findings = found(elements)
    assert [finding[:2] for finding in findings] == [case[:2] for case in expected]
    for (_, _, message), (_, _, words) in zip(findings, expected, strict=True):
        assert words in message


@pytest.mark.parametrize("version", ["1.40", "2.0", "1", "1.39.5", "x", ""])
def test_a_version_that_materialx_does_not_know_is_named_with_those_that_it_does(make_document, version):
    document = make_document(metal())
    document.setVersionString(version)
    (found,) = check_graph(document)
    assert (found.code, found.location) == ("DOC_INVALID", "")
    assert f"its version is '{version}', expected one up to 1.39" in found.message


def test_what_materialx_says_of_no_element_names_none(make_document):
    document = make_document('<conductor_bsdf name="metal" type="BSDF" inherit="metal"/>')
    (found,) = check_graph(document)
    assert (found.code, found.location) == ("DOC_INVALID", "")
    assert "element that is named" not in found.hint


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        (metal(), "no material with a surface, and no output to show"),
        (
            '<volume name="v" type="volumeshader"/><point_light name="l" type="lightshader"/>',
            "volumes and lights",
        ),
        ('<displacement name="d" type="displacementshader"/>', "displacements alone are not compared"),
    ],
)
def test_what_there_is_instead_of_a_surface_is_said(make_document, elements, words):
    assert words in nothing_to_render(make_document(elements)).message


# Where a value may stand beside a node's own input: code and place of a finding.
VALUES = {
    "a graph's interface": ('<nodegraph name="g"><input name="i" type="float" value="0,5"/></nodegraph>', "/g/i"),
    "a definition's default": (
        '<nodedef name="ND_a" node="a"><input name="i" type="float" value="0,5"/><output name="out" type="float"/>'
        "</nodedef>",
        "/ND_a/i",
    ),
    "a token": ('<token name="t" type="float" value="0,5"/>', "/t"),
    "a geometric property": (
        '<geominfo name="i" geom="/a"><geomprop name="p" type="float" value="0,5"/></geominfo>',
        "/i/p",
    ),
    "a member of a type": ('<typedef name="s"><member name="m" type="float" value="0,5"/></typedef>', "/s/m"),
    "a property of a look": ('<look name="l"><property name="p" type="float" value="0,5"/></look>', "/l/p"),
    "a variant": (
        '<variantset name="s"><variant name="v"><input name="i" type="float" value="0,5"/></variant></variantset>',
        "/s/v/i",
    ),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_has_the_form_of_its_type_wherever_it_stands(found, name):
    elements, place = VALUES[name]
    assert [finding[:2] for finding in found(elements)] == [("DOC_INPUT_VALUE", place)]


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("integer", "1.5"),
        ("integer", "1x"),
        ("integer", "3000000000"),
        ("float", "1e39"),
        ("boolean", "1"),
        ("matrix33", "1,0,0, 0,1,0, 0,0"),
        ("matrix44", "1,0,0,0, 0,1,0,0, 0,0.5.0,1,0, 0,0,0,1"),
        ("floatarray", "1, 2, x"),
        ("floatarray", "1 2"),
        ("integerarray", "1, 2.5"),
        ("color3array", "1, 2, 3, 4"),
        ("EDF", "4096"),
        ("BSDF", "0"),
        ("surfaceshader", "1"),
        ("material", "m"),
    ],
)
def test_a_value_that_is_not_of_its_type_is_named(found, kind, value):
    codes = [code for code, _, message in found(takes(kind, value)) if f"'{value}'" in message]
    assert codes == ["DOC_INPUT_VALUE"]


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("integer", "-2147483648"),
        ("matrix33", "1,0,0, 0,1,0, 0,0,1"),
        ("floatarray", "1, 2.5,3"),
        ("integerarray", "1,2"),
        ("color3array", "1,2,3, 4,5,6"),
        ("stringarray", "a b, c"),
        ("string", "0,5"),
        ("BSDF", ""),
    ],
)
def test_a_value_of_any_type_may_be_written_in_its_form(found, kind, value):
    assert found(takes(kind, value)) == []


@pytest.mark.parametrize(
    ("types", "kind", "value", "words"),
    [
        (STRUCT, "s", "{0.5;1, 0, 0}", None),
        (NESTED, "t", "{{0.5;1,0,0};3}", None),
        ('<typedef name="blind"/>', "blind", "what it may be", None),
        (STRUCT, "s", "{0.5}", "2 values in braces, separated by semicolons: {x;y}"),
        (STRUCT, "s", "0.5;1, 0, 0", "2 values in braces"),
        (STRUCT, "s", "{0.5;1, 0}", "'1, 0' is not a color3"),
        (NESTED, "t", "{{0,5;1,0,0};3}", "'0,5' is not a float"),
    ],
)
def test_a_struct_has_a_value_for_each_of_its_members(found, types, kind, value, words):
    findings = found(types + takes(kind, value))
    assert [code for code, _, _ in findings] == ([] if words is None else ["DOC_INPUT_VALUE"])
    assert words is None or words in findings[0][2]


@pytest.mark.parametrize(
    ("kind", "value"), [("color3", "1 0.5 0"), ("vector2", "0.5 0.5"), ("color3", "1 1,1"), ("vector2", " 1  2 ")]
)
def test_spaces_between_numbers_are_a_warning(found, kind, value):
    assert [finding[:2] for finding in found(takes(kind, value))] == [("DOC_VALUE_FORM", "/x/in")]


# MaterialX reads the number that a text begins with. A comma for a point is a slip of half of Europe.
@pytest.mark.parametrize(
    ("name", "kind", "value"),
    [
        ("weight", "float", "0,5"),
        ("weight", "float", "0.5x"),
        ("weight", "float", "0x10"),
        ("weight", "float", "0.5 0.5"),
        ("ior", "color3", "1, 2x, 3"),
        ("ior", "color3", "1.0.0, 2, 3"),
        ("ior", "color3", "1, , 2, 3"),
    ],
)
def test_a_number_with_something_behind_it_is_no_number(found, name, kind, value):
    assert [finding[:2] for finding in found(metal(given(name, kind, value=value)))] == [
        ("DOC_INPUT_VALUE", f"/metal/{name}")
    ]


@pytest.mark.parametrize("value", ["1", "1.", ".5", "5e-1", " 0.5 ", "+0.5"])
def test_a_number_may_be_written_in_any_of_its_forms(found, value):
    assert found(metal(given("weight", "float", value=value))) == []


@pytest.mark.parametrize(("count", "accepted"), [(MAXIMUM_CHAIN, True), (MAXIMUM_CHAIN + 1, False)])
def test_a_chain_may_be_as_long_as_is_stated(found, count, accepted):
    chain = '<constant name="n1" type="float"/>' + "".join(
        f'<multiply name="n{k}" type="float"><input name="in1" type="float" nodename="n{k - 1}"/></multiply>'
        for k in range(2, count + 1)
    )
    codes = [code for code, _, _ in found(chain)]
    assert codes == ([] if accepted else ["DOC_CYCLE"])


# The flag -------------------------------------------------------------------------------------------------------------

FLAG = given("retroreflective", "boolean", value="true")
SCHLICK, GLASS = "generalized_schlick_bsdf", "dielectric_bsdf"

RETRO = {
    "a retroreflector": (metal(FLAG), []),
    "an invisible one without the flag": (metal(given("weight", "float", value="0")), []),
    "of weight 0": (metal(FLAG + given("weight", "float", value="0")), [("RETRO_INVISIBLE", "weight is 0")]),
    "of a weight that is connected to 0": (
        '<constant name="c" type="float"><input name="value" type="float" value="0"/></constant>'
        + metal(FLAG + given("weight", "float", nodename="c")),
        [("RETRO_INVISIBLE", "weight is 0")],
    ),
    "of a weight that varies": (
        '<noise2d name="c" type="float"/>' + metal(FLAG + given("weight", "float", nodename="c")),
        [],
    ),
    "of black tint": (
        metal(FLAG + given("tint", "color3", value="0, 0, 0"), GLASS),
        [("RETRO_INVISIBLE", "tint is black")],
    ),
    "of a dark tint": (metal(FLAG + given("tint", "color3", value="0, 0, 0.01"), GLASS), []),
    "of air": (metal(FLAG + given("ior", "float", value="1"), GLASS), [("RETRO_INVISIBLE", "ior is 1")]),
    "of air under a film": (
        metal(FLAG + given("ior", "float", value="1") + given("thinfilm_thickness", "float", value="300"), GLASS),
        [],
    ),
    "of black colours": (
        metal(FLAG + given("color0", "color3", value="0, 0, 0") + given("color90", "color3", value="0, 0, 0"), SCHLICK),
        [("RETRO_INVISIBLE", "color0 and color90 are black")],
    ),
    "of a black colour in the middle": (metal(FLAG + given("color0", "color3", value="0, 0, 0"), SCHLICK), []),
    "that transmits": (
        metal(FLAG + given("scatter_mode", "string", value="T"), SCHLICK),
        [("RETRO_TRANSMISSION", "scatter_mode is T")],
    ),
    "that does both": (metal(FLAG + given("scatter_mode", "string", value="RT"), SCHLICK), []),
    "by its graph's interface": (
        '<nodegraph name="g"><input name="flag" type="boolean" value="true"/>'
        + metal(
            given("retroreflective", "boolean", interfacename="flag") + given("weight", "float", value="0"),
            name="inner",
        )
        + '<output name="out" type="BSDF" nodename="inner"/></nodegraph>',
        [("RETRO_INVISIBLE", "weight is 0")],
    ),
    "too narrow along one axis": (
        metal(FLAG + given("roughness", "vector2", value="0.1, 0.00001")),
        [("LOBE_TOO_NARROW", "alpha is 1e-05")],
    ),
    "too narrow and ordinary": (
        metal(given("roughness", "vector2", value="0, 0")),
        [("LOBE_TOO_NARROW", "alpha is 0")],
    ),
    "just wide enough": (metal(FLAG + given("roughness", "vector2", value="0.000026, 0.000026")), []),
    "as wide as the hint says": (metal(FLAG + given("roughness", "vector2", value="0.000025, 0.000025")), []),
}


@pytest.mark.parametrize(
    "name",
    list(RETRO),
)
def test_a_retroreflector_is_seen_through(make_document, name):
    elements, expected = RETRO[name]
    document = make_document(elements)
    findings = check_retroreflection(document)
    assert [f.code for f in findings] == [code for code, _ in expected]
    for found, (_, words) in zip(findings, expected, strict=True):
        assert words in found.message
        assert found.location in ("/metal", "/g/inner")


# Surface models, and the width that is told of them; "" if none is.
MODELS = {
    "of roughness 0": ('<UsdPreviewSurface name="u" type="surfaceshader">{}</UsdPreviewSurface>', "alpha is 1e-08"),
    "whose roughness is an image's": (
        '<image name="i" type="float"><input name="file" type="filename" value="r.png"/></image>'
        '<UsdPreviewSurface name="u" type="surfaceshader"><input name="roughness" type="float" nodename="i"/>'
        "</UsdPreviewSurface>",
        "",
    ),
    "without the lobe of roughness 0": (
        '<open_pbr_surface name="u" type="surfaceshader"><input name="coat_roughness" type="float" value="0"/>'
        "</open_pbr_surface>",
        "",
    ),
}


@pytest.mark.parametrize("name", MODELS)
def test_a_surface_model_with_a_lobe_too_narrow_for_float32_is_told(make_document, name):
    elements, words = MODELS[name]
    findings = check_retroreflection(make_document(elements.format(given("roughness", "float", value="0"))))
    assert [(f.code, f.location) for f in findings] == ([("LOBE_TOO_NARROW", "/u")] if words else [])
    assert all(words in f.message and "--ignore LOBE_TOO_NARROW" in f.hint for f in findings)


# Stranger than wrong --------------------------------------------------------------------------------------------------


def custom(definition: str, implementation: str) -> str:
    """A metal whose weight is a node of the document's own."""
    return f'{definition}{implementation}<a name="x" type="float"/>' + metal(given("weight", "float", nodename="x"))


# Documents on which MaterialX throws, recurses without end or leaves nothing where something is expected; with what may
# be said about them. None may end in CHECK_CRASHED.
STRANGE: dict[str, tuple[str, set[str]]] = {
    "a definition that inherits itself": (
        custom(f'<nodedef name="ND_a" node="a" inherit="ND_a">{OUT}', ""),
        {"DOC_CYCLE", "DOC_INVALID"},
    ),
    "two definitions that inherit each other": (
        custom(
            f'<nodedef name="ND_a" node="a" inherit="ND_b">{OUT}<nodedef name="ND_b" node="b" inherit="ND_a">{OUT}', ""
        ),
        {"DOC_CYCLE", "DOC_INVALID"},
    ),
    "an implementation by a graph that holds the node": (
        custom(
            DEFINED,
            '<implementation name="IM_a" nodedef="ND_a" nodegraph="NG_a"/><nodegraph name="NG_a">'
            '<a name="i" type="float"/><output name="out" type="float" nodename="i"/></nodegraph>',
        ),
        {"DOC_CYCLE"},
    ),
    "a graph whose output is connected to nothing": (
        custom(DEFINED, '<nodegraph name="NG_a" nodedef="ND_a"><output name="out" type="float"/></nodegraph>'),
        {"DOC_CONNECTION", "DOC_INVALID", "SHADER_GENERATE"},
    ),
    "a graph without outputs": (custom(DEFINED, '<nodegraph name="NG_a" nodedef="ND_a"/>'), {"DOC_DEFINITION"}),
    "a definition without outputs": (custom('<nodedef name="ND_a" node="a"/>', ""), {"DOC_UNKNOWN_NODE"}),
    "a definition without an implementation": (custom(DEFINED, ""), {"SHADER_GENERATE"}),
    "a type that contains itself": (
        '<typedef name="t"><member name="m" type="t" value="{1}"/></typedef><constant name="k" type="t">'
        '<input name="value" type="t" value="{1}"/></constant>' + metal(),
        {"DOC_INVALID"},
    ),
    "a unit of another kind": (
        '<unittypedef name="taste"/><unitdef name="UD" unittype="taste"><unit name="sweet" scale="1"/></unitdef>'
        + metal(given("thinfilm_thickness", "float", value="1", unit="sweet", unittype="taste")),
        {"DOC_INPUT_VALUE"},
    ),
    "outputs that name each other": (
        '<output name="a" type="float" output="b"/><output name="b" type="float" output="a"/>'
        + metal(given("weight", "float", output="a")),
        {"DOC_INVALID", "DOC_CONNECTION"},
    ),
    "a graph's output that is its own source": (
        '<nodegraph name="g"><output name="out" type="float" nodegraph="g" output="out"/></nodegraph>'
        + metal(given("weight", "float", nodegraph="g", output="out")),
        {"DOC_INVALID", "DOC_CONNECTION"},
    ),
    "targets that inherit each other": (
        '<targetdef name="a" inherit="b"/><targetdef name="b" inherit="a"/>' + metal(),
        {"DOC_INVALID"},
    ),
    "looks that inherit each other": (
        '<look name="a" inherit="b"/><look name="b" inherit="a"/>' + metal(),
        {"DOC_INVALID"},
    ),
    "collections that include each other": (
        '<collection name="a" includecollection="b"/><collection name="b" includecollection="a"/>' + metal(),
        {"DOC_INVALID"},
    ),
    "elements without names": (
        '<nodedef name="" node=""/><conductor_bsdf name="" type=""/>' + metal(),
        {"DOC_UNKNOWN_NODE"},
    ),
    "a range that is no number": (
        custom(
            f'<nodedef name="ND_a" node="a"><input name="in" type="float" value="0.5" uimin="nan" uimax="1, 2"/>{OUT}',
            '<implementation name="IM_a" nodedef="ND_a" target="genglsl" sourcecode="{{in}}"/>',
        ).replace(
            '<a name="x" type="float"/>', '<a name="x" type="float"><input name="in" type="float" value="1"/></a>'
        ),
        set(),
    ),
    "a hundred thousand digits": (metal(given("weight", "float", value="0." + "3" * 100_000)), set()),
    "a million components": (metal(given("ior", "color3", value=",".join("1" * 1_000_000))), {"DOC_INPUT_VALUE"}),
    "sixty sums of a node with itself": (
        metal(name="n0")
        + "".join(
            f'<mix name="n{k}" type="BSDF"><input name="fg" type="BSDF" nodename="n{k - 1}"/>'
            f'<input name="bg" type="BSDF" nodename="n{k - 1}"/></mix>'
            for k in range(1, 60)
        )
        + '<multiply name="metal" type="BSDF"><input name="in1" type="BSDF" nodename="n59"/></multiply>',
        set(),
    ),
    "thousands of nodes": ("".join(f'<constant name="c{k}" type="float"/>' for k in range(5000)) + metal(), set()),
    "a material of itself": (
        '<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="m"/>'
        "</surfacematerial>" + metal(),
        {"DOC_CYCLE"},
    ),
    "a material of nothing": ('<surfacematerial name="m" type="material"/>' + metal(), set()),
}


@pytest.fixture(scope="module")
def verdicts(bounded, tmp_path_factory) -> dict[str, list[dict[str, str]]]:
    """Findings of the strange documents, from one run with bounded memory and time."""
    folder = tmp_path_factory.mktemp("strange")
    for name, (elements, _) in STRANGE.items():
        text = f'<?xml version="1.0"?><materialx version="1.39">{elements}{SHOWN}</materialx>'
        (folder / f"{name}.mtlx").write_text(text, encoding="utf-8")
    done = bounded(
        "validate", folder, "--target", "msl", "--samples", "64", "--timeout", "60", "-j", "1", "--format", "json"
    )
    return {Path(d["path"]).stem: d["findings"] for d in json.loads(done.stdout)["documents"]}


@pytest.mark.parametrize("name", STRANGE)
def test_a_strange_document_gets_a_finding_and_not_a_crash(verdicts, name):
    codes = {f["code"] for f in verdicts[name]}
    expected = STRANGE[name][1]
    assert not codes & {"CHECK_CRASHED", "CHECK_TIMEOUT"}, verdicts[name]
    if expected:
        assert codes & expected
    else:
        assert codes == set()


def test_of_very_many_wrong_names_the_first_alone_are_compared_with_those_that_there_are(library):
    spelling = Spelling(library.document)
    said = [spelling.of("imagee", ["image"]) for _ in range(MAXIMUM_OF_A_RULE + 1)]
    assert said == ["; did you mean 'image'?"] * MAXIMUM_OF_A_RULE + [""]
