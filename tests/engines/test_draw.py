"""Drawing: what goes in reaches the shader, and what comes out is what it computed."""

from __future__ import annotations

import gc
from dataclasses import replace

import numpy as np
import pytest

from mrm_mtlx.engines.base import CompileError, DirectionalLight, Environment, Lighting, PointLight
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.engines.gl.context import context
from tests.fixtures.drivers import pending_error

UNIT = 2.0**-24

OVERHEAD = Lighting(DirectionalLight((0.0, 0.0, 1.0)))

# Relative, for a Lambertian surface: the normal and the view are normalised (8 units, GLSL 4.60 section 4.7.1: division
# 2.5 ulp, inversesqrt 2 ulp), n.l is a sum of three products (5), then five products by the colour and 1 / pi (5 + 2).
LAMBERT_TOL = 20 * UNIT

# Share of the samples in which a planted error has to show.
MOST = 0.5

LAMBERT = """
<geompropvalue name="paint" type="color3"><input name="geomprop" type="string" value="paint"/></geompropvalue>
<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">
  <input name="color" type="color3" nodename="paint"/><input name="roughness" type="float" value="0"/>
</oren_nayar_diffuse_bsdf>
"""

# What the surface emits is what the property says: no light, no cosine.
GLOWING = """
<geompropvalue name="glow" type="color3"><input name="geomprop" type="string" value="glow"/></geompropvalue>
<surface_unlit name="lamp" type="surfaceshader">
  <input name="emission_color" type="color3" nodename="glow"/>
</surface_unlit>
"""


@pytest.mark.parametrize("target", ["glsl", "essl"])
@pytest.mark.parametrize("count", [1, 7, 2048, 2 * 2048 + 3])
def test_inputs_come_out_bit_for_bit_and_in_order(program, make_document, rng, target, count):
    # Every normal float32 but the largest two exponents, so that products by 1 stay finite.
    bits = rng.integers(0x00800000, 0x7E000000, (count, 3), dtype=np.uint32)
    glow = (bits | (rng.integers(0, 2, bits.shape, dtype=np.uint32) << 31)).view(np.float32)
    drawn = program(make_document(GLOWING), element="lamp", target=target).draw({"i_geomprop_glow": glow}, Lighting())
    assert drawn.shape == (count, 4)
    assert drawn.dtype == np.float32
    assert np.array_equal(drawn[:, :3].view(np.uint32), glow.view(np.uint32))


def test_no_samples_give_no_colours(program, make_document):
    linked = program(make_document(GLOWING), element="lamp")
    assert linked.draw({"i_geomprop_glow": np.zeros((0, 3))}, Lighting()).shape == (0, 4)


def test_inputs_of_different_lengths_are_refused(program, surface_document, surface_inputs):
    linked = program(surface_document(LAMBERT))
    inputs = surface_inputs(np.tile([0.0, 0.0, 1.0], (4, 1)))
    with pytest.raises(ValueError, match=r"\S"):
        linked.draw({**inputs, "i_geomprop_paint": np.ones((2, 3))}, OVERHEAD)


def lambert_misses(drawn, paint, normal, to_light) -> float:
    """Share of the samples that are not colour * cosine / pi."""
    expected = paint * (np.maximum(normal @ to_light, 0.0) / np.pi)[:, None]
    return float(np.mean(np.any(np.abs(drawn[:, :3] - expected) > LAMBERT_TOL * np.abs(expected), axis=-1)))


def test_a_lambertian_surface_is_colour_times_cosine_over_pi(program, surface_document, surface_inputs, rng):
    count = 5000
    paint = rng.uniform(0.0, 1.0, (count, 3)).astype(np.float32)
    normal = rng.normal(size=(count, 3)) * [0.3, 0.3, 0.0] + [0.0, 0.0, 1.0]
    normal = (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32).astype(float)
    unit = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    to_light = np.float32([0.6, 0.0, 0.8]).astype(float)
    linked = program(surface_document(LAMBERT))
    inputs = {**surface_inputs(np.tile([0.0, 0.0, 1.0], (count, 1)), normal), "i_geomprop_paint": paint}
    drawn = linked.draw(inputs, Lighting(DirectionalLight(tuple(to_light))))
    assert np.all(drawn[:, 3] == 1.0)
    # Where n.l cancels, its rounding is relative to the products and not to it.
    lit = unit @ to_light > 0.2
    assert np.mean(lit) > MOST
    assert lambert_misses(drawn[lit], paint[lit], unit[lit], to_light) == 0.0
    # A slip in the twentieth bit of the colour, the cosine left out, samples exchanged: each is seen.
    for wrong in (drawn[lit] * np.float32(1.0 + 2.0**-19), paint[lit] / np.pi, drawn[lit][::-1]):
        assert lambert_misses(wrong, paint[lit], unit[lit], to_light) > MOST


