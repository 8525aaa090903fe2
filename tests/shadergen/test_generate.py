"""Generating source for every target, and what comes with it."""

from __future__ import annotations

import re
from dataclasses import replace

import MaterialX as mx
import pytest

import mrm_mtlx as mrm
from mrm_mtlx.library import DataLibrary, Origin, dialects
from mrm_mtlx.shadergen import (
    TARGETS,
    GenerationError,
    MissingCodeError,
    available_targets,
    generate,
    lacking_targets,
    renderable_elements,
)
from mrm_mtlx.shadergen.targets import Target
from tests.fixtures.versions import newest_closures, own_flag, since

NODES = ("dielectric", "conductor", "generalized_schlick")
# Those of the installed MaterialX.
HARDWARE = tuple(name for name in available_targets() if TARGETS[name].hardware)
OTHERS = tuple(name for name in available_targets() if not TARGETS[name].hardware and name != "osl")

by_node = pytest.mark.parametrize("node", NODES)
by_flag = pytest.mark.parametrize("flag", ["true", "false"])


@pytest.fixture(scope="module")
def shader(surface_document, library):
    """Function from a node, the flag and a target to the generated shader."""

    def make(node: str, flag: str, target: str, data: DataLibrary = library):
        document = surface_document(
            f'<{node}_bsdf name="bsdf" type="BSDF">'
            f'<input name="retroreflective" type="boolean" value="{flag}"/></{node}_bsdf>',
            data,
        )
        (element,) = renderable_elements(document)
        return generate(element, target, data)

    return make


@since("1.39.5", "generator for Slang")
def test_the_installed_materialx_generates_all_eight_targets():
    assert available_targets() == ("glsl", "essl", "vulkan", "msl", "slang", "wgsl", "osl", "mdl")


@by_node
@by_flag
@pytest.mark.parametrize("target", HARDWARE)
@newest_closures
def test_the_glsl_family_gets_the_wrapper(shader, node, flag, target):
    made = shader(node, flag, target)
    assert set(made.sources) == set(TARGETS[target].suffixes)
    pixel = made.sources["pixel"]
    assert pixel.count(f"void mrm_{node}_bsdf(") == 1
    # Called for a light, for the environment and, unless it is known to reflect only, for transmission.
    assert pixel.count(f"mrm_{node}_bsdf(closureData, ") == (2 if node == "conductor" else 3)
    assert pixel.count("ClosureData mrm_mirror_view(") == 1
    # The standard function is called by the wrapper alone, with its own flag off.
    assert pixel.count(f"mx_{node}_bsdf(") == 2
    assert f"mx_{node}_bsdf(mirrored, " in pixel


@by_node
@pytest.mark.parametrize("target", HARDWARE)
@own_flag
def test_the_upstream_library_has_no_wrapper(shader, upstream_library, node, target):
    pixel = shader(node, "true", target, upstream_library).sources["pixel"]
    assert "mrm_" not in pixel
    assert f"mx_{node}_bsdf(closureData, " in pixel


@by_node
@by_flag
@pytest.mark.parametrize("target", OTHERS)
def test_targets_of_other_families_generate_with_the_stock_implementation(shader, node, flag, target):
    pixel = shader(node, flag, target).sources["pixel"]
    assert "mrm_" not in pixel
    assert node in pixel


@by_node
@by_flag
@pytest.mark.parametrize("target", available_targets())
def test_the_same_document_gives_the_same_bytes(shader, node, flag, target):
    assert shader(node, flag, target) == shader(node, flag, target)


@by_node
@pytest.mark.parametrize("target", HARDWARE)
def test_the_flag_reaches_the_shaders_interface(shader, node, target):
    for flag, value in (("true", True), ("false", False)):
        ports = {port.path: port for port in shader(node, flag, target).uniforms}
        port = ports["bsdf/retroreflective"]
        assert bool(port.value) is value
        # WGSL knows no booleans in uniforms, and MaterialX since 1.39.5 makes them integers there.
        expected = "integer" if target == "wgsl" and dialects.installed().has_retroreflective else "boolean"
        assert port.type == expected


