"""Surface models with an amount: the blend of two models, whole documents on the targets, and errors that are seen."""

from __future__ import annotations

from dataclasses import replace

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.engines import osl
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import Origin, dialects, load_library, surface_models
from mrm_mtlx.library.surface_models import SURFACE_MODELS
from mrm_mtlx.reference import Environment, Illumination, ShadingPoints, Surface
from mrm_mtlx.render.ordinary import ordinary_copy
from mrm_mtlx.shadergen import generate
from mrm_mtlx.shadergen.precision import with_highp
from mrm_mtlx.validation.checks.retroreflection import (
    UNSEEN,
    check_retroreflection,
    is_retroreflective,
    retroreflecting_nodes,
)
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.closures import compare_closures, sun_points
from mrm_mtlx.validation.comparison.expectation import Expectation
from mrm_mtlx.validation.comparison.samples import draw
from mrm_mtlx.validation.flag_use import ignores_flag
from mrm_mtlx.validation.retro_sweep import flattened, variants

OPEN_PBR, STANDARD, GLTF = SURFACE_MODELS
# What the base's specular lobes are called in the graphs of MaterialX 1.39.5, flattened: the statement that the models
# are held to.
BASE = {
    OPEN_PBR: ("dielectric_reflection", "dielectric_reflection_tf", "metal_bsdf", "metal_bsdf_tf"),
    STANDARD: ("specular_bsdf", "metal_bsdf"),
    GLTF: ("reflection_bsdf", "tf_reflection_bsdf", "metal_bsdf", "tf_metal_bsdf"),
}
MODELS = pytest.mark.parametrize("model", SURFACE_MODELS, ids=lambda model: model.node)

# An amount that float32 holds, so that the document's is the test's.
BETWEEN = 0.375

# Inputs that are drawn from other ranges than 0.2 to 0.8, or left as they are (None); everything of a model is then on.
RANGES = {
    **dict.fromkeys(("specular_ior", "coat_ior", "specular_IOR", "coat_IOR", "ior"), (1.3, 1.8)),
    **dict.fromkeys(("thin_film_ior", "thin_film_IOR", "iridescence_ior"), (1.2, 1.5)),
    "thin_film_thickness": (0.2, 0.8),  # micrometres in OpenPBR; see STANDARD below
    "iridescence_thickness": (200.0, 800.0),
    # Lit surfaces are compared: neither their own light, nor what hides them, nor what has no hardware meaning.
    **dict.fromkeys(("emission", "emission_luminance", "emissive_strength", "emissive", "opacity"), None),
    **dict.fromkeys(("geometry_opacity", "alpha", "alpha_cutoff", "occlusion", "emission_color"), None),
}


def parameters(rng, model, library):
    """A value for every number and colour of a model, by name."""
    definition = library.document.getNodeDef(f"ND_{model.node}_surfaceshader")
    values = {}
    for given in definition.getActiveInputs():
        low, high = RANGES.get(given.getName(), (0.2, 0.8)) or (None, None)
        if low is None or given.getType() not in ("float", "color3"):
            continue
        if model is STANDARD and given.getName() == "thin_film_thickness":
            low, high = 200.0, 800.0  # nanometres
        drawn = np.round(rng.uniform(low, high, 3 if given.getType() == "color3" else 1), 3)
        values[given.getName()] = mx.Color3(*map(float, drawn)) if len(drawn) == 3 else float(drawn[0])
    return values


def document_of(model, values, library, amount=None):
    """A material of one surface model; with its amount if there is one."""
    document = mx.createDocument()
    document.setDataLibrary(library.document)
    node = document.addNode(model.node, "model", "surfaceshader")
    for name, value in values.items():
        node.setInputValue(name, value)
    if amount is not None:
        node.setInputValue(model.amount, amount)
    document.addMaterialNode("m", node)
    valid, message = document.validate()
    assert valid, message
    return document


def flagged(model, values, library):
    """The unmodified model, flattened, with the flag on in the lobes of its base."""
    document = flattened(document_of(model, values, library))
    for name in BASE[model]:
        document.getNode(name).setInputValue("retroreflective", True)
    return document


