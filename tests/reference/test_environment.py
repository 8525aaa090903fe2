"""An environment of varying radiance: the reference's sum over directions is the shader's, and a quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.engines.base import Environment as DrawnEnvironment
from mrm_mtlx.engines.base import Lighting
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import Environment, Illumination, Surface
from mrm_mtlx.render.environment import latlong_directions
from mrm_mtlx.shadergen import generate

# Radiance that varies linearly over the sphere: red along x, green along y, blue along z.
BASE, SLOPE = 1.0, 0.6

SURFACES = {
    "metal": '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" value="0.3, 0.2"/>'
    "</conductor_bsdf>",
    "retroreflective metal": '<conductor_bsdf name="bsdf" type="BSDF"><input name="roughness" type="vector2" '
    'value="0.3, 0.2"/><input name="retroreflective" type="boolean" value="true"/></conductor_bsdf>',
    "glass": '<dielectric_bsdf name="bsdf" type="BSDF"><input name="scatter_mode" type="string" value="RT"/>'
    '<input name="roughness" type="vector2" value="0.1, 0.1"/></dielectric_bsdf>',
    "diffuse": '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="roughness" type="float" value="0.4"/>'
    "</oren_nayar_diffuse_bsdf>",
}


def radiance(d):
    return BASE + SLOPE * d


def irradiance(n):
    """Over pi: the mean of the radiance, weighted with the cosine; two thirds of the slope."""
    return BASE + SLOPE * n * (2.0 / 3.0)


def latitude_longitude(function):
    """An image of a function of directions."""
    directions, _ = latlong_directions(128, 256)
    return function(directions).astype(np.float32)


@pytest.mark.parametrize("name", SURFACES)
def test_a_textured_environment_agrees_with_the_reference(
    gl, surface_document, library, turned_points, rng, direction_pairs, name
):
    document = surface_document(SURFACES[name])
    v, l = direction_pairs(rng, 300)
    # Off the horizon: there what is refracted is divided by a vanishing masking (docs/upstream-notes.md).
    steep = v[:, 2] > 0.2
    points = turned_points(rng, v[steep], l[steep])
    samples = 256
    with SurfaceProgram(generate(document.getNode("m"), "glsl", library)) as program:
        inputs = program.surface_inputs(points.position, points.normal, points.tangent, points.texcoord)
        drawn = DrawnEnvironment(latitude_longitude(radiance), latitude_longitude(irradiance), samples)
        found = program.draw(inputs, Lighting(environment=drawn))[:, :3]
    surface = Surface(document.getNode("m"))
    expected = surface.shade(points, Illumination(False, Environment(radiance, irradiance, samples)))
    # Texels are 1.4 degrees wide, and coarser where the shader blurs: a hundredth of the radiance's range. What it
    # refracts, it blurs as if it were reflected, over a wider angle.
    share = 0.04 if name == "glass" else 0.01
    assert np.max(np.abs(found - expected)) < share * 2.0 * SLOPE
    # The reference sees where the light comes from: an environment that is turned is another.
    turned = surface.shade(points, Illumination(False, Environment(lambda d: radiance(-d), irradiance, samples)))
    assert name == "diffuse" or np.max(np.abs(found - turned)) > 0.1


@pytest.mark.parametrize("name", ["metal", "retroreflective metal"])
def test_more_directions_come_to_a_limit(surface_document, turned_points, rng, direction_pairs, name):
    document = surface_document(SURFACES[name])
    points = turned_points(rng, *direction_pairs(rng, 200))
    surface = Surface(document.getNode("m"))

    def shown(samples):
        return surface.shade(points, Illumination(False, Environment(radiance, irradiance, samples)))

    limit = shown(4096)
    errors = [np.sqrt(np.mean((shown(count) - limit) ** 2)) for count in (16, 256)]
    # Fibonacci's points: the error falls about as fast as their number grows.
    assert errors[1] < 0.2 * errors[0] < 0.05
