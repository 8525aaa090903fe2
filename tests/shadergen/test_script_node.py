"""OSL for Blender's Script node: which sockets it has, how they are called, and that it is the same material."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.engines import registry
from mrm_mtlx.library import materials_folder
from mrm_mtlx.shadergen import (
    GenerationError,
    OslMode,
    ScriptNode,
    Socket,
    generate,
    renderable_elements,
    script_node,
    with_mesh_inputs,
)
from mrm_mtlx.shadergen.osl_parameters import joined, split

if TYPE_CHECKING:
    from collections.abc import Callable

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array

MATERIALS = sorted(path.stem for path in materials_folder().glob("*.mtlx"))

by_mode = pytest.mark.parametrize("mode", [OslMode.ALIGNED, OslMode.CYCLES])


@pytest.fixture(scope="module")
def ready(make_document) -> Callable[[str], mx.Document]:
    """Function from the name of a ready material to its document."""

    def read(name: str) -> mx.Document:
        text = (materials_folder() / f"{name}.mtlx").read_text(encoding="utf-8")
        return make_document(text[text.index(">", text.index("<materialx")) + 1 : text.index("</materialx>")])

    return read


@pytest.fixture(scope="module")
def made(library) -> Callable[..., ScriptNode]:
    """Function from a document to the Script node of its one element."""

    def make(document: mx.Document, mode: OslMode = OslMode.ALIGNED) -> ScriptNode:
        (element,) = renderable_elements(document)
        return script_node(element, generate(element, "osl", library, mode))

    return make


def table(node: ScriptNode) -> list[tuple[str, str, str, object]]:
    """Group, label, type and default of each socket."""
    return [(socket.group, socket.label, socket.type, socket.default) for socket in node.sockets]


# Which sockets, and what they are called ------------------------------------------------------------------------------


def test_the_sockets_are_what_the_document_sets_by_its_names(made, ready):
    assert table(made(ready("traffic_cone_collar"))) == [
        ("White backing", "Color", "color", (0.6, 0.6, 0.59)),
        ("White backing", "Roughness", "float", 0.2),
        ("Vinyl film", "Index of refraction", "float", 1.53),
        ("Vinyl film", "Microfacet width", "float", 0.03),
        ("Encapsulated beads", "Reflectance at 0 degrees", "color", (0.107, 0.107, 0.107)),
        ("Encapsulated beads", "Reflectance at 90 degrees", "color", (0.0, 0.0, 0.0)),
        ("Encapsulated beads", "Exponent", "float", 0.5),
        ("Encapsulated beads", "Microfacet width", "float", 0.0048),
        ("Encapsulated beads", "Retroreflective", "boolean", True),
    ]


def test_a_surface_models_sockets_have_its_names_and_folders(made, ready):
    node = made(ready("segmented_trim"))
    assert [(socket.group, socket.title) for socket in node.sockets] == [
        ("Pattern", "Segments X"),
        ("Pattern", "Segments Y"),
        ("Pattern", "Share turned back"),
        ("Base", "Base Color"),
        ("Base", "Base Metalness"),
        ("Specular", "Specular Roughness"),
    ]
    assert (node.uv, node.tangent) == ("mrm_uv", "mrm_tangent")
    assert made(ready("traffic_cone_collar")).uv == ""


def test_a_socket_has_the_limits_and_the_words_of_its_definition(made, ready):
    index = next(socket for socket in made(ready("cats_eye")).sockets if socket.name == "polished_glass_ior")
    limits = (index.minimum, index.maximum, index.soft_minimum, index.soft_maximum)
    assert limits == (0.0, None, 1.0, 3.0)
    assert index.title == "Polished glass: Index of refraction"
    assert index.doc.startswith("Index of refraction inside")
    assert index.to_json()["soft_maximum"] == 3.0


@pytest.mark.parametrize("name", MATERIALS)
def test_sockets_are_unique_group_by_group_and_all_that_the_shader_has(made, ready, name):
    node = made(ready(name))
    sockets = node.sockets
    for keys in ([s.name for s in sockets], [s.title for s in sockets], [(s.group, s.label) for s in sockets]):
        assert len(set(keys)) == len(keys) >= 4
    groups = [group for group, _ in groupby(sockets, key=lambda socket: socket.group)]
    assert len(set(groups)) == len(groups)
    told = [*(socket.name for socket in sockets), *filter(None, (node.uv, node.tangent)), "out"]
    assert [line.split(" = ")[0].split()[-1] for line in listed(node)] == told
    assert "#include" not in node.shader.sources["pixel"]
    assert "checkBox" not in "\n".join(listed(node))  # Blender 5.0 dies of one that is linked


def listed(node: ScriptNode) -> list[str]:
    """The lines of the shader's list of parameters."""
    return node.shader.sources["pixel"].rpartition("\n(\n")[2].partition("\n)\n{\n")[0].split("\n")