def samples(rng, count=512):
    """Samples in and about the peaks of ordinary and retroreflective lobes, one in eight lit from below."""
    shapes = [sampling.LobeShape(0.1, 0.1, flag) for flag in (False, True)]
    v, l = sampling.sample_local(rng, count, shapes)
    l[::8, 2] *= -1.0
    return sampling.shading_points(rng, v, l)


IN_ENVIRONMENT = Illumination(light=False, environment=Environment.constant((1.0, 0.75, 0.5), 8))


def shown(document, points):
    """What a document shows under a light and, at a few of the points, in an environment; (samples, 3)."""
    surface = Surface(document.getNode("m"))
    return np.concatenate([surface.shade(points), surface.shade(points.part(slice(0, 32)), IN_ENVIRONMENT)])


@MODELS
def test_0_is_the_unmodified_model_and_1_the_flag_in_its_base_digit_by_digit_with_the_linear_blend_between(
    rng, library, model
):
    values, points = parameters(rng, model, library), samples(rng)
    none, between, all_of_it = (shown(document_of(model, values, library, x), points) for x in (0.0, BETWEEN, 1.0))
    # MaterialX before 1.39.5 has mixtures in its graphs that leave 6e-16 of it.
    rounding = 0.0 if dialects.installed().has_retroreflective else 8 * 2.0**-53
    assert np.allclose(none, shown(document_of(model, values, library), points), rtol=rounding, atol=0.0)
    assert np.allclose(all_of_it, shown(flagged(model, values, library), points), rtol=rounding, atol=0.0)
    # Both are sums of a few dozen products of numbers that are not negative; each rounds by 2^-53.
    assert np.allclose(between, (1.0 - BETWEEN) * none + BETWEEN * all_of_it, rtol=100 * 2.0**-53, atol=1e-15)
    assert np.isfinite(all_of_it).all()
    assert np.max(all_of_it / np.maximum(none, 1e-3)) > 10.0  # else the amount would do nothing


def catching_coats(monkeypatch):
    monkeypatch.setattr(surface_models, "_interface_names", lambda _given: ["specular_roughness", "roughness"])


def missing_films(monkeypatch):
    every = surface_models._base_lobes
    with_film = ("thinfilm_thickness", "thinfilm_ior")

    def without_film(*arguments):
        return [node for node in every(*arguments) if not any(node.getInput(name) for name in with_film)]

    monkeypatch.setattr(surface_models, "_base_lobes", without_film)


@pytest.mark.parametrize("damage", [catching_coats, missing_films])
@MODELS
def test_a_transformation_of_other_nodes_is_seen(rng, library, monkeypatch, model, damage):
    damage(monkeypatch)
    wrong = library.document.copy()
    for each in SURFACE_MODELS:
        wrong.removeNodeDef(each.definition)
        wrong.removeNodeGraph(each.graph)
    reasons = [extension.reason for extension in surface_models.extend(wrong)]
    if damage is missing_films and model is STANDARD:
        assert "no reflecting microfacet node" in reasons[1]  # all of its lobes have a film
        return
    values, points = parameters(rng, model, library), samples(rng, 128)
    documents = (
        document_of(model, values, replace(library, document=wrong), 1.0),
        flagged(model, values, library),
    )
    found, expected = (Surface(document.getNode("m")).shade(points) for document in documents)
    assert not np.allclose(found, expected, rtol=1e-3)


# What makes that of a base which a light l sees depend on l: coat and cloth, diffuse roughness. See below.
UPPER = {
    OPEN_PBR: ("coat_weight", "fuzz_weight", "base_diffuse_roughness"),
    STANDARD: ("coat", "sheen", "diffuse_roughness"),
    GLTF: ("clearcoat", "sheen_color"),
}


