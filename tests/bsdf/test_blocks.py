"""Shapes, blocks and threads of the lobes' evaluation."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import numpy as np
import pytest

from mrm_mtlx.bsdf import Conductor, GeneralizedSchlick
from mrm_mtlx.bsdf.blocks import BLOCK, evaluate_in_blocks, processors
from mrm_mtlx.reference import versions

EPS = np.finfo(float).eps

# Of a white lobe, as MaterialX's shaders have it.
WHITE_ALBEDO = versions.installed().microfacet_albedo.white

# Relative to the lobe. A film's phase is up to 100 rad, and its cosine, exponential and arc tangent may be a rounding
# apart between NumPy's vector loops and what they leave over; its colour is a sum with coefficients up to 2.4.
FILM_TOL = 100 * 8 * EPS


def per_sample_lobe(count: int, rng: np.random.Generator, thickness: float = 0.0) -> Conductor:
    """A lobe with every parameter of its own per sample; half of them with a film of this thickness."""
    return Conductor(
        rng.uniform(0.1, 2.0, (count, 3)),
        rng.uniform(1.0, 4.0, (count, 3)),
        alpha=(rng.uniform(0.05, 1.0, count), rng.uniform(0.05, 1.0, count)),
        retroreflective=True,
        thinfilm_thickness=np.where(rng.uniform(size=count) < 0.5, 0.0, thickness),
        thinfilm_ior=rng.uniform(1.1, 2.0, count),
        energy_compensation=WHITE_ALBEDO,
    )


def select(lobe: Conductor, part: slice) -> Conductor:
    """The lobe of a part of the samples."""
    return Conductor(
        lobe.ior[part],
        lobe.extinction[part],
        alpha=(lobe.alpha[0][part], lobe.alpha[1][part]),
        retroreflective=lobe.retroreflective,
        thinfilm_thickness=lobe.thinfilm_thickness[part],
        thinfilm_ior=lobe.thinfilm_ior[part],
        energy_compensation=lobe.energy_compensation,
    )


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 3])
def test_a_block_boundary_changes_no_sample(rng, direction_pairs, count):
    v, l = direction_pairs(rng, count)
    lobe = per_sample_lobe(count, rng)
    whole = lobe.eval(v, l)
    assert whole.shape == (count, 3)
    # Bit for bit: without a film there are only correctly rounded operations, whatever loop runs them. Each part lies
    # within one block, and begins where blocks do not.
    step = BLOCK // 2 + 1
    for start in range(0, count, step):
        part = slice(start, start + step)
        assert np.array_equal(whole[part], select(lobe, part).eval(v[part], l[part]))
    # Shifted by one sample, as a slip of the bounds would have it, they differ.
    if count > 1:
        assert not np.array_equal(whole[1:], lobe.eval(v, l)[:-1])


def test_samples_alone_equal_samples_together(rng, direction_pairs):
    v, l = direction_pairs(rng, 64)
    lobe = per_sample_lobe(64, rng, thickness=300.0)
    together = lobe.eval(v, l)
    alone = np.array([select(lobe, slice(k, k + 1)).eval(v[k], l[k])[0] for k in range(64)])
    scale = np.max(together, axis=-1, keepdims=True)
    assert np.all(np.abs(together - alone) <= FILM_TOL * scale)
    assert not np.all(np.abs(together - np.roll(alone, 1, axis=0)) <= FILM_TOL * scale)


def test_one_view_and_many_lights_broadcast(rng, hemisphere):
    v, l = hemisphere(rng, 5)[:, None], hemisphere(rng, 7)
    lobe = Conductor(0.2, 3.4, alpha=(0.3, 0.1))
    grid = lobe.eval(v, l)
    assert grid.shape == (5, 7, 3)
    assert np.array_equal(grid[3, 4], lobe.eval(v[3, 0], l[4]))


def test_a_parameter_alone_may_carry_the_samples(rng):
    v = np.array([0.6, 0.0, 0.8])
    widths = rng.uniform(0.1, 1.0, (4, 5))
    values = GeneralizedSchlick(0.5, alpha=(widths, 0.3)).eval(v, v)
    assert values.shape == (4, 5, 3)
    assert np.array_equal(values[2, 3], GeneralizedSchlick(0.5, alpha=(widths[2, 3], 0.3)).eval(v, v))


def test_a_single_pair_of_directions_gives_a_colour():
    assert Conductor([0.2, 0.4, 1.4], 3.0).eval([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]).shape == (3,)


def test_three_samples_are_not_taken_for_a_colour():
    # Three scalars per sample and a colour have the same number of entries; the axis tells them apart.
    v = np.tile([0.6, 0.0, 0.8], (3, 1))
    per_sample = GeneralizedSchlick([[0.1], [0.2], [0.3]] * np.ones(3), alpha=(0.3, 0.3)).eval(v, v)
    one_colour = GeneralizedSchlick([0.1, 0.2, 0.3], alpha=(0.3, 0.3)).eval(v, v)
    assert np.array_equal(per_sample[0, 0], one_colour[0, 0])
    assert per_sample[0, 1] == per_sample[0, 0]
    assert one_colour[0, 1] != one_colour[0, 0]
    widths = GeneralizedSchlick(0.5, alpha=([0.1, 0.2, 0.3], 0.3)).eval(v, v)
    assert np.array_equal(widths[1], GeneralizedSchlick(0.5, alpha=(0.2, 0.3)).eval(v[0], v[0]))


def test_shapes_that_do_not_broadcast_are_named():
    with pytest.raises(ValueError, match=r"samples and parameters do not broadcast.*\(4,\).*\(5,\)"):
        Conductor(0.2, 3.4).eval(np.ones((4, 3)), np.ones((5, 3)))
    with pytest.raises(ValueError, match="do not broadcast"):
        Conductor(0.2, 3.4, alpha=(np.full(6, 0.1), 0.1)).eval(np.ones((4, 3)), np.ones(3))


def test_what_a_block_raises_reaches_the_caller():
    def refuse(v: np.ndarray) -> np.ndarray:
        if v.shape[1] < BLOCK:
            msg = "the last block"
            raise ArithmeticError(msg)
        return v

    with pytest.raises(ArithmeticError, match="the last block"):
        evaluate_in_blocks(refuse, {}, {}, (np.ones((3 * BLOCK + 1, 3)),))


@pytest.mark.parametrize("count", [0, 1, BLOCK + 1])
def test_a_function_may_have_any_number_of_components(rng, count):
    def first_two_doubled(a: np.ndarray, *, scale: np.ndarray) -> np.ndarray:
        assert a.shape[0] == 3
        return scale * a[:2]

    a, scale = rng.random((count, 3)), {"scale": np.asarray(2.0)}
    assert np.array_equal(evaluate_in_blocks(first_two_doubled, scale, {}, (a,), components=2), 2.0 * a[:, :2])
    one = evaluate_in_blocks(lambda a, scale: scale * a[2:], scale, {}, (a.reshape(count, 1, 3),), 1)
    assert one.shape == (count, 1, 1)
    # As many as are stated: another number is no result.
    if count:
        with pytest.raises(ValueError, match="broadcast"):
            evaluate_in_blocks(first_two_doubled, scale, {}, (a,))


def test_at_least_one_processor_may_be_used():
    assert processors() >= 1


# Prints how many pages the system hands out per block, once warm.
PAGES = """
import resource
import numpy as np
from mrm_mtlx.bsdf import Conductor, blocks
lobe, v = Conductor(0.2, 3.4), np.tile([0.6, 0.0, 0.8], (blocks.BLOCK, 1))
lobe.eval(v, v)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(20):
    lobe.eval(v, v)
print((resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before) // 20)
"""

# A colour of doubles for each sample of a block, in pages of 4 KiB: a block that gets its memory anew needs several.
PAGES_OF_ONE_ARRAY = BLOCK * 3 * 8 // 4096


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries keep freed memory by other rules")
def test_blocks_use_the_memory_of_those_before_again():
    def pages(**environment: str) -> int:
        run = subprocess.run(
            [sys.executable, "-c", PAGES],
            capture_output=True, text=True, check=True, timeout=60, env={**os.environ, **environment},
        )  # fmt: skip
        return int(run.stdout)

    assert pages() < PAGES_OF_ONE_ARRAY
    # With glibc's limits pinned to where they start, the array that raises them does nothing, and every block pays.
    assert pages(MALLOC_TRIM_THRESHOLD_="131072") > 4 * PAGES_OF_ONE_ARRAY
