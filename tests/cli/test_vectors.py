"""`mrm vectors`: one table in three forms."""

from __future__ import annotations

import csv
import io
import json
import re

from mrm_mtlx import __version__
from mrm_mtlx.api.vectors import TestVectors


def test_the_three_forms_have_the_same_values(mrm, tmp_path):
    done = mrm("vectors", "--format", "json", "-o", "vectors.json")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    document = json.loads((tmp_path / "vectors.json").read_text())
    # The other forms are made of the same rows, which take seconds: without the process, and of these.
    known = TestVectors(tuple(document["vectors"]))
    printed = {"csv": known.to_csv(), "text": known.report()}
    assert (document["schema"], document["versions"]) == ("mrm.vectors/1", {"mrm": __version__})
    rows = document["vectors"]
    table = list(csv.DictReader(io.StringIO(printed["csv"])))
    assert len(table) == len(rows) > 50
    for row, vector in zip(table, rows, strict=True):
        assert row["case"] == vector["case"]
        assert [float(row[f"f_{c}"]) for c in "rgb"] == vector["f"]
        assert [float(row[f"v_{c}"]) for c in "xyz"] == vector["v"]
        assert float(row["pdf"]) == vector["pdf"]
        assert max(vector["albedo"]) <= 1.0  # of energy
        assert row["retroreflective"] == str(vector.get("retroreflective", "")).lower()
        color0 = vector.get("color0")
        assert row["color0_g"] == ("" if color0 is None else str(color0))
    # In the text, six digits; a line of values begins with the angles, and there is one per row.
    shown = [line.split() for line in printed["text"].splitlines() if re.match(r" +-?\d+\.\d ", line)]
    assert [[float(x) for x in line[4:7]] for line in shown] == [
        [float(f"{x:.6g}") for x in vector["f"]] for vector in rows
    ]


def test_an_unknown_form_is_a_usage_error(mrm):
    done = mrm("vectors", "--format", "xml")
    assert (done.returncode, done.stdout) == (2, "")
    assert "'xml': expected one of text, json, csv" in done.stderr
