"""Documents whose definitions came to more nodes than memory holds, or had the names that replacing them makes."""

from __future__ import annotations

import subprocess

import MaterialX as mx
import pytest

from mrm_mtlx.documents.flattening import Sizes, TooManyNodesError, flatten
from mrm_mtlx.system.limits import MAXIMUM_NODES

# Of definitions that use each other twice: a million nodes.
TWENTY = 20

WEIGHT = '<input name="weight" type="float" nodename="x"/>'
METAL = '<conductor_bsdf name="metal" type="BSDF">{}</conductor_bsdf>'


def definition(name: str, nodes: str, output: str) -> str:
    """A definition of a float by a graph of nodes, one of which gives the output."""
    return (
        f'<nodedef name="ND_{name}" node="{name}"><output name="out" type="float"/></nodedef>'
        f'<nodegraph name="NG_{name}" nodedef="ND_{name}">{nodes}<output name="out" type="float" nodename="{output}"/>'
        "</nodegraph>"
    )


def twice(name: str) -> str:
    """Two nodes of a definition, and their sum."""
    return (
        f'<{name} name="a" type="float"/><{name} name="b" type="float"/><add name="s" type="float">'
        '<input name="in1" type="float" nodename="a"/><input name="in2" type="float" nodename="b"/></add>'
    )


def doubling(count: int, output: str = "s") -> str:
    """That many definitions, each of which uses the one before it twice, and a node `x` of the last one.

    `output` is what the graphs give: "s" the sum of both, "a" one of the two.
    """
    first = definition("d0", '<constant name="k" type="float"/>', "k")
    others = "".join(definition(f"d{k}", twice(f"d{k - 1}"), output) for k in range(1, count))
    return first + others + f'<d{count - 1} name="x" type="float"/>'


@pytest.fixture
def codes(check, place, document_text):
    """Function from elements, and inputs of the diffuse lobe, to the codes of a check without a driver."""

    def found(elements: str, inputs: str = "", **changes: object) -> list[str]:
        path = place.write("d.mtlx", document_text(elements, inputs))
        return [f.code for result in check(path, targets=("msl",), **changes) for f in result.findings]

    return found


@pytest.mark.parametrize("output", ["s", "a"])
@pytest.mark.parametrize("sweep", [False, True])
def test_twenty_definitions_did_not_take_the_memory_of_a_million_nodes(codes, sweep, output):
    assert codes(doubling(TWENTY, output), WEIGHT, retro_sweep=sweep) == ["DOC_TOO_LARGE"]


def test_definitions_that_no_surface_uses_were_not_replaced_either(codes):
    assert codes(doubling(TWENTY)) == []
    assert codes(doubling(TWENTY), retro_sweep=True) == ["DOC_TOO_LARGE"]


def test_a_definition_that_contains_itself_beside_its_output_was_not_replaced_without_end(codes):
    nodes = '<own name="again" type="float"/><constant name="k" type="float"/>'
    graph = definition("own", nodes, "k") + '<own name="x" type="float"/>'
    assert codes(graph, WEIGHT, retro_sweep=True) == ["DOC_TOO_LARGE"]


@pytest.mark.parametrize("suffix", ["glb", "usda", "gltf"])
def test_no_format_is_written_of_a_million_nodes(place, document_text, command, suffix):
    path = place.write("d.mtlx", document_text(doubling(TWENTY), WEIGHT))
    arguments = [*command, "convert", path, place.folder / f"d.{suffix}"]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert "DOC_TOO_LARGE" in done.stderr
    assert not (place.folder / f"d.{suffix}").exists()


def test_a_definition_of_the_documents_own_that_a_librarys_node_came_to_was_seen(make_document):
    # In the document, the nodes inside of a library's graph are nodes of the document's definitions.
    inputs = '<input name="in1" type="float"/><input name="in2" type="float"/><output name="out" type="float"/>'
    own = doubling(TWENTY).replace(
        f'name="ND_d{TWENTY - 1}" node="d{TWENTY - 1}"><output name="out" type="float"/>',
        f'name="ND_d{TWENTY - 1}" node="multiply">{inputs}',
    )
    elements = own.replace(f'<d{TWENTY - 1} name="x" type="float"/>', "")
    document = make_document(elements + '<standard_surface name="s" type="surfaceshader"/>')
    assert Sizes(document).of(document.getNode("s")) > MAXIMUM_NODES
    with pytest.raises(TooManyNodesError):
        flatten(document)


@pytest.mark.parametrize("count", [1, 5, 10])
def test_the_number_of_nodes_is_that_which_replacing_makes(make_document, count):
    document = make_document(doubling(count) + '<open_pbr_surface name="s" type="surfaceshader"/>')
    sizes = Sizes(document)
    expected = sum(sizes.of(node) for node in document.getNodes())
    assert sizes.of(document.getNode("x")) == 2**count - 1
    flatten(document)
    geometry = [node for node in document.getNodes() if node.getName().startswith("geomNode_")]
    assert len(document.getNodes()) - len(geometry) == expected


def test_the_libraries_stay_far_below_the_bound(library):
    document = mx.createDocument()
    document.setDataLibrary(library.document)
    sizes = Sizes(document)
    largest = 0
    for definition in library.document.getNodeDefs():
        node = document.addNode(definition.getNodeString(), "n", definition.getType())
        node.setNodeDefString(definition.getName())
        largest = max(largest, sizes.of(node))
        document.removeNode("n")
    assert 200 < largest < MAXIMUM_NODES / 50


# Names --------------------------------------------------------------------------------------------------------------


def test_a_node_with_the_name_of_a_geometric_default_was_not_taken_for_it(make_document):
    document = make_document(
        '<constant name="geomNode_Nworld" type="vector3"/><standard_surface name="s" type="surfaceshader"/>'
    )
    with pytest.raises(ValueError, match="geomNode_Nworld"):
        flatten(document)


@pytest.mark.parametrize("element", ["nodegraph", "backdrop", "constant"])
def test_a_name_that_replacing_makes_is_a_finding(codes, element):
    found = codes(f'<{element} name="geomNode_Nworld" type="vector3"/>', retro_sweep=True)
    assert [code for code in found if code != "DOC_CONNECTION"] == ["SHADER_GENERATE"]


@pytest.mark.parametrize("element", ["token", "foo", "output"])
def test_a_child_with_the_name_of_the_flag_was_not_taken_for_it(codes, element):
    child = f'<{element} name="retroreflective" type="boolean"/>'
    surface = (
        '<surface name="t" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="metal"/></surface>'
        '<surfacematerial name="n" type="material"><input name="surfaceshader" type="surfaceshader" nodename="t"/>'
        "</surfacematerial>"
    )
    assert codes(METAL.format(child) + surface, retro_sweep=True) == []