LOBE = """<generalized_schlick_bsdf name="{node}" type="BSDF">{inputs}</generalized_schlick_bsdf>"""


@pytest.fixture(scope="module")
def sockets_of(made, surface_document) -> Callable[..., dict[str, Socket]]:
    """Function from the inputs of a lobe, and other nodes, to its sockets by label."""

    def make(inputs: str, others: str = "") -> dict[str, Socket]:
        document = surface_document(others + LOBE.format(node="bsdf", inputs=inputs))
        return {socket.label: socket for socket in made(document).sockets}

    return make


def test_two_widths_are_one_socket_where_they_are_equal(sockets_of):
    width = '<input name="roughness" type="vector2" value="{}"/>'
    assert {label: s.default for label, s in sockets_of(width.format("0.2, 0.2")).items()} == {"Microfacet width": 0.2}
    two = sockets_of(width.format("0.2, 0.1"))
    assert {label: s.default for label, s in two.items()} == {"Microfacet width X": 0.2, "Microfacet width Y": 0.1}


def test_text_stays_as_it_is_and_arithmetic_where_it_has_no_name(sockets_of):
    plain = '<multiply name="twice" type="float"><input name="in1" type="float" value="0.2"/>{}</multiply>'
    inputs = '<input name="weight" type="float" nodename="twice"/><input name="scatter_mode" type="string" value="R"/>'
    assert sockets_of(inputs, plain.format("")) == {}
    named = sockets_of(inputs, plain.format('<input name="in2" type="float" value="0.5" uiname="Share" uimax="2"/>'))
    assert {(s.label, s.group, s.maximum) for s in named.values()} == {("Share", "Twice", 2.0)}


def test_equal_names_are_told_apart(sockets_of):
    found = sockets_of(
        '<input name="weight" type="float" value="0.5" uiname="Same" uifolder="One"/>'
        '<input name="exponent" type="float" value="4" uiname="Same" uifolder="One"/>'
        '<input name="color0" type="color3" value="0, 0, 0" uiname="Same" uifolder="Two"/>'
    )
    assert set(found) == {"Same", "Same (2)"}  # the third is in another group
    assert len({socket.title for socket in found.values()}) == len(found)


def test_inputs_of_a_graph_are_the_materials_own(made, make_document):
    document = make_document("""
        <nodegraph name="NG">
          <input name="shine" type="float" value="0.3" uiname="Shine" uifolder="Look"/>
          <conductor_bsdf name="metal" type="BSDF">
            <input name="weight" type="float" interfacename="shine"/></conductor_bsdf>
          <output name="out" type="BSDF" nodename="metal"/>
        </nodegraph>
        <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodegraph="NG" output="out"/></surface>
        <surfacematerial name="m" type="material">
          <input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>""")
    assert table(made(document)) == [("Look", "Shine", "float", 0.3)]


# That it is the same material -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def light(cycles) -> Callable[[str], Array]:
    """Function from OSL to the light that facets reflect of three suns."""
    bench = registry.engines()["cycles"].bench
    assert bench is not None
    rng = np.random.default_rng(3)
    normals = np.abs(rng.standard_normal((300, 3))) * [1.0, 1.0, 0.5] + [0.0, 0.0, 0.1]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    suns = np.array([[0.0, 0.0, 1.0], [0.02, 0.0, 1.0], [0.5, 0.2, 0.8]])
    suns /= np.linalg.norm(suns, axis=1, keepdims=True)
    return lambda source: bench.compile(source, "node").direct_light(normals, {}, suns)


