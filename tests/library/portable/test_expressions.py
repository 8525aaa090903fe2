"""Formulas as nodes: few, and worth what the formula is worth."""

from __future__ import annotations

import MaterialX as mx
import numpy as np
import pytest

from mrm_mtlx.library.portable.expressions import Expressions
from mrm_mtlx.reference import ShadingPoints, Surface
from mrm_mtlx.shadergen import renderable_elements


@pytest.fixture
def document(upstream_library):
    made = mx.createDocument()
    made.setDataLibrary(upstream_library.document)
    return made


@pytest.fixture
def x(document):
    """A number from outside, as a value."""
    document.addNode("geompropvalue", "x", "float").setInputValue("geomprop", "x")
    taker = document.addNode("absval", "taker", "float")
    taker.addInput("in", "float").setNodeName("x")
    return Expressions(document, "made").given(taker.getInput("in"))


def categories(document) -> list[str]:
    return sorted(node.getCategory() for node in document.getNodes() if node.getName().startswith("made"))


def test_nothing_is_written_before_a_value_is_taken_and_then_each_operation_once(document, x):
    square = x * x
    product = (square + 1.0) * (square + 1.0)
    assert categories(document) == []
    product.given_to(document.addNode("absval", "end", "float"), "in")
    assert categories(document) == ["add", "multiply", "multiply"]
    assert document.validate()[0]


def test_operations_of_constants_are_no_nodes(document, x):
    nodes = x.nodes
    two = nodes.constant(4.0).root()
    vector = nodes.constant((1.0, 2.0, 3.0), "vector3") * two
    assert (two.number, vector.number) == ((2.0,), (2.0, 4.0, 6.0))
    assert vector.component(2).number == (6.0,)
    assert (x * 1.0 is x, x + 0.0 is x, (x * 0.0).number) == (True, True, (0.0,))
    assert categories(document) == []


# A formula, and what it is worth at x; of vectors, the sum of the components.
FORMULAS = {
    "operators": (lambda x: (2.0 - x) / (1.0 + x * x) - (-x), lambda x: (2 - x) / (1 + x * x) + x),
    "a number and a vector": (
        lambda x: x.nodes.sum(x - x.nodes.constant((1.0, 2.0, 3.0), "vector3") * x),
        lambda x: 3 * x - 6 * x,
    ),
    "a number by a vector": (
        lambda x: x.nodes.sum(x / (x.nodes.constant((1.0, 2.0, 4.0), "vector3") + x)),
        lambda x: x / (1 + x) + x / (2 + x) + x / (4 + x),
    ),
    "functions": (
        lambda x: x.root().at_least(0.5).at_most(0.9).to_the(3.0) + (x - 1.0).absolute(),
        lambda x: np.clip(np.sqrt(x), 0.5, 0.9) ** 3 + np.abs(x - 1),
    ),
    "vectors": (
        lambda x: x.nodes.cross(
            x.nodes.vector([x, x * 0.0 + 1.0, x * x]).normalized(), x.nodes.constant((0.0, 0.0, 1.0), "vector3")
        ).length(),
        lambda x: np.sqrt((1 + x**2) / (1 + x**2 + x**4)),
    ),
    "choices": (lambda x: x.nodes.where(x, 0.5, x, -x), lambda x: np.where(x >= 0.5, x, -x)),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_a_formula_is_worth_what_it_says(document, x, name):
    formula, exact = FORMULAS[name]
    document.addNode("convert", "color", "color3")
    formula(x).given_to(document.getNode("color"), "in")
    surface = document.addNode("surface_unlit", "surface", "surfaceshader")
    surface.addInput("emission_color", "color3").setNodeName("color")
    document.addMaterialNode("material", surface)
    assert document.validate() == (True, "")
    numbers = np.array([0.05, 0.3, 0.5, 0.8])
    along = np.tile([0.0, 0.0, 1.0], (4, 1))
    points = ShadingPoints(along, along, along, along[:, ::-1], -along, along[:, :2], {"x": numbers})
    shaded = Surface(renderable_elements(document)[0]).shade(points)[:, 0]
    np.testing.assert_allclose(shaded, exact(numbers), rtol=1e-12)  # double precision
