"""Image files: reading them, and their way into the shader."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio
import pytest

from mrm_mtlx.engines.gl import Lighting
from mrm_mtlx.library.images import read_image

UNIT = 2.0**-24


def write_image(path, pixels) -> None:
    """An image file of the type that its name says; float for EXR, 8 bits for PNG."""
    height, width, channels = pixels.shape
    kind = oiio.FLOAT if path.suffix == ".exr" else oiio.UINT8
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), oiio.ImageSpec(width, height, channels, kind)), output.geterror()
    assert output.write_image(pixels.astype(np.float32)), output.geterror()
    output.close()


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
def test_an_image_node_shows_the_files_pixels(shown, rng, tmp_path, size):
    path = tmp_path / "picture.exr"
    stored = rng.uniform(-4.0, 4.0, (*size, 3)).astype(np.float32)
    write_image(path, stored)
    pixels = read_image(path)
    assert np.array_equal(pixels, stored)
    found = shown(pixels, centres(*size))
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


def test_pixels_of_eight_bits_are_shares_of_one(tmp_path):
    path = tmp_path / "picture.png"
    stored = np.arange(24).reshape(2, 4, 3) / 255.0 * 10.0
    write_image(path, stored)
    # Stored as whole numbers; as float32 again.
    np.testing.assert_allclose(read_image(path), np.round(stored * 255.0) / 255.0, rtol=4 * UNIT)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_images_of_any_number_of_channels_keep_their_order(shown, rng, tmp_path, channels):
    path = tmp_path / "picture.exr"
    stored = rng.uniform(0.0, 1.0, (2, 3, channels)).astype(np.float32)
    write_image(path, stored)
    found = shown(read_image(path), centres(2, 3))
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


def test_a_picture_that_is_not_given_is_black(program, make_document):
    document = make_document(PICTURE.format(kind="color3", use="emission_color", colorspace=""))
    linked = program(document, element="lamp")
    assert np.array_equal(linked.draw({"texcoord_0": [[0.3, 0.7]]}, Lighting()), [[0.0, 0.0, 0.0, 1.0]])


@pytest.mark.parametrize("content", [None, b"", b"no picture at all"])
def test_a_file_that_is_no_picture_is_a_value_error_with_its_name(tmp_path, content):
    path = tmp_path / "broken.exr"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=r"^broken\.exr: cannot be ") as caught:
        read_image(path)
    assert str(tmp_path) not in str(caught.value).replace(str(path), "")


def test_a_picture_that_ends_too_early_is_a_value_error(tmp_path, rng):
    path = tmp_path / "short.exr"
    write_image(path, rng.uniform(0.0, 1.0, (64, 64, 3)))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ValueError, match=r"^short\.exr: cannot be "):
        read_image(path)
