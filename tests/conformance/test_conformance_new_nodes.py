"""The nodes that MaterialX has not, against oracles that know nothing of their graphs; a wrong graph fails there."""

from __future__ import annotations

import numpy as np
import pytest

from mrm_mtlx.conformance import cases, new_cases, osl, run
from mrm_mtlx.conformance.new_nodes import AMOUNT, WEIGHT_NODE, NewCase, expected, new_document, new_points
from mrm_mtlx.engines.gl import SurfaceProgram
from mrm_mtlx.library import DataLibrary, Origin, load_library
from mrm_mtlx.reference import Surface
from mrm_mtlx.shadergen import generate, renderable_elements
from mrm_mtlx.validation.comparison import sampling
from mrm_mtlx.validation.comparison.samples import compare, draw

# Enough that every case meets its peaks and its grazing directions some hundred times.
SAMPLES = 1024
# A score per angle between v and l in Cycles.
OSL_SAMPLES = 240

PARTIAL = [case for case in new_cases() if case.node != WEIGHT_NODE]
WEIGHT = [case for case in new_cases() if case.node == WEIGHT_NODE]
by_case = pytest.mark.parametrize("case", new_cases(), ids=lambda case: case.name)


def test_the_cases_are_every_new_node_alone():
    names = [case.name for case in [*cases(), *new_cases()]]
    assert len(names) == len(set(names))
    nodes = {d.getNodeString() for d in load_library().document.getNodeDefs()}
    new = nodes - {d.getNodeString() for d in load_library(Origin.UPSTREAM).document.getNodeDefs()}
    # One of them is a part of another.
    assert {case.node for case in new_cases()} == new - {"mrm_cube_corner_share"}


@by_case
def test_every_new_node_passes_on_both_hardware_targets(gl_clean, case):
    results = list(run(("glsl", "essl"), SAMPLES, 0, Origin.MRM, chosen=[case]))
    assert [result.target for result in results] == ["glsl", "essl"]
    for result in results:
        assert result.status == "pass", result.target
        assert result.comparison.samples == SAMPLES
        # Two-sided: float32 was at work.
        assert 2.0**-26 < result.comparison.median_error < 2.0**-16
        assert 0.0 < result.comparison.excess < 1.0


@pytest.mark.parametrize("case", [case for case in new_cases() if not case.film], ids=lambda case: case.name)
def test_every_new_node_passes_in_cycles(cycles, case):
    (result,) = run(("osl",), OSL_SAMPLES, 0, Origin.MRM, chosen=[case])
    assert result.status == "pass"
    assert result.variant == ("closures" if case.node == WEIGHT_NODE else "parts")
    assert result.comparison.samples == OSL_SAMPLES
    assert 0.0 < result.comparison.excess < 1.0


def test_an_amount_that_is_off_by_some_roundings_is_seen_in_cycles(cycles, monkeypatch):
    case = next(case for case in new_cases() if "conductor" in case.node)
    told = osl._handed_on
    for factor, status in ((1.0, "pass"), (1.0 + 2.0**-18, "fail")):
        monkeypatch.setattr(osl, "_handed_on", lambda *given, factor=factor: factor * told(*given))
        (result,) = run(("osl",), OSL_SAMPLES, 0, Origin.MRM, chosen=[case])
        assert result.status == status


def test_materialx_alone_has_no_such_cases(monkeypatch):
    planned: list[list[str]] = []
    monkeypatch.setattr(osl, "steps", lambda _target, todo, *_: planned.append([case.node for case in todo]) or [])
    for origin in Origin:
        list(run(("osl",), 16, 0, origin))
    ours, theirs = planned
    assert set(ours) - set(theirs) == {case.node for case in new_cases()}
    assert len(theirs) == len(cases())


@by_case
def test_the_document_of_a_case_varies_its_inputs(library, case):
    document = new_document(case, library.document)
    valid, message = document.validate()
    assert valid, message
    connected = {given.getName() for given in document.getNode("lobe").getInputs() if given.getNodeName()}
    if case.node == WEIGHT_NODE:
        assert connected == {"ior", "rotation"}
    else:
        assert {AMOUNT, "weight", "roughness"} < connected


