"""Test vectors: their rows say all that another implementation needs, and the reference gives what they say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mrm_mtlx import bsdf
from mrm_mtlx.bsdf.testvectors import DIGITS, cases, direction, rows
from mrm_mtlx.reference import versions

# Relative, of a value printed with `DIGITS` digits for directions printed with as many: the narrowest lobe, alpha
# 0.0025, turns an error e of a direction into 4 e / alpha of its logarithm (slope over width, twice squared).
PRINTED_TOL = 10.0 ** (1 - DIGITS) * (1.0 + 4.0 / 0.0025)


@pytest.fixture(scope="module")
def table() -> list[dict[str, Any]]:
    return rows(albedos=False)


def from_row(row: dict[str, Any]) -> bsdf.Lobe:
    """The lobe that a row's parameters describe."""
    known = {"case", "model", "retroreflectivity", "v", "l", "f", "pdf", "albedo"}
    parameters = {name: value for name, value in row.items() if name not in known and not name.endswith("_deg")}
    if "energy_compensation" in row:
        given = versions.installed().microfacet_albedo.white if row["energy_compensation"] else None
        parameters["energy_compensation"] = given
    lobe = getattr(bsdf, row["model"])(**parameters)
    return bsdf.partially_retroreflective(lobe, row["retroreflectivity"]) if "retroreflectivity" in row else lobe


def misses(table: list[dict[str, Any]], quantity: str) -> list[str]:
    """Cases whose printed value is not the one that their printed parameters and directions give."""
    found = []
    for row in table:
        lobe = from_row(row)
        value = lobe.eval(row["v"], row["l"]) if quantity == "f" else lobe.pdf(row["v"], row["l"])
        if not np.allclose(value, row[quantity], rtol=PRINTED_TOL, atol=0.0):
            found.append(row["case"])
    return found


@pytest.mark.parametrize("quantity", ["f", "pdf"])
def test_a_row_holds_all_that_gives_its_values(table, quantity):
    assert misses(table, quantity) == []


@pytest.mark.parametrize(
    "wrong",
    [
        lambda row: {"alpha": [row["alpha"][1], row["alpha"][0] * 1.001]},
        lambda row: {"retroreflective": not row["retroreflective"]},
        lambda row: {"masking": "v_cavity" if row["masking"] == "smith" else "smith"},
        lambda row: {"v": row["l"], "l": row["v"]},
    ],
    ids=["widths exchanged", "flag", "masking", "directions exchanged"],
)
def test_a_wrong_row_is_seen(table, wrong):
    row = next(row for row in table if row["case"] == "Figure 6: retroreflective BRDF, ordinary BTDF")
    assert misses([{**row, **wrong(row)}], "f") or misses([{**row, **wrong(row)}], "pdf")


def test_vectors_are_those_of_the_angles(table):
    for row in table:
        for name in "vl":
            angles = np.deg2rad([row[f"theta_{name}_deg"], row[f"phi_{name}_deg"]])
            np.testing.assert_allclose(row[name], direction(*angles), rtol=0.0, atol=10.0**-DIGITS)


def test_every_part_and_combination_has_a_row(table):
    for name, values in {
        "model": ("Conductor", "Dielectric", "GeneralizedSchlick", "PrismaticSheeting"),
        "backing": ("air", "metal"),
        "distribution": ("ggx", "beckmann", "phong"),
        "masking": ("smith", "smith_separable", "v_cavity"),
        "sampling": ("bounded", "visible"),
        "retroreflective": (False, True),
        "retroreflective_btdf": (False, True),
        "retroreflectivity": (0.0, 0.25, 1.0),
    }.items():
        assert {row[name] for row in table if name in row} == set(values)
    # Reflection and transmission, seen from outside and from inside, and a pair beyond the critical angle.
    through = {(row["v"][2] > 0, row["l"][2] > 0) for row in table if row["f"][0] > 0.0}
    assert through == {(True, True), (True, False), (False, True), (False, False)}


def test_the_vectors_of_figure_4_are_its_values(table):
    values = [row["f"][0] for row in table if row["case"] == "yellow tape of Figure 4"]
    # Half of the last digit given.
    np.testing.assert_allclose(values, [5.790, 7.200, 15.567], rtol=0.0, atol=0.0005)


def test_names_of_cases_differ():
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names)
