"""Noise: what generated GLSL shows of it against the reference, and wrong noise, which has to be caught."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from mrm_mtlx.engines.base import Lighting
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.reference.textures import flakes, hashing
from mrm_mtlx.reference.textures import noise as noise_functions
from mrm_mtlx.shadergen import generate
from tests.fixtures.versions import planted, since

SAMPLES = 400
UNIT = 2.0**-24

# Share of the samples in which a planted error has to show.
MOST = 0.5


def inputs(given: dict[str, str]) -> str:
    """Inputs by name, type and value with a colon between them."""
    typed = {name: each.split(":") for name, each in given.items()}
    return "".join(f'<input name="{name}" type="{kind}" value="{v}"/>' for name, (kind, v) in typed.items())


def node(category: str, kind: str, **given: str) -> str:
    """The node `a`."""
    return f'<{category} name="a" type="{kind}">{inputs(given)}</{category}>'


def shown(nodes: str, kind: str, output: str = "") -> str:
    """The surface `s` that shows the first, the second and the last channel of the node `a`."""
    output = f'output="{output}"' if output else ""
    if kind in ("float", "color3"):
        use = {"float": "emission", "color3": "emission_color"}[kind]
        color = f'<input name="{use}" type="{kind}" nodename="a" {output}/>'
    elif kind == "integer":
        nodes += f'<convert name="n" type="float"><input name="in" type="integer" nodename="a" {output}/></convert>'
        color = '<input name="emission" type="float" nodename="n"/>'
    else:
        channels = {"in1": 0, "in2": 1, "in3": int(kind[-1]) - 1}
        for name, index in channels.items():
            given = f'<input name="in" type="{kind}" nodename="a" {output}/>' + inputs({"index": f"integer:{index}"})
            nodes += f'<extract name="{name}" type="float">{given}</extract>'
        parts = "".join(f'<input name="{name}" type="float" nodename="{name}"/>' for name in channels)
        nodes += f'<combine3 name="c" type="color3">{parts}</combine3>'
        color = '<input name="emission_color" type="color3" nodename="c"/>'
    return nodes + f'<surface_unlit name="s" type="surfaceshader">{color}</surface_unlit>'


@pytest.fixture
def points(rng):
    """Samples at random positions, negative ones among them, a quarter of them far away; and on lattice points."""
    spread = np.where(np.arange(SAMPLES) % 4 == 0, 1000.0, 4.0)[:, None]
    position, uv = (rng.uniform(-1.0, 1.0, (SAMPLES, n)) * spread for n in (3, 2))
    for a in (position, uv):
        a[:16] = np.round(a[:16])
    frames = np.linalg.qr(rng.normal(size=(SAMPLES, 3, 3)))[0]
    arrays = {"view": frames[:, 2], "normal": frames[:, 0], "tangent": frames[:, 1], "texcoord": uv}
    arrays |= {"position": position, "light": np.array([0.0, 0.0, 1.0])}
    return ShadingPoints(**{name: a.astype(np.float32).astype(float) for name, a in arrays.items()})


@pytest.fixture
def compared(drawn_at, points):
    """As `drawn_at`, at the usual samples."""
    return lambda nodes, old="", new="": drawn_at(nodes, points, old, new)


@pytest.fixture
def drawn_at(gl_clean, make_document, library):
    """Function from nodes and samples to the tolerance and what GLSL shows; `old` and `new` damage its source."""

    def compare(nodes: str, points: ShadingPoints, old: str = "", new: str = ""):
        document = make_document(nodes)
        shader = generate(document.getNode("s"), "glsl", library)
        if old:
            shader = replace(shader, sources={**shader.sources, "pixel": planted(shader.sources["pixel"], old, new)})
        with SurfaceProgram(shader) as program:
            at = points.position, points.normal, points.tangent, points.texcoord
            found = program.draw(program.surface_inputs(*at), Lighting())[:, :3]
        return Surface(document.getNode("s")).tolerance(points), found

    return compare


VECTORS = ("vector2", "vector3", "vector4")
OCTAVES = {"octaves": "integer:4", "lacunarity": "float:2.17", "diminish": "float:0.6"}
NOISES = [
    *(("noise", kind, {"pivot": "float:0.2"}) for kind in ("float", *VECTORS)),
    *(("fractal", kind, OCTAVES) for kind in ("float", *VECTORS)),
    ("noise", "color3", {"amplitude": "vector3:0.3, 1.5, -0.7"}),
    ("cellnoise", "float", {}),
    *(("worleynoise", kind, {"jitter": "float:0.8"}) for kind in ("float", "vector2", "vector3")),
    *(("worleynoise", kind, {"style": "integer:1"}) for kind in ("float", "vector2", "vector3")),
]


@pytest.mark.parametrize(("name", "kind", "given"), NOISES, ids=[f"{n}-{k}-{'-'.join(g)}" for n, k, g in NOISES])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_noise_agrees_with_glsl(compared, name, kind, given, dimensions):
    tolerance, found = compared(shown(node(f"{name}{dimensions}d", kind, **given), kind))
    assert np.max(tolerance.excess(found)) <= 1.0
    assert np.median(tolerance.allowed) < 0.01
    assert np.std(tolerance.expected) > 0.1


@pytest.mark.parametrize("kind", range(4))
def test_the_node_of_all_noises_agrees_with_glsl(excess, kind):
    given = {"type": f"integer:{kind}", "freq": "vector2:1.3, 0.7", "jitter": "float:0.9"}
    assert np.max(excess(shown(node("unifiednoise2d", "float", **given), "float"))) <= 1.0


# Number, priority and id of a flake in one colour.
NAMES = (
    '<convert name="whole" type="float"><input name="in" type="integer" nodename="a" output="id"/></convert>'
    '<combine3 name="all" type="vector3"><input name="in1" type="float" nodename="a" output="rand"/>'
    '<input name="in2" type="float" nodename="a" output="presence"/>'
    '<input name="in3" type="float" nodename="whole"/></combine3>'
)


# A colour by the number of a flake, beyond which float32 has no fractions.
COLORS = node("flake3d", "multioutput", size="float:0.002", coverage="float:1").replace('"a"', '"f"') + (
    '<randomcolor name="a" type="color3"><input name="seed" type="integer" nodename="f" output="id"/>{}</randomcolor>'
)


@pytest.fixture
def many(points, rng):
    """So many samples that what one in a thousand shows is met."""
    every = ShadingPoints.joined([points] * 20)
    return replace(every, position=rng.uniform(-4.0, 4.0, (len(every), 3)).astype(np.float32).astype(float))


# What the channels of noise differ by: the second is taken from the first, and a share of the third from both.
DIFFERENCE = node("noise2d", "vector3").replace('"a"', '"n"') + (
    '<dotproduct name="a" type="float"><input name="in1" type="vector3" nodename="n"/>'
    '<input name="in2" type="vector3" value="1, -1, 0.3"/></dotproduct>'
)


def test_the_difference_of_noises_channels_agrees_with_glsl(drawn_at, many, rng):
    at = replace(many, texcoord=rng.uniform(-1.0, 2.0, (len(many), 2)).astype(np.float32).astype(float))
    tolerance, found = drawn_at(shown(DIFFERENCE, "float"), at)
    assert np.max(tolerance.excess(found)) <= 1.0
    assert np.median(tolerance.allowed) < 1e-3
    tolerance, found = drawn_at(shown(DIFFERENCE, "float"), at, "0.6616", "0.6650")
    assert np.mean(tolerance.excess(found) > 1.0) > MOST


@since("1.39.5", "flakes")
def test_what_a_hash_gives_for_a_number_without_fractions_is_anything(drawn_at, many):
    tolerance, found = drawn_at(shown(COLORS.format(""), "color3"), many)
    assert np.max(tolerance.excess(found)) <= 1.0


def test_a_cell_that_is_known_has_one_random_number(drawn_at, many):
    """With the hash's start damaged, nearly all samples are wrong; those of known cells are allowed nothing."""
    tolerance, found = drawn_at(shown(node("cellnoise3d", "float"), "float"), many, "0xdeadbeef", "0xdeadbeee")
    assert np.mean(tolerance.excess(found) > 1.0) > MOST


