"""The directional albedo that the energy check integrates, against surfaces whose albedo is known."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.findings.rules.optics import ALBEDO_BOUND
from mrm_mtlx.reference import Surface
from mrm_mtlx.validation.comparison.sampling import LobeShape
from mrm_mtlx.validation.energy import VIEW_DEGREES, directional_albedos

# Of sums over 2048 samples in float64, of numbers rounded to float32.
EXACT_TOL = 2.0**-22

# MaterialX's energy compensation is a fit: an ideal white lobe comes out within this of 1 up to 75 degrees. Nearer to
# grazing it gains more, which the bound of the check allows for.
WHITE_TOL = 0.03
STEEP = 80.0  # degrees


def inputs(**values: str) -> str:
    kinds = {1: "float", 2: "vector2", 3: "color3"}
    return "".join(
        f'<input name="{name}" type="{"boolean" if v in ("true", "false") else kinds[len(v.split(","))]}" value="{v}"/>'
        for name, v in values.items()
    )


def white_paint(name: str, **values: str) -> str:
    given = inputs(color="1, 1, 1", **values)
    return f'<oren_nayar_diffuse_bsdf name="{name}" type="BSDF">{given}</oren_nayar_diffuse_bsdf>'


def white_metal(name: str, alpha_x: float, alpha_y: float, flag: str, **values: str) -> str:
    """Every facet reflects everything."""
    colors = dict.fromkeys(("color0", "color82", "color90"), "1, 1, 1")
    given = inputs(**colors, roughness=f"{alpha_x}, {alpha_y}", retroreflective=flag, **values)
    return f'<generalized_schlick_bsdf name="{name}" type="BSDF">{given}</generalized_schlick_bsdf>'


def pair(category: str, first: str, second: str, **values: str) -> str:
    return (
        f'<{category} name="bsdf" type="BSDF"><input name="{first}" type="BSDF" nodename="a"/>'
        f'<input name="{second}" type="BSDF" nodename="b"/>{inputs(**values)}</{category}>'
    )


@pytest.fixture
def albedos(surface_document, rng):
    """Function from BSDF nodes, as text, and shapes of lobes to the albedos at each view angle."""

    def of(nodes: str, *lobes: LobeShape):
        document = surface_document(nodes)
        return directional_albedos(Surface(document.getNode("m")), lobes, rng)

    return of


def shape(alpha_x: float, alpha_y: float, *, retroreflective: bool) -> LobeShape:
    return LobeShape(np.asarray(alpha_x), np.asarray(alpha_y), retroreflective)


def test_white_paint_reflects_all_light(albedos):
    found = albedos(white_paint("bsdf"))
    assert [a.view_deg for a in found] == list(VIEW_DEGREES)
    # Cosine-weighted samples of a constant: every one is the integral.
    assert [a.value for a in found] == pytest.approx([1.0] * len(VIEW_DEGREES), rel=EXACT_TOL)
    assert max(a.error for a in found) < EXACT_TOL


def test_grey_paint_reflects_its_share_in_the_brightest_channel(albedos):
    grey = white_paint("bsdf").replace("1, 1, 1", "0.25, 0.5, 0.125")
    assert [a.value for a in albedos(grey)] == pytest.approx([0.5] * len(VIEW_DEGREES), rel=EXACT_TOL)


def test_the_sum_of_two_white_paints_reflects_twice_the_light(albedos):
    found = albedos(white_paint("a") + white_paint("b") + pair("add", "in1", "in2"))
    assert [a.value for a in found] == pytest.approx([2.0] * len(VIEW_DEGREES), rel=EXACT_TOL)


WIDTHS = [(0.0025, 0.0025), (0.01, 0.0025), (0.05, 0.05), (0.3, 0.3), (1.0, 1.0)]


def assert_white(found, significance) -> None:
    """All light is reflected, and the estimates are good enough to tell."""
    for albedo in found:
        allowed = WHITE_TOL if albedo.view_deg < STEEP else ALBEDO_BOUND - 1.0
        assert abs(albedo.value - 1.0) <= allowed + significance.sigmas(len(found)) * albedo.error, albedo
        assert albedo.error < 0.02, albedo


@pytest.mark.parametrize("retroreflective", [False, True])
@pytest.mark.parametrize("alpha", WIDTHS)
def test_an_ideal_white_lobe_of_any_width_reflects_about_all_light(albedos, significance, alpha, retroreflective):
    lobe = white_metal("bsdf", *alpha, str(retroreflective).lower())
    assert_white(albedos(lobe, shape(*alpha, retroreflective=retroreflective)), significance)


def test_a_lobe_that_reflects_a_tenth_less_is_not_taken_for_white(albedos, share_of_false_alarms):
    dimmer = white_metal("bsdf", 0.0025, 0.0025, "true", weight="0.9")
    with pytest.raises(AssertionError):
        assert_white(albedos(dimmer, shape(0.0025, 0.0025, retroreflective=True)), share_of_false_alarms())


@pytest.mark.parametrize("alpha", WIDTHS)
def test_a_lobe_reflects_the_same_with_and_without_the_flag(albedos, significance, alpha):
    ordinary, turned = (
        albedos(white_metal("bsdf", *alpha, flag), shape(*alpha, retroreflective=flag == "true"))
        for flag in ("false", "true")
    )
    for a, b in zip(ordinary, turned, strict=True):
        assert abs(a.value - b.value) <= significance.sigmas(len(ordinary)) * np.hypot(a.error, b.error), (a, b)


@pytest.mark.parametrize("alpha", [(0.0025, 0.0025), (0.01, 0.0025)])
def test_a_narrow_lobe_looked_for_in_the_wrong_place_is_missed(albedos, alpha):
    # Why the shapes of lobes are needed: the flag of one and the other's direction.
    found = albedos(white_metal("bsdf", *alpha, "true"), shape(*alpha, retroreflective=False))
    assert abs(found[2].value - 1.0) > WHITE_TOL


@pytest.mark.parametrize("wrong", [0.5, 2.0])
def test_sampling_with_another_width_gives_the_same_albedo(albedos, significance, wrong):
    # Importance sampling changes the spread of an estimate, never its mean.
    alpha, sampled = 0.05, wrong * 0.05
    found = albedos(white_metal("bsdf", alpha, alpha, "true"), shape(sampled, sampled, retroreflective=True))
    for albedo in found:
        allowed = WHITE_TOL if albedo.view_deg < STEEP else ALBEDO_BOUND - 1.0
        assert abs(albedo.value - 1.0) <= allowed + significance.sigmas(len(found)) * albedo.error, albedo


def test_several_lobes_are_sampled_together(albedos, significance):
    nodes = (
        white_metal("a", 0.0025, 0.0025, "true")
        + white_metal("b", 0.01, 0.01, "false")
        + pair("mix", "fg", "bg", mix="0.25")
    )
    lobes = shape(0.0025, 0.0025, retroreflective=True), shape(0.01, 0.01, retroreflective=False)
    assert_white(albedos(nodes, *lobes), significance)


# The check ------------------------------------------------------------------------------------------------------------

SHOWN = """<?xml version="1.0"?><materialx version="1.39">{}
<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>
<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/>
</surfacematerial></materialx>"""


@pytest.fixture
def gains(check, tmp_path):
    """Function from BSDF nodes, as text, to the findings about energy as (code, message)."""

    def of(nodes: str) -> list[tuple[str, str]]:
        path = tmp_path / "surface.mtlx"
        path.write_text(SHOWN.format(nodes), encoding="utf-8")
        (found,) = check(path, targets=("mdl",))
        return [(f.code, f.message) for f in found.findings if f.code != "SHADER_IGNORES_RETRO"]

    return of


def test_a_gain_is_reported_with_its_albedo_and_view_angle(gains):
    ((code, message),) = gains(white_paint("a") + white_paint("b") + pair("add", "in1", "in2"))
    assert code == "ENERGY_GAIN"
    assert message.startswith("albedo 2.000 at a view angle of ")
    assert f"(up to {ALBEDO_BOUND:g} passes)" in message


def test_a_gain_is_reported_just_above_the_bound_and_not_below(gains):
    # The estimate for paint is exact: a ten-thousandth decides.
    for total, reported in ((ALBEDO_BOUND + 1e-4, ["ENERGY_GAIN"]), (ALBEDO_BOUND - 1e-4, [])):
        nodes = white_paint("a") + white_paint("b", weight=f"{total - 1.0:.6f}") + pair("add", "in1", "in2")
        assert [code for code, _ in gains(nodes)] == reported


@pytest.mark.parametrize("flag", ["true", "false"])
@pytest.mark.parametrize("alpha", [0.0025, 0.05, 0.3, 1.0])
def test_an_ideal_white_lobe_is_no_gain_and_with_a_quarter_more_it_is(gains, alpha, flag):
    white = white_metal("a", alpha, alpha, flag)
    assert gains(white.replace('"a"', '"bsdf"')) == []
    more = white + white_paint("b", weight="0.25") + pair("add", "in1", "in2")
    assert [code for code, _ in gains(more)] == ["ENERGY_GAIN"]


@pytest.mark.parametrize(
    "alpha",
    [
        (0.3, 0.05),
        (0.05, 0.3),
    ],
)
def test_an_anisotropic_gain_is_reported_along_whichever_axis_it_is(gains, alpha):
    assert [code for code, _ in gains(white_metal("bsdf", *alpha, "false"))] == ["ENERGY_ANISOTROPIC"]


def test_an_anisotropic_lobe_with_more_than_all_light_from_above_is_a_plain_gain(gains):
    nodes = white_metal("a", 0.3, 0.05, "true") + white_paint("b", weight="0.25") + pair("add", "in1", "in2")
    assert [code for code, _ in gains(nodes)] == ["ENERGY_GAIN"]