@pytest.mark.parametrize("target", ["glsl", "essl"])
def test_uniforms_carry_their_values_types_and_paths(shader, target):
    ports = {port.variable: port for port in shader("conductor", "true", target).uniforms}
    extinction = ports["bsdf_extinction"]
    assert (extinction.type, extinction.path) == ("color3", "bsdf/extinction")
    # As float32 holds them, which is what the shader gets.
    assert extinction.value == tuple(mx.Color3(3.424, 2.346, 1.770).asTuple())
    assert ports["u_envMatrix"].value is not None
    assert len(ports["u_envMatrix"].value) == 16
    assert ports["u_viewPosition"].value is None
    # Each is declared as a uniform of its own; the light's are members of an array.
    pixel = shader("conductor", "true", target).sources["pixel"]
    assert [name for name in ports if not re.search(rf"^uniform \w+ {name}\b", pixel, re.MULTILINE)] == []


def test_inputs_name_what_varies_over_the_surface(shader):
    for target, block in (("glsl", "vd"), ("essl", "")):
        made = shader("conductor", "true", target)
        assert {port.variable for port in made.inputs} == {"normalWorld", "tangentWorld", "positionWorld"}
        assert made.input_block == block
        assert all(f"{block}.{port.variable}".lstrip(".") in made.sources["pixel"] for port in made.inputs)
    assert shader("conductor", "true", "osl").inputs == ()


def test_lights_and_environment_have_their_place_in_the_shader(shader):
    pixel = shader("conductor", "true", "glsl").sources["pixel"]
    assert "u_lightData[" in pixel
    assert "u_envRadianceSamples" in pixel  # filtered importance sampling
    assert "mx_directional_light(light" in pixel
    assert "mx_point_light(light" in pixel


def test_renderable_elements_are_materials_and_loose_shaders(make_document):
    assert renderable_elements(make_document("")) == []
    surfaces = "".join(f'<surface name="{name}" type="surfaceshader"/>' for name in "ab")
    materials = "".join(
        f'<surfacematerial name="{m}" type="material">'
        f'<input name="surfaceshader" type="surfaceshader" nodename="{s}"/></surfacematerial>'
        for m, s in (("second", "b"), ("first", "a"))
    )
    # In the order of the file, not of the names.
    assert [e.getName() for e in renderable_elements(make_document(surfaces + materials))] == ["second", "first"]


# An implementation whose source file does not exist.
BROKEN = """
<nodedef name="ND_broken_bsdf" node="broken_bsdf"><output name="out" type="BSDF"/></nodedef>
<implementation name="IM_broken" nodedef="ND_broken_bsdf" function="f" file="no_such_file.glsl" target="genglsl"/>
<implementation name="IM_broken_osl" nodedef="ND_broken_bsdf" function="f" file="no_such_file.osl" target="genosl"/>
<broken_bsdf name="bsdf" type="BSDF"/>
"""


@pytest.mark.parametrize(
    "target", [name for name in available_targets() if name in ("glsl", "essl", "msl", "slang", "osl")]
)
def test_a_missing_source_file_is_a_generation_error_with_materialxs_words(surface_document, library, target):
    document = surface_document(BROKEN)
    with pytest.raises(GenerationError, match="no_such_file"):
        generate(document.getNode("m"), target, library)


@pytest.mark.parametrize("target", available_targets())
def test_a_node_without_implementation_is_a_generation_error(make_document, library, target):
    document = make_document(
        '<unheard_of name="bsdf" type="BSDF"/>'
        '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>'
    )
    with pytest.raises(GenerationError, match="bsdf"):
        generate(document.getNode("s"), target, library)


def test_an_element_that_is_no_surface_is_a_generation_error(make_document, library):
    document = make_document('<nodegraph name="empty"/>')
    with pytest.raises(GenerationError, match=r"\S"):
        generate(document.getNodeGraph("empty"), "glsl", library)


