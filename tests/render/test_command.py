"""`mrm render`: options, files and refusals, as the command has them."""

from __future__ import annotations

import os
import shutil
from functools import partial

import numpy as np
import pytest

from mrm_mtlx.documents.images import read_image

SIZE = 24


@pytest.fixture
def metal(gl, documents, tmp_path):
    """A document with a retroreflective metal, in the test's folder."""
    return shutil.copy(documents / "SHADER_IGNORES_RETRO" / "triggers.mtlx", tmp_path / "metal.mtlx")


@pytest.fixture
def render(mrm_here, metal):
    """Function from arguments after the document to the finished command."""
    return partial(mrm_here, "render", metal.name)


@pytest.fixture
def pixels(render, tmp_path):
    """Function from options to the linear pixels of the picture."""

    def read(*options: object):
        done = render("-o", "a.exr", "--size", SIZE, *options)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "wrote a.exr\n")
        return read_image(tmp_path / "a.exr")

    return read


def test_a_picture_is_written_and_said_so(mrm, metal, tmp_path):
    done = mrm("render", metal.name, "-o", "a.png", "--size", SIZE)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "wrote a.png\n")
    found = read_image(tmp_path / "a.png")
    assert found.shape == (SIZE, SIZE, 3)
    assert np.ptp(found) > 0.3


def test_options_show_in_the_picture(pixels):
    plain = pixels()
    assert np.array_equal(pixels(), plain)
    for options in (("--shape", "plane"), ("--shape", "cone"), ("--light", "30")):
        assert not np.allclose(pixels(*options), plain, rtol=0.1)


def test_a_comparison_is_four_pictures_wide(pixels):
    found = pixels("--compare")
    assert found.shape == (SIZE, 4 * SIZE + 3 * 4, 3)
    middle = [found[SIZE // 2, k * (SIZE + 4) + SIZE // 4] for k in range(4)]
    # A quarter from the left: away from the ordinary highlight, bright only as a retroreflector lit from the eye.
    assert np.argmax([m[0] for m in middle]) == 2
    assert middle[2][0] > 10.0 * max(middle[k][0] for k in (0, 1, 3))


def test_surroundings_are_read_from_an_image(pixels, write_image, tmp_path):
    sky = np.zeros((16, 32, 3))
    sky[:, :, 2] = 0.5
    write_image(tmp_path / "sky.exr", sky)
    found = pixels("--environment", "sky.exr")
    np.testing.assert_allclose(found[0], [[0.0, 0.0, 0.5]] * SIZE)
    dark = pixels()
    assert np.mean(found[..., 2] - dark[..., 2]) > 0.1
    np.testing.assert_allclose(found[8:16, 8:16, 0], dark[8:16, 8:16, 0], rtol=0.01)  # blue adds no red


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("-o", "a.jpg"), "a.jpg: expected a name that ends in .png or .exr"),
        (("-o", "a"), "a: expected a name that ends in .png or .exr"),
        (("-o", "no/such/folder/a.png"), "no/such/folder/a.png cannot be written"),
        (("-o", "no/such/folder/a.exr"), "no/such/folder/a.exr cannot be written"),
        (("-o", "a.png", "--light", "bright"), "'bright': expected headlight or an angle in degrees"),
        (("-o", "a.png", "--light", "181"), "181: expected an angle from -180 to 180 degrees"),
        (("-o", "a.png", "--light", "nan"), "nan: expected an angle from -180 to 180 degrees"),
        (("-o", "a.png", "--element", "other"), "other: expected one of material"),
        (("-o", "a.png", "--environment", "nothing.exr"), "nothing.exr: cannot be read as an image"),
        (("-o", "a.png", "--environment", "metal.mtlx"), "metal.mtlx: cannot be read as an image"),
        (("-o", "a.png", "--environment", "."), "cannot be read as an image"),
    ],
)
def test_a_wrong_call_is_one_line_and_no_picture(render, tmp_path, arguments, words):
    done = render(*arguments, "--size", SIZE)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("Error: ") == 1
    assert words in done.stderr.strip().splitlines()[-1]
    assert sorted(os.listdir(tmp_path)) == ["metal.mtlx"]  # noqa: PTH208


def test_a_comparison_of_a_material_without_the_flag_says_that_there_is_nothing_to_compare(render, tmp_path):
    text = (tmp_path / "metal.mtlx").read_text(encoding="utf-8")
    (tmp_path / "metal.mtlx").write_text(text.replace('value="true"', 'value="false"'), encoding="utf-8")
    done = render("-o", "a.exr", "--size", SIZE, "--compare")
    assert "retroreflective" in done.stderr
