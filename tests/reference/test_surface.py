"""Walking a document's graph: values, units, colour spaces, and what the reference refuses."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
import pytest

from mrm_mtlx.bsdf import Conductor, GeneralizedSchlick
from mrm_mtlx.reference import Surface, UnsupportedError, constant_input, versions
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.reference.survey import MAXIMUM_DEPTH
from tests.fixtures.versions import since

EPS = np.finfo(float).eps

# Relative, for a handful of operations in float64.
TOL = 64 * EPS

# Relative. Numbers of the document are rounded to float32.
FLOAT32_TOL = 2.0**-23

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="session")
def response(surface_document, flat_points):
    """Function from BSDF nodes, as text, to the response at one sample, or at those given."""

    def evaluate(nodes: str, points=None, attributes: str = "", graph: str = ""):
        document = surface_document(graph + nodes, attributes=attributes)
        return Surface(document.getNode("m")).response(flat_points(UP, UP) if points is None else points)

    return evaluate


def paint(color: str) -> str:
    """A Lambertian surface: from above its response is colour / pi."""
    kind = "oren_nayar_diffuse_bsdf"
    return f'<{kind} name="bsdf" type="BSDF"><input name="color" type="color3" {color}/></{kind}>'


def shown(response_value) -> np.ndarray:
    """Colour of a Lambertian surface from its response from above."""
    return np.asarray(response_value)[0] * np.pi


# Values -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ["sign.mtlx", None])
def test_what_is_no_element_is_refused(element):
    with pytest.raises(TypeError, match=f"^element is of type {type(element).__name__}, expected an element of"):
        Surface(element)


def test_a_surface_shows_its_elements_path(surface_document):
    document = surface_document(paint('value="1, 1, 1"'))
    assert repr(Surface(document.getNode("m"))) == "<Surface m>"


def test_a_given_value_wins_over_the_default(response):
    np.testing.assert_allclose(shown(response(paint('value="0.5, 0.25, 0.125"'))), [0.5, 0.25, 0.125], rtol=TOL)
    np.testing.assert_allclose(
        shown(response('<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"/>')), 0.18, rtol=FLOAT32_TOL
    )


def test_numbers_are_those_that_a_float32_holds(response):
    found = shown(response(paint('value="0.1, 0.2, 0.3"')))
    np.testing.assert_allclose(found, np.float32([0.1, 0.2, 0.3]).astype(float), rtol=TOL)
    assert np.all(np.abs(found - [0.1, 0.2, 0.3]) > TOL)


def test_a_connection_wins_over_a_value(response):
    constant = '<constant name="c" type="color3"><input name="value" type="color3" value="0.5, 0.5, 0.5"/></constant>'
    np.testing.assert_allclose(shown(response(constant + paint('nodename="c"'))), 0.5, rtol=TOL)


def test_a_value_reaches_through_a_graphs_interface_and_output(response):
    graph = (
        '<nodegraph name="g"><input name="shade" type="color3" value="0.25, 0.5, 0.75"/>'
        '<constant name="c" type="color3"><input name="value" type="color3" interfacename="shade"/></constant>'
        '<output name="first" type="color3" nodename="other"/><output name="out" type="color3" nodename="c"/>'
        '<constant name="other" type="color3"/></nodegraph>'
    )
    found = response(paint('nodegraph="g" output="out"'), graph=graph)
    np.testing.assert_allclose(shown(found), [0.25, 0.5, 0.75], rtol=TOL)


DEFINED = """
<nodedef name="ND_sheet" node="sheet">
  <input name="shade" type="color3" value="0.125, 0.25, 0.5"/><output name="out" type="BSDF"/>
</nodedef>
<nodegraph name="NG_sheet" nodedef="ND_sheet">
  <oren_nayar_diffuse_bsdf name="inner" type="BSDF">
    <input name="color" type="color3" interfacename="shade"/>
  </oren_nayar_diffuse_bsdf>
  <output name="out" type="BSDF" nodename="inner"/>