def test_an_unknown_target_is_a_key_error(surface_document, library):
    with pytest.raises(KeyError, match="hlsl"):
        generate(surface_document('<conductor_bsdf name="bsdf" type="BSDF"/>').getNode("m"), "hlsl", library)


def test_a_target_that_this_materialx_lacks_is_an_import_error_with_its_name():
    with pytest.raises(ImportError, match="no generator for later"):
        Target("later", "PyMaterialXGenGlsl", "LaterShaderGenerator", True, {}).create()
    with pytest.raises(ImportError, match="PyMaterialXGenLater"):
        replace(TARGETS["glsl"], module="PyMaterialXGenLater").create()


def test_the_libraries_are_not_changed_by_generating(shader, library, upstream_library):
    before = mx.writeToXmlString(library.document)
    shader("conductor", "true", "glsl")
    assert mx.writeToXmlString(library.document) == before
    assert (library.origin, upstream_library.origin) == (Origin.MRM, Origin.UPSTREAM)


EMITTER = (
    '<{0} name="e" type="EDF"/><surface name="s" type="surfaceshader"><input name="edf" type="EDF" nodename="e"/>'
    '</surface><surfacematerial name="m" type="material">'
    '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
)


@pytest.mark.parametrize("node", ["conical_edf", "measured_edf"])
def test_a_node_that_the_libraries_have_no_code_of_is_named(make_document, library, node):
    document = make_document(EMITTER.format(node))
    with pytest.raises(MissingCodeError, match=f"no code of {node} for this target"):
        generate(document.getNode("m"), "glsl", library)


def test_a_node_inside_of_a_graph_that_the_libraries_have_no_code_of_is_named(make_document, library):
    inside = EMITTER.format("conical_edf").partition("<surfacematerial")[0]
    definition = '<nodedef name="ND_lamp" node="lamp"><output name="out" type="surfaceshader"/></nodedef>'
    graph = (
        f'<nodegraph name="NG_lamp" nodedef="ND_lamp">{inside}<output name="out" type="surfaceshader" nodename="s"/>'
    )
    lamp = '<lamp name="s" type="surfaceshader"/>' + "<surfacematerial" + EMITTER.partition("<surfacematerial")[2]
    document = make_document(f"{definition}{graph}</nodegraph>{lamp}")
    with pytest.raises(MissingCodeError, match="conical_edf"):
        generate(document.getNode("m"), "glsl", library)


def test_a_node_of_the_documents_own_without_an_implementation_is_its_mistake(make_document, library):
    definition = '<nodedef name="ND_own" node="own"><output name="out" type="EDF"/></nodedef>'
    document = make_document(definition + EMITTER.format("own"))
    with pytest.raises(GenerationError) as caught:
        generate(document.getNode("m"), "glsl", library)
    assert not isinstance(caught.value, MissingCodeError)


TYPE_OF_THE_DOCUMENT = """
  <typedef name="pair">
    <member name="first" type="float" value="0.5"/><member name="second" type="float" value="0.5"/>
  </typedef>
  <nodedef name="ND_second" node="second">
    <input name="in" type="pair" value="{0.1;0.1}"/><output name="out" type="float"/>
  </nodedef>
  <implementation name="IM_second" nodedef="ND_second" target="genglsl" sourcecode="{{in}}.second"/>
  <second name="n" type="float"><input name="in" type="pair" value="{0.25;0.75}"/></second>
  <output name="o" type="float" nodename="n"/>
"""


@pytest.mark.parametrize("target", ["glsl", "essl"])
@since("1.39.3", "code for types of documents")
def test_a_type_that_the_document_defines_is_known(make_document, library, target):
    document = make_document(TYPE_OF_THE_DOCUMENT)
    shader = generate(document.getOutput("o"), target, library)
    assert "struct pair" in shader.sources["pixel"]
    assert {p.variable: p.value for p in shader.uniforms}["n_in"] == "{0.25;0.75}"


