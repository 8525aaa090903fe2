"""Findings are as many and as long as somebody reads, and the rest is counted."""

from __future__ import annotations

from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import MAXIMUM_OF_A_RULE, capped


def test_a_rule_is_told_a_hundred_times_and_the_rest_is_counted():
    unknown = [rules.DOC_UNKNOWN_NODE.at(f"/n{n}", "there is no such node") for n in range(MAXIMUM_OF_A_RULE + 3)]
    twice = [rules.DOC_DUPLICATE_NAME.at("/a", "again")] * 2
    found = capped([*unknown, *twice])
    assert found[:-1] == [*unknown[:MAXIMUM_OF_A_RULE], *twice]
    assert f"{found[-1].code} {found[-1].location} {found[-1].message}" == (
        "DOC_UNKNOWN_NODE  3 more findings of DOC_UNKNOWN_NODE; the first 100 are listed"
    )


def test_of_a_text_of_millions_both_ends_are_told():
    found = rules.DOC_UNKNOWN_NODE.at("/" + "a" * 5_000_000, "there is no node 'b'")
    assert len(found.location) < 5000
    assert found.location.startswith("/aaa")
    assert " [...] " in found.location
