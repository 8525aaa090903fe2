"""Pictures: what a pixel holds is what the reference says, and every option shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from mrm_mtlx.documents.images import read_image
from mrm_mtlx.engines.base import DirectionalLight, PointLight
from mrm_mtlx.engines.gl import ENGINE
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.render import picture
from mrm_mtlx.render.environment import look_up
from mrm_mtlx.render.shapes import EYE, SHAPES, camera_rays, intersect

SIZE = 24
BACKDROP = 0.004

# Relative, by GLSL 4.60, section 4.7.1. The light falls off as pow(distance + 1, 2), which is exp2(2 log2(7)): 3 ulp of
# a logarithm between 2 and 4, doubled; 3 + 2 * 6 ulp of exp2; 8 units for the distance, twice. One ulp is two units.
LIGHT_TOL = (3 * 4 * 2 * 2 + (3 + 2 * 6) * 2 + 2 * 8) * 2.0**-24

# Relative. Half has 11 bits; four samples are averaged before.
HALF_TOL = 2.0**-11
HALF_MAX = 65504.0

# Of a ratio of two logarithms in float64 that should be 1.
ONE_TOL = 4 * 2.0**-53

WHITE = (
    '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" value="1, 1, 1"/>'
    "</oren_nayar_diffuse_bsdf>"
)


def seen(shape: str, size: int = SIZE):
    """Whether a sample shows the shape, as the picture's array has it."""
    return intersect(shape, camera_rays(2 * size)).found.reshape(2 * size, 2 * size)


def expected(document, shape: str, degrees: float | None):
    """Radiance of the samples that show the shape by the reference, and how far float32 may be off."""
    hits = intersect(shape, camera_rays(2 * SIZE))
    p, n, x = (a[hits.found] for a in (hits.position, hits.normal, hits.tangent))
    to_eye = EYE - p
    distance = np.linalg.norm(to_eye, axis=1, keepdims=True)
    v = to_eye / distance
    # MaterialX's point light falls off as 1 / (distance + 1)^2; it is set for the origin.
    irradiance = np.pi * ((np.linalg.norm(EYE) + 1.0) / (distance + 1.0)) ** 2
    l = v
    if degrees is not None:
        ahead = EYE / np.linalg.norm(EYE)
        right = np.cross([0.0, 1.0, 0.0], ahead)
        angle = np.deg2rad(degrees)
        l = np.cos(angle) * ahead + np.sin(angle) * right / np.linalg.norm(right)
        irradiance = np.pi
    tolerance = Surface(document.getNode("m")).tolerance(
        ShadingPoints(
            view=v, light=np.broadcast_to(l, v.shape), normal=n, tangent=x, position=p, texcoord=np.zeros((len(p), 2))
        )
    )
    value = tolerance.expected * irradiance
    return value, tolerance.allowed * irradiance + LIGHT_TOL * np.abs(value)


def misses(found, value, allowed):
    return np.mean(np.any(np.abs(found - value) > allowed, axis=1))


@pytest.mark.parametrize("degrees", [None, 30.0, -75.0])
@pytest.mark.parametrize("flag", ["true", "false"])
@pytest.mark.parametrize("shape", SHAPES)
def test_every_sample_is_what_the_reference_says(rendered, surface_document, tape_nodes, shape, flag, degrees):
    image = rendered(tape_nodes(flag), shape=shape, light_degrees=degrees)
    assert image.shape == (2 * SIZE, 2 * SIZE, 3)
    document = surface_document(tape_nodes(flag))
    value, allowed = expected(document, shape, degrees)
    # Where the light is below the horizon, MaterialX's shaders clamp its cosine instead of cutting it off; so does the
    # reference. The samples on the very edge of that are covered by the tolerance.
    assert misses(image[seen(shape)], value, allowed) == 0.0
    assert np.all(image[~seen(shape)] == BACKDROP)
    # Two-sided: the tolerance tells the flag and the light from others.
    other, _ = expected(document, shape, 29.0 if degrees == 30.0 else 30.0)
    assert misses(image[seen(shape)], other, allowed) > 0.5
    turned = surface_document(tape_nodes("false" if flag == "true" else "true"))
    assert misses(image[seen(shape)], expected(turned, shape, degrees)[0], allowed) > 0.3


def test_a_white_diffuser_that_faces_the_light_has_radiance_1(rendered):
    image = rendered(WHITE)
    # The sphere's nearest point is closer than the origin, for which the light is set.
    nearest = ((np.linalg.norm(EYE) + 1.0) / np.linalg.norm(EYE)) ** 2
    assert np.max(image) == pytest.approx(nearest, rel=0.01)  # the sample nearest to it, a fortieth of the radius off
    assert rendered(WHITE, light_degrees=0.0).max() == pytest.approx(1.0, rel=0.01)