</nodegraph>
"""


def test_a_node_defined_by_a_graph_takes_its_own_values_and_defaults(response):
    half = (
        '<sheet name="a" type="BSDF"/><sheet name="b" type="BSDF">'
        '<input name="shade" type="color3" value="1, 0.5, 0.25"/></sheet>'
        '<mix name="bsdf" type="BSDF"><input name="fg" type="BSDF" nodename="a"/>'
        '<input name="bg" type="BSDF" nodename="b"/><input name="mix" type="float" value="0.5"/></mix>'
    )
    # Two uses of one graph, told apart.
    expected = 0.5 * np.array([0.125, 0.25, 0.5]) + 0.5 * np.array([1.0, 0.5, 0.25])
    np.testing.assert_allclose(shown(response(half, graph=DEFINED)), expected, rtol=TOL)


def test_geometric_properties_come_from_the_samples_or_the_default(response, flat_points):
    node = (
        '<geompropvalue name="p" type="color3"><input name="geomprop" type="string" value="mask"/>'
        '<input name="default" type="color3" value="0.5, 0.25, 0"/></geompropvalue>'
    )
    masks = np.array([[1.0, 0.0, 0.5], [0.25, 1.0, 0.0]])
    points = flat_points(np.tile(UP, (2, 1)), UP, mask=masks)
    np.testing.assert_allclose(response(node + paint('nodename="p"'), points) * np.pi, masks, rtol=TOL)
    np.testing.assert_allclose(shown(response(node + paint('nodename="p"'))), [0.5, 0.25, 0.0], rtol=TOL)


@pytest.mark.parametrize(
    "count",
    [1, 2, 3, 4],
)
def test_a_scalar_property_has_one_value_per_sample(response, flat_points, count):
    node = (
        '<geompropvalue name="p" type="float"><input name="geomprop" type="string" value="mask"/></geompropvalue>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" type="float" nodename="p"/>'
        '<input name="color" type="color3" value="1, 1, 1"/></oren_nayar_diffuse_bsdf>'
    )
    mask = np.linspace(0.25, 1.0, count)
    found = response(node, flat_points(np.tile(UP, (count, 1)), UP, mask=mask)) * np.pi
    np.testing.assert_allclose(found, np.repeat(mask[:, None], 3, axis=1), rtol=TOL)


def test_opacity_scales_the_response(surface_document, flat_points):
    document = surface_document(paint('value="0.5, 0.5, 0.5"'))
    surface = document.getNode("s")
    surface.addInput("opacity", "float").setValueString("0.25")
    found = Surface(document.getNode("m")).response(flat_points(UP, UP))
    np.testing.assert_allclose(shown(found), 0.125, rtol=TOL)


def test_a_material_and_its_surface_shader_are_the_same(surface_document, flat_points):
    document = surface_document(paint('value="0.5, 0.5, 0.5"'))
    material, shader = (Surface(document.getNode(name)).response(flat_points(UP, UP)) for name in "ms")
    assert np.array_equal(material, shader)


def test_a_material_without_a_surface_is_black(make_document, flat_points):
    document = make_document('<surfacematerial name="m" type="material"/>')
    assert np.array_equal(Surface(document.getNode("m")).response(flat_points(UP, UP)), np.zeros((1, 3)))


def test_artistic_colours_become_a_complex_index(response):
    nodes = (
        '<artistic_ior name="i" type="multioutput"><input name="reflectivity" type="color3" value="0.9, 0.5, 0.25"/>'
        '<input name="edge_color" type="color3" value="0.5, 0.5, 0"/></artistic_ior>'
        '<conductor_bsdf name="bsdf" type="BSDF"><input name="ior" type="color3" nodename="i" output="ior"/>'
        '<input name="extinction" type="color3" nodename="i" output="extinction"/></conductor_bsdf>'
    )
    # Whatever the index, at normal incidence the reflectance is what was asked for.
    alpha = np.float64(np.float32(0.05))
    white = GeneralizedSchlick(1.0, alpha=(alpha, alpha)).eval(UP, UP)
    compensated = GeneralizedSchlick(
        [0.9, 0.5, 0.25], alpha=(alpha, alpha), energy_compensation=versions.installed().microfacet_albedo.white
    ).eval(UP, UP)
    found = response(nodes)[0]
    np.testing.assert_allclose(found, compensated, rtol=4 * FLOAT32_TOL)
    assert np.all(found < white)


ANISOTROPIC = (
    '<roughness_anisotropy name="r" type="vector2"><input name="roughness" type="float" value="{}"/>'
    '<input name="anisotropy" type="float" value="{}"/></roughness_anisotropy>'
    '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" nodename="r"/></conductor_bsdf>'
)


@pytest.mark.parametrize(
    ("roughness", "anisotropy", "alpha"),
    [
        (0.5, 0.0, (0.25, 0.25)),
        (0.5, 0.75, (0.5, 0.125)),
        # The aspect ends at anisotropy 0.98, the width at 1.
        (0.5, 1.0, (1.0, 0.25 * np.sqrt(0.02))),
        (1.0, 0.75, (1.0, 0.5)),
    ],
)
def test_roughness_and_anisotropy_become_two_widths(response, flat_points, polar, roughness, anisotropy, alpha):
    given = (
        '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="{!r}, {!r}"/>'
        "</conductor_bsdf>"
    )
    points = flat_points(polar(0.5, 0.3), polar(0.8, np.array([2.0, 3.0, 4.0])))
    found = response(ANISOTROPIC.format(roughness, anisotropy), points)
    # The widths are rounded to float32, and D goes with their fourth power at most.
    tolerance = 8 * FLOAT32_TOL
    np.testing.assert_allclose(found, response(given.format(*map(float, alpha)), points), rtol=tolerance)
    exchanged = response(given.format(*map(float, alpha[::-1])), points)
    assert anisotropy == 0.0 or np.max(np.abs(found / exchanged - 1.0)) > tolerance


@pytest.mark.parametrize(("roughness", "widths"), [(0.5, [0.5, 0.125]), (1.0, [1.0, 0.5])])
def test_widths_from_roughness_and_anisotropy_are_constant(surface_document, roughness, widths):
    document = surface_document(ANISOTROPIC.format(roughness, 0.75))
    found = constant_input(document.getNode("bsdf"), "roughness")
    np.testing.assert_allclose(found, widths, rtol=FLOAT32_TOL)


# Units and colour spaces --------------------------------------------------------------------------------------------

FILM = '<conductor_bsdf name="bsdf" type="BSDF"><input name="thinfilm_thickness" type="float" {}/></conductor_bsdf>'


@pytest.mark.parametrize("given", ['value="300"', 'value="0.3" unit="micron"', 'value="0.0000003" unit="meter"'])
def test_a_films_thickness_is_converted_to_nanometres(surface_document, given):
    unit = ' unittype="distance"' if "unit=" in given else ""
    document = surface_document(FILM.format(given + unit))
    # A number of three roundings: as given, the factor, the product.
    assert constant_input(document.getNode("bsdf"), "thinfilm_thickness") == pytest.approx(300.0, rel=4 * FLOAT32_TOL)


def test_a_film_of_another_unit_is_another_film(response):
    microns, nanometres, wrong = (
        response(FILM.format(given))[0]
        for given in ('value="0.3" unittype="distance" unit="micron"', 'value="300"', 'value="0.3"')
    )
    # The film's colour follows its thickness with a slope below 0.1 per nanometre.
    tolerance = 30.0 * 4 * FLOAT32_TOL * np.max(nanometres)
    np.testing.assert_allclose(microns, nanometres, rtol=0.0, atol=tolerance)
    assert np.max(np.abs(wrong - nanometres)) > tolerance


def decoded(x: float) -> float:
    """IEC 61966-2-1; its numbers are float32 in MaterialX's graph."""
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def test_a_colour_of_srgb_is_decoded(response):
    found = shown(response(paint('value="0.5, 0.75, 0.03125" colorspace="srgb_texture"')))
    np.testing.assert_allclose(found, [decoded(x) for x in (0.5, 0.75, 0.03125)], rtol=4 * FLOAT32_TOL)
    assert np.all(np.abs(found - [0.5, 0.75, 0.03125]) > FLOAT32_TOL)


