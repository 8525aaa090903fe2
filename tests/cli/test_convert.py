"""`mrm convert`: writes OpenMATERIAL's block, merges it, compares with it, and how it refuses."""

from __future__ import annotations

import json
import re
import textwrap
from functools import partial
from pathlib import Path

import pytest

TAPE = Path(__file__).parents[2] / "materials" / "conspicuity_tape_white.mtlx"


@pytest.fixture
def here(in_process, tmp_path):
    """Function from arguments of `mrm convert` to the finished command, run beside the materials."""
    (tmp_path / "materials").symlink_to(TAPE.parent)
    return partial(in_process, "convert")


def test_the_commands_of_the_page_run_and_it_shows_what_they_write(here, repository, page_commands):
    text = (repository / "docs" / "openmaterial.md").read_text(encoding="utf-8")
    convert = (arguments for name, *arguments in page_commands("openmaterial.md") if name == "convert")
    write, merge, compare, fit = convert
    done = here(*write)
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "wrote tape.json\n")
    shown = re.search(r"^    \{.*?^    \}$", text, re.MULTILINE | re.DOTALL)[0]
    assert Path("tape.json").read_text(encoding="utf-8") == textwrap.dedent(shown) + "\n"
    assert here(*merge).exit_code == 0
    done = here(*compare)
    assert done.exit_code == 0
    assert "observation 0.5 deg, entrance -4 deg (as the file states)" in done.stdout
    assert done.stdout.splitlines()[-1] == "PASSED  equal within 1%"
    assert here(*fit).exit_code == 0
    assert here(fit[-1], "--compare", "tape.json").exit_code == 0


def test_a_block_is_put_where_it_is_told_and_another_value_is_seen(here):
    Path("sign.json").write_text('{"name": "sign", "optical": {}}')
    assert here(TAPE, "-o", "sign.json", "--into", "sign.json", "--at", "/optical").exit_code == 0
    data = json.loads(Path("sign.json").read_text())
    assert (data["name"], list(data), list(data["optical"])) == ("sign", ["name", "optical"], ["retroreflectivityData"])
    value = data["optical"]["retroreflectivityData"]["coefficientOfRetroreflection"]
    # What counts as equal, from both sides.
    for factor, status in ((0.991, 0), (1.009, 0), (0.989, 1), (1.0112, 1)):
        data["optical"]["retroreflectivityData"]["coefficientOfRetroreflection"] = factor * value
        Path("sign.json").write_text(json.dumps(data))
        done = here(TAPE, "--compare", "sign.json")
        assert (done.exit_code, done.stdout.splitlines()[-1][:6]) == (status, ("PASSED", "FAILED")[status])
    assert "the file states other angles or none" in here(TAPE, "--compare", "sign.json", "--entrance", "5").stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "expected a file to write"),
        ({"output": "a.xyz"}, ".json, or --to"),
        ({"output": "no/a.json"}, "the folder no does not exist"),
        ({"output": "a.json", "at": "/x"}, "only with --into"),
        ({"output": "a.json", "compare": "plain.json"}, "not with --compare"),
        ({"output": "a.json", "into": "absent.json"}, "does not exist"),
        ({"output": "a.json", "into": "plain.json", "at": "/x"}, "there is no object at '/x'"),
        ({"output": "a.json", "observation": -1.0}, "expected 0 to 90 degrees"),
        ({"output": "a.json", "observation": float("nan")}, "expected 0 to 90 degrees"),
        ({"output": "a.json", "entrance": 91.0}, "expected -90 to 90 degrees"),
        ({"compare": "plain.json"}, "has no retroreflectivityData"),
    ],
    ids=str,
)
def test_a_wrong_call_is_told_so(in_process, tmp_path, metal, options, message):
    (tmp_path / "plain.json").write_text("{}")
    done = in_process("convert", metal, *(f"--{name}={value}" for name, value in options.items()))
    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr.splitlines()[-1]
    assert not (tmp_path / "a.json").exists()


def test_a_wrong_format_is_a_usage_error(mrm, metal):
    done = mrm("convert", metal, "-o", "a.json", "--to", "gltf")
    assert (done.returncode, done.stdout) == (2, "")
    assert "'gltf'" in done.stderr


