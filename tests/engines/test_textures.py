"""Images on their way into the shader, and the state of their samplers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.documents.images import as_read
from mrm_mtlx.engines.base import Lighting
from mrm_mtlx.engines.gl.context import context, parking_target
from mrm_mtlx.engines.gl.image_calls import Sampling, samplings
from mrm_mtlx.engines.gl.textures import upload
from tests.fixtures.versions import since

UNIT = 2.0**-24


PICTURE = """
<image name="picture" type="{kind}">
  <input name="file" type="filename" value="picture.exr" {colorspace}/>
  <input name="uaddressmode" type="string" value="periodic"/>
</image>
<surface_unlit name="lamp" type="surfaceshader"><input name="{use}" type="{kind}" nodename="picture"/></surface_unlit>
"""


@pytest.fixture
def shown(program, make_document):
    """Function from pixels and texture coordinates to what a surface shows of the picture."""

    def show(pixels, texcoord, kind: str = "color3", colorspace: str = ""):
        use = {"color3": "emission_color", "float": "emission"}[kind]
        document = make_document(PICTURE.format(kind=kind, use=use, colorspace=colorspace))
        linked = program(document, element="lamp", textures={"picture_file": pixels})
        return linked.draw({"texcoord_0": texcoord}, Lighting())[:, :3]

    return show


def centres(height: int, width: int):
    """Texture coordinates of the texels' centres, row by row from the top: v grows upward."""
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, 1.0 - (np.arange(height) + 0.5) / height)
    return np.stack([u, v], axis=-1).reshape(-1, 2)


# Absolute, for pixels up to 4: a texel's centre is found to within a rounding of a coordinate times the size, up to 10
# texels, and the neighbour enters with that weight in each of two directions.
TEXEL_TOL = 2 * 10 * 4 * UNIT * 2


@pytest.mark.parametrize("size", [(4, 8), (3, 5), (10, 7), (1, 1)])
def test_an_image_node_shows_the_pixels(shown, rng, size):
    stored = rng.uniform(-4.0, 4.0, (*size, 3)).astype(np.float32)
    found = shown(stored, centres(*size))
    np.testing.assert_allclose(found, stored.reshape(-1, 3), rtol=0.0, atol=TEXEL_TOL)
    if size != (1, 1):
        upside_down = stored[::-1].reshape(-1, 3) if size[0] > 1 else stored[:, ::-1].reshape(-1, 3)
        assert np.max(np.abs(found - upside_down)) > TEXEL_TOL


def test_between_two_texels_the_picture_is_their_mean(shown, rng):
    pixels = rng.uniform(0.0, 4.0, (1, 4, 3)).astype(np.float32)
    found = shown(pixels, np.array([[0.5, 0.5]]))
    np.testing.assert_allclose(found[0], pixels[0, 1:3].mean(axis=0), rtol=0.0, atol=TEXEL_TOL)


def test_the_picture_repeats_beyond_its_border(shown, rng):
    pixels = rng.uniform(0.0, 4.0, (4, 4, 3)).astype(np.float32)
    at = centres(4, 4)
    # Coordinates up to 3 lose another bit and a half.
    np.testing.assert_allclose(
        shown(pixels, at + np.array([2.0, 0.0])), shown(pixels, at), rtol=0.0, atol=4 * TEXEL_TOL
    )


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_images_of_any_number_of_channels_keep_their_order(shown, rng, channels):
    stored = rng.uniform(0.0, 1.0, (2, 3, channels)).astype(np.float32)
    found = shown(stored, centres(2, 3))
    # A grey picture is grey, a second channel is its opacity, as image files have it.
    colour = stored if channels >= 3 else np.repeat(stored[..., :1], 3, axis=-1)
    np.testing.assert_allclose(found, colour[..., :3].reshape(-1, 3), rtol=0.0, atol=TEXEL_TOL)


def test_a_grey_picture_serves_as_a_number(shown, rng):
    pixels = rng.uniform(0.0, 1.0, (2, 2, 1)).astype(np.float32)
    found = shown(pixels, centres(2, 2), kind="float")
    np.testing.assert_allclose(found[:, 0], pixels.ravel(), rtol=0.0, atol=TEXEL_TOL)


