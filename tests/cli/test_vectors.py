"""`mrm vectors`: one table in three forms."""

from __future__ import annotations

import csv
import io
import json
import re

from mrm_mtlx import __version__


def test_the_three_forms_have_the_same_values(mrm, tmp_path):
    done = {form: mrm("vectors", "--format", form) for form in ("text", "json")}
    done["csv"] = mrm("vectors", "--format", "csv", "-o", "vectors.csv")
    assert {(run.returncode, run.stderr) for run in done.values()} == {(0, "")}
    assert done["csv"].stdout == ""
    printed = {form: run.stdout for form, run in done.items()} | {"csv": (tmp_path / "vectors.csv").read_text()}
    document = json.loads(printed["json"])
    assert (document["schema"], document["versions"]) == ("mrm.vectors/1", {"mrm": __version__})
    vectors = document["vectors"]
    table = list(csv.DictReader(io.StringIO(printed["csv"])))
    assert len(table) == len(vectors) > 50
    for row, vector in zip(table, vectors, strict=True):
        assert row["case"] == vector["case"]
        assert [float(row[f"f_{c}"]) for c in "rgb"] == vector["f"]
        assert [float(row[f"v_{c}"]) for c in "xyz"] == vector["v"]
        assert float(row["pdf"]) == vector["pdf"]
        assert row["retroreflective"] == str(vector.get("retroreflective", "")).lower()
        color0 = vector.get("color0")
        assert row["color0_g"] == ("" if color0 is None else str(color0))
    # In the text, six digits; a line of values begins with the angles, and there is one per row.
    shown = [line.split() for line in printed["text"].splitlines() if re.match(r" +-?\d+\.\d ", line)]
    assert [[float(x) for x in line[4:7]] for line in shown] == [
        [float(f"{x:.6g}") for x in vector["f"]] for vector in vectors
    ]


def test_an_unknown_form_is_a_usage_error(mrm):
    done = mrm("vectors", "--format", "xml")
    assert (done.returncode, done.stdout) == (2, "")
    assert "'xml' is not one of 'text', 'json', 'csv'" in done.stderr
