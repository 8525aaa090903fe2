"""What a tolerance allows for sums that cancel and for built-in functions."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.reference import ROUNDING_FACTOR, Model, ShadingPoints, Surface
from mrm_mtlx.reference.float32.precision import ARCTANGENT_ERROR, FAST_EXPONENTIAL, SINE_ERROR, ULP
from mrm_mtlx.reference.float32.rounding import UNIT, Perturbation, Quantity

# What is left, of the roundings of a handful of numbers: far less than the smallest of the errors below.
ROUNDINGS = 1e3 * UNIT


@pytest.fixture
def allowed(make_document):
    """Function from nodes to what the tolerance of the red of `a` is, of a float or of a vector's first channel."""

    def tolerance(nodes, model=Model.HARDWARE):
        document = make_document(
            nodes + '<combine3 name="c" type="color3"><input name="in1" type="float" nodename="a"/></combine3>'
            '<surface_unlit name="s" type="surfaceshader"><input name="emission_color" type="color3" nodename="c"/>'
            "</surface_unlit>"
        )
        axes = (np.tile(axis, (2, 1)) for axis in np.eye(3)[[2, 2, 2, 0, 2]])
        return float(
            Surface(document.getNode("s"), model).tolerance(ShadingPoints(*axes, np.zeros((2, 2)))).allowed[0, 0]
        )

    return tolerance


def function(category, **values):
    inputs = "".join(f'<input name="{name}" type="float" value="{value}"/>' for name, value in values.items())
    return f'<{category} name="a" type="float">{inputs}</{category}>'


def rotation(amount):
    return (
        f'<rotate2d name="r" type="vector2"><input name="in" type="vector2" value="0.5, 0"/>'
        f'<input name="amount" type="float" value="{amount}"/></rotate2d>'
        '<extract name="a" type="float"><input name="in" type="vector2" nodename="r"/></extract>'
    )


def test_a_sum_that_cancels_may_miss_by_roundings_of_its_terms(allowed):
    nodes = (
        '<dotproduct name="a" type="float"><input name="in1" type="vector3" value="1000, -1000, 0.001"/>'
        '<input name="in2" type="vector3" value="1, 1, 1"/></dotproduct>'
    )
    terms = 2000.001 * ROUNDING_FACTOR * UNIT
    assert terms < allowed(nodes) < 1.01 * terms


def test_a_mixture_of_all_of_one_may_miss_by_roundings_of_the_other(allowed):
    assert allowed(function("mix", fg=0.001, bg=1000.0, mix=1.0)) > 1000.0 * ROUNDING_FACTOR * UNIT


@pytest.mark.parametrize(
    ("nodes", "error"),
    [
        (function("sin", **{"in": 1.0}), SINE_ERROR),
        (function("cos", **{"in": 1.0}), SINE_ERROR),
        (function("tan", **{"in": 1.0}), SINE_ERROR * (np.cos(1.0) + np.sin(1.0)) / np.cos(1.0) ** 2),
        (function("atan2", iny=1.0, inx=1.0), ARCTANGENT_ERROR * 0.25 * np.pi),
        (function("asin", **{"in": 0.5}), ARCTANGENT_ERROR * np.pi / 6.0),
        (function("acos", **{"in": 0.5}), ARCTANGENT_ERROR * np.pi / 3.0),
        (rotation(60.0), 0.5 * SINE_ERROR),
    ],
)
def test_functions_may_miss_by_their_stated_errors(allowed, nodes, error):
    assert error < allowed(nodes) < error + ROUNDINGS


def test_a_rotation_by_nothing_may_miss_by_roundings_alone(allowed):
    assert allowed(rotation(0.0)) < ROUNDINGS


def test_powers_and_exponentials_of_osl_may_miss_by_more(allowed):
    for nodes in (function("exp", **{"in": 1.0}), function("power", in1=np.e, in2=1.0)):
        assert allowed(nodes, Model.CLOSURES) > allowed(nodes) + 0.9 * FAST_EXPONENTIAL * np.e


def test_the_fit_of_hairs_absorption_may_miss_by_roundings_of_its_terms(make_document):
    document = make_document(
        '<chiang_hair_absorption_from_color name="a" type="vector3">'
        '<input name="color" type="color3" value="0, 0, 0"/><input name="azimuthal_roughness" type="float" value="1"/>'
        '</chiang_hair_absorption_from_color><convert name="c" type="color3">'
        '<input name="in" type="vector3" nodename="a"/></convert><surface_unlit name="s" type="surfaceshader">'
        '<input name="emission_color" type="color3" nodename="c"/></surface_unlit>'
    )
    surface = Surface(document.getNode("s"))
    points = ShadingPoints(*(np.tile(axis, (2, 1)) for axis in np.eye(3)[[2, 2, 2, 0, 2]]), np.zeros((2, 2)))
    off = surface.shade(points, perturbation=Perturbation(quantity=Quantity.FUNCTIONS)) - surface.shade(points)
    # Black is taken for 0.001. The logarithm is off by 3 ulp; the terms, at a roughness of 1, are the coefficients.
    fit, terms = 5.969 - 0.215 + 2.532 - 10.73 + 5.574 + 0.245, 5.969 + 0.215 + 2.532 + 10.73 + 5.574 + 0.245
    root = np.log(1000.0) / fit
    error = 3.0 * ULP * np.log(1000.0) / ROUNDING_FACTOR + UNIT * terms * root
    assert off[0, 0] == pytest.approx(2.0 * root * error / fit, rel=1e-6)