def test_irradiance_multiplies_and_no_light_is_dark(program, surface_document, surface_inputs):
    linked = program(surface_document(LAMBERT))
    inputs = {**surface_inputs([0.0, 0.0, 1.0]), "i_geomprop_paint": np.ones((1, 3))}
    plain = linked.draw(inputs, OVERHEAD)[0, :3]
    # Powers of two multiply without rounding.
    coloured = linked.draw(inputs, Lighting(DirectionalLight((0.0, 0.0, 1.0), (2.0, 0.5, 0.0))))[0, :3]
    assert np.array_equal(coloured, plain * np.float32([2.0, 0.5, 0.0]))
    assert np.array_equal(linked.draw(inputs, Lighting())[0], [0.0, 0.0, 0.0, 1.0])


ROUGH = """
<oren_nayar_diffuse_bsdf name="bsdf" type="BSDF">
  <input name="color" type="color3" value="{color}"/><input name="roughness" type="float" value="0.5"/>
</oren_nayar_diffuse_bsdf>
"""


def test_the_eye_is_where_the_lighting_says(program, surface_document, surface_inputs):
    linked = program(surface_document(ROUGH.format(color="1, 1, 1")))
    inputs = surface_inputs(np.array([0.6, 0.0, 0.8]))
    moved = {**inputs, "positionWorld": inputs["positionWorld"] + np.array([1.0, 2.0, 4.0])}
    slanted = Lighting(DirectionalLight((0.36, 0.48, 0.8)))
    here = linked.draw(inputs, slanted)
    # The same difference of eye and point, rounded at a size of up to 5.
    there = linked.draw(moved, replace(slanted, view_position=(1.0, 2.0, 4.0)))
    np.testing.assert_allclose(there, here, rtol=5 * LAMBERT_TOL)
    assert not np.allclose(linked.draw(moved, slanted), here, rtol=5 * LAMBERT_TOL)


def test_a_point_light_lights_from_where_it_stands(program, surface_document, surface_inputs):
    linked = program(surface_document(LAMBERT))
    inputs = {**surface_inputs([0.0, 0.0, 1.0]), "i_geomprop_paint": np.ones((1, 3))}
    point = inputs["positionWorld"][0]

    def shading(offset: tuple[float, float, float]) -> float:
        light = PointLight(tuple(point + offset), (1.0, 1.0, 1.0))
        return float(linked.draw(inputs, Lighting(light))[0, 0])

    # At the same distance, only the cosine differs.
    assert shading((3.0, 0.0, 4.0)) / shading((0.0, 0.0, 5.0)) == pytest.approx(0.8, rel=LAMBERT_TOL)
    assert shading((0.0, 0.0, -5.0)) == pytest.approx(0.0, abs=UNIT)


def test_a_point_light_falls_with_the_square_of_the_distance_plus_one(program, surface_document, surface_inputs):
    linked = program(surface_document(LAMBERT))
    inputs = {**surface_inputs([0.0, 0.0, 1.0]), "i_geomprop_paint": np.ones((1, 3))}
    near, far = (
        float(linked.draw(inputs, Lighting(PointLight((0.0, 0.0, height), (1.0, 1.0, 1.0))))[0, 0])
        for height in (0.0, 4.0)  # the surface is at -1
    )
    # pow in GLSL: 2^-21 of each logarithm, twice, and the rest as above.
    assert near / far == pytest.approx((6.0 / 2.0) ** 2, rel=LAMBERT_TOL + 4 * 2.0**-21)


BRUSHED = """
<conductor_bsdf name="bsdf" type="BSDF">
  <input name="roughness" type="vector2" value="0.3, 0.1"/>
  <input name="retroreflective" type="boolean" value="true"/>
</conductor_bsdf>
"""


def test_essl_and_glsl_give_the_same_numbers(program, surface_document, surface_inputs, rng, hemisphere):
    inputs = surface_inputs(hemisphere(rng, 2000))
    lighting = Lighting(DirectionalLight((0.36, 0.48, 0.8)))
    on = surface_document(BRUSHED)
    glsl, essl = (program(on, target=target).draw(inputs, lighting) for target in ("glsl", "essl"))
    # Bit for bit: the sources differ in their declarations, and one compiler turns both into the same arithmetic.
    assert np.array_equal(glsl, essl)
    # The flag is an initialised uniform in GLSL and has to be uploaded in ESSL.
    off = program(on, target="essl").draw(inputs, lighting, {"bsdf_retroreflective": False})
    assert np.mean(np.any(glsl != off, axis=-1)) > MOST


def test_uniforms_of_a_draw_replace_those_of_the_document(program, surface_document, surface_inputs):
    inputs = surface_inputs([0.6, 0.0, 0.8])
    grey, red = (program(surface_document(ROUGH.format(color=c))) for c in ("0.5, 0.5, 0.5", "1, 0.25, 0"))
    expected = red.draw(inputs, OVERHEAD)
    assert not np.array_equal(grey.draw(inputs, OVERHEAD), expected)
    assert np.array_equal(grey.draw(inputs, OVERHEAD, {"bsdf_color": (1.0, 0.25, 0.0)}), expected)