def test_a_headlight_lights_up_a_retroreflector_all_over_and_an_ordinary_surface_in_one_spot(rendered, tape_nodes):
    narrow = "0.0025, 0.0025"
    turned, ordinary = (rendered(tape_nodes(flag, narrow))[seen("sphere")] for flag in ("true", "false"))
    assert np.median(turned[:, 0] / ordinary[:, 0]) > 1000.0
    assert np.median(ordinary[:, 0]) < 1.0 < 100.0 < np.median(turned[:, 0])
    # From aside, the difference is gone but for the spot.
    turned, ordinary = (
        rendered(tape_nodes(flag, narrow), light_degrees=30.0)[seen("sphere")] for flag in ("true", "false")
    )
    assert np.median(turned[:, 0] / ordinary[:, 0]) == pytest.approx(1.0, abs=0.05)


def test_a_comparison_has_four_panels_flag_by_light(rendered, tape_nodes):
    image = rendered(tape_nodes("true"), compare=True, size=16)
    width, gap = 32, 8
    assert image.shape == (32, 4 * width + 3 * gap, 3)
    panels = [image[:, k * (width + gap) : k * (width + gap) + width] for k in range(4)]
    for panel, (flag, degrees) in zip(
        panels, [("false", None), ("false", 30.0), ("true", None), ("true", 30.0)], strict=True
    ):
        assert np.array_equal(panel, rendered(tape_nodes(flag), light_degrees=degrees, size=16))
    for k in range(3):
        assert np.all(image[:, k * (width + gap) + width : (k + 1) * (width + gap)] == BACKDROP)


def test_a_comparison_takes_the_angle_of_its_light_from_the_settings(rendered, tape_nodes):
    image = rendered(tape_nodes("true"), compare=True, size=16, light_degrees=10.0)
    assert np.array_equal(image[:, 40:72], rendered(tape_nodes("false"), light_degrees=10.0, size=16))


# Environment ----------------------------------------------------------------------------------------------------------


def test_the_surroundings_are_seen_behind_the_shape(rendered, rng):
    sky = rng.random((16, 32, 3))
    image = rendered(WHITE, environment=sky)
    away = ~seen("sphere")
    behind = look_up(sky, camera_rays(2 * SIZE)).reshape(image.shape).astype(np.float32)
    assert np.array_equal(image[away], behind[away])


def test_the_surroundings_light_the_shape_on_top_of_the_light(rendered):
    black, grey = (rendered(WHITE, environment=np.full((16, 32, 3), level))[seen("sphere")] for level in (0.0, 0.5))
    np.testing.assert_allclose(black, rendered(WHITE)[seen("sphere")], rtol=LIGHT_TOL)
    # A white diffuser under a constant environment has its radiance, wherever it faces.
    np.testing.assert_allclose(grey - black, 0.5, rtol=1e-3)


def test_the_surroundings_light_from_where_they_are(rendered):
    sky = np.zeros((16, 32, 3))
    sky[:8] = 1.0
    up, down = (rendered(WHITE, environment=image)[seen("sphere")].sum() for image in (sky, sky[::-1]))
    # The eye looks down on the sphere: what the sky lights is turned to it.
    assert up > 1.05 * down
    left, right = np.zeros((2, 16, 32, 3))
    left[:, 4:12], right[:, 20:28] = 1.0, 1.0
    lit = [rendered(WHITE, environment=image) - rendered(WHITE) for image in (left, right)]
    half = np.broadcast_to(np.arange(2 * SIZE) < SIZE, (2 * SIZE, 2 * SIZE)) & seen("sphere")
    other = half[:, ::-1] & seen("sphere")
    assert lit[0][half].mean() > 2.0 * lit[0][other].mean()
    assert lit[1][other].mean() > 2.0 * lit[1][half].mean()


# Files ----------------------------------------------------------------------------------------------------------------


