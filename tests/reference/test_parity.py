"""Generated GLSL on a real driver against the reference, and wrong GLSL, which has to be caught."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.reference import Surface
from tests.fixtures.versions import own_flag

NODES = ("conductor", "dielectric", "generalized_schlick")
SAMPLES = 4096

# Colours that no channel shares; two widths, neither of them special.
NUMBERS = {
    "conductor": '<input name="ior" type="color3" value="0.183, 0.421, 1.373"/>'
    '<input name="extinction" type="color3" value="3.424, 2.346, 1.77"/>',
    "dielectric": '<input name="ior" type="float" value="1.52"/>'
    '<input name="tint" type="color3" value="0.9, 0.6, 0.3"/>',
    "generalized_schlick": '<input name="color0" type="color3" value="0.9, 0.5, 0.2"/>'
    '<input name="color82" type="color3" value="0.6, 0.8, 0.4"/>',
}


def node(
    name: str, kind: str, *, flag: str = "true", alpha: str = "0.31, 0.12", film: str = "0", more: str = ""
) -> str:
    """A microfacet node of the document."""
    return (
        f'<{kind}_bsdf name="{name}" type="BSDF">{NUMBERS[kind]}{more}'
        f'<input name="roughness" type="vector2" value="{alpha}"/>'
        f'<input name="retroreflective" type="boolean" value="{flag}"/>'
        f'<input name="thinfilm_thickness" type="float" value="{film}"/>'
        f'<input name="thinfilm_ior" type="float" value="1.33"/></{kind}_bsdf>'
    )


# A coat, half of it taken away by a mix with nothing, over paint: two nodes of different throughput, one to layer with.
LAYERED = (
    node("coat", "dielectric", alpha="0.4, 0.2")
    + '<mix name="veil" type="BSDF"><input name="fg" type="BSDF" nodename="coat"/>'
    '<input name="mix" type="float" value="0.5"/></mix>'
    '<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" value="0.8, 0.4, 0.2"/>'
    '</oren_nayar_diffuse_bsdf><layer name="bsdf" type="BSDF"><input name="top" type="BSDF" nodename="veil"/>'
    '<input name="base" type="BSDF" nodename="paint"/></layer>'
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


# What one program is drawn with, and the document of the same numbers that it has to agree with.
VARIANTS = {
    "retroreflective": {},
    "ordinary": {"flag": "false"},
    "narrow": {"alpha": "0.0025, 0.01"},
    "narrow and ordinary": {"alpha": "0.0025, 0.01", "flag": "false"},
    "filmed": {"film": "350"},
    "narrow and filmed": {"alpha": "0.01, 0.005", "film": "800"},
}


@pytest.mark.parametrize("kind", NODES)
@pytest.mark.parametrize("variant", VARIANTS)
def test_glsl_agrees_with_the_reference(surface_document, drawn, points, kind, variant):
    numbers = {"flag": "true", "alpha": "0.31, 0.12", "film": "0", **VARIANTS[variant]}
    uniforms = {
        "bsdf_retroreflective": numbers["flag"] == "true",
        "bsdf_roughness": tuple(float(x) for x in numbers["alpha"].split(",")),
        "bsdf_thinfilm_thickness": float(numbers["film"]),
    }
    document, given = surface_document(node("bsdf", kind)), surface_document(node("bsdf", kind, **numbers))
    tolerance = Surface(given.getNode("m")).tolerance(points)
    assert np.max(tolerance.excess(drawn(document, points, uniforms=uniforms))) <= 1.0
    if variant != "retroreflective":
        plain = drawn(document, points, uniforms={**uniforms, "bsdf_retroreflective": numbers["flag"] != "true"})
        lobe = np.max(tolerance.expected, axis=-1) > LOBE * tolerance.scale
        assert np.mean(tolerance.excess(plain)[lobe] > 1.0) > MOST


def test_layers_agree_with_the_reference(differing):
    assert differing(LAYERED) == (0.0, 0.0)


def test_a_film_measured_in_another_unit_agrees_with_the_reference(differing):
    thickness = 'value="0.35" unittype="distance" unit="micron"'
    nodes = node("bsdf", "conductor", film="0.35").replace('value="0.35"', thickness)
    assert differing(nodes) == (0.0, 0.0)


@own_flag
def test_the_upstream_library_with_its_own_flag_agrees_with_the_reference_too(
    surface_document, upstream_library, drawn, points
):
    document = surface_document(node("bsdf", "conductor"), upstream_library)
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


# Planted errors: the nodes they are planted in, what is replaced in the generated source, and by what.
MIRRORED = "(retroreflective && reflects) ? reflect(-closureData.V, N) : closureData.V"
FRESNEL = "NdotL = clamp(dot(N, L), M_FLOAT_EPS, 1.0);\n        float VdotH = clamp(dot({}, H), M_FLOAT_EPS, 1.0);"
MASKING = "mx_ggx_smith_G2(NdotL, NdotV, {});\n\n        vec3 comp"
METAL = ("conductor",)
DAMAGE = {
    "v is not mirrored": (METAL, MIRRORED, "closureData.V"),
    "the flag is ignored": (METAL, "bsdf_retroreflective, bsdf_thinfilm", "false, bsdf_thinfilm"),
    # In there V is v', and v once mirrored back.
    "v is mirrored in D and left in Fresnel": (NODES, FRESNEL.format("V"), FRESNEL.format("reflect(-V, N)")),
    "the two widths are exchanged": (METAL, "mx_ggx_NDF(Ht, safeAlpha)", "mx_ggx_NDF(Ht, safeAlpha.yx)"),
    "energy compensation is left out": (METAL, "= mx_ggx_energy_compensation(NdotV, avgAlpha, F)", "= vec3(1.0)"),
    "masking takes one of the widths": (METAL, MASKING.format("avgAlpha"), MASKING.format("safeAlpha.x")),
}


@pytest.mark.parametrize(
    ("damage", "kind"), [(damage, kind) for damage, (kinds, *_) in DAMAGE.items() for kind in kinds]
)
def test_a_wrong_shader_is_caught(differing, damage, kind):
    _, old, new = DAMAGE[damage]
    assert differing(node("bsdf", kind), old=old, new=new)[0] > MOST


def test_a_shader_that_always_retroreflects_is_caught(differing):
    always = {"old": "(retroreflective && reflects)", "new": "(reflects)"}
    assert differing(node("bsdf", "conductor", flag="false"), **always)[0] > MOST


def test_a_layer_with_its_bases_throughput_is_caught(differing):
    right = "top.response + base.response * top.throughput"
    assert differing(LAYERED, old=right, new=right.replace("top.throughput", "base.throughput"))[0] > MOST


def test_a_layer_with_the_throughput_of_another_node_is_caught(differing):
    call = "mx_layer_bsdf(closureData, veil_out, paint_out, bsdf_out);"
    wrong = call + " bsdf_out.response = veil_out.response + paint_out.response * coat_out.throughput;"
    assert differing(LAYERED, old=call, new=wrong)[0] > MOST