def test_amounts_cover_their_range_with_both_ends(rng):
    amount = new_points(PARTIAL[0], 4096, rng).properties[AMOUNT]
    for end in (0.0, 1.0):
        assert 0.05 < np.mean(amount == end) < 0.25
    assert np.all((amount >= 0.0) & (amount <= 1.0))
    assert np.ptp(amount[(amount > 0.0) & (amount < 1.0)]) > 0.9


def passes(case: NewCase, library: DataLibrary) -> bool:
    """One case of a library, as `conformance.run` does it with the installed one."""
    document = new_document(case, library.document)
    element = renderable_elements(document)[0]
    points = new_points(case, SAMPLES, sampling.generator(0, case.name))
    # What is allowed, too, follows from the wrong graph.
    tolerance = expected(case, points, Surface(element).tolerance(points), library.document)
    with SurfaceProgram(generate(element, "glsl", library)) as program:
        return compare(draw(program, points).colors, tolerance, points).passed


FACES = '<input name="in2" type="float" nodename="area_faces" />'
HALF = '<input name="in1" type="float" nodename="share_sum" />\n      <input name="in2" type="float" value="{}" />'
MIX = """    <mix name="partial" type="BSDF">
      <input name="fg" type="BSDF" nodename="retroreflected" />
      <input name="bg" type="BSDF" nodename="{}" />"""
# Generators write the mixture as a sum of both; a part without a weight of its own counts whole in the throughput.
UNWEIGHTED = """    <multiply name="unweighted" type="BSDF">
      <input name="in1" type="BSDF" nodename="ordinary" />
      <input name="in2" type="float" value="1.0" />
    </multiply>
"""
FLAG = '<input name="retroreflective" type="boolean" value="{}" uniform="true" />'
AIR, METAL = WEIGHT
GLOSSY = [case for case in PARTIAL if not case.film]
GLASS = [case for case in GLOSSY if "dielectric" in case.node]  # where tried on one alone: drivers take their time

# What is changed in the graphs, the cases that are tried, and those of them that fail.
DAMAGE = {
    "nothing": (HALF.format(0.5), HALF.format(0.5), [AIR, METAL], []),
    "total reflection left out": (FACES, FACES.replace("area_faces", "area"), [AIR, METAL], [AIR]),
    "rotated the other way": ('value="57.29578"', 'value="-57.29578"', [AIR, METAL], [AIR, METAL]),
    "rotated by radians": ('value="57.29578"', 'value="1.0"', [AIR, METAL], [AIR, METAL]),
    "three percent too much": (HALF.format(0.5), HALF.format(0.515), [AIR, METAL], [AIR, METAL]),
    "one orientation alone": (
        'nodename="share_turned" />',
        'nodename="share_one" />',
        [AIR, METAL],
        [AIR, METAL],
    ),
    "retroreflective in both branches": (FLAG.format("false"), FLAG.format("true"), GLASS, GLASS),
    "what lies below lost": (MIX.format("ordinary"), UNWEIGHTED + MIX.format("unweighted"), GLASS, GLASS),
    "flags on the wrong branches": (
        MIX.format("ordinary"),
        MIX.format("retroreflected").replace('"retroreflected', '"ordinary', 1),
        GLASS,
        GLASS,
    ),
    "ordinary in both branches": (
        MIX.format("ordinary"),
        MIX.format("ordinary").replace('"retroreflected', '"ordinary'),
        GLOSSY,
        GLOSSY,
    ),
    "another input for the amount": (
        '<input name="mix" type="float" nodename="amount" />',
        '<input name="mix" type="float" interfacename="weight" />',
        GLASS,
        GLASS,
    ),
    "weight left out": (
        '<input name="weight" type="float" interfacename="weight" />',
        '<input name="weight" type="float" value="1.0" />',
        GLASS,
        GLASS,
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_wrong_graph_fails_in_the_cases_that_it_is_wrong_in(gl_clean, changed_library, damage):
    old, new, tried, failing = DAMAGE[damage]
    wrong, _ = changed_library("mrm_ng.mtlx", old, new)
    assert [case for case in tried if not passes(case, wrong)] == failing
