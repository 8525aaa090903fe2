"""Where something stands, as it is written and as it crosses processes."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from mrm_mtlx.findings import rules
from mrm_mtlx.findings.source_location import SourceLocation

FOUND = rules.DOC_CYCLE.at("/a", "it goes round")


@pytest.mark.parametrize(
    ("source", "written", "within", "line"),
    [
        (SourceLocation("a.mtlx", 12, 5), "a.mtlx:12:5", "12:5", "a.mtlx:12:5: error DOC_CYCLE /a: it goes round"),
        (SourceLocation("b.mtlx", 1, 1), "b.mtlx:1:1", "b.mtlx:1:1", "b.mtlx:1:1: error DOC_CYCLE /a: it goes round"),
        (SourceLocation("a.mtlx"), "a.mtlx", "", "error DOC_CYCLE /a: it goes round"),
        (SourceLocation("b.usda", layer="b.usda", prim="/a"), "b.usda", "b.usda", None),
        (SourceLocation("b.gltf", 3, 4, pointer="/a"), "b.gltf:3:4", "b.gltf:3:4", None),
    ],
)
def test_it_is_written_as_compilers_write_it(source, written, within, line):
    assert (str(source), source.within("a.mtlx")) == (written, within)
    told = str(replace(FOUND, source=source))
    assert told == (line or f"{written}: error DOC_CYCLE /a: it goes round")


def test_a_finding_keeps_the_source_that_is_known_better():
    named = FOUND.in_file("a.mtlx")
    assert named.source == SourceLocation("a.mtlx")
    assert named.in_file("b.mtlx") is named
    assert str(named) == str(FOUND)


def test_it_crosses_processes_as_it_is():
    source = SourceLocation("a.usdz", layer="a.usdz[b.usda]", prim="/a")
    assert pickle.loads(pickle.dumps(source)) == source
    assert source.to_json() == {
        "file": "a.usdz", "line": None, "column": None, "layer": "a.usdz[b.usda]", "prim": "/a"
    }  # fmt: skip
