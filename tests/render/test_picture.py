"""Pictures: what is in them, not how they look."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mrm_mtlx.engines.gl.textures import read_image
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.render import environment, picture
from mrm_mtlx.render.shapes import EYE, SHAPES, camera_rays, intersect
from mrm_mtlx.shadergen import renderable_elements

REPOSITORY = Path(__file__).parents[2]
# Relative rounding of float64, with room for a dozen operations.
EPS = 16 * np.finfo(float).eps
# Half floats hold 11 bits.
HALF = 2.0**-11

TAPE = (
    '<generalized_schlick_bsdf name="bsdf" type="BSDF"><input name="color0" type="color3" value="0.2, 0.2, 0.2"/>'
    '<input name="color90" type="color3" value="0.2, 0.2, 0.2"/>'
    '<input name="roughness" type="vector2" value="0.05, 0.05"/>'
    '<input name="retroreflective" type="boolean" value="true"/></generalized_schlick_bsdf>'
)


def settings(shape="sphere", light=None, size=24, surroundings=None, compare=False):
    return picture.Settings(shape, light, size, surroundings, compare)


@pytest.fixture
def tape(surface_document, library):
    document = surface_document(TAPE)
    return lambda chosen: picture.render(renderable_elements(document)[0], library, Path(), chosen)


# Shapes ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_meet_a_shape_where_it_is(shape):
    rays = camera_rays(64)
    hits = intersect(shape, rays)
    seen = hits.found
    assert 0.1 < seen.mean() < 0.9
    position, normal, tangent = hits.position[seen], hits.normal[seen], hits.tangent[seen]
    along = position - EYE
    # On the ray, facing the eye, with an orthonormal frame; distances are up to 7.
    np.testing.assert_allclose(np.cross(along, rays[seen]), 0.0, atol=7 * EPS)
    assert np.all(np.sum(normal * along, axis=1) < 0.0)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=EPS)
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, rtol=EPS)
    np.testing.assert_allclose(np.sum(normal * tangent, axis=1), 0.0, atol=EPS)
    assert np.all((hits.texcoord[seen] >= 0.0) & (hits.texcoord[seen] <= 1.0))


def test_the_sphere_has_its_radius_and_the_cone_its_slope():
    rays = camera_rays(32)
    sphere = intersect("sphere", rays)
    np.testing.assert_allclose(np.linalg.norm(sphere.position[sphere.found], axis=1), 1.0, rtol=100 * EPS)
    cone = intersect("cone", rays)
    p = cone.position[cone.found]
    ratio = np.hypot(p[:, 0], p[:, 2]) / (1.05 - p[:, 1])
    np.testing.assert_allclose(ratio, 0.72 / 2.05, rtol=1e5 * EPS)  # near the apex both vanish


# Environment ----------------------------------------------------------------------------------------------------------


def test_a_constant_environment_gives_its_constant_as_irradiance():
    image = np.full((40, 80, 3), [1.0, 2.0, 0.5])
    np.testing.assert_allclose(
        environment.irradiance_over_pi(image), np.broadcast_to([1.0, 2.0, 0.5], (32, 64, 3)), rtol=EPS
    )


def test_directions_of_pixels_lead_back_to_the_pixels():
    image = np.arange(16 * 32 * 3, dtype=float).reshape(16, 32, 3)
    directions, solid_angle = environment.latlong_directions(16, 32)
    np.testing.assert_array_equal(environment.look_up(image, directions.reshape(-1, 3)), image.reshape(-1, 3))
    # Midpoint rule over the latitude: its error is pi^2 / (24 rows^2).
    np.testing.assert_allclose(solid_angle.sum(), 4.0 * np.pi, rtol=np.pi**2 / 24 / 16**2 * 1.1)


def test_light_from_above_gives_irradiance_above_only():
    image = np.zeros((32, 64, 3))
    image[:16] = 1.0
    irradiance = environment.irradiance_over_pi(image)
    assert irradiance[0].min() > 0.95  # all of the upper hemisphere, but for the half-row at the horizon
    assert irradiance[-1].max() < 0.05


# Pictures -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_a_headlight_lights_the_whole_retroreflective_shape(tape, gl, shape):
    shown = tape(settings(shape))
    seen = intersect(shape, camera_rays(48)).found.reshape(48, 48)
    # F D / 4 at the peak, over cos: at least 0.2 / (4 pi 0.05^2) * pi, times G2 / cos^2 >= 1 up to a rounding.
    assert shown[seen].min() > 0.9 * 0.2 / (4 * 0.05**2)
    assert shown[~seen].max() < 0.01


def test_a_pixel_is_what_the_reference_says(tape, gl, surface_document):
    shown = tape(settings("sphere", 20.0)).reshape(-1, 3)
    rays = camera_rays(48)
    hits = intersect("sphere", rays)
    chosen = np.flatnonzero(hits.found)[::97]
    to_eye = EYE / np.linalg.norm(EYE)
    right = np.cross([0.0, 1.0, 0.0], to_eye)
    angle = np.deg2rad(20.0)
    light = np.cos(angle) * to_eye + np.sin(angle) * right / np.linalg.norm(right)
    points = ShadingPoints(
        view=-rays[chosen],
        light=np.float32(light).astype(float),
        normal=hits.normal[chosen],
        tangent=hits.tangent[chosen],
        position=hits.position[chosen],
        texcoord=hits.texcoord[chosen],
    )
    document = surface_document(TAPE)
    tolerance = Surface(renderable_elements(document)[0]).tolerance(points)
    # The eye is 6 away: positions are rounded at that size and v is their difference, 7 roundings instead of 1.
    assert np.all(np.abs(shown[chosen] / np.pi - tolerance.expected) <= 7 * tolerance.allowed)


def test_a_comparison_has_four_panels_and_the_third_is_bright(tape, gl):
    shown = tape(settings(compare=True))
    width = shown.shape[1] // 4
    centres = [shown[24, i * width + 24 :][0] for i in range(4)]
    brightness = [shown[:, i * width : (i + 1) * width].mean() for i in range(4)]
    assert len(centres) == 4
    assert brightness[2] > 20 * max(brightness[0], brightness[1], brightness[3])


def test_surroundings_show_and_light_the_shape(tape, gl):
    image = np.full((8, 16, 3), [0.2, 0.4, 0.8])
    shown = tape(settings("sphere", 90.0, surroundings=image))
    np.testing.assert_allclose(shown[0, 0], [0.2, 0.4, 0.8])
    middle = shown[24, 24]
    assert middle[2] > middle[1] > middle[0] > 0.0


def test_exr_holds_the_linear_radiance(tape, gl, tmp_path):
    shown = tape(settings())
    picture.write(shown, tmp_path / "a.exr", None)
    pixels = read_image(tmp_path / "a.exr")
    reduced = shown.reshape(24, 2, 24, 2, 3).mean(axis=(1, 3))
    assert pixels.shape == (24, 24, 3)
    np.testing.assert_allclose(pixels, reduced, rtol=HALF, atol=1e-6)


def test_tone_mapping_keeps_order_and_range():
    ramp = np.geomspace(1e-4, 1e4, 50)[:, None, None] * np.ones(3)
    mapped = picture.tone_map(ramp, None)[:, 0, 0]
    assert np.all(np.diff(mapped) >= 0.0)
    assert mapped.min() >= 0.0
    assert mapped.max() <= 1.0
    assert picture.tone_map(ramp, 2.0)[10, 0, 0] > picture.tone_map(ramp, -2.0)[10, 0, 0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-o", "picture.gif"), "ends in .png or .exr"),
        (("-o", "no/such/folder/a.png"), "cannot be written"),
        (("-o", "a.png", "--light", "bright"), "expected headlight or an angle"),
        (("-o", "a.png", "--light", "200"), "from -180 to 180"),
        (("-o", "a.png", "--environment", "missing.exr"), "cannot be read as an image"),
        (("-o", "a.png", "--shape", "torus"), "--shape"),
    ],
)
def test_a_wrong_call_is_told_in_one_message(gl, tmp_path, arguments, message):
    material = str(REPOSITORY / "materials" / "cats_eye.mtlx")
    command = [sys.executable, "-m", "mrm_mtlx.cli.main", "render", material, "--size", "16", *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_the_command_writes_a_picture(gl, tmp_path):
    material = str(REPOSITORY / "materials" / "cats_eye.mtlx")
    command = [
        sys.executable,
        "-m",
        "mrm_mtlx.cli.main",
        "render",
        material,
        "--size",
        "16",
        "-o",
        "a.png",
        "--compare",
    ]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    assert read_image(tmp_path / "a.png").shape == (16, 16 * 4 + 3 * 4, 3)