def test_a_picture_in_a_colour_space_is_decoded_in_the_shader(shown):
    stored = np.linspace(0.0, 1.0, 12, dtype=np.float32).reshape(2, 2, 3)
    found = shown(stored, centres(2, 2), colorspace='colorspace="srgb_texture"')
    # IEC 61966-2-1; relative, for pow in GLSL: 2^-21 of the logarithm, times the exponent, and a few units more.
    x = stored.reshape(-1, 3).astype(float)
    expected = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(found, expected, rtol=64 * UNIT, atol=TEXEL_TOL)
    assert np.max(np.abs(found - x)) > TEXEL_TOL


@pytest.mark.parametrize(("kind", "default"), [("color3", "0.25, 0.5, 0.75"), ("float", "0.25")])
def test_a_picture_that_is_not_given_is_the_nodes_default(program, make_document, kind, default):
    use = {"color3": "emission_color", "float": "emission"}[kind]
    given = f'<input name="default" type="{kind}" value="{default}"/></image>'
    document = make_document(PICTURE.format(kind=kind, use=use, colorspace="").replace("</image>", given))
    linked = program(document, element="lamp", textures={})
    numbers = [float(x) for x in default.split(",")]
    expected = numbers if kind == "color3" else numbers * 3
    # Exact: the numbers are float32's.
    assert np.array_equal(linked.draw({"texcoord_0": [[0.3, 7.7]]}, Lighting())[0], [*expected, 1.0])


# How a row of four texels goes on to its left and its right, two texels each.
BEYOND = {"constant": [8, 8, 8, 8], "clamp": [0, 0, 3, 3], "periodic": [2, 3, 0, 1], "mirror": [1, 0, 3, 2]}


@pytest.mark.parametrize("mode", BEYOND)
def test_what_is_beyond_the_border_follows_from_the_address_modes(gl_clean, mode):
    row = np.arange(4, dtype=np.float32).reshape(1, 4, 1)
    at = np.array([-1.5, -0.5, 4.5, 5.5]) / 4.0
    for u, v, pixels, texcoord in (
        (mode, "clamp", row, [[x, 0.5] for x in at]),
        ("clamp", mode, row[:, ::-1].swapaxes(0, 1), [[0.5, y] for y in at]),  # counted from below
    ):
        found = look_up(pixels, Sampling(u, v, "closest", (8.0,), 1), np.array(texcoord))
        np.testing.assert_array_equal(found[:, 0], BEYOND[mode])


def test_the_border_has_the_defaults_colour_whatever_the_channels_of_the_image(gl_clean):
    for channels in (1, 2, 3, 4):
        pixels = np.ones((2, 2, channels), dtype=np.float32)
        sampling = Sampling("constant", "constant", "linear", (0.25, 0.5, 0.75), 3)
        found = look_up(pixels, sampling, np.array([[-1.0, 0.5], [0.5, 3.0]]))
        np.testing.assert_array_equal(found[:, :3], [[0.25, 0.5, 0.75]] * 2)


def test_the_closest_texel_is_not_mixed_with_its_neighbour(gl_clean):
    row = np.arange(4, dtype=np.float32).reshape(1, 4, 1)
    at = np.array([[0.26, 0.5], [0.49, 0.5]])
    np.testing.assert_array_equal(look_up(row, Sampling(filter="closest"), at)[:, 0], [1.0, 1.0])
    for smooth in ("linear", "cubic"):
        # A 25th of a texel from the border: 0.46 of the way from texel to texel.
        np.testing.assert_allclose(look_up(row, Sampling(filter=smooth), at)[:, 0], [0.54, 1.46], atol=TEXEL_TOL)


LOOK_UP = """
#version 400
{declared}
void main() {{ {body} }}
"""


