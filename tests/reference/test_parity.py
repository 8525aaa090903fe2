"""Generated GLSL on a real driver against the reference, and wrong GLSL, which has to be caught."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.reference import Surface

NODES = ("conductor", "dielectric", "generalized_schlick")
SAMPLES = 4096

# Colours that no channel shares; two widths, neither of them special.
NUMBERS = {
    "conductor": '<input name="ior" type="color3" value="0.183, 0.421, 1.373"/>'
    '<input name="extinction" type="color3" value="3.424, 2.346, 1.77"/>',
    "dielectric": '<input name="ior" type="float" value="1.52"/><input name="tint" type="color3" value="0.9, 0.6, 0.3"/>',
    "generalized_schlick": '<input name="color0" type="color3" value="0.9, 0.5, 0.2"/>'
    '<input name="color82" type="color3" value="0.6, 0.8, 0.4"/>',
}


def node(name: str, kind: str, flag: str = "true", alpha: str = "0.31, 0.12", more: str = "") -> str:
    """A microfacet node of the document."""
    return (
        f'<{kind}_bsdf name="{name}" type="BSDF">{NUMBERS[kind]}{more}'
        f'<input name="roughness" type="vector2" value="{alpha}"/>'
        f'<input name="retroreflective" type="boolean" value="{flag}"/></{kind}_bsdf>'
    )


LAYERED = (
    node("coat", "dielectric", alpha="0.4, 0.2")
    + node("flakes", "generalized_schlick", more='<input name="weight" type="float" value="0.5"/>')
    + '<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value="0.8, 0.4, 0.2"/>'
    "</oren_nayar_diffuse_bsdf>"
    '<layer name="under" type="BSDF"><input name="top" type="BSDF" nodename="flakes"/>'
    '<input name="base" type="BSDF" nodename="paint"/></layer>'
    '<layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="coat"/>'
    '<input name="base" type="BSDF" nodename="under"/></layer>'
)

# The lobe's samples: those within a thousandth of its largest value, where what is seen of a surface comes from.
LOBE = 1e-3

# Share of the lobe's samples in which a planted error has to show.
MOST = 0.5


@pytest.fixture
def points(rng, direction_pairs, turned_points):
    """Samples of every kind, in random frames."""
    return turned_points(rng, *direction_pairs(rng, SAMPLES, 0.15))


@pytest.fixture
def differing(surface_document, drawn, points):
    """Function from nodes to the share of the lobe's samples in which GLSL and reference differ, and of all samples.

    Extra arguments damage the GLSL.
    """

    def compare(nodes: str, **damage) -> tuple[float, float]:
        document = surface_document(nodes)
        tolerance = Surface(document.getNode("m")).tolerance(points)
        wrong = tolerance.excess(drawn(document, points, **damage)) > 1.0
        lobe = np.max(tolerance.expected, axis=-1) > LOBE * tolerance.scale
        return float(np.mean(wrong[lobe])), float(np.mean(wrong))

    return compare


@pytest.mark.parametrize("kind", NODES)
@pytest.mark.parametrize("flag", ["true", "false"])
def test_glsl_agrees_with_the_reference(differing, kind, flag):
    assert differing(node("bsdf", kind, flag)) == (0.0, 0.0)


@pytest.mark.parametrize("kind", NODES)
def test_narrow_lobes_agree_with_the_reference(differing, kind):
    assert differing(node("bsdf", kind, alpha="0.0025, 0.01")) == (0.0, 0.0)


@pytest.mark.parametrize("kind", NODES)
def test_filmed_surfaces_agree_with_the_reference(differing, kind):
    film = (
        '<input name="thinfilm_thickness" type="float" value="0.35" unittype="distance" unit="micron"/>'
        '<input name="thinfilm_ior" type="float" value="1.33"/>'
    )
    assert differing(node("bsdf", kind, more=film)) == (0.0, 0.0)


def test_layers_agree_with_the_reference(differing):
    assert differing(LAYERED) == (0.0, 0.0)


@pytest.mark.parametrize("kind", NODES)
def test_the_upstream_library_with_its_own_flag_agrees_with_the_reference_too(
    surface_document, upstream_library, drawn, points, kind
):
    document = surface_document(node("bsdf", kind), upstream_library)
    tolerance = Surface(document.getNode("m")).tolerance(points)
    assert np.max(tolerance.excess(drawn(document, points, upstream_library))) <= 1.0


def test_colours_of_srgb_and_geometric_properties_agree_with_the_reference(surface_document, drawn, turned_points, rng):
    document = surface_document(
        '<geompropvalue name="w" type="float"><input name="geomprop" type="string" value="mask"/></geompropvalue>'
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="weight" type="float" nodename="w"/>'
        '<input name="color" type="color3" value="0.7, 0.3, 0.02" colorspace="srgb_texture"/>'
        '<input name="roughness" type="float" value="0.4"/></oren_nayar_diffuse_bsdf>'
    )
    v, l = (np.tile(d, (256, 1)) for d in ([0.6, 0.0, 0.8], [0.0, 0.28, 0.96]))
    points = turned_points(rng, v, l, {"mask": rng.uniform(0.1, 1.0, 256)})
    tolerance = Surface(document.getNode("m")).tolerance(points)
    found = drawn(document, points)
    assert np.max(tolerance.excess(found)) <= 1.0
    assert np.mean(tolerance.excess(found[::-1]) > 1.0) > MOST


# Planted errors: what is replaced in the generated source, by what.
MIRRORED = "(retroreflective && reflects) ? reflect(-closureData.V, N) : closureData.V"
DAMAGE = {
    "v is not mirrored": (MIRRORED, "closureData.V"),
    "v is mirrored at the tangent plane": (MIRRORED, MIRRORED.replace("reflect(-", "reflect(")),
    "the flag is ignored": ("bsdf_retroreflective, bsdf_thinfilm", "false, bsdf_thinfilm"),
    # Inside the wrapper's call V is v', and v again once mirrored back.
    "v is mirrored in D and left in Fresnel": ("clamp(dot(V, H), M_FLOAT_EPS", "clamp(dot(reflect(-V, N), H), M_FLOAT_EPS"),
    "the two widths are exchanged": ("mx_ggx_NDF(Ht, safeAlpha)", "mx_ggx_NDF(Ht, safeAlpha.yx)"),
    "one width serves for both": ("mx_ggx_NDF(Ht, safeAlpha)", "mx_ggx_NDF(Ht, vec2(avgAlpha))"),
    "energy compensation is left out": ("mx_ggx_energy_compensation(NdotV, avgAlpha, F);", "vec3(1.0);"),
    "masking has true widths' larger one": (
        "mx_ggx_smith_G2(NdotL, NdotV, avgAlpha)", "mx_ggx_smith_G2(NdotL, NdotV, max(safeAlpha.x, safeAlpha.y))",
    ),
    "the cosine comes twice": ("* weight / (4.0 * NdotV)", "* weight * NdotL / (4.0 * NdotV)"),
}  # fmt: skip


@pytest.mark.parametrize("kind", NODES)
@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_shader_is_caught(differing, kind, damage):
    old, new = DAMAGE[damage]
    assert differing(node("bsdf", kind), old=old, new=new)[0] > MOST


@pytest.mark.parametrize("kind", NODES)
def test_a_shader_that_always_retroreflects_is_caught(differing, kind):
    always = {"old": "(retroreflective && reflects)", "new": "(reflects)"}
    assert differing(node("bsdf", kind, "false"), **always)[0] > MOST


LAYER = "top.response + base.response * top.throughput"


@pytest.mark.parametrize(
    "wrong",
    [
        LAYER.replace("top.throughput", "base.throughput"),
        LAYER.replace(" * top.throughput", ""),
        "base.response + top.response * base.throughput",
    ],
    ids=["of the base", "left out", "the other way round"],
)
def test_a_layer_with_the_wrong_throughput_is_caught(differing, wrong):
    assert differing(LAYERED, old=LAYER, new=wrong)[0] > MOST


def test_a_throughput_of_the_wrong_node_is_caught(differing):
    # The inner layer's base seen through the outer layer's top.
    old, new = "mx_layer_bsdf(closureData, flakes_out, paint_out, under_out);", (
        "under_out.response = flakes_out.response + paint_out.response * coat_out.throughput;"
        "under_out.throughput = coat_out.throughput * paint_out.throughput;"
    )
    assert differing(LAYERED, old=old, new=new)[0] > MOST
