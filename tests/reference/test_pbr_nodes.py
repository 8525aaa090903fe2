"""The nodes of the physically based library against generated GLSL: under a light, and in an environment of one colour.

Every number of a node is a geometric property and differs from sample to sample over its whole range, ends included.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.engines.base import DirectionalLight, Lighting
from mrm_mtlx.engines.base import Environment as DrawnEnvironment
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import dialects
from mrm_mtlx.reference import ROUNDING_FACTOR, Environment, Illumination, Surface
from mrm_mtlx.reference.closures import hair
from mrm_mtlx.reference.deviations import Deviation
from mrm_mtlx.reference.float32 import precision
from mrm_mtlx.shadergen import generate
from tests.fixtures.versions import planted

SAMPLES = 4096
# Films and many directions cost more than a lobe under a light.
FEW = 768

# Share of the samples that a planted error has to show in, at least. Some show in one of several lobes or layers.
SHOWN = 0.2

# No two channels alike, and exact in float32.
ENVIRONMENT = (0.875, 0.6875, 0.40625)


# Numbers --------------------------------------------------------------------------------------------------------------


def between(low: float, high: float, channels: int = 1, ends: bool = True):
    """Function that draws numbers between two ends; one in eight is an end."""

    def draw(rng: np.random.Generator, count: int) -> np.ndarray:
        shape = (count,) if channels == 1 else (count, channels)
        found = rng.uniform(low, high, shape)
        if ends:
            chosen = rng.random(shape) < 0.125
            found[chosen] = rng.choice([low, high], size=int(chosen.sum()))
        return found

    return draw


def magnitudes(low: float, high: float, channels: int = 1):
    """Function that draws numbers whose logarithms are even between two ends, and the ends."""
    logarithms = between(np.log(low), np.log(high), channels)
    return lambda rng, count: np.exp(logarithms(rng, count))


def often(value: float, other):
    """Function that draws one value half of the time."""

    def draw(rng: np.random.Generator, count: int) -> np.ndarray:
        found = other(rng, count)
        found[rng.random(count) < 0.5] = value
        return found

    return draw


UNIT_FLOAT, COLOR = ("float", between(0.0, 1.0)), ("color3", between(0.0, 1.0, 3))
WEIGHT = ("float", often(1.0, between(0.0, 1.0)))
# What is put together is compared as the installed MaterialX has it, and so is hair with its constants; as specified in
# tests/validation/comparison/test_deviations.py.
AS_WRITTEN = frozenset({Deviation.HAIR_CONSTANTS, Deviation.COMBINED_THROUGHPUT, Deviation.IGNORED_MEDIA})

# Widths from a mirror's to the roughest, equal and unequal; variances and scales of hair likewise.
WIDTHS = ("vector2", magnitudes(1e-4, 1.0, 2))
HAIR_WIDTHS = ("vector2", magnitudes(5e-4, 1.2, 2))
FILM = {"thinfilm_thickness": ("float", often(0.0, between(0.0, 1500.0))), "thinfilm_ior": ("float", between(1.0, 2.5))}
FACETS = {"weight": WEIGHT, "roughness": WIDTHS, **FILM}
CLOTH = {"weight": WEIGHT, "color": COLOR, "roughness": UNIT_FLOAT}

# By a case's name: the node, its numbers with their types and how they are drawn, and inputs that are the same for all.
CASES = {
    "oren_nayar": ("oren_nayar_diffuse_bsdf", CLOTH, {}),
    "oren_nayar, compensated": ("oren_nayar_diffuse_bsdf", CLOTH, {"energy_compensation": ("boolean", "true")}),
    "burley": ("burley_diffuse_bsdf", CLOTH, {}),
    "translucent": ("translucent_bsdf", {"weight": WEIGHT, "color": COLOR}, {}),
    "subsurface": (
        "subsurface_bsdf",
        {"weight": WEIGHT, "color": COLOR, "radius": ("color3", magnitudes(0.03, 100.0, 3))},
        {},
    ),
    "sheen": ("sheen_bsdf", CLOTH, {}),
    "sheen, zeltner": ("sheen_bsdf", CLOTH, {"mode": ("string", "zeltner")}),
    "hair": (
        "chiang_hair_bsdf",
        {
            "tint_R": COLOR,
            "tint_TT": COLOR,
            "tint_TRT": COLOR,
            "ior": ("float", often(1.55, between(1.0, 2.5))),
            "roughness_R": HAIR_WIDTHS,
            "roughness_TT": HAIR_WIDTHS,
            "roughness_TRT": HAIR_WIDTHS,
            # As far as the shader's Bessel function does not overflow; see below.
            "cuticle_angle": ("float", often(0.5, between(0.49, 0.51))),
            "absorption_coefficient": ("vector3", often(0.0, magnitudes(1e-3, 20.0, 3))),
        },
        {},
    ),
    "conductor": (
        "conductor_bsdf",
        {"ior": ("color3", between(0.1, 3.0, 3)), "extinction": ("color3", between(0.0, 8.0, 3)), **FACETS},
        {},
    ),
    **{
        f"dielectric, {mode}": (
            "dielectric_bsdf",
            {"ior": ("float", often(1.5, between(1.01, 3.0))), "tint": COLOR, **FACETS},
            {"scatter_mode": ("string", mode)},
        )
        for mode in ("R", "T", "RT")
    },
    **{
        f"generalized_schlick, {mode}": (
            "generalized_schlick_bsdf",
            {
                "color0": COLOR,
                "color82": ("color3", often(1.0, between(0.0, 1.0, 3))),
                "color90": ("color3", often(1.0, between(0.0, 1.0, 3))),
                "exponent": ("float", often(5.0, between(0.5, 8.0))),
                **FACETS,
            },
            {"scatter_mode": ("string", mode)},
        )
        for mode in ("R", "T", "RT")
    },
}
BROAD = [name for name, (_, numbers, _) in CASES.items() if "thinfilm_ior" not in numbers]
GLOSSY = [name for name in CASES if name not in BROAD]


def varied(name: str, numbers: dict) -> str:
    """Nodes that give the geometric properties of a node of this name."""
    return "".join(
        f'<geompropvalue name="{name}_{key}" type="{kind}">'
        f'<input name="geomprop" type="string" value="{name}_{key}"/></geompropvalue>'
        for key, (kind, _) in numbers.items()
    )


def node(
    category: str, kind: str, numbers: dict, more: dict | None = None, name: str = "bsdf", inputs: str = ""
) -> str:
    """A node whose numbers are geometric properties, with the nodes that give them; `inputs` are more, as text."""
    connected = "".join(f'<input name="{key}" type="{t}" nodename="{name}_{key}"/>' for key, (t, _) in numbers.items())
    given = "".join(f'<input name="{key}" type="{t}" value="{value}"/>' for key, (t, value) in (more or {}).items())
    return varied(name, numbers) + f'<{category} name="{name}" type="{kind}">{connected}{given}{inputs}</{category}>'


def bsdf(case: str, name: str = "bsdf", more: dict | None = None) -> str:
    category, numbers, given = CASES[case]
    return node(category, "BSDF", numbers, {**given, **(more or {})}, name)


def link(key: str, kind: str, source: str) -> str:
    return f'<input name="{key}" type="{kind}" nodename="{source}"/>'


def drawn_numbers(rng: np.random.Generator, count: int, numbers: dict, name: str = "bsdf") -> dict[str, np.ndarray]:
    return {f"{name}_{key}": draw(rng, count) for key, (_, draw) in numbers.items()}


# Samples and draws ----------------------------------------------------------------------------------------------------

LIT = Illumination()
AROUND = Illumination(light=False, environment=Environment.constant(ENVIRONMENT, 16))


@pytest.fixture
def samples(rng, direction_pairs, turned_points):
    """Function from numbers of samples and of nodes to samples; a quarter of the lights is below the surface."""

    def make(count: int, numbers: dict[str, np.ndarray], below: float = 0.25):
        v, l = direction_pairs(rng, count, 0.15)
        # Not where that is opposite to the view: there is no half-vector.
        chosen = (rng.random(count) < below) & (np.linalg.norm(v[:, :2] + l[:, :2], axis=-1) > 1e-3)
        l[chosen] *= [1.0, 1.0, -1.0]
        return turned_points(rng, v, l, numbers)

    return make


@pytest.fixture(scope="module")
def shown(gl, library):
    """Function from a document and samples to what generated GLSL shows of them, under a light or in an environment.

    `damage` replaces text of the pixel source by other text. Programs are kept for the module.
    """
    programs: dict[str, SurfaceProgram] = {}

    def draw(document, points, illumination=LIT, damage=(), uniforms=None):
        shader = generate(document.getNode("m"), "glsl", library)
        pixel = shader.sources["pixel"]
        if damage:
            pixel = planted(pixel, *damage)
        if pixel not in programs:
            programs[pixel] = SurfaceProgram(replace(shader, sources={**shader.sources, "pixel": pixel}))
        around = illumination.environment
        pixels = np.full((1, 1, 3), ENVIRONMENT, dtype=np.float32)
        lighting = Lighting(
            DirectionalLight(tuple(points.light)) if illumination.light else None,
            None if around is None else DrawnEnvironment(pixels, pixels, around.samples),
        )
        inputs = {"positionWorld": points.position, "normalWorld": points.normal, "tangentWorld": points.tangent}
        inputs |= {f"i_geomprop_{name}": value for name, value in points.properties.items()}
        return programs[pixel].draw(inputs, lighting, uniforms)[:, :3]

    yield draw
    for program in programs.values():
        program.release()


@pytest.fixture
def excess(shown):
    """Function from a document and samples to the error over the allowance per sample; see `shown`."""

    def compare(document, points, illumination=LIT, damage=(), uniforms=None, reference=None):
        surface = Surface((reference or document).getNode("m"), deviations=AS_WRITTEN)
        return surface.tolerance(points, illumination).excess(shown(document, points, illumination, damage, uniforms))

    return compare


# BSDFs ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", BROAD)
def test_a_broad_lobe_agrees_under_a_light_and_in_an_environment(surface_document, samples, excess, rng, case):
    document = surface_document(bsdf(case))
    points = samples(SAMPLES, drawn_numbers(rng, SAMPLES, CASES[case][1]))
    for illumination in (LIT, AROUND):
        assert np.max(excess(document, points, illumination)) <= 1.0


@pytest.mark.parametrize("case", GLOSSY)
def test_a_microfacet_lobe_agrees_in_an_environment_with_and_without_the_flag(
    surface_document, samples, excess, rng, case
):
    given = {
        flag: surface_document(bsdf(case, more={"retroreflective": ("boolean", flag)})) for flag in ("false", "true")
    }
    points = samples(FEW, drawn_numbers(rng, FEW, CASES[case][1]))
    for flag, reference in given.items():
        uniforms = {"bsdf_retroreflective": flag == "true"}
        found = excess(given["false"], points, AROUND, uniforms=uniforms, reference=reference)
        assert np.max(found) <= 1.0


@pytest.mark.parametrize("directions", [dialects.installed().least_environment_samples, 1, 64])
def test_a_lobe_agrees_with_any_number_of_directions(surface_document, samples, excess, rng, directions):
    document = surface_document(bsdf("conductor"))
    points = samples(FEW, drawn_numbers(rng, FEW, CASES["conductor"][1]) | {"bsdf_thinfilm_thickness": np.zeros(FEW)})
    around = Illumination(light=False, environment=Environment.constant(ENVIRONMENT, directions))
    assert np.max(excess(document, points, around)) <= 1.0


def test_a_light_and_an_environment_add_up(surface_document, samples, excess, rng):
    document = surface_document(bsdf("dielectric, RT"))
    points = samples(FEW, drawn_numbers(rng, FEW, CASES["dielectric, RT"][1]))
    assert np.max(excess(document, points, replace(AROUND, light=True))) <= 1.0


# A cloth over a fuzz over a coat that is filled with a medium, and paint beside it: what each lets through, in three
# modes. OpenGL takes 16 values that vary, so that not all of them do.
PARTS = {
    "cloth": ("sheen_bsdf", "BSDF", {"color": COLOR, "roughness": UNIT_FLOAT}, {}),
    "fuzz": ("sheen_bsdf", "BSDF", {"weight": WEIGHT, "roughness": UNIT_FLOAT}, {"mode": ("string", "zeltner")}),
    "coat": (
        "dielectric_bsdf",
        "BSDF",
        {"ior": ("float", between(1.01, 3.0)), "tint": COLOR, "roughness": WIDTHS},
        {"scatter_mode": ("string", "RT")},
    ),
    "medium": ("anisotropic_vdf", "VDF", {"absorption": ("vector3", magnitudes(1e-3, 20.0, 3))}, {}),
    "paint": ("burley_diffuse_bsdf", "BSDF", {"color": COLOR}, {}),
}
LAYERS = (
    "".join(node(category, kind, numbers, more, name) for name, (category, kind, numbers, more) in PARTS.items())
    + f'<layer name="filled" type="BSDF">{link("top", "BSDF", "coat")}{link("base", "VDF", "medium")}</layer>'
    + f'<mix name="mixed" type="BSDF">{link("fg", "BSDF", "filled")}{link("bg", "BSDF", "paint")}'
    '<input name="mix" type="float" value="0.7"/></mix>'
    f'<layer name="under" type="BSDF">{link("top", "BSDF", "fuzz")}{link("base", "BSDF", "mixed")}</layer>'
    f'<layer name="bsdf" type="BSDF">{link("top", "BSDF", "cloth")}{link("base", "BSDF", "under")}</layer>'
)


@pytest.fixture
def layered_numbers(rng):
    drawn = (drawn_numbers(rng, FEW, numbers, name) for name, (_, _, numbers, _) in PARTS.items())
    return {key: value for numbers in drawn for key, value in numbers.items()}


@pytest.mark.parametrize("illumination", [LIT, AROUND], ids=["light", "environment"])
def test_layers_of_cloth_and_media_agree(surface_document, samples, excess, layered_numbers, illumination):
    points = samples(FEW, layered_numbers)
    assert np.max(excess(surface_document(LAYERS), points, illumination)) <= 1.0


# Hair -----------------------------------------------------------------------------------------------------------------


def hair_points(rng, samples, count, **given):
    numbers = drawn_numbers(rng, count, CASES["hair"][1]) | given
    return samples(count, numbers, below=0.5)


def bessel_argument(points) -> np.ndarray:
    """The least cos theta_i cos theta_o / v of the three tilted paths."""
    normal = np.where(np.sum(points.normal * points.view, axis=-1, keepdims=True) < 0.0, -points.normal, points.normal)
    x = points.tangent - np.sum(points.tangent * normal, axis=-1, keepdims=True) * normal
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    theta_o, theta_i = np.arcsin(np.sum(points.view * x, axis=-1)), np.arcsin(x @ points.light)
    tilt = np.pi * (points.properties["bsdf_cuticle_angle"] - 0.5)
    arguments = []
    for path, times in (("R", 2.0), ("TT", -1.0), ("TRT", -4.0)):
        variance = np.clip(points.properties[f"bsdf_roughness_{path}"][:, 0], 0.001, 1.0)
        arguments.append(np.cos(theta_i + times * tilt) * np.cos(theta_o) / variance)
    return np.min(arguments, axis=0)


# The power series of I0 is evaluated for any negative argument x; its last term holds x^18, which leaves float32's
# range at 3.4e38^(1/18) = 138.
OVERFLOW = 138.0


def test_hair_with_any_tilt_of_its_cuticle_agrees_or_overflows(surface_document, samples, shown, rng):
    points = hair_points(rng, samples, SAMPLES, bsdf_cuticle_angle=between(0.0, 1.0)(rng, SAMPLES))
    document = surface_document(bsdf("hair"))
    surface = Surface(document.getNode("m"), deviations=AS_WRITTEN)
    tolerance, found = surface.tolerance(points), shown(document, points)
    finite = np.all(np.isfinite(found), axis=-1)
    assert np.max(tolerance.excess(found)[finite]) <= 1.0
    least = bessel_argument(points)
    assert np.all(finite[least > -0.99 * OVERFLOW])
    assert not np.any(finite[least < -1.01 * OVERFLOW])
    assert 0.05 < np.mean(~finite) < 0.3


def test_hair_agrees_where_its_formulas_change(surface_document, samples, excess, rng):
    # Variances of 0.1, and those that make the argument of the Bessel function 12, within two roundings.
    points = hair_points(rng, samples, SAMPLES, bsdf_cuticle_angle=np.full(SAMPLES, 0.5))
    for path in ("R", "TT", "TRT"):
        points.properties[f"bsdf_roughness_{path}"][:, 0] = 1.0
    variance = np.where(rng.random(SAMPLES) < 0.5, 0.1, np.clip(bessel_argument(points) / 12.0, 0.001, 1.0))
    variance *= 1.0 + rng.uniform(-2.0, 2.0, SAMPLES) * 2.0**-24
    for path in ("R", "TT", "TRT"):
        points.properties[f"bsdf_roughness_{path}"][:, 0] = variance.astype(np.float32)
    assert np.max(excess(surface_document(bsdf("hair")), points)) <= 1.0


@pytest.mark.parametrize(("argument", "step"), [(12.0, 0.0148), (11.9, 0.0), (12.1, 0.0)])
def test_the_step_of_the_hairs_series_is_allowed_where_a_rounding_decides(argument, step):
    across, along = np.ones(1), np.zeros(1)
    moved = [
        hair._longitudinal((along, across), (along, across), np.array([1.0 / argument]), 0.0, switch, 0.0)
        for switch in (-1.0, 1.0)
    ]
    assert moved[0] / moved[1] - 1.0 == pytest.approx(step, abs=5e-4)


# Emission -------------------------------------------------------------------------------------------------------------

EMITTER = '<surface name="s" type="surfaceshader"><input name="edf" type="EDF" nodename="edf"/></surface>'
MATERIAL = f'<surfacematerial name="m" type="material">{link("surfaceshader", "surfaceshader", "s")}</surfacematerial>'
ANY_COLOR = ("color3", between(-0.5, 3.0, 3))

EMISSION = {
    "generalized_schlick_edf": (
        {
            "edf": {"color0": COLOR, "color90": COLOR, "exponent": ("float", often(5.0, magnitudes(0.05, 8.0)))},
            "base": {"color": ANY_COLOR},
        },
        lambda parts: (
            node("uniform_edf", "EDF", parts["base"], name="base")
            + node("generalized_schlick_edf", "EDF", parts["edf"], name="edf", inputs=link("base", "EDF", "base"))
        ),
    ),
    "mix, add and multiply": (
        {
            "one": {"color": ANY_COLOR},
            "two": {"color": ANY_COLOR},
            "mixed": {"mix": UNIT_FLOAT},
            "tinted": {"in2": ANY_COLOR},
            "dimmed": {"in2": ("float", between(-1.0, 2.0))},
        },
        lambda parts: (
            node("uniform_edf", "EDF", parts["one"], name="one")
            + node("uniform_edf", "EDF", parts["two"], name="two")
            + node(
                "mix", "EDF", parts["mixed"], name="mixed", inputs=link("fg", "EDF", "one") + link("bg", "EDF", "two")
            )
            + node("multiply", "EDF", parts["tinted"], name="tinted", inputs=link("in1", "EDF", "mixed"))
            + node("multiply", "EDF", parts["dimmed"], name="dimmed", inputs=link("in1", "EDF", "one"))
            + f'<add name="edf" type="EDF">{link("in1", "EDF", "tinted")}{link("in2", "EDF", "dimmed")}</add>'
        ),
    ),
}


@pytest.fixture
def emitting(make_document):
    """Function from nodes to a document whose material emits what the node `edf` gives."""

    def make(nodes: str):
        document = make_document(nodes + EMITTER + MATERIAL)
        valid, message = document.validate()
        assert valid, message
        return document

    return make


@pytest.mark.parametrize("case", EMISSION)
def test_emission_agrees(emitting, samples, excess, rng, case):
    parts, text = EMISSION[case]
    numbers = {k: v for name, part in parts.items() for k, v in drawn_numbers(rng, SAMPLES, part, name).items()}
    assert np.max(excess(emitting(text(parts)), samples(SAMPLES, numbers))) <= 1.0


def test_emission_is_shown_without_light_and_dimmed_by_opacity(emitting, flat_points):
    document = emitting(
        '<uniform_edf name="edf" type="EDF"><input name="color" type="color3" value="1, 2, 4"/></uniform_edf>'
    )
    surface, points = Surface(document.getNode("m")), flat_points([0.6, 0.0, 0.8], [0.0, 0.6, 0.8])
    assert surface.shade(points, Illumination(light=False)).tolist() == [[1.0, 2.0, 4.0]]
    assert not np.any(surface.response(points))
    document.getNode("s").setInputValue("opacity", 0.25)
    assert Surface(document.getNode("m")).shade(points).tolist() == [[0.25, 0.5, 1.0]]


# Numbers that artists give --------------------------------------------------------------------------------------------


def temperatures(rng: np.random.Generator, count: int) -> np.ndarray:
    """Within the range and beyond it, and where the cubics change."""
    found = magnitudes(600.0, 30000.0)(rng, count)
    found[::8] = rng.choice([800.0, 2222.0, 4000.0, 25000.0], size=len(found[::8]))
    return found


# Node, numbers, type of the output, and its name where there are several.
VALUES = {
    "blackbody": ("blackbody", {"temperature": ("float", temperatures)}, "color3", ""),
    "roughness_dual": ("roughness_dual", {"roughness": ("vector2", between(-1.0, 1.2, 2))}, "vector2", ""),
    "absorption from melanin": (
        "deon_hair_absorption_from_melanin",
        {
            "melanin_concentration": ("float", often(0.25, between(0.0, 1.0))),
            "melanin_redness": ("float", between(-0.2, 1.2)),
            "eumelanin_color": ("color3", between(0.01, 1.0, 3)),
            "pheomelanin_color": ("color3", between(0.01, 1.0, 3)),
        },
        "vector3",
        "",
    ),
    "absorption from colour": (
        "chiang_hair_absorption_from_color",
        {"color": ("color3", between(-0.2, 1.2, 3)), "azimuthal_roughness": UNIT_FLOAT},
        "vector3",
        "",
    ),
    **{
        f"hair roughness, {path}": (
            "chiang_hair_roughness",
            {
                "longitudinal": ("float", between(-0.1, 1.1)),
                "azimuthal": ("float", between(-0.1, 1.1)),
                "scale_TT": ("float", between(0.1, 1.0)),
                "scale_TRT": ("float", between(1.0, 3.0)),
            },
            "vector2",
            f"roughness_{path}",
        )
        for path in ("R", "TT", "TRT")
    },
}


def valued(case: str) -> str:
    """Nodes that emit a number: vectors take the way over `convert` to a colour."""
    category, numbers, kind, output = VALUES[case]
    text = node(category, "multioutput" if output else kind, numbers, name="value")
    steps = {"color3": (), "vector3": ("color3",), "vector2": ("vector3", "color3")}[kind]
    source, chosen = "value", f' output="{output}"' if output else ""
    for step, target in enumerate(steps):
        given = f'<input name="in" type="{kind}" nodename="{source}"{chosen}/>'
        text += f'<convert name="step{step}" type="{target}">{given}</convert>'
        source, kind, chosen = f"step{step}", target, ""
    return text + f'<uniform_edf name="edf" type="EDF">{link("color", "color3", source)}</uniform_edf>'


@pytest.mark.parametrize("case", VALUES)
def test_numbers_agree(emitting, samples, excess, rng, case):
    numbers = drawn_numbers(rng, SAMPLES, VALUES[case][1], "value")
    assert np.max(excess(emitting(valued(case)), samples(SAMPLES, numbers))) <= 1.0


# Planted errors -------------------------------------------------------------------------------------------------------

PI = "(2.0 * M_PI);\n}\n\nfloat mx_imageworks_sheen_brdf"
# Case, lighting, what is replaced in the generated source and by what.
DAMAGE = {
    "Burley's edge is 5 % less rough": ("burley", LIT, "0.5 + (2.0 * roughness", "0.5 + (1.9 * roughness"),
    "Burley's albedo is left out": (
        "burley",
        AROUND,
        "mx_environment_irradiance(N) *\n",
        "mx_environment_irradiance(N); //",
    ),
    "light does not come from the other side": ("translucent", LIT, "N = -N;", ""),
    "diffused light lacks 1 / pi": ("subsurface", LIT, "radius, mfp) / vec3(M_PI)", "radius, mfp)"),
    "the profile's second exponential is narrower": (
        "subsurface",
        LIT,
        "exp(-shape * dist / 3.0)",
        "exp(-shape * dist / 2.0)",
    ),
    "a coefficient of the sheen's fit is 1 % off": ("sheen", AROUND, "799.08825", "807.08"),
    "the distribution of fibres lacks its 2": ("sheen", LIT, PI, PI.replace("2.0 * M_PI", "M_PI")),
    "the shear is mirrored": ("sheen, zeltner", LIT, "bInv*w.z", "-bInv*w.z"),
    "the albedo of sheen is left out": ("sheen, zeltner", LIT, "dirAlbedo * fr", "fr"),
    "the lobes of hair are exchanged": ("hair", LIT, "vs[1] = roughness_TT;", "vs[1] = roughness_TRT;"),
    "TRT has the sign of TT": ("hair", LIT, "2.0 * fP * gammaT - 2.0 * gammaO", "2.0 * fP * gammaT + 2.0 * gammaO"),
    "hair absorbs half": ("hair", LIT, "(2.0 * cosGammaT / cosThetaT)", "(cosGammaT / cosThetaT)"),
    "the metal in an environment is not compensated": (
        "conductor",
        AROUND,
        "response = Li * comp * weight",
        "response = Li * weight",
    ),
    "the environment is masked once": ("conductor", AROUND, "F * G;", "F;"),
    "what is transmitted was not reflected": ("dielectric, T", AROUND, "vec3(1.0) - F : F", "vec3(1.0) : F"),
    "what is transmitted has no tint": ("dielectric, T", AROUND, "distribution, fd) * tint;", "distribution, fd);"),
    "reflection in an environment has no tint": ("dielectric, R", AROUND, "Li * safeTint * comp", "Li * comp"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_a_wrong_lobe_is_caught(surface_document, samples, excess, rng, name):
    case, illumination, *damage = DAMAGE[name]
    numbers = drawn_numbers(rng, FEW, CASES[case][1])
    numbers |= {f"bsdf_{key}": np.ones(FEW) for key in ("weight",) if key in CASES[case][1]}
    found = excess(surface_document(bsdf(case)), samples(FEW, numbers, below=0.0), illumination, damage)
    assert np.mean(found > 1.0) > SHOWN


LAYER_DAMAGE = {
    "the sheen's throughput is dropped": (LIT, "bsdf.throughput = vec3(1.0 - dirAlbedo * weight);", ""),
    "the medium dims reflections too": (
        LIT,
        "CLOSURE_TYPE_TRANSMISSION)\n    {\n        vdf",
        "CLOSURE_TYPE_REFLECTION)\n    {\n        vdf",
    ),
    "the medium absorbs twice": (AROUND, "exp(-absorption)", "exp(-2.0 * absorption)"),
}


@pytest.mark.parametrize("name", LAYER_DAMAGE)
def test_a_wrong_throughput_is_caught(surface_document, samples, excess, layered_numbers, name):
    illumination, *damage = LAYER_DAMAGE[name]
    points = samples(FEW, layered_numbers, below=0.0)
    assert np.mean(excess(surface_document(LAYERS), points, illumination, damage) > 1.0) > SHOWN


EMISSION_DAMAGE = {
    "the normal is not turned to the viewer": (
        "generalized_schlick_edf",
        "mx_forward_facing_normal(closureData.N, closureData.V)",
        "closureData.N",
    ),
    "Schlick's exponent is 5": (
        "generalized_schlick_edf",
        "mx_fresnel_schlick(NdotV, color0, color90, exponent)",
        "mx_fresnel_schlick(NdotV, color0, color90)",
    ),
    "fore- and background are exchanged": (
        "mix, add and multiply",
        "result = mix(bg, fg, mixValue)",
        "result = mix(fg, bg, mixValue)",
    ),
}


@pytest.mark.parametrize("name", EMISSION_DAMAGE)
def test_wrong_emission_is_caught(emitting, samples, excess, rng, name):
    case, *damage = EMISSION_DAMAGE[name]
    parts, text = EMISSION[case]
    numbers = {k: v for key, part in parts.items() for k, v in drawn_numbers(rng, FEW, part, key).items()}
    wrong = excess(emitting(text(parts)), samples(FEW, numbers), LIT, damage) > 1.0
    behind = np.arange(FEW) % 16 == 15
    assert np.mean(wrong[behind] if "normal" in name else wrong) > SHOWN


VALUE_DAMAGE = {
    "a coefficient of the locus is 0.1 % off": ("blackbody", "0.8776956", "0.8786"),
    "a pigment has the other's colour": (
        "absorption from melanin",
        "pheomelanin * -log(pheomelanin_color)",
        "pheomelanin * -log(eumelanin_color)",
    ),
    "absorption is not squared": ("absorption from colour", "absorption = sigma * sigma", "absorption = sigma"),
    "TRT is scaled once": ("hair roughness, TRT", "v * scale_TRT * scale_TRT", "v * scale_TRT"),
    "the second roughness is the first": ("roughness_dual", "roughness.y * roughness.y", "roughness.x * roughness.x"),
}


@pytest.mark.parametrize("name", VALUE_DAMAGE)
def test_a_wrong_number_is_caught(emitting, samples, excess, rng, name):
    case, *damage = VALUE_DAMAGE[name]
    numbers = drawn_numbers(rng, FEW, VALUES[case][1], "value")
    assert np.mean(excess(emitting(valued(case)), samples(FEW, numbers), LIT, damage) > 1.0) > SHOWN


# Rounding -------------------------------------------------------------------------------------------------------------


def test_errors_are_tried_at_both_edges_and_added_up():
    def function(x: float = 0.0, y: float = 0.0) -> np.ndarray:
        return np.asarray((1.0 + x) ** 2 - y)

    # To 1.5^2 and not to 0.5^2, and by 2; what y takes away does not hide what x adds.
    moved = precision.widened(function, x=0.5, y=2.0)
    assert moved == pytest.approx(1.0 + (1.25 + 2.0) / ROUNDING_FACTOR, rel=1e-12)
    assert precision.widened(function) == 1.0


def test_errors_of_built_in_functions_are_those_of_the_standards():
    ulp = 2.0**-23
    assert precision.exponential_error(np.asarray(-10.0)) == 23.0 * ulp
    assert precision.logarithm_error(np.asarray(1.0)) == 2.0**-21
    assert precision.logarithm_error(np.asarray(np.exp(3.0))) == pytest.approx(9.0 * ulp, rel=1e-12)


def test_white_hair_reflects_all_light_in_a_white_furnace(surface_document, flat_points, rng):
    """The integral of the response over all directions; as MaterialX writes it, it is about a third."""
    document = surface_document(
        '<chiang_hair_bsdf name="bsdf" type="BSDF"><input name="roughness_R" type="vector2" value="0.2, 0.4"/>'
        '<input name="roughness_TT" type="vector2" value="0.2, 0.4"/>'
        '<input name="roughness_TRT" type="vector2" value="0.2, 0.4"/></chiang_hair_bsdf>'
    )
    count = 40_000
    l = rng.normal(size=(count, 3))
    l /= np.linalg.norm(l, axis=1, keepdims=True)
    points = flat_points(np.broadcast_to([0.36, 0.48, 0.8], (count, 3)), l)

    def furnace(deviations):
        response = Surface(document.getNode("m"), deviations=deviations).response(points)[:, 0]
        return 4.0 * np.pi * np.mean(response), 4.0 * np.pi * np.std(response) / np.sqrt(count)

    (true, error), (written, _) = furnace(frozenset()), furnace(AS_WRITTEN)
    assert abs(true - 1.0) < 4.0 * error < 0.05
    assert written < 0.5