@pytest.mark.parametrize(
    ("bare", "tolerance"),
    [
        # Sums of 600 numbers; v' and l' are rounded, which a lobe of alpha 0.04 multiplies by 1 / alpha^2.
        pytest.param(True, 1e-11, id="the base alone"),
        # MaterialX takes what a layer lets through from the Fresnel term at the half-vector of v and l. So it depends
        # on l, and light that comes back passes another share than mirrored light: of 75 draws, 3e-4 more at most up to
        # 60 degrees, 3.5e-3 at 88. The flag in a layer of standard nodes does the same.
        pytest.param(False, 5e-3, id="with coat and cloth"),
    ],
)
@MODELS
def test_as_much_light_is_reflected_as_by_the_unmodified_model(rng, library, model, bare, tolerance):
    # f_retro(v, l) = f(v, l'), l' = l mirrored about n, as distributions are the same at m and m mirrored. A set of l
    # that holds l' with each l sums both to the same albedo; the layers around the base see the same albedo of it.
    values = parameters(rng, model, library)
    values = {name: value for name, value in values.items() if not (bare and name in UPPER[model])}
    l = sampling.spherical(rng.random(300), rng.random(300))
    theta = np.deg2rad([0.0, 35.0, 70.0, 88.0])
    v = np.stack([np.sin(theta), np.zeros(4), np.cos(theta)], axis=1)
    pairs = np.repeat(v, 600, axis=0), np.tile(np.concatenate([l, l * [-1.0, -1.0, 1.0]]), (4, 1))
    unmodified, between, all_of_it = (
        np.sum(lit(document_of(model, values, library, amount), *pairs).reshape(4, 600, 3), axis=1)
        for amount in (None, BETWEEN, 1.0)
    )
    assert np.allclose(between, unmodified, rtol=tolerance)
    assert np.allclose(all_of_it, unmodified, rtol=tolerance)


