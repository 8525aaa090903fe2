"""Documents in nodes of the standard library alone."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.documents.elements import nodes_of
from mrm_mtlx.documents.portable import portable
from mrm_mtlx.library import Origin, load_library, materials_folder
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.validation.comparison import sampling

if TYPE_CHECKING:
    from pathlib import Path

MATERIALS = sorted(materials_folder().glob("*.mtlx"))


def read(path: Path) -> mx.Document:
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(load_library().document)
    return document


def elements(document: mx.Document) -> dict[str, str]:
    """What is directly in a document, as text, by name; without what the conversion makes."""
    return {c.getName(): mx.prettyPrint(c) for c in document.getChildren() if not c.getName().startswith("retro_")}


@pytest.mark.parametrize("path", MATERIALS, ids=lambda path: path.stem)
def test_a_ready_material_needs_nothing_but_the_standard_library(path):
    document, lost = portable(read(path))
    assert lost == []
    assert document.validate() == (True, "")
    standard = load_library(Origin.UPSTREAM).document
    names = []
    for node in nodes_of(document):
        assert standard.getNodeDef(node.getNodeDef().getName()) is not None
        assert node.getInput("retroreflective") is None
        names.append(node.getName())
    assert len(names) > 200
    # Nodes of all graphs come into one shader, in which they are told apart by their names.
    assert len(set(names)) == len(names)


def test_a_document_without_retroreflection_stays_as_it_is(documents):
    for path in sorted((documents / "corpus").glob("*.mtlx")):
        document = read(path)
        made, lost = portable(document)
        assert (mx.writeToXmlString(made), lost) == (mx.writeToXmlString(document), []), path.name


def test_all_else_of_a_document_stays():
    before = read(materials_folder() / "cats_eye.mtlx")
    after = portable(before)[0]
    assert elements(after).keys() == elements(before).keys()
    for name, text in elements(before).items():
        if name != "NG_cats_eye":
            assert elements(after)[name] == text
    inside = after.getNodeGraph("NG_cats_eye")
    assert inside.getNode("aluminised_lens_back").getDocString().startswith("Mirror behind the lens")
    assert mx.prettyPrint(inside.getNode("stud")) == mx.prettyPrint(before.getNodeGraph("NG_cats_eye").getNode("stud"))


LOBE = '<{node} name="bsdf" type="BSDF">{inputs}</{node}>'
FLAG = '<input name="retroreflective" type="boolean" value="{}"/>'
WIDTH = '<input name="roughness" type="vector2" value="{}"/>'


def lobe(*inputs: str, node: str = "dielectric_bsdf") -> str:
    return LOBE.format(node=node, inputs="".join(inputs))


def shaded(document: mx.Document, element: int = 0) -> np.ndarray:
    """Response to light in and about the lobe's peak."""
    rng = np.random.default_rng(0)
    shape = sampling.LobeShape(np.full(256, 0.1), np.full(256, 0.1), retroreflective=True)
    points = sampling.shading_points(rng, *sampling.sample_local(rng, 256, [shape]))
    return Surface(renderable_elements(document)[element]).shade(points)


def test_a_flag_that_is_off_is_dropped_and_the_node_stays(surface_document):
    plain, off = surface_document(lobe()), surface_document(lobe(FLAG.format("false")))
    assert mx.writeToXmlString(portable(off)[0]) == mx.writeToXmlString(plain)
    transmits = '<input name="scatter_mode" type="string" value="T"/>'
    on = surface_document(lobe(FLAG.format("true"), transmits))
    assert mx.writeToXmlString(portable(on)[0]) == mx.writeToXmlString(surface_document(lobe(transmits)))


def test_what_transmits_stays_beside_the_lobe(surface_document):
    mode = '<input name="scatter_mode" type="string" value="RT"/>'
    document = portable(surface_document(lobe(FLAG.format("true"), mode)))[0]
    kept = [n for n in nodes_of(document) if n.getCategory() == "dielectric_bsdf"]
    assert [n.getInput("scatter_mode").getValueString() for n in kept] == ["T"]
    assert len([n for n in nodes_of(document) if n.getCategory() == "generalized_schlick_bsdf"]) == 2


SWITCHED = """
  <nodedef name="ND_own" node="own">
    <input name="back" type="boolean" value="false" uniform="true"/>
    <output name="out" type="BSDF"/>
  </nodedef>
  <nodegraph name="NG_own" nodedef="ND_own">
    <dielectric_bsdf name="lobe" type="BSDF">
      <input name="roughness" type="vector2" value="0.1, 0.1"/>
      <input name="retroreflective" type="boolean" interfacename="back"/>
    </dielectric_bsdf>
    <output name="out" type="BSDF" nodename="lobe"/>
  </nodegraph>
  <own name="bsdf" type="BSDF"><input name="back" type="boolean" value="{}"/></own>
"""


@pytest.mark.parametrize("flag", ["true", "false"])
def test_a_flag_from_the_interface_of_a_graph_of_the_document_still_decides(surface_document, flag):
    switched = portable(surface_document(SWITCHED.format(flag)))[0]
    width = WIDTH.format("0.1, 0.1")
    written = portable(surface_document(lobe(FLAG.format(flag), width)))[0]
    # The same products in another order, in double precision.
    np.testing.assert_allclose(shaded(switched), shaded(written), rtol=1e-12)


def test_equal_widths_that_are_known_make_fewer_nodes_and_the_same_lobe(surface_document):
    fields = '<constant name="width" type="vector2"><input name="value" type="vector2" value="0.1, 0.1"/></constant>'
    connected = '<input name="roughness" type="vector2" nodename="width"/>'
    given, known = (
        portable(surface_document(nodes))[0]
        for nodes in (
            fields + lobe(FLAG.format("true"), connected),
            lobe(FLAG.format("true"), WIDTH.format("0.1, 0.1")),
        )
    )
    assert len(nodes_of(known)) < 0.85 * len(nodes_of(given))
    # Constants are written with nine digits.
    np.testing.assert_allclose(shaded(known), shaded(given), rtol=1e-5)


