"""Image nodes: what generated GLSL shows of image files against the reference, and errors that have to be caught."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.documents.images import ADDRESS_MODES, FILTER_TYPES, read_image
from mrm_mtlx.engines.base import Lighting
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import ROUNDING_FACTOR, ShadingPoints, Surface
from mrm_mtlx.reference.textures import hextile
from mrm_mtlx.reference.textures import lookup as texture_lookup
from mrm_mtlx.shadergen import generate
from tests.fixtures.versions import NODES_AS_WRITTEN, planted

if TYPE_CHECKING:
    from mrm_mtlx.bsdf.arrays import Array

SAMPLES = 512
UNIT = 2.0**-24

# Share of the samples in which a planted error has to show.
MOST = 0.5

DEFAULTS = {
    "float": "0.3",
    "color3": "0.2, 0.5, 0.7",
    "color4": "0.2, 0.5, 0.7, 0.4",
    "vector2": "0.2, 0.6",
    "vector3": "0.2, 0.6, 0.9",
    "vector4": "0.1, 0.4, 0.6, 0.9",
}


def values(given: dict[str, str]) -> str:
    """Inputs by name: the type before a colon, and the value or, with an @, the node."""
    text = ""
    for name, typed in given.items():
        kind, _, value = typed.partition(":")
        text += f'<input name="{name}" type="{kind}" ' + (
            f'nodename="{value[1:]}"/>' if value.startswith("@") else f'value="{value}"/>'
        )
    return text


def image(kind: str = "color3", node: str = "image", file: str = "a.exr", more: str = "", **given: str) -> str:
    """The node `a`, of an image with a default that is not black."""
    inputs = values({"default": f"{kind}:{DEFAULTS[kind]}", **given})
    return f'<{node} name="a" type="{kind}"><input name="file" type="filename" value="{file}" {more}/>{inputs}</{node}>'


def modes(u: str, v: str, filtertype: str = "linear") -> dict[str, str]:
    given = {"uaddressmode": u, "vaddressmode": v, "filtertype": filtertype}
    return {name: f"string:{value}" for name, value in given.items()}


def shown(nodes: str, kind: str = "color3", output: str = "") -> str:
    """The surface `s` that shows the first, the second and the last channel of the node `a`."""
    output = f'output="{output}"' if output else ""
    if kind in ("float", "color3"):
        use = {"float": "emission", "color3": "emission_color"}[kind]
        color = f'<input name="{use}" type="{kind}" nodename="a" {output}/>'
    else:
        last = int(kind[-1]) - 1
        for name, index in (("in1", 0), ("in2", 1), ("in3", last)):
            given = f'<input name="in" type="{kind}" nodename="a" {output}/>' + values({"index": f"integer:{index}"})
            nodes += f'<extract name="{name}" type="float">{given}</extract>'
        nodes += (
            f'<combine3 name="c" type="color3">{values({n: f"float:@{n}" for n in ("in1", "in2", "in3")})}</combine3>'
        )
        color = '<input name="emission_color" type="color3" nodename="c"/>'
    return nodes + f'<surface_unlit name="s" type="surfaceshader">{color}</surface_unlit>'


@pytest.fixture
def pictures(tmp_path, write_image):
    """Function that writes image files with these pixels and gives them as they are read again."""

    def write(**pixels: Array) -> dict[str, Array]:
        found = {}
        for name, values in pixels.items():
            kind = "png" if values.dtype == np.uint8 else "exr" if name < "m" else "tif"
            path = write_image(tmp_path / f"{name}.{kind}", values)
            found[path.name] = read_image(path)
        return found

    return write


@pytest.fixture
def picture(pictures, rng):
    """A small picture `a.exr` of odd sizes, no two texels alike."""
    return pictures(a=rng.uniform(0.0, 1.0, (5, 7, 4)).astype(np.float32))


@pytest.fixture
def points(rng, random_surface):
    """Samples over several repetitions of a texture; an eighth of them far away, where float32 has few digits."""
    uv = rng.uniform(-1.5, 2.5, (SAMPLES, 2))
    uv[::8] *= 100.0
    return random_surface(rng, uv)


@pytest.fixture(scope="module")
def random_surface():
    """Function from texture coordinates to samples in random frames at random positions."""

    def make(rng: np.random.Generator, uv: Array) -> ShadingPoints:
        frames = np.linalg.qr(rng.normal(size=(len(uv), 3, 3)))[0]
        arrays = {"view": frames[:, 2], "normal": frames[:, 0], "tangent": frames[:, 1], "texcoord": uv}
        arrays |= {"position": rng.uniform(-2.0, 2.0, (len(uv), 3)), "light": np.array([0.0, 0.0, 1.0])}
        return ShadingPoints(**{name: a.astype(np.float32).astype(float) for name, a in arrays.items()})

    return make


@pytest.fixture
def compared(gl_clean, make_document, library):
    """Function from a document's nodes, samples and images to the tolerance and what GLSL shows.

    `drawn` and `instead` are other images and nodes for GLSL alone; `old` and `new` damage its source.
    """

    def compare(nodes, points, images, drawn=None, instead="", old="", new=""):
        document = make_document(nodes)
        surface = Surface(document.getNode("s"), images=images.get, deviations=NODES_AS_WRITTEN)
        tolerance = surface.tolerance(points)
        document = make_document(instead or nodes)
        shader = generate(document.getNode("s"), "glsl", library)
        if old:
            shader = replace(shader, sources={**shader.sources, "pixel": planted(shader.sources["pixel"], old, new)})
        files = {p.variable: (drawn or images).get(p.value) for p in shader.uniforms if p.type == "filename"}
        with SurfaceProgram(shader, {name: a for name, a in files.items() if a is not None}) as program:
            at = points.position, points.normal, points.tangent, points.texcoord
            return tolerance, program.draw(program.surface_inputs(*at), Lighting())[:, :3]

    return compare


SIZES = {"linear": (5, 7), "closest": (8, 4), "cubic": (1, 3)}


@pytest.mark.parametrize("filtertype", FILTER_TYPES)
@pytest.mark.parametrize("u", ADDRESS_MODES)
def test_every_address_mode_and_filter_agrees_with_glsl(excess, pictures, points, rng, u, filtertype):
    images = pictures(a=rng.uniform(0.0, 1.0, (*SIZES[filtertype], 3)).astype(np.float32))
    for v in ADDRESS_MODES:
        assert np.max(excess(shown(image(**modes(u, v, filtertype))), points, images)) <= 1.0, v


@pytest.mark.parametrize("kind", DEFAULTS)
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_images_of_any_number_of_channels_agree_for_every_type(excess, pictures, points, rng, kind, channels):
    images = pictures(z=rng.uniform(0.0, 1.0, (4, 3, channels)).astype(np.float32))
    for mode in ("periodic", "constant"):
        nodes = image(kind, file="z.tif", **modes(mode, mode))
        assert np.max(excess(shown(nodes, kind), points, images)) <= 1.0


@pytest.mark.parametrize("kind", DEFAULTS)
def test_a_missing_image_is_its_default(compared, points, kind):
    tolerance, found = compared(shown(image(kind), kind), points, {})
    assert np.max(tolerance.excess(found)) <= 1.0
    numbers = [float(x) for x in DEFAULTS[kind].split(",")]
    expected = [numbers[0]] * 3 if kind == "float" else [*numbers[:2], numbers[-1]]
    np.testing.assert_allclose(tolerance.expected, np.tile(expected, (SAMPLES, 1)), rtol=2 * UNIT)


def test_eight_bits_in_srgb_agree(excess, pictures, points, rng):
    images = pictures(a=rng.integers(0, 256, (6, 5, 3), dtype=np.uint8))
    srgb = 'colorspace="srgb_texture"'
    nodes = shown(image(file="a.png", more=srgb))
    assert np.max(excess(nodes, points, images)) <= 1.0
    assert np.mean(excess(nodes, points, images, instead=nodes.replace(srgb, "")) > 1.0) > MOST


@pytest.mark.parametrize(
    ("node", "kind", "output"),
    [("tiledimage", "color3", ""), ("gltf_colorimage", "multioutput", "outcolor"), ("image", "color3", "")],
)
def test_the_colour_space_of_a_file_holds_where_it_is_given(excess, picture, points, node, kind, output):
    file = '<input name="file" type="filename" value="a.exr"{}/>'
    nodes = f'<{node} name="a" type="{kind}">{file}</{node}>'
    srgb = shown(nodes.format(' colorspace="srgb_texture"'), output=output)
    assert np.max(excess(srgb, points, picture)) <= 1.0
    assert np.mean(excess(srgb, points, picture, instead=shown(nodes.format(""), output=output)) > 1.0) > MOST


def test_a_default_of_the_files_colour_space_agrees(excess, picture, points):
    srgb = 'colorspace="srgb_texture"'
    nodes = shown(image(more=srgb, **modes("constant", "clamp"))).replace('name="default"', f'name="default" {srgb}')
    assert np.max(excess(nodes, points, picture)) <= 1.0


def test_a_coordinate_on_a_texels_edge_is_settled_where_it_is_constant(compared, pictures, points, rng):
    images = pictures(a=rng.uniform(0.0, 1.0, (4, 4, 3)).astype(np.float32))
    coordinate = f'<constant name="uv" type="vector2">{values({"value": "vector2:0.5, 0.25"})}</constant>'
    nodes = coordinate + image(texcoord="vector2:@uv", **modes("clamp", "clamp", "closest"))
    tolerance, found = compared(shown(nodes), points, images)
    assert np.max(tolerance.excess(found)) <= 1.0
    # The texel right of the middle, in the third row from above; allowed is the rounding of values, and no other texel.
    np.testing.assert_allclose(tolerance.expected[0], images["a.exr"][2, 2], rtol=2 * UNIT)
    assert np.max(tolerance.allowed) < 20 * ROUNDING_FACTOR * UNIT


def coordinates(**given: str) -> str:
    """The node `uv`: texture coordinates turned, scaled and shifted."""
    given = {"rotate": "float:33", "scale": "vector2:0.3, 0.7", "offset": "vector2:0.1, 0.4", **given}
    return f'<place2d name="uv" type="vector2">{values(given)}</place2d>'


NORMAL = '<normal name="n" type="vector3"><input name="space" type="string" value="world"/></normal>'
PROJECTED = '<triplanarprojection name="a" type="color3">{}{}</triplanarprojection>'
FILES = "".join(
    f'<input name="file{axis}" type="filename" value="{name}"/>'
    for axis, name in zip("xyz", ("a.exr", "b.exr", "a.exr"), strict=True)
)

GRAPHS = {
    "tiledimage": image(node="tiledimage", uvtiling="vector2:3.3, 2.1", realworldimagesize="vector2:2, 3"),
    "tiledimage, closest": image(node="tiledimage", uvoffset="vector2:0.3, -0.2", filtertype="string:closest"),
    "place2d": coordinates() + image(texcoord="vector2:@uv", **modes("mirror", "constant")),
    "place2d, closest": coordinates(pivot="vector2:0.2, 0.9")
    + image(texcoord="vector2:@uv", **modes("clamp", "mirror", "closest")),
    "latlongimage": NORMAL + image(node="latlongimage", viewdir="vector3:@n", rotation="float:40"),
    "triplanarprojection": PROJECTED.format(FILES, values({"blend": "float:0.7"})),
    "triplanarprojection, x up": PROJECTED.format(FILES, values({"upaxis": "integer:0"})),
    "gltf_image": image(node="gltf_image", uaddressmode="string:constant", rotate="float:20", scale="vector2:2, 3"),
    "hextiledimage": image(node="hextiledimage"),
    "hextiledimage, contrast": image(node="hextiledimage", falloff="float:0.7", falloffcontrast="float:0.9"),
    "hextiledimage, constant": image(node="hextiledimage", rotation="float:0", scale="float:0", offset="float:0.5"),
}  # fmt: skip


@pytest.mark.parametrize("name", GRAPHS)
def test_graphs_and_tilings_of_images_agree_with_glsl(excess, pictures, points, rng, name):
    images = pictures(**{n: rng.uniform(0.0, 1.0, (5, 7, 3)).astype(np.float32) for n in "ab"})
    assert np.max(excess(shown(GRAPHS[name]), points, images)) <= 1.0


@pytest.mark.parametrize("wrap", ["black", "clamp", "periodic", "mirror"])
def test_a_usd_texture_agrees_with_glsl(excess, picture, points, wrap):
    given = {"wrapS": f"string:{wrap}", "fallback": "color4:0.1, 0.3, 0.6, 0.4", "scale": "color4:0.7, 1.5, 1, 1"}
    file = '<input name="file" type="filename" value="a.exr"/>'
    nodes = f'<UsdUVTexture name="a" type="multioutput">{file}{values(given)}</UsdUVTexture>'
    assert np.max(excess(shown(nodes, output="rgb"), points, picture)) <= 1.0


def test_four_channels_and_normals_through_hex_tiles_agree_with_glsl(excess, pictures, points, rng):
    normals = rng.uniform(0.2, 0.8, (5, 7, 3)).astype(np.float32)
    normals[..., 2] = 0.5 + 0.5 * normals[..., 2]  # none of them looks inward
    images = pictures(a=rng.uniform(0.0, 1.0, (5, 7, 4)).astype(np.float32), b=normals)
    assert np.max(excess(shown(image("color4", "hextiledimage"), "color4"), points, images)) <= 1.0
    for flip in ("false", "true"):
        given = {"flip_g": f"boolean:{flip}", "strength": "float:0.7", "falloff": "float:0.6"}
        nodes = image("vector3", "hextilednormalmap", "b.exr", **given)
        assert np.max(excess(shown(nodes, "vector3"), points, images)) <= 1.0


# Texels along a side of a picture in which the random numbers' errors span several.
LARGE = 640


@pytest.fixture
def ruled(pictures, rng):
    """A picture `a.exr` of flat squares between dark lines of one texel."""
    squares = rng.uniform(0.5, 1.0, (LARGE // 16, LARGE // 16, 4))
    pixels = np.repeat(np.repeat(squares, 16, axis=0), 16, axis=1)
    pixels[::16] = pixels[:, ::16] = 0.02
    return pictures(a=pixels.astype(np.float32))


@pytest.mark.parametrize("kind", ["color3", pytest.param("color4", marks=pytest.mark.large)])
@pytest.mark.parametrize("space", ["", pytest.param('colorspace="srgb_texture"', marks=pytest.mark.large)])
def test_a_line_that_a_hex_tile_may_just_meet_is_allowed(compared, ruled, random_surface, rng, kind, space):
    near = random_surface(rng, rng.uniform(-1.0, 2.0, (16 * SAMPLES, 2)))
    tolerance, found = compared(shown(image(kind, "hextiledimage", more=space), kind), near, ruled)
    assert np.max(tolerance.excess(found)) <= 1.0
    # Where no line is near, nothing of it is.
    assert np.mean(np.max(tolerance.allowed, axis=1) < 0.05) > 0.05


@pytest.mark.large
def test_what_rises_and_falls_over_the_range_of_a_hex_tile_is_allowed(excess, ruled, random_surface, rng):
    near = random_surface(rng, rng.uniform(-1.0, 2.0, (16 * SAMPLES, 2)))
    tiled = image("color3", "hextiledimage").replace('name="a"', 'name="tiled"')
    # As a lobe's height over its width: little at both ends, 0 and 0.9, and most in the middle.
    under = values({"in1": "color3:0.9, 0.9, 0.9", "in2": "color3:@tiled"})
    both = values({"in1": "color3:@tiled", "in2": "color3:@under"})
    nodes = (
        f'{tiled}<subtract name="under" type="color3">{under}</subtract>'
        f'<multiply name="a" type="color3">{both}</multiply>'
    )
    assert np.max(excess(shown(nodes, "color3"), near, ruled)) <= 1.0


@pytest.mark.large
def test_a_line_that_a_hex_tiled_normal_may_just_meet_is_allowed(excess, ruled, random_surface, rng):
    near = random_surface(rng, rng.uniform(-1.0, 2.0, (16 * SAMPLES, 2)))
    assert np.max(excess(shown(image("vector3", "hextilednormalmap"), "vector3"), near, ruled)) <= 1.0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.1031", "0.1033"),
        pytest.param("sqrt(3.0) * 2.0", "sqrt(3.0) * 2.1", marks=pytest.mark.large),
        pytest.param("0.12345", "0.12346", marks=pytest.mark.large),
    ],
)
def test_wrong_tiles_of_a_large_picture_are_caught(excess, pictures, random_surface, rng, old, new):
    u = np.linspace(0.0, 2.0 * np.pi, LARGE, endpoint=False)
    smooth = np.stack(np.broadcast_arrays(np.sin(u), np.cos(u)[:, None], np.sin(u + u[:, None])), axis=-1)
    images = pictures(a=(0.5 + 0.4 * smooth).astype(np.float32))
    near = random_surface(rng, rng.uniform(-1.5, 2.5, (SAMPLES, 2)))
    nodes = shown(image(node="hextiledimage", rotation="float:0", scale="float:0"))
    assert np.mean(excess(nodes, near, images, old=old, new=new) > 1.0) > MOST


@pytest.mark.parametrize(("size", "widest"), [((6, 5), 0.15), ((24, 40), 0.4), ((300, 200), 0.2)])
def test_extremes_are_those_of_all_that_is_shown_within_reach(rng, size, widest):
    pixels = rng.uniform(0.0, 1.0, (*size, 3)).astype(np.float32)
    uv, reach = rng.uniform(-1.5, 2.5, (2, 40)), rng.uniform(0.0, widest, (2, 40)) * rng.integers(0, 2, 40)
    least, most = texture_lookup.extremes(pixels, uv, reach, 3)
    modes, border = texture_lookup.AddressModes(), np.zeros((3, 1))
    tries = np.concatenate([uv[:, None] + reach[:, None] * rng.uniform(-1.0, 1.0, (2, 2000, 40)), uv[:, None]], axis=1)
    within = texture_lookup.linear(pixels, tries.reshape(2, -1), modes, border).reshape(3, -1, 40)
    assert np.all(least <= within.min(axis=1) + 1e-12)
    assert np.all(most >= within.max(axis=1) - 1e-12)
    # Exactly what is there where it reaches nowhere, and never more than the picture has.
    still = ~reach.any(axis=0)
    np.testing.assert_allclose(least[:, still], most[:, still])
    assert np.all(least >= pixels.min(axis=(0, 1))[:, None])
    assert np.all(most <= pixels.max(axis=(0, 1))[:, None])


def test_extremes_of_less_than_a_texel_are_exact(rng):
    pixels = rng.uniform(0.0, 1.0, (8, 8, 1)).astype(np.float32)
    uv, reach = rng.uniform(-1.0, 2.0, (2, 60)), rng.uniform(0.0, 0.99 / 8.0, (2, 60))
    steps = np.linspace(-1.0, 1.0, 201)
    tries = (
        np.stack(np.broadcast_arrays(*np.meshgrid(steps, steps)))[..., None] * reach[:, None, None] + uv[:, None, None]
    )
    modes, border = texture_lookup.AddressModes(), np.zeros((1, 1))
    within = texture_lookup.linear(pixels, tries.reshape(2, -1), modes, border).reshape(-1, 60)
    least, most = texture_lookup.extremes(pixels, uv, reach, 1)
    # A hundredth of the way between neighbours that differ by 1 at most.
    assert np.max(np.abs(least - within.min(axis=0))) < 0.02
    assert np.max(np.abs(most - within.max(axis=0))) < 0.02


# Planted errors: what is done to the pixels that GLSL gets.
WRONG_PIXELS = {
    "a texel to the right": lambda a: np.roll(a, 1, axis=1),
    "a texel up": lambda a: np.roll(a, -1, axis=0),
    "upside down": lambda a: a[::-1],
    "a quarter turned": lambda a: np.rot90(a).copy(),
    "channels exchanged": lambda a: a[..., [1, 0, 2, 3]],
}


@pytest.mark.parametrize("damage", WRONG_PIXELS)
@pytest.mark.parametrize("filtertype", ["linear", "closest"])
def test_wrong_pixels_are_caught(excess, picture, points, damage, filtertype):
    wrong = {name: WRONG_PIXELS[damage](pixels) for name, pixels in picture.items()}
    nodes = shown(image(**modes("periodic", "mirror", filtertype)))
    assert np.mean(excess(nodes, points, picture, drawn=wrong) > 1.0) > MOST


@pytest.mark.parametrize(
    ("right", "wrong"), [(a, b) for a, b in product(ADDRESS_MODES, repeat=2) if a != b], ids="-".join
)
def test_another_address_mode_is_caught(excess, picture, random_surface, rng, right, wrong):
    outside = random_surface(rng, rng.uniform(1.1, 2.0, (SAMPLES, 2)))
    nodes, instead = (shown(image(**modes(mode, mode))) for mode in (right, wrong))
    assert np.mean(excess(nodes, outside, picture, instead=instead) > 1.0) > MOST


def test_another_filter_is_caught(excess, picture, points):
    linear, closest = (shown(image(**modes("clamp", "mirror", f))) for f in ("linear", "closest"))
    assert np.mean(excess(linear, points, picture, instead=closest) > 1.0) > MOST
    assert np.mean(excess(closest, points, picture, instead=linear) > 1.0) > MOST


# Planted errors in the source: the nodes, what is replaced, and by what.
LOOKED_UP = "texture(tex_sampler, uv)"
DAMAGE = {
    "a twentieth of a texel beside": (image(), LOOKED_UP, "texture(tex_sampler, uv + vec2(0.05 / 7.0, 0.0))"),
    "v downward": (image(), LOOKED_UP, "texture(tex_sampler, vec2(uv.x, 1.0 - uv.y))"),
    "u and v exchanged": (image(), LOOKED_UP, "texture(tex_sampler, uv.yx)"),
    "another random number": (image(node="hextiledimage"), "0.1031", "0.1033"),
    "tiles turned the other way": (
        image(node="hextiledimage", offset="float:0", rotationrange="vector2:20, 60"),
        "cos_r.x, -sin_r.x, sin_r.x, cos_r.x", "cos_r.x, sin_r.x, -sin_r.x, cos_r.x",
    ),
    "two tiles exchanged": (image(node="hextiledimage"), "w.x * c1 + w.y * c2", "w.y * c1 + w.x * c2"),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_shader_is_caught(excess, picture, random_surface, rng, damage):
    near = random_surface(rng, rng.uniform(-1.5, 2.5, (SAMPLES, 2)))
    nodes, old, new = DAMAGE[damage]
    assert np.mean(excess(shown(nodes), near, picture, old=old, new=new) > 1.0) > MOST


def test_the_tolerance_of_a_texture_is_a_part_of_a_texel(compared, picture, points):
    tolerance, found = compared(shown(image()), points, picture)
    # Half a 256th of a texel in each of two directions, of pixels in [0, 1]; a third more for coordinates far away.
    assert np.max(tolerance.allowed) < 2.0 * texture_lookup.WEIGHT_ERROR * 4.0 / 3.0
    # What it is for: on the hardware that this runs on, or any other, the weights are of eight bits or better.
    assert np.max(np.abs(found - tolerance.expected)) < np.max(tolerance.allowed)


def test_a_picture_is_its_texels_at_their_centres_and_the_mean_between_them(rng):
    pixels = rng.uniform(0.0, 1.0, (3, 4, 3))
    border = np.zeros((3, 1))
    u, v = (np.arange(4) + 0.5) / 4.0, np.full(4, 1.0 - 0.5 / 3.0)  # the uppermost row
    clamped = texture_lookup.AddressModes("clamp", "clamp")
    np.testing.assert_allclose(texture_lookup.linear(pixels, np.stack([u, v]), clamped, border), pixels[0].T)
    between = np.array([[0.25], [0.5]])
    found = texture_lookup.linear(pixels, between, clamped, border)[:, 0]
    np.testing.assert_allclose(found, 0.5 * (pixels[1, 0] + pixels[1, 1]))


# The texels that a row of four shows from two before its first to two behind its last.
ROWS = {
    "constant": [-1, -1, 0, 1, 2, 3, -1, -1],
    "clamp": [0, 0, 0, 1, 2, 3, 3, 3],
    "periodic": [2, 3, 0, 1, 2, 3, 0, 1],
    "mirror": [1, 0, 0, 1, 2, 3, 3, 2],
}


@pytest.mark.parametrize("mode", ROWS)
def test_address_modes_are_what_their_names_say(mode):
    row = np.arange(4.0)[None, :, None]
    cells = np.stack([np.arange(-2.0, 6.0), np.zeros(8)])
    found = texture_lookup.texel(row, cells, texture_lookup.AddressModes(mode, "clamp"), np.full((1, 1), -1.0))
    np.testing.assert_array_equal(found[0], ROWS[mode])
    columns = texture_lookup.texel(
        row[:, ::-1].swapaxes(0, 1), cells[::-1], texture_lookup.AddressModes("clamp", mode), np.full((1, 1), -1.0)
    )
    np.testing.assert_array_equal(columns[0], ROWS[mode])  # counted from below


def test_coordinates_that_are_no_numbers_find_some_texel():
    pixels = np.ones((2, 2, 1))
    uv = np.array([[np.nan, np.inf, -np.inf], [0.5, 0.5, 0.5]])
    for mode in ADDRESS_MODES:
        with np.errstate(invalid="ignore"):
            found = texture_lookup.texel(
                pixels, texture_lookup.cell(pixels, uv), texture_lookup.AddressModes(mode), np.zeros((1, 1))
            )
        assert found.shape == (1, 3)


def test_tiles_cover_the_plane_and_do_not_jump(rng):
    edge = np.array([1.0, 0.0, 0.5]), np.array([0.0, 1.0, 0.5])
    assert all(len(e) == 3 for e in edge)
    spread = hextile.Spread(*(np.asarray(x) for x in (0.0, [0.0, 360.0], 0.0, [0.5, 2.0], 0.0, [0.0, 1.0])))
    coord = rng.uniform(-3.0, 3.0, (2, 20000))
    tiles = hextile.tiles(coord, spread)
    barycentric = tiles.weights ** (1.0 / hextile.SHARPNESS)
    np.testing.assert_allclose(np.sum(barycentric, axis=0), 1.0, rtol=1e-12)
    assert np.min(barycentric) >= 0.0
    # Neither turned, scaled nor shifted, all tiles show the same place.
    np.testing.assert_allclose(tiles.coordinates, np.broadcast_to(coord, tiles.coordinates.shape), atol=1e-12)
    step = 1e-7
    moved = hextile.tiles(coord + step, spread).weights
    jumps = np.abs(np.sort(moved, axis=0) - np.sort(tiles.weights, axis=0))
    assert np.max(jumps) < 100.0 * step


def test_random_numbers_of_tiles_are_within_their_error_in_float32():
    corners = np.stack(np.meshgrid(np.arange(-60.0, 60.0), np.arange(-60.0, 60.0))).reshape(1, 2, -1)
    exact, error = hextile.random_pair(corners), hextile.random_error(corners)
    single = float32_pair(corners[0])
    off = np.abs(single - exact[0])
    off = np.minimum(off, 1.0 - off)  # around the circle
    assert np.all(off <= error[0])
    assert np.max(off / error[0]) > 0.1  # within a factor of ten of what happens
    assert np.max(error) < 0.1


def float32_pair(corners: Array) -> Array:
    """The hash of MaterialX's hex tiling, step by step in float32."""
    f = np.float32
    p = corners.astype(f) + f(0.12345)
    p = np.stack([p[0] * f(0.1031), p[1] * f(0.1030), p[0] * f(0.0973)])
    p = p - np.floor(p)
    terms = p * (p[[1, 2, 0]] + f(33.33))
    p = p + ((terms[0] + terms[1]) + terms[2])
    found = (p[0] + p[1:]) * p[[2, 1]]
    assert found.dtype == f
    return (found - np.floor(found)).astype(float)