@pytest.mark.parametrize(("dimensions", "coverage"), [(2, 0.5), (3, 0.2), (3, 1.0)])
@since("1.39.5", "flakes")
def test_flakes_agree_with_glsl(compared, dimensions, coverage):
    given = {"size": "float:0.13", "coverage": f"float:{coverage}", "roughness": "float:0.6"}
    nodes = node(f"flake{dimensions}d", "multioutput", **given)
    tolerance, found = compared(shown(nodes, "vector3", "flakenormal"))
    assert np.max(tolerance.excess(found)) <= 1.0
    # With the nodes' names exchanged, what is shown is the colour.
    tolerance, found = compared(
        shown(nodes.replace('"a"', '"f"') + NAMES.replace('"a"', '"f"').replace('"all"', '"a"'), "vector3")
    )
    assert np.max(tolerance.excess(found)) <= 1.0
    flakes_seen = tolerance.expected[:, 1] > 0.0
    assert abs(np.mean(flakes_seen) - coverage) < 0.13  # five standard deviations of a share of 400 samples
    # The ids are whole numbers, and as float32 they are exact.
    assert np.array_equal(found[:, 2], tolerance.expected[:, 2])


def test_a_constant_position_on_a_cells_edge_is_settled(excess):
    nodes = '<constant name="p" type="vector2"><input name="value" type="vector2" value="2, -3"/></constant>'
    at = '<input name="texcoord" type="vector2" nodename="p"/>'
    for name, given in (("cellnoise2d", {}), ("worleynoise2d", {"style": "integer:1", "jitter": "float:0"})):
        text = node(name, "float", **given).replace("</", at + "</")
        assert np.max(excess(shown(nodes + text, "float"))) <= 1.0