def test_a_material_is_fitted_to_a_file_by_its_content(here):
    """R_A and its angles are the file's, those of the options where it states none."""
    of_a_lab = {"retroreflectivityData": {"coefficientOfRetroreflection": 250, "sources": "a lab"}}
    Path("sign.json").write_text(json.dumps({"name": "sign", "optical": of_a_lab}))
    for options, angles in (((), "0.2 and -4"), (("--observation", 0.5, "--entrance", 5), "0.5 and 5")):
        done = here("sign.json", "sign.mtlx", *options)
        assert (done.exit_code, done.stdout) == (0, "")
        first, _, last = done.stderr.splitlines()
        assert f"warning INTERCHANGE_LOST: the file says no more of the material than R_A, 250 at {angles} deg" in first
        assert last == "wrote sign.mtlx"
        assert here("sign.mtlx", "--compare", "sign.json", *options).exit_code == 0
    stated = {"coefficientOfRetroreflection": 250, "sources": "observation angle 0.5 deg, entrance angle 5 deg"}
    Path("stated.json").write_text(json.dumps({"retroreflectivityData": stated}))
    assert here("stated.json", "stated.mtlx").exit_code == 0
    comments = (Path(name).read_text().partition("<nodegraph")[0] for name in ("stated.mtlx", "sign.mtlx"))
    assert len(set(comments)) == 1
    # Any format can be written of it.
    assert here("sign.json", "sign.usda", *options).exit_code == 0
    assert here("sign.usda", "--compare", "sign.json", *options).exit_code == 0


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('{"a": 1', "no JSON: Expecting"),
        ("{}", "it has no retroreflectivityData"),
        ('{"retroreflectivityData": {"coefficientOfRetroreflection": 0, "sources": ""}}', "its R_A is 0"),
        ('{"retroreflectivityData": {"coefficientOfRetroreflection": 5001, "sources": ""}}', "expected 0 to 5000"),
    ],
    ids=["text", "block", "zero", "range"],
)
def test_a_file_that_no_material_can_be_fitted_to_is_a_finding(here, content, message):
    Path("sign.json").write_text(content)
    done = here("sign.json", "sign.mtlx")
    assert (done.exit_code, done.stdout) == (1, "")
    assert done.stderr.startswith("error READ_FORMAT")
    assert message in done.stderr
    assert not Path("sign.mtlx").exists()


def test_a_portable_document_is_written_as_materialx_and_as_usd(here):
    for name, *more in (("cone.mtlx",), ("cone.usda", "--no-preview")):
        done = here("materials/traffic_cone_collar.mtlx", name, "--portable", *more)
        assert (done.exit_code, done.stdout, done.stderr) == (0, "", f"wrote {name}\n")
    assert '"retroreflective"' not in Path("cone.mtlx").read_text(encoding="utf-8")
    # The look for hosts without MaterialX is that of the document itself.
    for name, *more in (("look.usda", "--portable"), ("itself.usda",)):
        assert here("materials/traffic_cone_collar.mtlx", name, *more).exit_code == 0
    portable, itself = (Path(name).read_text(encoding="utf-8") for name in ("look.usda", "itself.usda"))
    look = itself[itself.index('def Shader "preview"') :]
    assert "color3f inputs:diffuseColor = (0.50" in look
    assert portable.endswith(look)


@pytest.mark.parametrize("page", ["portable.md", "hosts/houdini.md"])
def test_the_commands_of_a_page_about_the_portable_form_run(mrm_here, page_commands, tmp_path, page):
    (tmp_path / "materials").symlink_to(TAPE.parent)
    smaller = {"render": ("--size", "32"), "validate": ("--samples", "256")}
    commands = page_commands(page)
    assert commands[0][0] == "convert"
    for name, *arguments in commands:
        done = mrm_here(name, *arguments, *smaller.get(name, ()))
        # Without a driver, nothing can be compared.
        assert done.returncode in ((0, 3) if name == "validate" else (0,)), done.stderr


def test_what_the_portable_form_cannot_say_is_told_and_the_rest_is_written(here):
    lobe = '<conductor_bsdf name="bsdf" type="BSDF"><input name="retroreflective" type="boolean" value="true"/>'
    film = '<input name="thinfilm_thickness" type="float" value="300"/></conductor_bsdf>'
    surface = '<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="bsdf"/></surface>'
    material = '<input name="surfaceshader" type="surfaceshader" nodename="s"/>'
    surface += f'<surfacematerial name="m" type="material">{material}</surfacematerial>'
    text = f'<?xml version="1.0"?><materialx version="1.39">{lobe}{film}{surface}</materialx>'
    Path("film.mtlx").write_text(text, encoding="utf-8")
    done = here("film.mtlx", "written.mtlx", "--portable")
    assert done.exit_code == 0
    assert "warning INTERCHANGE_LOST /bsdf/thinfilm_thickness" in done.stderr
    assert done.stderr.splitlines()[-1] == "wrote written.mtlx"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cone.glb", "--portable"), "--portable: glTF has no nodes of MaterialX"),
        (("cone.mtlx",), "is MaterialX already: --portable writes it for hosts without the node library"),
        (("--portable", "--compare", "x.json"), "not with --compare"),
    ],
    ids=str,
)
def test_a_portable_form_of_what_has_no_nodes_is_a_wrong_call(here, arguments, message):
    done = here(TAPE, *arguments)
    assert (done.exit_code, done.stdout) == (2, "")
    assert message in " ".join(done.stderr.split())