def test_an_exr_holds_the_linear_radiance_averaged_over_each_pixel(rendered, tape_nodes, tmp_path):
    image = rendered(tape_nodes("true", "0.0025, 0.0025"))
    picture.write(image, tmp_path / "a.exr", None)
    found = read_image(tmp_path / "a.exr")
    assert found.shape == (SIZE, SIZE, 3)
    assert found.max() > 100.0  # not clipped to what a screen shows
    mean = image.reshape(SIZE, 2, SIZE, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(found, np.minimum(mean, HALF_MAX), rtol=HALF_TOL)


def test_an_exr_ends_where_half_does(tmp_path):
    picture.write(np.full((2, 2, 3), 1e9), tmp_path / "a.exr", None)
    assert np.all(read_image(tmp_path / "a.exr") == HALF_MAX)


def test_a_png_holds_the_tone_mapped_picture_in_8_bits(rendered, tape_nodes, tmp_path):
    image = rendered(tape_nodes("true"))
    picture.write(image, tmp_path / "a.png", 1.0)
    found = read_image(tmp_path / "a.png")
    shown = picture.tone_map(image, 1.0).reshape(SIZE, 2, SIZE, 2, 3).mean(axis=(1, 3))
    # Absolute: half a step of 8 bits, and one of float32.
    np.testing.assert_allclose(found, shown, rtol=0.0, atol=0.5 / 255.0 + 1e-6)
    assert oiio.ImageInput.open(str(tmp_path / "a.png")).spec().format == "uint8"
    assert np.ptp(found) > 0.3


@pytest.mark.parametrize("name", ["no/such/folder/a.png", "no/such/folder/a.exr"])
def test_a_picture_that_cannot_be_written_says_so(tmp_path, name):
    with pytest.raises(ValueError, match="cannot be written"):
        picture.write(np.zeros((2, 2, 3)), tmp_path / name, None)


# Tone mapping ---------------------------------------------------------------------------------------------------------

# From a hundredth of the darkest that shows to what a retroreflector has.
LEVELS = np.geomspace(1e-4, 1e5, 400)


@pytest.mark.parametrize("exposure", [None, -8.0, 0.0, 4.0])
def test_tone_mapping_is_monotone_and_stays_between_black_and_white(exposure):
    shown = picture.tone_map(np.repeat(LEVELS[:, None], 3, axis=1)[None], exposure)[0]
    assert np.all((shown >= 0.0) & (shown <= 1.0))
    assert np.all(np.diff(shown, axis=0) >= -ONE_TOL)
    if exposure is not None:
        below = 2.0**-exposure > LEVELS
        assert np.all(np.diff(shown[below], axis=0) > 0.0)
        np.testing.assert_allclose(shown[~below], 1.0, rtol=0.0, atol=ONE_TOL)
    assert np.ptp(shown) > 0.9  # not a constant


def test_tone_mapping_keeps_black_black_and_fits_the_picture():
    assert np.all(picture.tone_map(np.zeros((4, 4, 3)), None) == 0.0)
    fitted = picture.tone_map(np.repeat(LEVELS[:, None], 3, axis=1)[None], None)[0]
    # The brightest thousandth is white.
    assert fitted[-1, 0] == pytest.approx(1.0, abs=ONE_TOL)
    assert fitted[-20, 0] < 1.0


def test_tone_mapping_keeps_the_ratios_of_channels_in_the_encoding_of_screens():
    red = picture.tone_map(np.array([[[8.0, 2.0, 0.0]], [[0.8, 0.2, 0.0]]]), 0.0)
    np.testing.assert_allclose(red[0, 0] / red[0, 0, 0], red[1, 0] / red[1, 0, 0], rtol=1e-12)
    # IEC 61966-2-1 of a quarter: 1.055 * 0.25^(1 / 2.4) - 0.055.
    assert red[0, 0, 1] / red[0, 0, 0] == pytest.approx(1.055 * 0.25 ** (1 / 2.4) - 0.055, rel=1e-12)


def test_more_exposure_is_brighter():
    level = np.full((1, 1, 3), 0.3)
    shown = [float(picture.tone_map(level, exposure).max()) for exposure in (-4.0, -2.0, 0.0, 1.0)]
    assert shown == sorted(shown)
    assert len(set(shown)) == 4


def test_a_picture_is_evaluated_in_bands_that_show_the_same(rendered, monkeypatch):
    whole = rendered(WHITE)
    monkeypatch.setattr(picture, "_BAND", 5 * 2 * SIZE)
    assert np.array_equal(rendered(WHITE), whole)


def test_a_picture_is_written_in_bands_that_show_the_same(tmp_path, rng, monkeypatch):
    radiance = rng.random((24, 10, 3)).astype(np.float32)
    for name in ("a.png", "a.exr"):
        picture.write(radiance, tmp_path / name, None)
        whole = read_image(tmp_path / name)
        with monkeypatch.context() as patched:
            patched.setattr(picture, "_BAND", 45)
            picture.write(radiance, tmp_path / name, None)
        assert whole.shape == (12, 5, 3)
        assert np.array_equal(read_image(tmp_path / name), whole)


@pytest.mark.parametrize(
    ("less", "options", "reason"),
    [
        ({"lights": frozenset({DirectionalLight})}, {"light_degrees": None}, "gl takes no such light"),
        ({"lights": frozenset({PointLight})}, {"light_degrees": 10.0}, "gl takes no such light"),
        ({"environment": False}, {"environment": np.ones((4, 8, 3), np.float32)}, "gl takes no environment"),
    ],
)
def test_an_engine_that_lacks_what_the_picture_needs_is_refused(rendered, monkeypatch, less, options, reason):
    monkeypatch.setattr(ENGINE, "capabilities", replace(ENGINE.capabilities, **less), raising=False)
    with pytest.raises(ValueError, match=reason):
        rendered(WHITE, **options)
