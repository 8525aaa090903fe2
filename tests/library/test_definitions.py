"""The node library's definitions against those of the installed MaterialX, and how well they are documented."""

from __future__ import annotations

from typing import TYPE_CHECKING

import MaterialX as mx
import pytest

from mrm_mtlx.library import node_library_folder
from tests.fixtures.versions import own_flag

if TYPE_CHECKING:
    from collections.abc import Callable

NODES = ("dielectric_bsdf", "conductor_bsdf", "generalized_schlick_bsdf")

# Attributes that decide what a document means; documentation and ranges are ours.
INTERFACE = ("type", "uniform", "enum", "enumvalues", "unittype", "unit", "defaultgeomprop", "colorspace")
DEFINITION = ("node", "nodegroup", "bsdf", "target", "version", "isdefaultversion", "inherit")

NUMERIC = ("float", "color3", "color4", "vector2", "integer")


@pytest.fixture(scope="module")
def ours() -> mx.Document:
    """The definitions file alone."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(node_library_folder() / "pbrlib" / "mrm_defs.mtlx"))
    return document


@pytest.fixture(scope="module")
def new_nodes() -> mx.Document:
    """The file with the definitions of the nodes that MaterialX has not."""
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(node_library_folder() / "pbrlib" / "mrm_node_defs.mtlx"))
    return document


def differences(ours: mx.Document, upstream: mx.Document) -> list[str]:
    """What a document could notice of the change from one library's definitions to the other's."""
    found = []
    for definition in ours.getNodeDefs():
        name = definition.getName()
        stock = upstream.getNodeDef(name)
        if stock is None:
            found.append(f"{name}: unknown upstream")
            continue
        found += [f"{name}: {a}" for a in DEFINITION if definition.getAttribute(a) != stock.getAttribute(a)]
        for kind, get in (("inputs", mx.NodeDef.getActiveInputs), ("outputs", mx.NodeDef.getActiveOutputs)):
            mine, theirs = get(definition), get(stock)
            if [p.getName() for p in mine] != [p.getName() for p in theirs]:
                found.append(f"{name}: {kind} or their order")
                continue
            for port, other in zip(mine, theirs, strict=True):
                place = f"{name}/{port.getName()}"
                found += [f"{place}: {a}" for a in INTERFACE if port.getAttribute(a) != other.getAttribute(a)]
                # As values, not as text: "0" and "0.0" are one float.
                if port.getValue() != other.getValue() or port.hasValueString() != other.hasValueString():
                    found.append(f"{place}: value")
    return found


def test_the_library_defines_the_three_microfacet_nodes(ours):
    assert sorted(d.getNodeString() for d in ours.getNodeDefs()) == sorted(NODES)
    assert all(d.getName() == f"ND_{d.getNodeString()}" for d in ours.getNodeDefs())


@own_flag
def test_the_definitions_are_those_of_the_installed_materialx(ours, upstream_library):
    assert differences(ours, upstream_library.document) == []


def test_each_file_of_definitions_knows_its_types_as_the_standard_library_has_them(ours, new_nodes, upstream_library):
    # USD reads every file by itself, and warns of a type that it does not find there.
    for document in (ours, new_nodes):
        (bsdf,) = document.getTypeDefs()
        standard = upstream_library.document.getTypeDef("BSDF")
        assert {a: bsdf.getAttribute(a) for a in bsdf.getAttributeNames()} == {
            a: standard.getAttribute(a) for a in standard.getAttributeNames()
        }


PARTIAL = "retroreflectivity"


def as_standard(document: mx.Document) -> mx.Document:
    """The definitions of partial retroreflection under the names of the nodes they extend, with the flag again."""
    standard = mx.createDocument()
    for node in NODES:
        definition = standard.addNodeDef(f"ND_{node}", "", node)
        definition.copyContentFrom(document.getNodeDef(f"ND_mrm_{node}"))
        definition.setNodeString(node)  # which the copy has overwritten
        flag = definition.getInput(PARTIAL)
        flag.setName("retroreflective")
        flag.setType("boolean")
        flag.setValueString("false")
        flag.setAttribute("uniform", "true")
    return standard


@own_flag
def test_partial_retroreflection_has_the_interface_of_the_standard_nodes_but_for_the_flag(new_nodes, upstream_library):
    assert differences(as_standard(new_nodes), upstream_library.document) == []
    for node in NODES:
        amount = new_nodes.getNodeDef(f"ND_mrm_{node}").getInput(PARTIAL)
        assert (amount.getType(), amount.getIsUniform()) == ("float", False)
    damaged = new_nodes.copy()
    damaged.getNodeDef("ND_mrm_dielectric_bsdf").getInput("ior").setValue(1.6)
    assert differences(as_standard(damaged), upstream_library.document) == ["ND_dielectric_bsdf/ior: value"]


def test_no_new_node_has_a_name_of_the_standard_library(new_nodes, upstream_library):
    for definition in new_nodes.getNodeDefs():
        assert definition.getNodeString().startswith("mrm_")
        assert not upstream_library.document.getMatchingNodeDefs(definition.getNodeString())


def _swap_inputs(document: mx.Document) -> None:
    document.getNodeDef("ND_conductor_bsdf").setChildIndex("ior", 2)


DAMAGE: dict[str, tuple[Callable[[mx.Document], object], str]] = {
    "default": (lambda d: d.getNodeDef("ND_dielectric_bsdf").getInput("ior").setValue(1.6), "ior: value"),
    "order": (_swap_inputs, "inputs or their order"),
    "missing input": (lambda d: d.getNodeDef("ND_conductor_bsdf").removeInput("distribution"), "inputs or their order"),
    "type": (lambda d: d.getNodeDef("ND_dielectric_bsdf").getInput("tint").setType("color4"), "tint: type"),
    "uniform": (
        lambda d: d.getNodeDef("ND_conductor_bsdf").getInput("retroreflective").removeAttribute("uniform"),
        "retroreflective: uniform",
    ),
    "enum": (
        lambda d: d.getNodeDef("ND_dielectric_bsdf").getInput("scatter_mode").setAttribute("enum", "R,T"),
        "scatter_mode: enum",
    ),
    "unit": (
        lambda d: d.getNodeDef("ND_dielectric_bsdf").getInput("thinfilm_thickness").setUnit("micron"),
        "thinfilm_thickness: unit",
    ),
    "geometry": (
        lambda d: d.getNodeDef("ND_dielectric_bsdf").getInput("normal").setDefaultGeomPropString("Nobject"),
        "normal: defaultgeomprop",
    ),
    "kind of scattering": (
        lambda d: d.getNodeDef("ND_conductor_bsdf").removeAttribute("bsdf"), "ND_conductor_bsdf: bsdf",
    ),
    "name": (lambda d: d.getNodeDef("ND_conductor_bsdf").setName("ND_metal_bsdf"), "ND_metal_bsdf: unknown upstream"),
}  # fmt: skip


@pytest.mark.parametrize("damage", sorted(DAMAGE))
@own_flag
def test_a_definition_that_departs_is_seen(ours, upstream_library, damage):
    change, seen = DAMAGE[damage]
    damaged = ours.copy()
    change(damaged)
    found = differences(damaged, upstream_library.document)
    assert seen in found[0]
    # A change of type changes the value with it; nothing else is reported.
    assert len({entry.partition(":")[0] for entry in found}) == 1


def undocumented(document: mx.Document) -> list[str]:
    """Definitions and inputs without a description, a label, or a range where they hold numbers."""
    found = []
    for definition in document.getNodeDefs():
        if not definition.getAttribute("doc"):
            found.append(f"{definition.getName()}: doc")
        for port in definition.getInputs():
            place = f"{definition.getName()}/{port.getName()}"
            found += [f"{place}: {a}" for a in ("doc", "uiname") if not port.getAttribute(a)]
            if port.getType() in NUMERIC:
                low, high = (port.getAttribute(f"ui{x}") or port.getAttribute(f"uisoft{x}") for x in ("min", "max"))
                if not (low and high):
                    found.append(f"{place}: range")
    return found


def test_every_input_says_what_it_is_and_where_it_may_go(ours, new_nodes):
    assert undocumented(ours) == []
    assert undocumented(new_nodes) == []


def test_the_stock_definitions_would_not_pass(upstream_library):
    stock = mx.createDocument()
    for node in NODES:
        stock.addNodeDef(f"ND_{node}").copyContentFrom(upstream_library.document.getNodeDef(f"ND_{node}"))
    kinds = {entry.partition(": ")[2] for entry in undocumented(stock)}
    assert kinds == {"doc", "uiname", "range"}


def components(text: str, kind: str) -> list[float]:
    """Numbers of an attribute, one per component."""
    value = mx.createValueFromStrings(text, kind)
    return [value] if isinstance(value, float) else list(value.asTuple())


def out_of_range(document: mx.Document) -> list[str]:
    """Inputs whose default is outside their hard range."""
    found = []
    for definition in document.getNodeDefs():
        for port in definition.getInputs():
            for bound, sign in (("uimin", 1.0), ("uimax", -1.0)):
                if port.hasAttribute(bound):
                    values, limits = (
                        components(text, port.getType()) for text in (port.getValueString(), port.getAttribute(bound))
                    )
                    if any(sign * value < sign * limit for value, limit in zip(values, limits, strict=True)):
                        found.append(f"{definition.getName()}/{port.getName()}: {bound}")
    return found


def test_defaults_lie_within_their_ranges(ours, new_nodes):
    assert out_of_range(ours) == []
    assert out_of_range(new_nodes) == []
    damaged = ours.copy()
    damaged.getNodeDef("ND_conductor_bsdf").getInput("roughness").setAttribute("uimin", "0.1, 0.0")
    assert out_of_range(damaged) == ["ND_conductor_bsdf/roughness: uimin"]