@pytest.mark.parametrize(
    ("name", "library_name"), [("gamma22", "g22_rec709"), ("lin_ap1", "acescg"), ("lin_p3d65_scene", "lin_displayp3")]
)
def test_a_colour_is_decoded_by_any_name_of_its_space(response, name, library_name):
    one, other = (response(paint(f'value="0.5, 0.75, 0.1" colorspace="{space}"')) for space in (name, library_name))
    np.testing.assert_array_equal(one, other)
    assert np.all(np.abs(shown(one) - [0.5, 0.75, 0.1]) > FLOAT32_TOL)


@pytest.mark.parametrize("space", ["lin_rec709_scene", "Raw"])
def test_a_colour_that_is_to_be_used_as_it_is_is(response, space):
    np.testing.assert_allclose(
        shown(response(paint(f'value="0.5, 0.25, 0.125" colorspace="{space}"'))), [0.5, 0.25, 0.125], rtol=TOL
    )


def test_a_documents_colour_space_holds_for_its_colours_and_not_for_numbers(response):
    inherited = response(paint('value="0.5, 0.5, 0.5"'), attributes='colorspace="srgb_texture"')
    np.testing.assert_allclose(shown(inherited), decoded(0.5), rtol=4 * FLOAT32_TOL)
    own = response(paint('value="0.5, 0.5, 0.5" colorspace="lin_rec709"'), attributes='colorspace="srgb_texture"')
    np.testing.assert_allclose(shown(own), 0.5, rtol=TOL)
    weight = paint('value="1, 1, 1"').replace("</", '<input name="weight" type="float" value="0.5"/></')
    np.testing.assert_allclose(
        shown(response(weight, attributes='colorspace="srgb_texture"')), 0.5, rtol=4 * FLOAT32_TOL
    )


