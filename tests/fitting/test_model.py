"""The material that is fitted: what it reflects is what its document reflects."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.fitting.document import material_name, write
from mrm_mtlx.fitting.model import Evaluator, LayerStack, albedos
from mrm_mtlx.photometry import document_brdf

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array

STACKS = {
    "all layers in colour": LayerStack(coats=2, lobes=2, falling=True, rough=True, channels=3),
    "level lobe": LayerStack(coats=1, lobes=1),
    "tinted lobe": LayerStack(lobes=1, falling=True, tint=(1.0, 0.5, 0.1)),
    "paper": LayerStack(lobes=1, diffuse=False, paper=True),
    "given numbers": LayerStack(
        lobes=1, falling=True, fixed={"lobe.exponent": (0.5,), "diffuse.color": (0.1, 0.2, 0.3)}
    ),
    "base alone": LayerStack(rough=True),
}
# MaterialX keeps numbers in single precision: half a unit of 2^-23, amplified by the flank of a lobe, where D goes as
# the fourth power of alpha, and by the F82 curve, which crosses zero, hence the part of the largest value.
SINGLE = 0.5 * 2.0**-23 * 8.0


@pytest.fixture
def directions(rng) -> tuple[Array, Array]:
    """v and l, a fifth of them next to retroreflection and another fifth next to the mirror."""
    v, l = (np.abs(rng.normal(size=(500, 3))) * [1.0, 1.0, 1.0] + [0.0, 0.0, 0.05] for _ in range(2))
    v[:, :2] *= rng.choice([-1.0, 1.0], (500, 2))
    near = 0.01 * rng.normal(size=(100, 3)) * [1.0, 1.0, 0.0]
    v[:100], v[100:200] = l[:100] + near, l[100:200] * [-1.0, -1.0, 1.0] + near
    return tuple(w / np.linalg.norm(w, axis=1, keepdims=True) for w in (v, l))


def drawn(stack: LayerStack, rng: np.random.Generator) -> dict[str, Array]:
    """Values anywhere within the bounds, as a document has them."""
    lower, upper = stack.bounds()
    return stack.rounded(stack.values(lower + (upper - lower) * rng.random(len(lower))))


@pytest.fixture
def document_values(library) -> Callable[[LayerStack, dict[str, Array], Array, Array], Array]:
    """Function that evaluates the document of a stack, by the reference."""

    def evaluate(stack: LayerStack, values: dict[str, Array], v: Array, l: Array) -> Array:
        document = mx.createDocument()
        mx.readFromXmlString(document, write(stack, values, "sheet", ["Notes -- with hyphens, < and &."], doc="a < b"))
        document.setDataLibrary(library.document)
        valid, message = document.validate()
        assert valid, message
        return document_brdf(document.getNode("M_sheet"))(v, l)

    return evaluate


@pytest.mark.parametrize("name", STACKS)
def test_a_written_document_evaluates_to_the_values_of_the_model(name, directions, document_values, rng):
    stack = STACKS[name]
    values = drawn(stack, rng)
    expected = Evaluator(stack, *directions).eval(values)
    found = document_values(stack, values, *directions)
    np.testing.assert_allclose(found, expected, rtol=SINGLE, atol=SINGLE * 1e-2 * np.max(np.abs(expected)))


@pytest.mark.parametrize("error", ["level", "one lobe less", "coats exchanged", "a digit"])
def test_a_document_of_another_material_is_seen(error, directions, document_values, rng):
    stack = STACKS["all layers in colour"]
    values = drawn(stack, rng)
    expected = Evaluator(stack, *directions).eval(values)
    if error == "level":
        stack = replace(stack, falling=False)
    elif error == "one lobe less":
        stack = replace(stack, lobes=1)
    elif error == "coats exchanged":
        values = values | {"coat.alpha": values["haze.alpha"], "haze.alpha": values["coat.alpha"]}
    else:
        values = values | {"lobe.color0": values["lobe.color0"] * 1.0001}
    found = document_values(stack, values, *directions)
    assert np.max(np.abs(found / expected - 1.0)) > 10.0 * SINGLE


@pytest.mark.parametrize("name", STACKS)
def test_derivatives_are_those_of_central_differences(name, directions, rng):
    stack = STACKS[name]
    lower, upper = stack.bounds()
    vector = lower + (upper - lower) * rng.uniform(0.2, 0.8, len(lower))
    model = Evaluator(stack, *directions)
    _, slopes = model.eval_with_jacobian(vector)
    for i in range(len(vector)):
        step = 1e-5 * (upper[i] - lower[i]) * np.eye(len(vector))[i]
        ends = [model.eval(stack.values(vector + side * step)) for side in (1.0, -1.0)]
        expected = (ends[0] - ends[1]) / (2.0 * step[i])
        # Forward differences of 1e-7 are off by half of that times the curvature, and by 1e-9 of rounding; of narrow
        # lobes, the curvature is some tens of the value.
        np.testing.assert_allclose(slopes[..., i], expected, rtol=1e-4, atol=1e-5 * np.max(np.abs(expected)))


def test_derivatives_do_not_leave_the_bounds(directions):
    stack = STACKS["all layers in colour"]
    model = Evaluator(stack, *directions)
    for vector in stack.bounds():
        assert np.all(np.isfinite(model.eval_with_jacobian(vector)[1]))


def test_grey_layers_never_reflect_more_than_arrives(rng):
    stack = LayerStack(coats=2, lobes=2, falling=True, rough=True)
    cosines = np.linspace(0.05, 1.0, 20)
    lower, upper = stack.bounds()
    corners = [np.where(rng.random(len(lower)) < 0.5, lower, upper) for _ in range(50)]
    # MaterialX's rational fit of a white lobe's albedo is up to 3 % above 1.
    assert max(np.max(albedos(stack, stack.values(x), cosines)) for x in corners) < 1.03


def test_coloured_layers_can_and_that_is_seen():
    stack = LayerStack(lobes=1, channels=3)
    red = {"lobe.color0": np.array([0.9, 0.0, 0.0]), "lobe.alpha": np.array([0.01]), "diffuse.color": np.ones(3)}
    # 0.9 of the red comes back, and the base gets 1 - 0.9 / 3 of it.
    np.testing.assert_allclose(albedos(stack, red, np.array([1.0]))[0], [1.6, 0.7, 0.7], atol=0.01)


def test_two_lobes_are_put_in_the_order_of_their_widths(directions):
    stack = LayerStack(coats=2, lobes=2, falling=True)
    names = [p.name for p in stack.parameters]
    values = {name: np.array([0.1 + 0.02 * i]) for i, name in enumerate(names)}
    values |= {"coat.alpha": np.array([0.3]), "haze.alpha": np.array([0.05]), "haze.share": np.array([0.2])}
    values |= {"lobe.alpha": np.array([0.2]), "lobe2.alpha": np.array([0.02])}
    ordered = stack.ordered(values)
    assert (ordered["lobe.alpha"][0], ordered["lobe2.alpha"][0]) == (0.02, 0.2)
    assert ordered["lobe.color0"] == values["lobe2.color0"]
    assert (ordered["coat.alpha"][0], ordered["haze.share"][0]) == (0.05, 0.8)
    only_coats = values | {name: ordered[name] for name in names if name.startswith(("coat", "haze"))}
    model = Evaluator(stack, *directions)
    # Gloss and haze are a mixture: the same one. float64 rounds the shares.
    np.testing.assert_allclose(model.eval(only_coats), model.eval(values), rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "name"), [("Sheet 3M-983", "sheet_3m_983"), ("3m", "sheet_3m"), ("éé", "sheet"), ("", "sheet")]
)
def test_any_text_gives_a_name_that_a_document_can_have(text, name):
    assert material_name(text) == name
    assert mx.createValidName(name) == name