def look_up(pixels, sampling: Sampling, texcoord):
    """A texture as a shader sees it, (samples, 4)."""
    gl = context()
    program = gl.program(
        vertex_shader=LOOK_UP.format(
            declared="in vec2 at; out vec2 uv; uniform int size;",
            body="uv = at; gl_Position = vec4((float(gl_VertexID) + 0.5) / float(size) * 2.0 - 1.0, 0.0, 0.0, 1.0);",
        ).strip(),
        fragment_shader=LOOK_UP.format(
            declared="in vec2 uv; out vec4 color; uniform sampler2D image;", body="color = texture(image, uv);"
        ).strip(),
    )
    program["size"] = len(texcoord)
    texture = upload(gl, pixels, sampling)
    buffer = gl.buffer(np.asarray(texcoord, dtype="f4").tobytes())
    target = gl.framebuffer(color_attachments=[gl.texture((len(texcoord), 1), 4, dtype="f4")])
    target.use()
    texture.use(0)
    gl.vertex_array(program, [(buffer, "2f", "at")]).render(gl.POINTS)
    found = np.frombuffer(target.read(components=4, dtype="f4"), dtype=np.float32).reshape(-1, 4)
    parking_target().use()
    for each in (texture, buffer, target, program):
        each.release()
    return found


FILE = '<input name="file" type="filename" value="picture.exr"/>'
MODES = '<input name="uaddressmode" type="string" value="{}"/><input name="vaddressmode" type="string" value="{}"/>'
# Nodes `a`, the output that is shown, and how they look up their image.
CALLS = {
    "what the node has": (
        f'<image name="a" type="color3">{FILE}{MODES.format("mirror", "clamp")}'
        '<input name="filtertype" type="string" value="closest"/>'
        '<input name="default" type="color3" value="0.25, 0.5, 0.75"/></image>',
        Sampling("mirror", "clamp", "closest", (0.25, 0.5, 0.75), 3),
    ),
    "defaults": (f'<image name="a" type="color3">{FILE}</image>', Sampling(default=(0.0,) * 3, components=3)),
    "a mode that a graph decides": (
        f'<latlongimage name="a" type="color3">{FILE}</latlongimage>',
        Sampling("periodic", "mirror", "linear", (0.0, 0.0, 0.0), 3),
    ),
    "a mode of another name": (
        f'<UsdUVTexture name="a" type="multioutput">{FILE}<input name="wrapT" type="string" value="black"/>'
        '<input name="fallback" type="color4" value="0.25, 0.5, 0.75, 0.5"/></UsdUVTexture>',
        Sampling("periodic", "constant", "linear", (0.25, 0.5, 0.75, 0.5), 4),
    ),
    "through two graphs": (
        f'<gltf_colorimage name="a" type="multioutput">{FILE}<input name="filtertype" type="string" value="cubic"/>'
        "</gltf_colorimage>",
        Sampling(filter="cubic"),
    ),
    "a default in a colour space": (
        f'<image name="a" type="color3">{FILE}'
        '<input name="default" type="color3" value="0.25, 0.5, 0.75" colorspace="srgb_texture"/></image>',
        Sampling(default=(0.25, 0.5, 0.75), components=3),
    ),
    "a default that is computed": (
        '<texcoord name="t" type="vector2"/><convert name="c" type="vector3">'
        '<input name="in" type="vector2" nodename="t"/></convert><convert name="d" type="color3">'
        '<input name="in" type="vector3" nodename="c"/></convert>'
        f'<image name="a" type="color3">{FILE}<input name="default" type="color3" nodename="d"/></image>',
        Sampling(default=(0.0,) * 3, components=3),
    ),
    "a mode by its name": (
        '<nodedef name="ND_own" node="own"><input name="file" type="filename" uniform="true"/>'
        '<input name="beyond" type="string" value="clamp" uniform="true"/><output name="out" type="color3"/></nodedef>'
        '<nodegraph name="NG_own" nodedef="ND_own"><image name="i" type="color3">'
        '<input name="file" type="filename" interfacename="file"/>'
        '<input name="uaddressmode" type="string" interfacename="beyond"/></image>'
        '<output name="out" type="color3" nodename="i"/></nodegraph>'
        f'<own name="a" type="color3">{FILE}<input name="beyond" type="string" value="mirror"/></own>',
        Sampling("mirror", default=(0.0,) * 3, components=3),
    ),
    "hex tiles": (
        f'<hextiledimage name="a" type="color4">{FILE}<input name="default" type="color4" value="0.25, 0.5, 0, 1"/>'
        '</hextiledimage><convert name="b" type="color3"><input name="in" type="color4" nodename="a"/></convert>',
        Sampling(default=(0.25, 0.5, 0.0, 1.0)),
    ),
}