def lit(document, v, l):
    """Response of a flat surface, seen along v, to light from l; (directions, 3)."""
    axes = (np.broadcast_to(axis, l.shape) for axis in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    points = ShadingPoints(np.broadcast_to(v, l.shape), l, *axes, np.zeros_like(l), np.zeros((len(l), 2)))
    return Surface(document.getNode("m")).response(points)


ROWS = [(model, *row) for model in SURFACE_MODELS for row in UNSEEN[model.node]]


@pytest.mark.parametrize(("model", "off", "reason"), ROWS, ids=[f"{m.node}: {reason}" for m, _, reason in ROWS])
def test_coat_sheen_and_transmission_are_unchanged_and_a_base_that_reflects_nothing_is_reported(
    rng, library, model, off, reason
):
    values = parameters(rng, model, library)
    values |= {n: mx.Color3(x, x, x) if isinstance(values[n], mx.Color3) else x for n, x in off.items()}
    documents = [document_of(model, values, library, amount) for amount in (0.0, 1.0)]
    points = samples(rng, 256)
    none, all_of_it = (shown(document, points) for document in documents)
    # A black tint leaves what the layer lets through, which depends on the half-vector (see above): up to 1e-2 of it.
    assert np.allclose(none, all_of_it, rtol=2e-2, atol=1e-5)
    assert np.max(none) > 0.0
    assert [(f.code, f.message) for f in check_retroreflection(documents[1])] == [("RETRO_INVISIBLE", reason)]
    assert check_retroreflection(documents[0]) == []
    for name in off:  # each of them is needed
        if name in (model.amount, "thin_film_weight", "coat_weight", "thin_film_thickness"):
            continue
        visible = document_of(model, values | {name: parameters(rng, model, library)[name]}, library, 1.0)
        assert check_retroreflection(visible) == []


@MODELS
def test_light_from_below_is_let_through_as_by_the_unmodified_model(rng, library, model):
    values = parameters(rng, model, library)
    if model is not GLTF:  # which lets no light of a lamp through
        values[{OPEN_PBR: "geometry_thin_walled", STANDARD: "thin_walled"}[model]] = True
    below = sampling.spherical(rng.random(64), rng.random(64)) * [1.0, 1.0, -1.0]
    v = np.array([0.6, 0.0, 0.8])
    unmodified, retroreflective = (lit(document_of(model, values, library, a), v, below) for a in (None, 1.0))
    # Lobes clamp n.l at 1e-8 where it is negative, and show as much of what they would above; layers as above.
    assert np.allclose(unmodified, retroreflective, rtol=5e-3, atol=1e-6)
    assert bool(np.max(unmodified) > 1e-3) is (model is not GLTF)


def test_the_ordinary_copy_of_a_document_has_an_amount_of_0(rng, library):
    values = parameters(rng, OPEN_PBR, library)
    copy = ordinary_copy(document_of(OPEN_PBR, values, library, 1.0))
    assert copy.getNode("model").getInputValue(OPEN_PBR.amount) == 0.0
    with pytest.raises(ValueError, match="nothing to compare"):
        ordinary_copy(document_of(OPEN_PBR, values, library))


def test_the_sweep_leaves_out_the_lobes_that_are_retroreflective_in_part(rng, library):
    copy = flattened(document_of(STANDARD, parameters(rng, STANDARD, library), library, BETWEEN))
    assert [variant.name for variant in variants(copy.getNode("m"))] == ["transmission_bsdf", "coat_bsdf"]


# On the targets. A driver takes ten seconds for a shader of an extended model, so that one stands for all of them here:
# the graphs of the others differ in nothing that is ours. Ready materials and assets have the others.


def test_an_amount_that_is_an_image_is_drawn_as_the_reference_has_it(gl, rng, library):
    pixels = np.linspace(-0.1, 1.1, 16, dtype=np.float32).reshape(4, 4, 1)  # beyond both ends: clamped
    document = document_of(STANDARD, parameters(rng, STANDARD, library), library, 0.0)
    image = document.addNode("image", "where", "float")
    image.setInputValue("file", "where.exr", "filename")
    document.getNode("model").getInput(STANDARD.amount).setConnectedNode(image)
    element = document.getNode("m")
    shader = with_highp(generate(element, "essl", library))
    (file,) = [port.variable for port in shader.uniforms if port.path == "where/file"]
    expectation = Expectation(element, rng, 256, lambda _name: pixels)
    with SurfaceProgram(shader, {file: pixels}) as program:
        assert expectation.compare(expectation.draw(program)).comparison.passed


LOBE = """
  <{prefix}generalized_schlick_bsdf name="lobe" type="BSDF">
    <input name="color0" type="color3" value="0.3, 0.2, 0.1"/><input name="weight" type="float" value="0.8"/>
    <input name="roughness" type="vector2" value="0.2, 0.1"/>{amount}
  </{prefix}generalized_schlick_bsdf>
  <oren_nayar_diffuse_bsdf name="paint" type="BSDF"/>
  <layer name="bsdf" type="BSDF">
    <input name="top" type="BSDF" nodename="lobe"/><input name="base" type="BSDF" nodename="paint"/>
  </layer>
"""


def test_lobes_of_amount_0_are_drawn_bit_by_bit_as_the_standard_ones(gl, rng, surface_document, library):
    # What alone is another in the graph of an extended model. All three models were measured so, in GLSL and in ESSL.
    none = LOBE.format(prefix="mrm_", amount='<input name="retroreflectivity" type="float" value="0"/>')
    points, drawn = samples(rng), []
    for text in (none, LOBE.format(prefix="", amount="")):
        document = surface_document(text)
        with SurfaceProgram(generate(document.getNode("m"), "glsl", library), {}) as program:
            drawn.append(draw(program, points).colors)
    assert np.array_equal(*drawn)
    assert np.max(drawn[0]) > 1.0


PLAIN = """<?xml version="1.0"?>
<materialx version="1.39">
  <{node} name="model" type="surfaceshader"><input name="{amount}" type="float" value="0.5"/></{node}>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="model"/>
  </surfacematerial>
</materialx>
"""


@pytest.fixture
def plain(tmp_path):
    """Function from a model to a file with a material of it, partly retroreflective, and the text of the file."""

    def write(model):
        text = PLAIN.format(node=model.node, amount=model.amount)
        (tmp_path / "plain.mtlx").write_text(text, encoding="utf-8")
        return tmp_path / "plain.mtlx", text

    return write


@MODELS
def test_the_standard_library_has_no_such_input(check, plain, model):
    (result,) = check(plain(model)[0], origin=Origin.UPSTREAM)
    assert [(f.code, f.location) for f in result.findings] == [("RETRO_UNDEFINED", f"/model/{model.amount}")]


def test_mdl_does_not_honour_an_amount(library):
    document = document_of(GLTF, {}, library, 0.5)
    assert [node.getName() for node in retroreflecting_nodes(document) if is_retroreflective(node)] == ["model"]
    assert ignores_flag(generate(document.getNode("m"), "mdl", library), "model")


# Of OpenPBR in the installed MaterialX.
OWN_VERSION = load_library().document.getNodeDef("ND_open_pbr_surface_surfaceshader").getVersionString()


def test_a_definition_that_is_named_and_one_of_another_version_say_what_they_lack(check, plain):
    path, text = plain(OPEN_PBR)
    path.write_text(text.replace('name="model"', 'name="model" nodedef="ND_open_pbr_surface_surfaceshader"'))
    assert [f.code for f in check(path)[0].findings] == ["RETRO_UNDEFINED"]
    path.write_text(text.replace('name="model"', 'name="model" version="1.2"'))
    (found,) = check(path)[0].findings
    assert (found.code, found.message) == (
        "DOC_UNKNOWN_NODE",
        f"version 1.2 of 'open_pbr_surface' is not defined; it exists in {OWN_VERSION}",
    )


@MODELS
def test_in_cycles_it_is_the_unmodified_model_at_0_the_flag_in_its_base_at_1_and_their_blend_between(
    cycles, rng, library, model
):
    # Left out is what Cycles does not light, or lights by chance: media, which make the whole surface black, and
    # scattering below the surface. White and without film, as Cycles' layers take the largest channel's albedo.
    left_out = ("transmission", "subsurface", "thin_film", "iridescence", "specular_color", "base_color")
    values = {n: v for n, v in parameters(rng, model, library).items() if not n.startswith(left_out)}
    groups = sun_points(rng, 40, [sampling.LobeShape(0.1, 0.1, flag) for flag in (False, True)])[::4]
    # Each sun lights all of its facets for each amount; documents are compared at facets in the same place.
    normals = np.concatenate([np.tile(group.normal, (3, 1)) for group in groups])
    amounts = np.tile(np.repeat([0.0, BETWEEN, 1.0], len(groups[0])), len(groups))

    def measured(document, **inputs):
        shader = osl.compile_for_cycles(generate(document.getNode("m"), "osl", library).sources["pixel"], "document")
        return osl.direct_light_by_groups(shader, normals, inputs, [group.light for group in groups])

    found = measured(document_of(model, values, library, BETWEEN), **{f"model_{model.amount}": amounts})
    none, between, all_of_it = (found[amounts == amount] for amount in (0.0, BETWEEN, 1.0))
    assert np.array_equal(none, measured(document_of(model, values, library))[amounts == 0.0])
    assert np.array_equal(all_of_it, measured(flagged(model, values, library))[amounts == 1.0])
    # Cycles' albedo of a layer's top is the largest channel's, which is not linear; the facets' places move the rest.
    assert np.allclose(between, (1.0 - BETWEEN) * none + BETWEEN * all_of_it, rtol=1e-3, atol=1e-5)
    assert np.max(all_of_it / np.maximum(none, 1e-3)) > 10.0


def test_in_cycles_a_metal_agrees_with_the_reference(cycles, library):
    document = document_of(GLTF, {"metallic": 1.0, "roughness": 0.5}, library, 1.0)
    rng = sampling.generator(0, "metal")
    assert compare_closures(document.getNode("m"), library, 8 * 12 * 40, rng, osl.CYCLES.bench).passed
