"""Values of nodes that follow from the specification by hand, at edges above all; the generated GLSL has them, too."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.library import load_library
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.reference.float32.rounding import UNIT
from mrm_mtlx.reference.nodes import NODES
from tests.fixtures.versions import since

FG, BG = {"fg": "0.25, 0.5, 0.75, 0.5"}, {"bg": "0.5, 0.25, 0, 0.25"}
OPAQUE = {"fg": "0.25, 0.5, 0.75, 0.75", "bg": "0.5, 0.25, 0, 0.5"}
NINE = "1, 2, 3, 4, 5, 6, 7, 8, 10"
SIXTEEN = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16"
CYCLE = "0, 1, 0, 0, 0, 1, 1, 0, 0"


def blend(fg: str, bg: str, mix: str = "1") -> dict[str, str]:
    return {"fg": fg, "bg": bg, "mix": mix}


def compared(first: str, second: str) -> dict[str, str]:
    return {"value1": first, "value2": second, "in1": "1", "in2": "2"}


# Of the installed MaterialX; `fract` came with 1.39.3.
DEFINED = {str(definition.getName()) for definition in load_library().document.getNodeDefs()}

VALUES = [
    ("round_integer", {"in": "2.75"}, [3.0]),
    ("subtract_integer", {"in1": "3", "in2": "5"}, [-2.0]),
    ("atan2_float", {"iny": "1", "inx": "-1"}, [0.75 * np.pi]),
    ("add_matrix33FA", {"in1": NINE, "in2": "1"}, [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 11.0]),
    # Vectors and matrices: v' = v M, and the product M1 M2 takes v through M1 first.
    ("transformmatrix_vector3", {"in": "0, 1, 0", "mat": NINE}, [4.0, 5.0, 6.0]),
    ("transformmatrix_vector2M3", {"in": "0, 0", "mat": NINE}, [7.0, 8.0]),
    ("transformmatrix_vector3M4", {"in": "0, 0, 0", "mat": SIXTEEN}, [13.0, 14.0, 15.0]),
    ("transformmatrix_vector4", {"in": "0, 0, 1, 0", "mat": SIXTEEN}, [9.0, 10.0, 11.0, 12.0]),
    ("multiply_matrix33", {"in1": NINE, "in2": CYCLE}, [3.0, 1.0, 2.0, 6.0, 4.0, 5.0, 10.0, 7.0, 8.0]),
    ("divide_matrix33", {"in1": NINE, "in2": CYCLE}, [2.0, 3.0, 1.0, 5.0, 6.0, 4.0, 8.0, 10.0, 7.0]),
    ("invertmatrix_matrix33", {"in": CYCLE}, [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    ("transpose_matrix33", {"in": NINE}, [1.0, 4.0, 7.0, 2.0, 5.0, 8.0, 3.0, 6.0, 10.0]),
    ("determinant_matrix33", {"in": NINE}, [-3.0]),
    ("transformnormal_vector3", {"in": "0, 0, 2"}, [0.0, 0.0, 1.0]),
    ("transformpoint_vector3", {"in": "1, 2, 3", "fromspace": "object", "tospace": "world"}, [1.0, 2.0, 3.0]),
    # Clockwise, as in all of MaterialX's targets (issue 2154: its specification says the opposite).
    ("rotate2d_vector2", {"in": "1, 0", "amount": "90"}, [0.0, -1.0]),
    ("rotate3d_vector3", {"in": "1, 0, 0", "amount": "90", "axis": "0, 0, 2"}, [0.0, -1.0, 0.0]),
    ("rotate3d_vector3", {"in": "0, 1, 0", "amount": "90", "axis": "1, 0, 0"}, [0.0, 0.0, -1.0]),
    ("extract_vector3", {"in": "0.25, 0.5, 0.75", "index": "2"}, [0.75]),
    ("combine2_color4CF", {"in1": "0.25, 0.5, 0.75", "in2": "2"}, [0.25, 0.5, 0.75, 2.0]),
    ("combine2_vector4VV", {"in1": "1, 2", "in2": "3, 4"}, [1.0, 2.0, 3.0, 4.0]),
    ("convert_boolean_float", {"in": "true"}, [1.0]),
    ("convert_integer_float", {"in": "-7"}, [-7.0]),
    ("ifequal_floatB", compared("true", "false"), [2.0]),
    ("remap_float", {"in": "0.5", "inlow": "0", "inhigh": "2", "outlow": "1", "outhigh": "3"}, [1.5]),
    ("luminance_color3", {"in": "1, 1, 1"}, [1.0, 1.0, 1.0]),
    ("luminance_color4", {"in": "0, 1, 0, 0.5"}, [0.6740818, 0.6740818, 0.6740818, 0.5]),
    ("plus_float", blend("0.5", "0.25", "0.5"), [0.5]),
    ("minus_float", blend("0.5", "0.25"), [-0.25]),
    ("difference_float", blend("0.5", "0.25"), [0.25]),
    ("screen_float", blend("0.5", "0.5"), [0.75]),
    ("in_color4", FG | BG, [0.0625, 0.125, 0.1875, 0.125]),
    ("out_color4", FG | BG, [0.1875, 0.375, 0.5625, 0.375]),
    ("mask_color4", FG | BG, [0.25, 0.125, 0.0, 0.125]),
    ("over_color4", FG | BG, [0.5, 0.625, 0.75, 0.625]),
    ("matte_color4", FG | BG, [0.375, 0.375, 0.375, 0.625]),
    ("premult_color4", {"in": "1, 0.5, 2, 0.5"}, [0.5, 0.25, 1.0, 0.5]),
    ("unpremult_color4", {"in": "1, 0.5, 2, 0.5"}, [2.0, 1.0, 4.0, 0.5]),
    ("outside_float", {"in": "0.5", "mask": "0.25"}, [0.375]),
    ("heighttonormal_vector3", {"in": "3"}, [0.5, 0.5, 1.0]),
    ("geomcolor_color4", {"index": "0"}, [1.0, 1.0, 1.0, 1.0]),
    ("frame_float", {}, [1.0]),
    ("time_float", {}, [0.0]),
]

# At steps, ends, and where something would be divided by nothing: drawn as well.
EDGES = [
    ("modulo_float", {"in1": "-5", "in2": "3"}, [1.0]),
    ("modulo_float", {"in1": "5", "in2": "-3"}, [-1.0]),
    *([("fract_float", {"in": "-0.25"}, [0.75])] if "ND_fract_float" in DEFINED else []),
    ("floor_float", {"in": "-0.5"}, [-1.0]),
    ("ceil_integer", {"in": "-0.5"}, [0.0]),
    ("sign_vector3", {"in": "-3, 0, 0.5"}, [-1.0, 0.0, 1.0]),
    ("power_vector3FA", {"in1": "0, 2, 9", "in2": "0.5"}, [0.0, np.sqrt(2.0), 3.0]),
    ("clamp_vector3FA", {"in": "-1, 0.5, 2", "low": "0.25", "high": "1.5"}, [0.25, 0.5, 1.5]),
    ("asin_vector2", {"in": "-1, 1"}, [-0.5 * np.pi, 0.5 * np.pi]),
    ("acos_vector2", {"in": "-1, 1"}, [np.pi, 0.0]),
    ("ifgreater_float", compared("0.3", "0.3"), [2.0]),
    ("ifgreatereq_float", compared("0.3", "0.3"), [1.0]),
    ("ifequal_float", compared("0.3", "0.3"), [1.0]),
    ("smoothstep_float", {"in": "0.25", "low": "0", "high": "1"}, [0.15625]),
    ("smoothstep_float", {"in": "0.5", "low": "0.5", "high": "0.5"}, [1.0]),
    ("smoothstep_float", {"in": "0.4375", "low": "0.5", "high": "0.5"}, [0.0]),
    ("rgbtohsv_color3", {"in": "0, 0.5, 0"}, [1.0 / 3.0, 1.0, 0.5]),
    ("rgbtohsv_color3", {"in": "0.75, 0.25, 0.5"}, [11.0 / 12.0, 2.0 / 3.0, 0.75]),
    ("rgbtohsv_color4", {"in": "0.5, 0.5, 0.5, 0.25"}, [0.0, 0.0, 0.5, 0.25]),
    ("rgbtohsv_color3", {"in": "0, 0, 0"}, [0.0, 0.0, 0.0]),
    ("hsvtorgb_color3", {"in": "-0.25, 1, 0.5"}, [0.25, 0.0, 0.5]),
    ("hsvtorgb_color3", {"in": "1.125, 0.5, 1"}, [1.0, 0.875, 0.5]),
    ("hsvtorgb_color4", {"in": "0.4, 0, 0.75, 0.5"}, [0.75, 0.75, 0.75, 0.5]),
    ("burn_float", blend("0.5", "0.75"), [0.5]),
    ("burn_float", blend("0", "0.75"), [0.0]),
    ("dodge_float", blend("0.5", "0.25"), [0.5]),
    ("dodge_float", blend("1", "0.25"), [0.0]),
    ("disjointover_color4", FG | BG, [0.75, 0.75, 0.75, 0.75]),
    ("disjointover_color4", OPAQUE, [0.5, 0.625, 0.75, 1.0]),
]

# Where the specification has a value, and the targets another one, or none.
DEVIATING = [
    ("unpremult_color4", {"in": "0.25, 0.5, 0.75, 0"}, [0.25, 0.5, 0.75, 0.0]),
    # GLSL leaves these undefined.
    ("extract_vector3", {"in": "0.25, 0.5, 0.75", "index": "3"}, [0.75]),
    ("power_float", {"in1": "-8", "in2": "0.5"}, [0.0]),
    ("acos_float", {"in": "-1.5"}, [np.pi]),
    ("sqrt_float", {"in": "-1"}, [0.0]),
]


def as_shown(value):
    """A value as the colours that `evaluated` shows it by: rows, of whose channels the fourth is in the third."""
    rows = np.reshape(value, (-1, 3) if len(value) == 9 else (1, -1))
    padded = np.pad(rows, ((0, 0), (0, 4 - rows.shape[1])))
    return padded[:, :3] + [0.0, 0.0, 0.375] * padded[:, 3:]


def named(case):
    return " ".join([case[0], *case[1].values()])


@since("1.39.5", "rows of matrices")
def test_a_row_of_a_matrix_is_its_vector(evaluated):
    assert evaluated("ND_extract_matrix33", {"in": NINE, "index": "1"}).tolist() == [[4.0, 5.0, 6.0]]


@pytest.mark.parametrize(
    ("name", "given", "value"), VALUES + EDGES + DEVIATING, ids=map(named, VALUES + EDGES + DEVIATING)
)
def test_the_reference_has_the_value(evaluated, name, given, value):
    # A document's numbers are float32.
    expected = pytest.approx(as_shown(value), rel=8.0 * UNIT, abs=8.0 * UNIT)
    assert evaluated(f"ND_{name}", given) == expected


def test_the_generated_glsl_agrees_at_edges(shown):
    nodes = shown([*((f"ND_{name}", given) for name, given, _ in EDGES), ("ND_normalmap_float", {"in": "0, 0, 0"})])
    assert {node.label: e for node in nodes if not (e := np.max(node.tolerance().excess(node.found))) <= 1.0} == {}


UNLIT = (
    '<combine3 name="c" type="color3"><input name="in1" type="float" nodename="a"/></combine3>'
    '<surface_unlit name="s" type="surfaceshader"><input name="emission_color" type="color3" nodename="c"/>'
    "</surface_unlit>"
)


@pytest.fixture
def red(make_document):
    """Function from a document's nodes, coordinates and a property `grey` to the red of a surface that shows `a`."""

    def shade(nodes, texcoord, grey=0.0):
        texcoord = np.atleast_2d(texcoord)
        axes = (np.tile(axis, (len(texcoord), 1)) for axis in np.eye(3)[[2, 2, 2, 0, 2]])
        points = ShadingPoints(*axes, texcoord, {"grey": np.broadcast_to(grey, len(texcoord))})
        document = make_document(nodes + UNLIT)
        return Surface(document.getNode("s")).shade(points)[:, 0].tolist()

    return shade