@pytest.mark.parametrize("source", ["image", "geompropvalue"])
def test_what_an_image_or_a_geometric_property_gives_is_no_constant(surface_document, source):
    document = surface_document(
        f'<{source} name="varying" type="float"/><conductor_bsdf name="bsdf" type="BSDF">'
        '<input name="weight" type="float" nodename="varying"/></conductor_bsdf>'
    )
    name, value = {"image": ("file", "a.png"), "geompropvalue": ("geomprop", "wear")}[source]
    document.getNode("varying").setInputValue(name, value, "filename" if source == "image" else "string")
    assert constant_input(document.getNode("bsdf"), "weight") is None


@pytest.mark.parametrize(
    ("given", "metres"), [('value="3"', 3.0), ('value="3" unittype="distance" unit="centimeter"', 0.03)]
)
def test_a_distance_of_no_definitions_unit_is_in_metres(response, given, metres):
    nodes = (
        f'<add name="sum" type="float"><input name="in1" type="float" {given}/></add>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" value="1, 1, 1"/>'
        '<input name="weight" type="float" nodename="sum"/></oren_nayar_diffuse_bsdf>'
    )
    np.testing.assert_allclose(shown(response(nodes)), metres, rtol=4 * FLOAT32_TOL)


BARE = """
  <nodedef name="ND_bare" node="bare">
    <input name="share" type="float"/><input name="tint" type="color3"/><input name="turn" type="matrix33"/>
    <output name="out" type="BSDF"/>
  </nodedef>
  <nodegraph name="NG_bare" nodedef="ND_bare">
    <add name="weight" type="float">
      <input name="in1" type="float" interfacename="share"/><input name="in2" type="float" value="0.5"/>
    </add>
    <add name="color" type="color3">
      <input name="in1" type="color3" interfacename="tint"/><input name="in2" type="color3" nodename="turned_color"/>
    </add>
    <transformmatrix name="turned" type="vector3">
      <input name="in" type="vector3" value="0.5, 0.25, 0.125"/>
      <input name="mat" type="matrix33" interfacename="turn"/>
    </transformmatrix>
    <convert name="turned_color" type="color3"><input name="in" type="vector3" nodename="turned"/></convert>
    <oren_nayar_diffuse_bsdf name="diffuse" type="BSDF">
      <input name="weight" type="float" nodename="weight"/><input name="color" type="color3" nodename="color"/>
    </oren_nayar_diffuse_bsdf>
    <output name="out" type="BSDF" nodename="diffuse"/>
  </nodegraph>
  <bare name="bsdf" type="BSDF"/>
"""


def test_inputs_without_a_value_anywhere_are_zero_and_matrices_unity(response):
    np.testing.assert_allclose(shown(response(BARE)), [0.25, 0.125, 0.0625], rtol=TOL)


# What is refused ----------------------------------------------------------------------------------------------------


