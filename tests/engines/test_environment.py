"""Light from all around: a retroreflective surface sees what is behind the viewer."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.engines.base import Environment, Lighting
from tests.fixtures.versions import newest_closures

NODES = ("conductor", "dielectric", "generalized_schlick")
by_node = pytest.mark.parametrize("node", NODES)

VIEW = np.array([0.6, 0.0, 0.8])
MIRROR = VIEW * [-1.0, 1.0, 1.0]

# The disc has 10 degrees about it and the lobe, of alpha 0.05, some 5: most of the lobe is inside. Seen elsewhere, only
# its tail and the coarse end of the image pyramid reach it, 1e-3 of that here.
CONTRAST = 50.0

# Share of the views in which a planted error has to show.
MOST = 0.9

BSDF = """
<{node}_bsdf name="bsdf" type="BSDF">
  <input name="retroreflective" type="boolean" value="true"/>
  {more}
</{node}_bsdf>
"""


@pytest.fixture
def bsdf(program, surface_document):
    """Function to the program of one of the three nodes."""

    def link(node: str, more: str = "", **damage: str):
        return program(surface_document(BSDF.format(node=node, more=more)), **damage)

    return link


def white(radiance: float = 1.0) -> Environment:
    """The same light from everywhere."""
    return Environment(np.full((16, 32, 3), radiance), np.full((1, 1, 3), radiance))


def numbers(flag: bool, alpha_x: float = 0.05, alpha_y: float = 0.05) -> dict[str, object]:
    """Flag and widths as uniforms of one draw."""
    return {"bsdf_retroreflective": flag, "bsdf_roughness": (alpha_x, alpha_y)}


@pytest.fixture
def seen(bsdf, surface_inputs, spot):
    """Function to what a surface shows of a spot behind the viewer, and of one in the mirror direction."""

    def look(node: str, flag: bool, **damage: str) -> tuple[float, float]:
        linked = bsdf(node, **damage)
        return tuple(
            float(linked.draw(surface_inputs(VIEW), Lighting(environment=spot(d)), numbers(flag))[0, 0])
            for d in (VIEW, MIRROR)
        )

    return look


@by_node
def test_a_retroreflective_surface_sees_what_is_behind_the_viewer(seen, node):
    behind, mirrored = seen(node, True)
    assert behind > CONTRAST * mirrored
    assert behind > 0.0


@by_node
def test_an_ordinary_surface_sees_what_lies_in_the_mirror_direction(seen, node):
    behind, mirrored = seen(node, False)
    assert mirrored > CONTRAST * behind
    assert mirrored > 0.0


def test_a_surface_that_retroreflects_lights_but_not_surroundings_is_seen(seen):
    behind, mirrored = seen("conductor", True, old=" || closureData.closureType == CLOSURE_TYPE_INDIRECT", new="")
    assert not behind > CONTRAST * mirrored


def furnace_differences(linked, v, surface_inputs) -> float:
    """Share of the views for which a white environment tells the flag on from the flag off.

    The shader's sample directions are fixed in the tangent frame, so that v' in one frame is v in the frame turned by
    half a turn about n: the two are compared in these, where every sample of one has its equal in the other.
    """
    on, off = (
        linked.draw(surface_inputs(v, tangent=(x, 0.0, 0.0)), Lighting(environment=white()), numbers(flag, 0.3, 0.1))
        for flag, x in ((True, 1.0), (False, -1.0))
    )
    # Bit for bit: with n = z, mirroring v is a change of two signs, exact like the turn of the frame.
    return float(np.mean(np.any(on != off, axis=-1)))


@by_node
def test_in_a_white_furnace_the_flag_makes_no_difference(bsdf, surface_inputs, rng, hemisphere, node):
    assert furnace_differences(bsdf(node), hemisphere(rng, 1000), surface_inputs) == 0.0


@newest_closures
def test_a_furnace_that_depends_on_the_flag_is_seen(bsdf, surface_inputs, rng, hemisphere):
    tilted = {"old": "? reflect(-closureData.V, N)", "new": "? normalize(N + reflect(-closureData.V, N))"}
    linked = bsdf("conductor", **tilted)
    assert furnace_differences(linked, hemisphere(rng, 1000), surface_inputs) > MOST


# Absolute, for views from 6 degrees above the surface up: what the fit of the albedo and 64 samples leave.
FURNACE_TOL = 0.05


def test_a_white_surface_in_a_white_furnace_is_white(bsdf, surface_inputs, rng, hemisphere):
    linked = bsdf("generalized_schlick")
    v = hemisphere(rng, 1000)
    inputs = surface_inputs(v[v[:, 2] > 0.1])
    drawn = linked.draw(inputs, Lighting(environment=white()), numbers(True, 0.3, 0.3))[:, :3]
    assert np.max(np.abs(drawn - 1.0)) < FURNACE_TOL
    twice = linked.draw(inputs, Lighting(environment=white(2.0)), numbers(True, 0.3, 0.3))[:, :3]
    assert np.array_equal(twice, 2.0 * drawn)


AXES = np.concatenate([np.eye(3), -np.eye(3), [[0.48, 0.64, -0.6]]])


def test_the_environment_lies_as_its_class_says(bsdf, surface_inputs, spot):
    linked = bsdf("conductor")
    for direction in AXES:
        # Looked at from straight above, a mirror shows what is straight above it.
        tangent = np.cross(direction, np.roll(direction, 1) + np.array([0.0, 0.1, 0.3]))
        inputs = surface_inputs(direction, normal=direction, tangent=tangent / np.linalg.norm(tangent))
        shown = [float(linked.draw(inputs, Lighting(environment=spot(d)), numbers(False))[0, 0]) for d in AXES]
        assert np.array_equal(AXES[int(np.argmax(shown))], direction)
        assert max(shown) > CONTRAST * sorted(shown)[-2]


def test_a_diffuse_surface_takes_the_irradiance(program, surface_document, surface_inputs):
    diffuse = (
        '<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF"><input name="color" type="color3" value="0.5, 0.25, 1.0"/>'
        "</oren_nayar_diffuse_bsdf>"
    )
    linked = program(surface_document(diffuse))
    irradiance = Environment(np.zeros((2, 4, 3)), np.full((2, 4, 3), 2.0))
    drawn = linked.draw(surface_inputs([0.0, 0.0, 1.0]), Lighting(environment=irradiance))
    # At roughness 0 the fit of the diffuse albedo is exactly 1.
    assert np.array_equal(drawn[0], [1.0, 0.5, 2.0, 1.0])


def transmission_differences(linked, surface_inputs, rng) -> float:
    """Share of the views for which the flag changes what a transmitting surface shows of its environment."""
    environment = Environment(rng.uniform(0.0, 1.0, (8, 16, 3)), np.zeros((1, 1, 3)))
    v = rng.normal(size=(500, 3)) * [0.4, 0.4, 0.0] + [0.0, 0.0, 1.0]
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    on, off = (
        linked.draw(surface_inputs(v), Lighting(environment=environment), numbers(flag, 0.2, 0.1))
        for flag in (True, False)
    )
    assert np.mean(off[:, :3] > 0.0) > MOST  # something is transmitted
    return float(np.mean(np.any(on != off, axis=-1)))


# Transmitting alone; Schlick's curve is white unless told otherwise, and then transmits nothing.
GLASS = {
    "dielectric": '<input name="scatter_mode" type="string" value="T"/>',
    "generalized_schlick": '<input name="scatter_mode" type="string" value="T"/>'
    '<input name="color0" type="color3" value="0.04, 0.04, 0.04"/>',
}


@pytest.mark.parametrize("node", GLASS)
def test_transmission_is_the_same_with_and_without_the_flag(bsdf, surface_inputs, rng, node):
    assert transmission_differences(bsdf(node, GLASS[node]), surface_inputs, rng) == 0.0


@newest_closures
def test_a_surface_that_mirrors_the_view_in_transmission_too_is_seen(bsdf, surface_inputs, rng):
    damage = {"old": "(retroreflective && reflects)", "new": "retroreflective"}
    linked = bsdf("dielectric", GLASS["dielectric"], **damage)
    assert transmission_differences(linked, surface_inputs, rng) > MOST