# Planted errors: the node they are planted in, what is replaced in the generated source, and by what.
FLAKE = ("flake3d", "multioutput", {"size": "float:0.7", "coverage": "float:1"}, "rand")
DAMAGE = {
    "another start of the hash": (("noise2d", "float", {}), "0xdeadbeef", "0xdeadbeee"),
    "another rotation in the hash": (("cellnoise3d", "float", {}), "mx_rotl32(b,24)", "mx_rotl32(b,23)"),
    "another mixing of longer keys": (("worleynoise3d", "float", {}), "mx_rotl32(a,19)", "mx_rotl32(a,18)"),
    "gradients exchanged": (("noise2d", "float", {}), "mx_select(h<4u, x, y)", "mx_select(h<4u, y, x)"),
    "gradients of the other sign": (("noise3d", "float", {}), "(u, bool(h&1u))", "(u, bool(h&2u))"),
    "another scale": (("noise3d", "float", {}), "0.9820", "0.9821"),
    "another fading": (("noise2d", "float", {}), "(t * 6.0 - 15.0) + 10.0", "(t * 5.0 - 14.0) + 10.0"),
    "channels from other bits": (("noise2d", "vector3", {}), "(h >> 8 )", "(h >> 9 )"),
    "another place of the fourth channel": (("noise3d", "vector4", {}), "vec3(19, 73, 29)", "vec3(19, 73, 28)"),
    "another place of the second channel": (("fractal2d", "vector2", {}), "vec2(19, 193)", "vec2(19, 192)"),
    "the first octave diminished": (("fractal2d", "float", {}), "amplitude = 1.0;", "amplitude = diminish;"),
    "points not in the middle": (("worleynoise2d", "float", {"jitter": "float:0.5"}), "off += 0.5f", "off += 0.51f"),
    "squares of distances": (("worleynoise2d", "vector2", {}), "sqdist = sqrt(sqdist)", "sqdist = sqdist"),
    "the cell of the sample": (
        ("worleynoise2d", "float", {"style": "integer:1"}), "mx_cell_noise_float(minpos + p)", "mx_cell_noise_float(p)",
    ),
    "smaller flakes": (FLAKE, "1.5 / sqrt(3.0)", "0.8 / sqrt(3.0)"),
    "the first flake on top": (FLAKE, "priority < flake_priority", "flake_priority > 0.0"),
    "another likelihood": (FLAKE, "26.39663835", "27.39663835"),
}  # fmt: skip


LATER = {"fractal2d": since("1.39.4", "fractal2d"), **dict.fromkeys((FLAKE[0], "flake3d"), since("1.39.5", "flakes"))}

# Where fewer samples can differ: the nearest point may be in the sample's cell; another flake may not be on top.
SHARES = {"the cell of the sample": 0.3, "another likelihood": 0.05}


@pytest.mark.parametrize("damage", [pytest.param(n, marks=LATER.get(d[0][0], ())) for n, d in DAMAGE.items()])
def test_wrong_noise_is_caught(excess, damage):
    (name, kind, given, *output), old, new = DAMAGE[damage]
    nodes = shown(node(name, kind, **given), *(("float", output[0]) if output else (kind,)))
    assert np.mean(excess(nodes, old=old, new=new) > 1.0) > SHARES.get(damage, MOST)


@pytest.mark.parametrize(("initial", "expected"), [(0, 0x17770551), (1, 0xCD628161)])
def test_the_hash_is_the_one_that_was_published(monkeypatch, initial, expected):
    """Values of the self-test in lookup3.c; there, the length counts in bytes, here in words of four."""
    text = b"Four score and seven years ago"
    words = np.frombuffer(text + bytes(-len(text) % 4), dtype="<u4").astype(float)
    monkeypatch.setattr(hashing, "_START", 0xDEADBEEF + initial + len(text) - 4 * len(words))
    assert int(hashing.hashed(*words)[0]) == expected