def test_everything_unknown_is_named_at_once(make_document):
    document = make_document(
        '<conical_edf name="a" type="EDF"/><measured_edf name="b" type="EDF"/>'
        '<add name="both" type="EDF"><input name="in1" type="EDF" nodename="a"/>'
        '<input name="in2" type="EDF" nodename="b"/></add>'
        '<subsurface_bsdf name="c" type="BSDF"><input name="color" type="color3" value="1, 1, 1" '
        'colorspace="unheard_of"/></subsurface_bsdf>'
        '<surface name="m" type="surfaceshader"><input name="edf" type="EDF" nodename="both"/>'
        '<input name="bsdf" type="BSDF" nodename="c"/></surface>'
    )
    with pytest.raises(UnsupportedError) as caught:
        Surface(document.getNode("m"))
    assert caught.value.names == ["ND_conical_edf", "ND_measured_edf", "colour space unheard_of"]
    assert str(caught.value) == "the reference does not know " + ", ".join(caught.value.names)


def test_a_colour_space_of_a_graphs_interface_and_a_documents_own_geometry_are_named(make_document):
    document = make_document(
        '<geompropdef name="mine" type="vector3" geomprop="normal"/>'
        '<nodedef name="ND_own" node="own"><input name="n" type="vector3" defaultgeomprop="mine"/>'
        '<output name="out" type="BSDF"/></nodedef>'
        '<nodegraph name="NG_own" nodedef="ND_own"><oren_nayar_diffuse_bsdf name="d" type="BSDF">'
        '<input name="normal" type="vector3" interfacename="n"/></oren_nayar_diffuse_bsdf>'
        '<output name="out" type="BSDF" nodename="d"/></nodegraph><own name="bsdf" type="BSDF"/>'
        '<nodegraph name="g"><input name="c" type="color3" value="1, 0, 0" colorspace="foo"/>'
        '<uniform_edf name="e" type="EDF"><input name="color" type="color3" interfacename="c"/></uniform_edf>'
        '<output name="out" type="EDF" nodename="e"/></nodegraph>'
        '<surface name="m" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/>'
        '<input name="edf" type="EDF" nodegraph="g" output="out"/></surface>'
    )
    with pytest.raises(UnsupportedError) as caught:
        Surface(document.getNode("m"))
    assert caught.value.names == ["colour space foo", "geometric property mine"]


def doubled(levels):
    """Definitions of which each uses the one before it twice, and a surface that shows the last."""
    declared = '<input name="in" type="float" value="1"/><output name="out" type="float"/>'
    bound = '<input name="{}" type="float" {}/>'.format
    interface, first = 'interfacename="in"', 'nodename="x"'
    text = ""
    for k in range(levels):
        node = f"d{k - 1}" if k else "absval"
        twice = f'<{node} name="x" type="float">{bound("in", interface)}</{node}>' + (
            f'<{node} name="y" type="float">{bound("in", first)}</{node}>'
        )
        text += f'<nodedef name="ND_d{k}" node="d{k}">{declared}</nodedef><nodegraph name="NG_d{k}" nodedef="ND_d{k}">'
        text += f'{twice}<output name="out" type="float" nodename="y"/></nodegraph>'
    return text + (
        f'<d{levels - 1} name="last" type="float"/>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" type="float" nodename="last"/>'
        "</oren_nayar_diffuse_bsdf>"
    )


def test_graphs_that_multiply_beyond_all_bounds_are_refused(surface_document):
    few, many = (surface_document(doubled(levels)) for levels in (6, 18))
    Surface(few.getNode("m"))
    with pytest.raises(UnsupportedError, match=r"ND_d17 \(its graphs have more than 20000 nodes in all\)"):
        Surface(many.getNode("m"))


def test_a_chain_of_graphs_is_evaluated_up_to_the_depth_and_refused_beyond(surface_document, flat_points):
    def chain(count):
        nodes = '<constant name="c0" type="color3"><input name="value" type="color3" value="0.5, 0.5, 0.5"/></constant>'
        for k in range(count):
            nodes += (
                f'<saturate name="c{k + 1}" type="color3"><input name="in" type="color3" nodename="c{k}"/></saturate>'
            )
        return surface_document(
            f'{nodes}<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" '
            f'nodename="c{count}"/></oren_nayar_diffuse_bsdf>'
        )

    deep, deeper = chain(100), chain(MAXIMUM_DEPTH)
    up = np.array([0.0, 0.0, 1.0])
    assert np.isfinite(Surface(deep.getNode("m")).response(flat_points(up, up))).all()
    with pytest.raises(RecursionError, match="deeper than"):
        Surface(deeper.getNode("m"))