# Nodes that came with a version.
LATER = {
    "hex tiles": since("1.39.4", "hex-tiled images"),
    "a mode that a graph decides": since("1.39.3", "latlongimage"),
}


@pytest.mark.parametrize("name", [pytest.param(name, marks=LATER.get(name, ())) for name in CALLS])
@pytest.mark.parametrize("target", ["glsl", "essl"])
def test_generated_code_says_how_its_images_are_looked_up(shader_of, make_document, name, target):
    nodes, expected = CALLS[name]
    last = "b" if 'name="b"' in nodes else "a"
    outputs = {"<UsdUVTexture": 'output="rgb"', "<gltf_colorimage": 'output="outcolor"'}
    output = outputs.get(nodes.split()[0], "")
    color = f'<input name="emission_color" type="color3" nodename="{last}" {output}/>'
    lamp = f'<surface_unlit name="lamp" type="surfaceshader">{color}</surface_unlit>'
    found = samplings(shader_of(make_document(nodes + lamp), element="lamp", target=target))
    assert set(found) == {"a_file"}
    assert found["a_file"].default == pytest.approx(expected.default)
    assert replace(found["a_file"], default=expected.default, read=4) == expected
    assert found["a_file"].read == found["a_file"].components


@pytest.mark.parametrize("order", [("float", "color3"), ("color3", "float")])
def test_a_texture_has_what_all_nodes_read_that_share_its_file(shader_of, make_document, order):
    images = "".join(
        f'<image name="{kind}" type="{kind}"><input name="file" type="filename" interfacename="file"/></image>'
        for kind in order
    )
    nodes = (
        '<nodedef name="ND_own" node="own"><input name="file" type="filename" uniform="true"/>'
        '<output name="out" type="color3"/></nodedef>'
        f'<nodegraph name="NG_own" nodedef="ND_own">{images}<multiply name="p" type="color3">'
        '<input name="in1" type="color3" nodename="color3"/><input name="in2" type="float" nodename="float"/>'
        '</multiply><output name="out" type="color3" nodename="p"/></nodegraph>'
        f'<own name="a" type="color3">{FILE}</own>'
        '<surface_unlit name="lamp" type="surfaceshader">'
        '<input name="emission_color" type="color3" nodename="a"/></surface_unlit>'
    )
    (found,) = samplings(shader_of(make_document(nodes), element="lamp", target="glsl")).values()
    assert found.read == 3


@pytest.mark.parametrize("kind", ["u1", "u2", "f2", "f4"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("mode", ["periodic", "constant"])
@pytest.mark.parametrize("read", [1, 2, 3, 4])
def test_pixels_are_shown_as_they_are_stored(gl_clean, rng, monkeypatch, kind, channels, mode, read):
    monkeypatch.setattr("mrm_mtlx.engines.gl.textures._STRIP_BYTES", 64)  # so that an image goes in several parts
    stored = (rng.integers(0, 256, (5, 7, channels)) * (257 if kind == "u2" else 1)).astype(kind)
    stored = stored if kind[0] == "u" else (stored / 255).astype(kind)
    row, column = np.divmod(np.arange(35), 7)
    at = np.stack([(column + 0.5) / 7, 1.0 - (row + 0.5) / 5], axis=1)
    sampling = Sampling(mode, mode, components=read, read=read)
    found = look_up(stored, sampling, at)[:, :read]
    # Texels in the middle; a whole number becomes a float by one rounding, as does its weight.
    np.testing.assert_allclose(found, as_read(stored, read).reshape(35, -1), rtol=2**-22)