def test_uniforms_of_a_draw_are_gone_with_it(program, surface_document, surface_inputs):
    linked = program(surface_document(ROUGH.format(color="0.5, 0.5, 0.5")))
    inputs = surface_inputs([0.6, 0.0, 0.8])
    before = linked.draw(inputs, OVERHEAD)
    assert not np.array_equal(linked.draw(inputs, OVERHEAD, {"bsdf_color": (1.0, 0.0, 0.0)}), before)
    assert np.array_equal(linked.draw(inputs, OVERHEAD), before)


def test_the_lighting_of_a_draw_is_gone_with_it(program, surface_document, surface_inputs):
    linked = program(surface_document(ROUGH.format(color="0.5, 0.5, 0.5")))
    inputs = surface_inputs([0.6, 0.0, 0.8])
    before = linked.draw(inputs, OVERHEAD)
    environment = Environment(np.ones((2, 4, 3)), np.ones((2, 4, 3)))
    other = Lighting(PointLight((0.0, 0.0, 3.0), (9.0, 9.0, 9.0)), environment, (1.0, 0.0, 0.0))
    assert not np.array_equal(linked.draw(inputs, other), before)
    assert np.array_equal(linked.draw(inputs, OVERHEAD), before)


def test_a_missing_input_is_a_key_error_with_its_name(program, surface_document, surface_inputs):
    linked = program(surface_document(LAMBERT))
    assert set(linked.input_names) == {"positionWorld", "normalWorld", "i_geomprop_paint"}
    with pytest.raises(KeyError, match="the shader reads i_geomprop_paint, which the caller did not give"):
        linked.draw(surface_inputs([0.0, 0.0, 1.0]), OVERHEAD)


def test_an_unknown_uniform_is_a_key_error_with_its_name(program, surface_document, surface_inputs):
    linked = program(surface_document(ROUGH.format(color="0.5, 0.5, 0.5")))
    with pytest.raises(KeyError, match="the shader has no uniform bsdf_colour, bsdf_rough"):
        linked.draw(surface_inputs([0.0, 0.0, 1.0]), OVERHEAD, {"bsdf_rough": 1.0, "bsdf_colour": 1.0})


def test_a_compile_error_carries_the_line_its_text_and_the_drivers_words(surface_document, shader_of, gl_clean):
    shader = shader_of(surface_document(LAMBERT))
    lines = shader.sources["pixel"].split("\n")
    at = next(k for k, line in enumerate(lines) if "vec3 c_out" in line or "vec3 paint_out" in line)
    lines[at] = "    vec3 paint_out = no_such_thing;"
    with pytest.raises(CompileError, match="no_such_thing") as caught:
        SurfaceProgram(replace(shader, sources={**shader.sources, "pixel": "\n".join(lines)}))
    first = caught.value.messages[0]
    assert first.line == at + 1
    assert first.source == "vec3 paint_out = no_such_thing;"
    assert "no_such_thing" in first.message
    assert "no_such_thing" in str(caught.value)


def test_a_source_that_does_not_link_is_a_compile_error_too(surface_document, shader_of, gl_clean):
    shader = shader_of(surface_document(LAMBERT))
    pixel = shader.sources["pixel"].replace("vec3 i_geomprop_paint;", "vec2 i_geomprop_paint;")
    pixel = pixel.replace("= vd.i_geomprop_paint;", "= vec3(vd.i_geomprop_paint, 0.0);")
    with pytest.raises(CompileError, match=r"\S") as caught:
        SurfaceProgram(replace(shader, sources={**shader.sources, "pixel": pixel}))
    assert len(caught.value.messages) >= 1


INTEGER = """
<geompropvalue name="count" type="integer"><input name="geomprop" type="string" value="count"/></geompropvalue>
<convert name="share" type="float"><input name="in" type="integer" nodename="count"/></convert>
<surface_unlit name="lamp" type="surfaceshader"><input name="emission" type="float" nodename="share"/></surface_unlit>
"""


@pytest.mark.parametrize(
    "target",
    [
        "glsl",
        pytest.param(
            "essl",
            marks=pytest.mark.xfail(
                strict=True, raises=CompileError, reason="MaterialX's ESSL declares integer inputs without 'flat'"
            ),
        ),
    ],
)
def test_integers_reach_the_shader(program, make_document, target):
    counts = np.array([-3, 0, 7, 2**24])
    drawn = program(make_document(INTEGER), element="lamp", target=target).draw(
        {"i_geomprop_count": counts}, Lighting()
    )
    assert np.array_equal(drawn[:, 0], counts)


def test_a_program_is_released_with_its_block_and_the_driver_has_no_complaint(make_document, shader_of, gl_clean):
    shader = shader_of(make_document(GLOWING), element="lamp")
    for glow in ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]):
        with SurfaceProgram(shader) as linked:
            drawn = linked.draw({"i_geomprop_glow": [glow]}, Lighting())
        gc.collect()
        assert drawn[0, :3].tolist() == glow


def test_an_error_that_is_left_in_the_driver_is_seen_and_told_once(gl_clean):
    texture = context().texture((1, 1), 4)
    texture.use(location=10**6)  # no driver has so many units
    assert pending_error() != "GL_NO_ERROR"
    assert pending_error() == "GL_NO_ERROR"
    texture.release()
