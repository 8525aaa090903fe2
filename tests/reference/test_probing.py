"""Values of single inputs: constant ones wherever they stand, others at given points."""

from __future__ import annotations

import numpy as np

from mrm_mtlx.reference import ShadingPoints, constant_input, input_at


def test_the_constant_value_of_an_input_is_found_wherever_it_stands(surface_document):
    document = surface_document(
        '<constant name="c" type="color3"><input name="value" type="color3" value="0.5, 0.25, 0.125"/></constant>'
        '<geompropvalue name="p" type="float"><input name="geomprop" type="string" value="w"/></geompropvalue>'
        '<noise2d name="n" type="float"/>'
        '<dielectric_bsdf name="bsdf" type="BSDF"><input name="tint" type="color3" nodename="c"/>'
        '<input name="retroreflective" type="boolean" value="true"/><input name="ior" type="float" nodename="n"/>'
        '<input name="scatter_mode" type="string" value="RT"/></dielectric_bsdf>'
    )
    node = document.getNode("bsdf")
    assert constant_input(node, "tint").tolist() == [0.5, 0.25, 0.125]
    assert bool(constant_input(node, "retroreflective")) is True
    assert constant_input(node, "scatter_mode") == "RT"
    assert float(constant_input(node, "weight")) == 1.0  # by default
    assert constant_input(node, "ior") is None  # of a node that is not known here
    assert constant_input(node, "normal") is None  # differs from point to point


def test_a_constant_is_one_whatever_function_it_comes_from(make_document):
    document = make_document(
        '<sqrt name="root" type="float"><input name="in" type="float" value="9"/></sqrt>'
        '<dot name="d" type="float"><input name="in" type="float" nodename="root"/></dot>'
        '<image name="i" type="float"><input name="texcoord" type="vector2" nodename="uv"/></image>'
        '<texcoord name="uv" type="vector2"/>'
    )
    root = constant_input(document.getNode("d"), "in")
    assert isinstance(root, np.ndarray)
    assert root == 3.0
    assert constant_input(document.getNode("i"), "texcoord") is None
    z, x = (np.tile(axis, (2, 1)) for axis in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    at = ShadingPoints(z, z, z, x, x, texcoord=np.array([[0.1, 0.2], [0.3, 0.4]]))
    assert input_at(document.getNode("i"), "texcoord", at).tolist() == [[0.1, 0.3], [0.2, 0.4]]
    assert input_at(document.getNode("i"), "uaddressmode", at) is None  # a text
