"""Documents with nothing retroreflective, for comparisons."""

from __future__ import annotations

import pytest

from mrm_mtlx.render.ordinary import ordinary_copy

CONDUCTOR = '<conductor_bsdf name="a" type="BSDF">{}</conductor_bsdf>'
PARTIAL = '<mrm_conductor_bsdf name="a" type="BSDF">{}</mrm_conductor_bsdf><constant name="amount" type="float"/>'
AMOUNT = '<input name="retroreflectivity" type="float" {}/>'


@pytest.mark.parametrize(
    ("nodes", "name", "off"),
    [
        (CONDUCTOR.format('<input name="retroreflective" type="boolean" value="true"/>'), "retroreflective", False),
        (PARTIAL.format(AMOUNT.format('value="0.5"')), "retroreflectivity", 0.0),
        (PARTIAL.format(AMOUNT.format('nodename="amount"')), "retroreflectivity", 0.0),
        (PARTIAL.format(""), "retroreflectivity", 0.0),
    ],
    ids=["flag", "amount", "connected amount", "amount by default"],
)
def test_what_is_retroreflective_is_off_in_the_copy_alone(make_document, nodes, name, off):
    document = make_document(nodes)
    before = document.getNode("a").getInput(name)
    before = (before.getValue(), before.getNodeName()) if before else None
    copy = ordinary_copy(document)
    switched = copy.getNode("a").getInput(name)
    assert (switched.getValue(), switched.getNodeName()) == (off, "")
    after = document.getNode("a").getInput(name)
    assert ((after.getValue(), after.getNodeName()) if after else None) == before


@pytest.mark.parametrize(
    "nodes", [CONDUCTOR.format(""), PARTIAL.format(AMOUNT.format('value="0"')), '<add name="a" type="float"/>']
)
def test_where_nothing_is_retroreflective_there_is_nothing_to_compare(make_document, nodes):
    with pytest.raises(ValueError, match=r"^nothing to compare: no lobe of the material is retroreflective$"):
        ordinary_copy(make_document(nodes))