COLOR = '<input name="color0" type="color3" value="{}" {}/>'


def test_colours_are_read_in_their_colour_space_and_constants_are_not(surface_document):
    space = 'colorspace="srgb_texture"'
    linear = ", ".join(f"{((c + 0.055) / 1.055) ** 2.4:.9g}" for c in (0.5, 0.7, 0.2))
    inputs = FLAG.format("true"), WIDTH.format("0.1, 0.1")
    node = "generalized_schlick_bsdf"
    of_input = surface_document(lobe(*inputs, COLOR.format("0.5, 0.7, 0.2", space), node=node))
    of_file = surface_document(lobe(*inputs, COLOR.format("0.5, 0.7, 0.2", ""), node=node), attributes=space)
    plain = surface_document(lobe(*inputs, COLOR.format(linear, ""), node=node))
    exact = shaded(portable(plain)[0])
    for document in (of_input, of_file):
        # The linear colour is written with nine digits here, and used in float32 there.
        np.testing.assert_allclose(shaded(portable(document)[0]), exact, rtol=1e-6)


MASKED = """
  <geompropvalue name="mask" type="float"><input name="geomprop" type="string" value="mask"/></geompropvalue>
  <dielectric_bsdf name="lobe" type="BSDF">
    <input name="roughness" type="vector2" value="0.1, 0.1"/>
    <input name="retroreflective" type="boolean" value="true"/>
  </dielectric_bsdf>
  <dielectric_bsdf name="gloss" type="BSDF"><input name="roughness" type="vector2" value="0.1, 0.1"/></dielectric_bsdf>
  <mix name="both" type="BSDF">
    <input name="fg" type="BSDF" nodename="lobe"/>
    <input name="bg" type="BSDF" nodename="gloss"/>
    <input name="mix" type="float" nodename="mask"/>
  </mix>
  <oren_nayar_diffuse_bsdf name="paint" type="BSDF"/>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="both"/>
    <input name="base" type="BSDF" nodename="paint"/>
  </layer>
"""


def test_what_lies_below_a_mixture_by_a_mask_is_not_lost_in_generated_code(gl, surface_document, tmp_path, check):
    """Generators multiply the weights of what is mixed, and would multiply those of a sum as a whole."""
    path = tmp_path / "masked.mtlx"
    mx.writeToXmlFile(portable(surface_document(MASKED))[0], str(path))
    (result,) = check(path, origin=Origin.UPSTREAM)
    assert [one.targets["glsl"].status for one in result.renderables] == ["pass"]
    assert result.findings == []


FILM = '<input name="thinfilm_thickness" type="float" value="{}"/>'
LOSSES = {
    "a film": (lobe(FLAG.format("true"), FILM.format(300)), ["thin film is left out"]),
    "no film": (lobe(FLAG.format("true"), FILM.format(0)), []),
    "a film on an ordinary lobe": (lobe(FILM.format(300)), []),
    "a wide lobe": (lobe(FLAG.format("true"), WIDTH.format("0.3, 0.3")), ["a width of 0.3 is beyond 0.1"]),
    "two widths": (lobe(FLAG.format("true"), WIDTH.format("0.02, 0.1")), ["keeps its energy"]),
    "both": (lobe(FLAG.format("true"), WIDTH.format("0.2, 0.3"), FILM.format(1)), ["thin film", "a width of 0.3"]),
    "a partial lobe": (lobe(FILM.format(300), node="mrm_dielectric_bsdf"), ["thin film is left out"]),
}


@pytest.mark.parametrize("name", LOSSES)
def test_what_the_form_cannot_say_is_told(surface_document, name):
    nodes, expected = LOSSES[name]
    document, lost = portable(surface_document(nodes))
    assert document.validate() == (True, "")
    assert [found.code for found in lost] == ["INTERCHANGE_LOST"] * len(expected)
    for found, words in zip(lost, expected, strict=True):
        assert re.search(words, found.message)
        assert found.location.startswith("/bsdf/")


def test_a_metal_that_covers_something_is_told(surface_document):
    covered = (
        lobe(FLAG.format("true"), node="conductor_bsdf").replace('"bsdf"', '"metal"')
        + '<oren_nayar_diffuse_bsdf name="paint" type="BSDF"/><layer name="bsdf" type="BSDF">'
        '<input name="top" type="BSDF" nodename="{}"/><input name="base" type="BSDF" nodename="{}"/></layer>'
    )
    (found,) = portable(surface_document(covered.format("metal", "paint")))[1]
    assert (found.location, found.message[:13]) == ("/metal", "a metal hides")
    assert portable(surface_document(covered.format("paint", "metal")))[1] == []


def test_the_film_of_a_surface_model_is_told_where_there_is_one(make_document):
    def lost(model: str, amount: str, *inputs: str):
        given = "".join(f'<input name="{name}" type="float" value="0.5"/>' for name in (amount, *inputs))
        return portable(make_document(f'<{model} name="s" type="surfaceshader">{given}</{model}>'))[1]

    for model, amount, film in (
        ("open_pbr_surface", "specular_retroreflectivity", "thin_film_weight"),
        ("standard_surface", "retroreflectivity", "thin_film_thickness"),
        ("gltf_pbr", "retroreflectivity", "iridescence"),
    ):
        assert lost(model, amount) == []
        assert [found.location for found in lost(model, amount, film)] == [f"/s/{film}"]