ACROSS = [(-0.5, 0.25), (0.25, 0.5), (0.5, 0.75), (2.0, 1.5)]


@pytest.mark.parametrize(
    ("kind", "ends", "values"),
    [
        ("ramplr", "lr", [1.0, 1.5, 2.0, 3.0]),
        ("ramptb", "bt", [1.5, 2.0, 2.5, 3.0]),
        ("splitlr", "lr", [1.0, 1.0, 3.0, 3.0]),
        ("splittb", "bt", [1.0, 3.0, 3.0, 3.0]),
    ],
)
def test_ramps_go_to_the_right_and_upwards(red, kind, ends, values):
    inputs = (
        f'<input name="value{end}" type="float" value="{value}"/>' for end, value in zip(ends, (1, 3), strict=True)
    )
    assert red(f'<{kind} name="a" type="float">{"".join(inputs)}</{kind}>', ACROSS) == values


def test_texts_go_through_nodes(red):
    nodes = (
        '<constant name="t" type="string"><input name="value" type="string" value="grey"/></constant>'
        '<dot name="u" type="string"><input name="in" type="string" nodename="t"/></dot>'
        '<geompropvalueuniform name="v" type="string"><input name="default" type="string" nodename="u"/>'
        '</geompropvalueuniform><geompropvalue name="a" type="float">'
        '<input name="geomprop" type="string" nodename="v"/></geompropvalue>'
    )
    assert red(nodes, ACROSS, [0.25, 0.5, 0.75, 1.0]) == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize("category", ["constant", "dot", "geompropvalueuniform"])
def test_names_of_files_are_texts(category):
    assert NODES[f"ND_{category}_filename"] is NODES[f"ND_{category}_string"]


def test_a_surface_goes_through_a_dot(make_document, flat_points):
    # MaterialX 1.39.5 writes GLSL for it that does not compile: it names the surface's variable without declaring it.
    document = make_document(
        '<surface_unlit name="s" type="surfaceshader">'
        '<input name="emission_color" type="color3" value="0.25, 0.5, 0.75"/></surface_unlit>'
        '<dot name="d" type="surfaceshader"><input name="in" type="surfaceshader" nodename="s"/></dot>'
    )
    points = flat_points([0.0, 0.6, 0.8], [0.6, 0.0, 0.8])
    assert Surface(document.getNode("d")).shade(points).tolist() == [[0.25, 0.5, 0.75]]
