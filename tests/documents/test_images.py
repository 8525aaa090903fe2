"""Image files: reading them, and their channels."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio
import pytest

from mrm_mtlx.documents import images
from mrm_mtlx.documents.images import as_read, read_image, srgb_decoded, srgb_encoded

UNIT = 2.0**-24


@pytest.mark.parametrize("size", [(4, 8), (3, 5), (1, 1)])
def test_what_is_read_is_what_was_written(write_image, rng, tmp_path, size):
    path = tmp_path / "picture.exr"
    stored = rng.uniform(-4.0, 4.0, (*size, 3)).astype(np.float32)
    write_image(path, stored)
    assert np.array_equal(read_image(path), stored)


def test_pixels_of_eight_bits_are_shares_of_one(write_image, tmp_path):
    path = tmp_path / "picture.png"
    stored = np.arange(24).reshape(2, 4, 3) / 255.0 * 10.0
    write_image(path, stored)
    # Stored as whole numbers; as float32 again.
    np.testing.assert_allclose(read_image(path), np.round(stored * 255.0) / 255.0, rtol=4 * UNIT)


@pytest.mark.parametrize("content", [None, b"", b"no picture at all"])
def test_a_file_that_is_no_picture_is_a_value_error_with_its_name(tmp_path, content):
    path = tmp_path / "broken.exr"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=r"^broken\.exr: cannot be ") as caught:
        read_image(path)
    assert str(tmp_path) not in str(caught.value).replace(str(path), "")


def test_a_picture_that_ends_too_early_is_a_value_error(write_image, tmp_path, rng):
    path = tmp_path / "short.exr"
    write_image(path, rng.uniform(0.0, 1.0, (64, 64, 3)))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ValueError, match=r"^short\.exr: cannot be "):
        read_image(path)


@pytest.mark.parametrize(("limit", "bound"), [("MAXIMUM_SIDE", 7), ("MAXIMUM_VALUES", 8 * 4 * 3 - 1)])
def test_a_picture_that_is_too_large_is_a_value_error(write_image, monkeypatch, tmp_path, limit, bound):
    path = tmp_path / "large.png"
    write_image(path, np.zeros((4, 8, 3)))
    monkeypatch.setattr(images, limit, bound)
    with pytest.raises(ValueError, match=r"^large\.png: 8 x 4 pixels are more than are read$"):
        read_image(path)
    monkeypatch.setattr(images, limit, bound + 1)
    assert read_image(path).shape == (4, 8, 3)


# What nodes of one to four components read of images of one to four channels; 9 is opaque.
READ = {
    1: ([1], [1, 1], [1, 1, 1], [1, 1, 1, 9]),
    2: ([1], [1, 2], [1, 1, 1], [1, 1, 1, 2]),
    3: ([1], [1, 2], [1, 2, 3], [1, 2, 3, 9]),
    4: ([1], [1, 2], [1, 2, 3], [1, 2, 3, 4]),
    6: ([1], [1, 2], [1, 2, 3], [1, 2, 3, 4]),
}


@pytest.mark.parametrize("channels", READ)
def test_channels_become_components(channels):
    pixels = np.tile(np.arange(1.0, channels + 1.0), (2, 3, 1))
    for components, expected in enumerate(READ[channels], 1):
        found = as_read(pixels, components)
        assert found.shape == (2, 3, components)
        assert [9 if n == 9 else x for n, x in zip(expected, found[0, 0], strict=True)] == expected
        assert all(x == 1.0 for n, x in zip(expected, found[0, 0], strict=True) if n == 9)


def test_the_colours_of_a_transparent_png_are_those_stored(tmp_path):
    stored = np.array([[[200, 100, 50, 128]]], dtype=np.uint8)
    spec = oiio.ImageSpec(1, 1, 4, "uint8")
    spec.attribute("oiio:UnassociatedAlpha", 1)
    target = oiio.ImageOutput.create(str(tmp_path / "clear.png"))
    target.open(str(tmp_path / "clear.png"), spec)
    target.write_image(stored)
    target.close()
    # Multiplied by the alpha, as OpenImageIO has it by default, they would be half of that.
    assert np.round(read_image(tmp_path / "clear.png") * 255.0).tolist() == stored.tolist()


def test_srgb_is_encoded_and_decoded_as_the_standard_says():
    # IEC 61966-2-1: the line up to 0.0031308, and the power above it, which gives the middle grey of 8 bits, 118.
    np.testing.assert_allclose(
        srgb_encoded(np.array([-0.001, 0.0, 0.003, 1.0])), [-0.01292, 0.0, 0.03876, 1.0], rtol=1e-9
    )
    assert round(255.0 * float(srgb_encoded(np.array(0.18)))) == 118
    levels = np.linspace(-0.1, 1.5, 200)
    # The two pieces meet within 1e-7 of each other in the standard's rounded constants.
    np.testing.assert_allclose(srgb_decoded(srgb_encoded(levels)), levels, rtol=0.0, atol=1e-6)
