"""What others make of what is written: the validator of documents, and a USD that has UsdMtlx."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import jsonschema
import MaterialX as mx
import pytest

from mrm_mtlx.documents.files import Reach
from mrm_mtlx.engines.osl.process import VARIABLE
from mrm_mtlx.library import node_library_folder
from mrm_mtlx.system.versions import versions
from mrm_mtlx.validation import reports
from mrm_mtlx.validation.document import check_document
from mrm_mtlx.validation.options import Request
from mrm_mtlx.validation.results import ValidationResult
from mrm_mtlx.validation.runner import engines

REPOSITORY = Path(__file__).parents[3]
PROGRAM = Path(__file__).with_name("usdmtlx_program.py")
DOCUMENTS = (
    "materials/licence_plate", "tests/rules/RETRO_INVISIBLE/triggers", "tests/rules/ENERGY_GAIN/triggers",
    "tests/rules/DOC_VALUE_RANGE/triggers", "tests/rules/LOBE_TOO_NARROW/triggers",
)  # fmt: skip


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_verdict_on_the_stage_is_that_on_the_document(name, imported, written):
    path = REPOSITORY / f"{name}.mtlx"
    stage = written(imported(path))
    document, converted = (check_document(Request(p, Reach.beside(p), p.name, targets=())) for p in (path, stage))
    assert [f.code for f in converted.findings] == [f.code for f in document.findings]
    assert [f.message for f in converted.findings] == [f.message for f in document.findings]
    assert all(f.location.startswith("/Materials/") for f in converted.findings)
    assert [r.name.removeprefix("/Materials/") for r in converted.renderables] == [r.name for r in document.renderables]


def test_every_target_gives_the_same_result(gl, imported, written):
    path = REPOSITORY / "materials" / "licence_plate.mtlx"
    stage = written(imported(path))
    document, converted = (
        check_document(Request(p, Reach.beside(p), p.name, targets=("glsl", "mdl"), samples=64)).renderables[0].targets
        for p in (path, stage)
    )
    assert document["glsl"].status == "pass"
    assert converted == document


def test_a_report_on_a_stage_follows_the_schema(stage_of, usda):
    path = usda('def Material "M" {\n token outputs:mtlx:surface\n}\n', head="#usda 1.0\n")
    result = check_document(Request(path, Reach.beside(path), path.name, targets=()))
    assert {f.code for f in result.findings} >= {"USD_VALIDATOR", "DOC_CONNECTION"}
    report = json.loads(reports.to_json(ValidationResult(versions(), engines(()), [result])))
    jsonschema.validate(report, json.loads((REPOSITORY / "docs" / "report.schema.json").read_text(encoding="utf-8")))
    assert "usd" in report["versions"]


@pytest.fixture(scope="session")
def usdmtlx(cycles):
    """Function from files to what Blender's USD with UsdMtlx makes of them: networks, and ids it does not know."""
    interpreter = os.environ.get(VARIABLE)
    if not interpreter:
        pytest.skip(f"{VARIABLE} names no interpreter with Blender's module apart from this one's USD")

    def run(*paths):
        # The MaterialX that Blender brings lacks the flag, and knows nothing of our nodes.
        standard = Path(mx.getDefaultDataSearchPath().asString().split(os.pathsep)[0], "libraries")
        folders = {
            "PXR_MTLX_STDLIB_SEARCH_PATHS": str(standard),
            "PXR_MTLX_PLUGIN_SEARCH_PATHS": str(node_library_folder()),
        }
        command = [interpreter, str(PROGRAM), "--blender", *map(str, paths)]
        environment = {**os.environ, **folders}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        answers = json.loads(done.stdout.splitlines()[-1])
        return [answers[str(path)] for path in paths]

    return run


# What UsdMtlx writes otherwise, and why: lengths and node definitions of the document are not translated.
EXPECTED = {
    "own/id": ("ND_own", None),
    "own/amount": ([3.0, ""], None),
    "inner/id": (None, "ND_multiply_color3FA"),
    "inner/in1": (None, [[0.5, 0.25, 0.125], ""]),
    "inner/in2": (None, [0.07620000094175339, ""]),
    "paint/color": (["own", "out"], ["inner", "out"]),
}
OWN = """
<nodedef name="ND_own" node="own"><input name="amount" type="float" value="1" unittype="distance" unit="meter" />
  <output name="out" type="color3" /></nodedef>
<nodegraph name="NG_own" nodedef="ND_own"><multiply name="inner" type="color3">
  <input name="in1" type="color3" value="0.5, 0.25, 0.125" /><input name="in2" type="float" interfacename="amount" />
  </multiply><output name="out" type="color3" nodename="inner" /></nodegraph>
<nodegraph name="NG"><own name="own" type="color3">
  <input name="amount" type="float" value="3" unittype="distance" unit="inch" /></own>
  <oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" nodename="own" />
  </oren_nayar_diffuse_bsdf><output name="out" type="BSDF" nodename="paint" /></nodegraph>
<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodegraph="NG" output="out" /></surface>
<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s" />
</surfacematerial>
"""


def test_a_network_is_that_of_usdmtlx_but_for_what_is_named(usdmtlx, imported, written, tmp_path):
    """By ids, values, connections and colour spaces; modulo where the nodes live."""
    own = tmp_path / "own.mtlx"
    own.write_text(f'<materialx version="1.39">{OWN}</materialx>')
    names = ("embossed_foil", "road_marking_paint", "hi_vis_tape_silver")
    paths = [*(REPOSITORY / "materials" / f"{name}.mtlx" for name in names), own]
    stages = [written(imported(path), f"stage_{k}.usda", []) for k, path in enumerate(paths)]
    answers = usdmtlx(*paths, *stages)
    theirs, ours = answers[: len(paths)], answers[len(paths) :]
    for path, their, our in zip(paths, theirs, ours, strict=True):
        (network,) = our["networks"].values()
        assert len(network["nodes"]) >= 2
        assert our["unknown"] == []  # with UsdMtlx, every id is registered
        differing = _differences(their["networks"], our["networks"])
        assert differing == (EXPECTED if path == own else {}), path.name


def _differences(theirs, ours):
    """By "node/input": what one of them has, and the other has not, or otherwise."""
    first, second = (_flat(networks) for networks in (theirs, ours))
    return {
        name: (first.get(name), second.get(name))
        for name in sorted(first.keys() | second.keys())
        if first.get(name) != second.get(name)
    }


def _flat(networks):
    (network,) = networks.values()
    found = {f"terminal/{name}": node for name, node in network["terminals"].items()}
    for name, node in network["nodes"].items():
        found |= {f"{name}/id": node["id"]} | {f"{name}/{given}": said for given, said in node["inputs"].items()}
    return found