def same_light(light: Callable[[str], Array], document: mx.Document, library, mode: OslMode) -> None:
    """The constants are the same numbers, and the closures the same: so is every bit of the light."""
    (element,) = renderable_elements(document)
    ordinary = generate(element, "osl", library, mode)
    expected = light(with_mesh_inputs(ordinary.sources["pixel"]))
    assert np.max(expected) > 0.1
    np.testing.assert_array_equal(light(script_node(element, ordinary).shader.sources["pixel"]), expected)


@by_mode
@pytest.mark.parametrize("name", ["traffic_cone_collar", "segmented_trim"])
def test_it_reflects_what_the_ordinary_form_reflects(light, ready, library, name, mode):
    same_light(light, ready(name), library, mode)


@pytest.mark.large
@by_mode
@pytest.mark.parametrize("name", MATERIALS)
def test_every_ready_material_reflects_what_its_ordinary_form_reflects(light, ready, library, name, mode):
    same_light(light, ready(name), library, mode)


def test_a_socket_with_another_value_than_the_documents_is_seen(light, ready, made):
    source = made(ready("traffic_cone_collar")).shader.sources["pixel"]
    damaged = source.replace("roughness_xy = 0.0048 ", "roughness_xy = 0.00480001 ")
    assert damaged != source
    assert np.any(light(damaged) != light(source))


def test_a_constant_that_is_forgotten_is_seen(light, ready, made):
    source = made(ready("traffic_cone_collar")).shader.sources["pixel"]
    damaged = source.replace('encapsulated_beads_scatter_mode = "R"', 'encapsulated_beads_scatter_mode = "T"')
    assert damaged != source
    assert np.any(light(damaged) != light(source))


# Documents that ask for more ------------------------------------------------------------------------------------------


def test_words_of_a_document_stay_words(cycles, made, surface_document):
    from mrm_mtlx.engines import osl

    said = "a &quot;name&quot; \\ with /* &#10; ]] };"
    document = surface_document(
        LOBE.format(node="bsdf", inputs=f'<input name="weight" type="float" value="0.5" uiname="{said}"/>')
    )
    node = made(document)
    assert node.sockets[0].label == 'a "name" \\ with /* ]] };'
    osl.check(node.shader.sources["pixel"], node.shader.name)


def test_texture_coordinates_within_a_definition_of_the_document_are_refused(made, make_document):
    document = make_document("""
        <nodedef name="ND_own" node="own"><output name="out" type="float"/></nodedef>
        <nodegraph name="NG_own" nodedef="ND_own">
          <texcoord name="place" type="vector2"/>
          <dotproduct name="d" type="float"><input name="in1" type="vector2" nodename="place"/>
            <input name="in2" type="vector2" value="1, 0"/></dotproduct>
          <output name="out" type="float" nodename="d"/>
        </nodegraph>
        <own name="o" type="float"/>
        <conductor_bsdf name="b" type="BSDF"><input name="weight" type="float" nodename="o"/></conductor_bsdf>
        <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="b"/></surface>
        <surfacematerial name="m" type="material">
          <input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>""")
    with pytest.raises(GenerationError, match="looks up texture coordinates itself"):
        made(document)


def test_parameters_come_apart_and_together_again(ready, library):
    document = ready("segmented_trim")
    (element,) = renderable_elements(document)
    source = generate(element, "osl", library).sources["pixel"]
    parts = split(source)
    assert {"surfaceshader", "vector2", "float", "color", "string", "int"} <= {p.type for p in parts[1]}
    assert split(joined(*parts)) == parts
    for other in ("shader s() {}", "\nshader s\n(\n", "\n(\n\n)\n{\n}"):
        with pytest.raises(GenerationError, match="no shader with a list of parameters"):
            split(other)