def test_one_sample_is_judged_like_two(make_document, flat_points):
    document = make_document(
        '<floor name="f" type="color3"><input name="in" type="color3" value="1, 1, 1"/></floor>'
        '<surface_unlit name="m" type="surfaceshader"><input name="emission_color" type="color3" nodename="f"/>'
        "</surface_unlit>"
    )
    up = np.array([0.0, 0.0, 1.0])
    for count in (1, 2):
        found = Surface(document.getNode("m")).tolerance(flat_points(np.tile(up, (count, 1)), up))
        assert found.expected.shape == (count, 3)
        assert np.max(found.allowed) < 1e-4


def test_a_node_that_is_no_node_is_named_by_its_category(make_document):
    document = make_document(
        '<unheard_of name="x" type="BSDF"/>'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="x"/></surface>'
    )
    with pytest.raises(UnsupportedError, match=r"does not know unheard_of$"):
        Surface(document.getNode("s"))


def test_a_surface_of_known_nodes_is_not_refused(surface_document):
    document = surface_document('<conductor_bsdf name="bsdf" type="BSDF"/>')
    Surface(document.getNode("m"))


@since("1.39.5", "definition of each function of the reference")
def test_the_reference_knows_definitions_that_exist(library):
    assert [name for name in NODES if library.document.getNodeDef(name) is None] == []


# Deep and cyclic graphs must be refused in a blink; the walk visits each node once.
TIME_LIMIT_S = 1.0


def chain(count: int, last: str = "bsdf") -> str:
    """A BSDF multiplied by 1, `count` nodes in all."""
    names = [f"n{k}" for k in range(count - 1)] + [last]
    return '<conductor_bsdf name="n0" type="BSDF"/>' + "".join(
        f'<multiply name="{name}" type="BSDF"><input name="in1" type="BSDF" nodename="{below}"/></multiply>'
        for below, name in pairwise(names)
    )


def test_a_graph_of_five_hundred_nodes_in_a_row_is_refused_at_once(surface_document):
    document = surface_document(chain(500))
    start = time.perf_counter()
    with pytest.raises(RecursionError, match=rf"deeper than {MAXIMUM_DEPTH} nodes at n\d+"):
        Surface(document.getNode("m"))
    assert time.perf_counter() - start < TIME_LIMIT_S


def test_a_graph_at_the_limit_is_evaluated_and_one_beyond_is_refused(response):
    # The surface itself is a node of the graph.
    metal = '<conductor_bsdf name="bsdf" type="BSDF"/>'
    assert np.array_equal(response(chain(MAXIMUM_DEPTH - 1)), response(metal))
    with pytest.raises(RecursionError, match=f"deeper than {MAXIMUM_DEPTH} nodes"):
        response(chain(MAXIMUM_DEPTH))


def test_a_wide_graph_of_shared_nodes_takes_no_time(response):
    # Sixty additions of a node to itself: 2^60 paths, 61 nodes.
    doubled = '<conductor_bsdf name="n0" type="BSDF"/>' + "".join(
        f'<mix name="{name}" type="BSDF"><input name="fg" type="BSDF" nodename="n{k}"/>'
        f'<input name="bg" type="BSDF" nodename="n{k}"/><input name="mix" type="float" value="0.5"/></mix>'
        for k, name in enumerate([f"n{k}" for k in range(1, 60)] + ["bsdf"])
    )
    start = time.perf_counter()
    found = response(doubled)
    assert time.perf_counter() - start < TIME_LIMIT_S
    np.testing.assert_allclose(found, response('<conductor_bsdf name="bsdf" type="BSDF"/>'), rtol=60 * EPS)


CYCLE = (
    '<mix name="bsdf" type="BSDF"><input name="fg" type="BSDF" nodename="other"/></mix>'
    '<mix name="other" type="BSDF"><input name="fg" type="BSDF" nodename="bsdf"/></mix>'
)


def test_a_cyclic_graph_is_refused_at_once(surface_document):
    document = surface_document(CYCLE)
    start = time.perf_counter()
    with pytest.raises(RecursionError, match="the graph is cyclic at "):
        Surface(document.getNode("m"))
    assert time.perf_counter() - start < TIME_LIMIT_S