@pytest.mark.parametrize(
    ("target", "name", "expected"),
    [
        ("osl", "float", "float1"),
        ("osl", "BSDF", "BSDF1"),
        ("osl", "__LINE__", "__LINE__1"),
        ("osl", "material", "material"),
        ("mdl", "material", "material1"),
        ("mdl", "float3x3", "float3x31"),
        ("mdl", "float5", "float5"),
        ("glsl", "float", "float"),
    ],
)
@since("1.39.5", "shader named as its output")
def test_a_shader_is_not_named_as_a_word_of_its_language(make_document, library, target, name, expected):
    graph = f'<nodegraph name="g"><noise2d name="n" type="float"/><output name="{name}" type="float" nodename="n"/>'
    document = make_document(f"{graph}</nodegraph>")
    (element,) = renderable_elements(document)
    made = generate(element, target, library)
    assert made.name == expected
    if target != "glsl":
        assert re.search(rf"\b(shader|material) {expected}\b", made.sources["pixel"])


def planar(space_of_x: str, space_of_y: str, kind: str = "color3", given: str = 'value="a.png"') -> str:
    files = f'<input name="filex" type="filename" {given} {space_of_x}/>'
    files += f'<input name="filey" type="filename" {given} {space_of_y}/>'
    node = f'<triplanarprojection name="t" type="{kind}">{files}</triplanarprojection>'
    return f'<nodegraph name="g"><input name="f" type="filename"/>{node}<output name="o" type="{kind}" nodename="t"/>'


SRGB, ACESCG = 'colorspace="srgb_texture"', 'colorspace="acescg"'


@pytest.mark.parametrize(
    "graph",
    [
        planar(SRGB, SRGB),
        planar(SRGB, ACESCG),
        planar(SRGB, SRGB, given='interfacename="f"'),
        planar("", "").replace("<nodegraph", f"<nodegraph {ACESCG}"),
    ],
)
def test_two_files_in_a_colour_space_on_one_node_are_refused_before_materialx_dies(make_document, library, graph):
    document = make_document(f"{graph}</nodegraph>")
    (element,) = renderable_elements(document)
    with pytest.raises(GenerationError, match="two files in a colour space on one node; transform what 'g/t' gives"):
        generate(element, "glsl", library)


@pytest.mark.parametrize(
    "graph",
    [
        planar(SRGB, ""),
        planar(SRGB, 'colorspace="lin_rec709"'),
        planar(SRGB, SRGB, kind="float"),
        planar(SRGB, SRGB, given=""),
        planar(SRGB, SRGB).replace('nodename="t"', 'nodename="c"') + '<constant name="c" type="color3"/>',
    ],
)
def test_one_transform_behind_a_node_is_generated(make_document, library, graph):
    document = make_document(f"{graph}</nodegraph>")
    (element,) = renderable_elements(document)
    assert generate(element, "glsl", library).sources["pixel"]


def test_a_target_that_this_version_lacks_is_named_with_the_version(monkeypatch, tmp_path):
    monkeypatch.setattr("mrm_mtlx.shadergen.all_targets", lambda: ("glsl", "essl"))
    monkeypatch.setattr("mrm_mtlx.shadergen.lacking_targets", lambda: ("slang",))
    with pytest.raises(mrm.ArgumentError, match=r"slang: MaterialX 1\.39\.\d has no generator for slang; expected one"):
        mrm.generate(tmp_path / "any.mtlx", target="slang")
    with pytest.raises(mrm.ArgumentError, match=r"hlsl: expected one of glsl, essl$"):
        mrm.generate(tmp_path / "any.mtlx", target="hlsl")


def test_the_targets_of_all_versions_are_there_or_lacking():
    assert {*available_targets(), *lacking_targets()} == set(TARGETS)
    assert not {*available_targets()} & {*lacking_targets()}