def test_whole_numbers_count_by_their_lowest_bits():
    assert hashing.hashed(-1.0, -7.0) == hashing.hashed(2.0**32 - 1.0, 2.0**32 - 7.0)
    keys = np.arange(-500.0, 500.0)
    assert len(np.unique(hashing.hashed(keys, 3.0))) == 1000
    assert len(np.unique(hashing.hashed(keys, keys[:400, None]))) > 4e5 * (1.0 - 4e5 / 2.0**32)  # as at random


def test_hashes_fill_the_unit_interval_evenly():
    values = noise_functions.cell_noise(*np.mgrid[0:100, 0:100, 0:100].astype(float).reshape(3, -1))
    count, _ = np.histogram(values, bins=100, range=(0.0, 1.0))
    # Chi-square with 99 degrees of freedom: mean 99, standard deviation 14; five of them.
    assert np.sum((count - 1e4) ** 2 / 1e4) < 99.0 + 5.0 * np.sqrt(2.0 * 99.0)
    assert hashing.unit_interval(np.array([0xFFFFFFFF], dtype=np.uint32)) == 1.0


def test_gradients_are_all_of_their_kind():
    plane = {tuple(g) for g in noise_functions.GRADIENTS[2].T}
    assert plane == {(a * x, b * y) for x, y in ((1, 2), (2, 1)) for a, b in product((-1, 1), repeat=2)}
    space = [tuple(g) for g in noise_functions.GRADIENTS[3].T]
    assert set(space) == {g for g in product((-1, 0, 1), repeat=3) if np.sum(np.abs(g)) == 2}
    assert {g for g in space if space.count(g) == 2} == {(1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1)}


@pytest.mark.parametrize("dimensions", [2, 3])
def test_gradient_noise_is_smooth_zero_on_the_lattice_and_no_steeper_than_said(rng, dimensions):
    lattice = np.round(rng.uniform(-100.0, 100.0, (dimensions, 1000)))
    assert np.all(noise_functions.gradient_noise(lattice, 3) == 0.0)
    at = rng.uniform(-100.0, 100.0, (dimensions, 100_000))
    at[:, ::10] = np.round(at[:, ::10])  # on the seams between cells, too
    step = 1e-5
    here, there, back = (noise_functions.gradient_noise(at + step * k, 1) for k in (0.0, 1.0, -1.0))
    steepness = np.abs(there - here) / step / dimensions
    assert 0.3 * noise_functions.SLOPE < np.max(steepness) < noise_functions.SLOPE
    assert np.max(np.abs(there - 2.0 * here + back)) < 100.0 * step * step  # no kink
    assert 0.8 < np.max(np.abs(here)) <= 1.0


def test_the_nearest_points_are_those_of_a_search_further_around(rng):
    position = rng.uniform(-5.0, 5.0, (2, 200))
    distances, ways = noise_functions.nearest_points(position, np.asarray(0.6), 3)
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), distances)
    cells = np.mgrid[-9:9, -9:9].reshape(2, -1).astype(float)
    points = cells + (noise_functions.cell_noises(*cells)[:2] - 0.5) * 0.6 + 0.5
    every = np.sort(np.linalg.norm(points[:, :, None] - position[:, None], axis=0), axis=0)[:3]
    np.testing.assert_allclose(distances, every)


def test_flakes_are_turned_cubes(rng):
    vector, random = rng.normal(size=(3, 1000)), rng.uniform(0.0, 1.0, (3, 1000))
    columns = np.stack([flakes._turned(np.broadcast_to(axis[:, None], (3, 1000)), random) for axis in np.eye(3)])
    product = np.einsum("ikn,jkn->ijn", columns, columns)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3)[:, :, None], product.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(np.moveaxis(columns, -1, 0)), 1.0)
    turned = flakes._turned(vector, random)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=0), np.linalg.norm(vector, axis=0))


def test_a_flake_has_the_same_number_everywhere_and_another_than_its_neighbour(rng):
    position = rng.uniform(-4.0, 4.0, (3, 20_000))
    seen = flakes.top_flake(position, np.asarray(1.0))
    names = {tuple(cell) for cell in seen.cell.T}
    assert len(np.unique(flakes.identity(seen))) == len(names)
    assert np.all(np.max(np.abs(seen.cell + 0.5 - position), axis=0) <= np.sqrt(3.0) * flakes.HALF)