def test_the_depth_of_a_graph_is_that_of_its_longest_path(surface_document):
    # Two rows of nodes, each below the limit, end to end, and a short cut to the middle that comes first in the file.
    lower = chain(MAXIMUM_DEPTH - 20, last="middle")
    upper = chain(MAXIMUM_DEPTH - 20, last="top").replace('"n0"', '"middle"').replace('"n', '"u')
    upper = upper.partition("/>")[2]
    both = (
        '<add name="bsdf" type="BSDF"><input name="in2" type="BSDF" nodename="middle"/>'
        '<input name="in1" type="BSDF" nodename="top"/></add>'
    )
    document = surface_document(lower + upper + both)
    with pytest.raises(RecursionError, match=f"deeper than {MAXIMUM_DEPTH} nodes"):
        Surface(document.getNode("m"))


def test_a_metal_of_the_document_is_the_lobe_of_its_numbers(response, flat_points, rng, hemisphere):
    # Broad, in float32, off the axes: one comparison of the whole way with the optics.
    v, l = hemisphere(rng, 100), hemisphere(rng, 100)
    alpha = float(np.float32(0.4))
    lobe = Conductor(
        np.float32([0.183, 0.421, 1.373]), np.float32([3.424, 2.346, 1.770]), alpha=(alpha, alpha),
        retroreflective=True, energy_compensation=versions.installed().microfacet_albedo.white,
    )  # fmt: skip
    text = (
        '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.4, 0.4"/>'
        '<input name="retroreflective" type="boolean" value="true"/></conductor_bsdf>'
    )
    # Relative; grazing cosines, from 1e-3 up, are rounded as parts of unit vectors.
    np.testing.assert_allclose(response(text, flat_points(v, l)), lobe.eval(v, l) * l[:, 2:], rtol=64 * EPS / 1e-3)


def test_the_only_output_of_a_defining_graph_is_that_of_its_definition_whatever_its_name(response):
    nodes = '<oren_nayar_diffuse_bsdf name="lobe" type="BSDF"/>'
    one, other = (
        response(
            '<nodedef name="ND_a" node="a"><output name="out" type="BSDF"/></nodedef>'
            f'<nodegraph name="NG_a" nodedef="ND_a">{nodes}'
            f'<output name="{name}" type="BSDF" nodename="lobe"/></nodegraph><a name="bsdf" type="BSDF"/>'
        )
        for name in ("out", "other")
    )
    np.testing.assert_array_equal(one, other)
    assert np.all(one > 0.0)


def test_the_only_output_of_a_node_is_meant_whatever_is_named(make_document, flat_points):
    nodes = (
        '<nodedef name="ND_a" node="a"><output name="made" type="color3"/></nodedef>'
        '<nodegraph name="NG_a" nodedef="ND_a"><constant name="c" type="color3">'
        '<input name="value" type="color3" value="0.5, 0.25, 0.125"/></constant>'
        '<output name="made" type="color3" nodename="c" output="first"/></nodegraph><a name="x" type="color3"/>'
    )
    surface = '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>'
    for name in ("made", "second"):
        document = make_document(nodes + paint(f'nodename="x" output="{name}"') + surface)
        found = shown(Surface(document.getNode("s")).response(flat_points(UP, UP)))
        np.testing.assert_allclose(found, [0.5, 0.25, 0.125], rtol=TOL)


# What is no finite number ---------------------------------------------------------------------------------------------

ZERO = '<normalize name="zero" type="vector3"><input name="in" type="vector3" value="0, 0, 0"/></normalize>'
LOBE = '<conductor_bsdf name="{}" type="BSDF"><input name="normal" type="vector3" nodename="{}"/></conductor_bsdf>'
WITHIN = (
    '<nodedef name="ND_a" node="a"><output name="out" type="BSDF"/></nodedef><nodegraph name="NG_a" nodedef="ND_a">'
    f'{ZERO}{LOBE.format("lobe", "zero")}<output name="out" type="BSDF" nodename="lobe"/></nodegraph>'
    '<a name="bsdf" type="BSDF"/>'
)


@pytest.mark.parametrize(
    ("nodes", "path"),
    [
        (ZERO + LOBE.format("bsdf", "zero"), "zero"),
        (WITHIN, "bsdf/NG_a/zero"),
        ('<conductor_bsdf name="bsdf" type="BSDF"/>', ""),
    ],
)
def test_the_first_node_that_gives_no_finite_number_is_named(surface_document, flat_points, nodes, path):
    document = surface_document(nodes)
    assert Surface(document.getNode("m")).not_finite(flat_points(UP, UP)) == path
