"""`mrm photometry`: tables, verdicts, exit statuses, forms of the report, and how wrong calls are refused."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path

import jsonschema
import pytest

from mrm_mtlx.photometry.color import METHODS
from mrm_mtlx.standards.tables import MISSING, classes, standards

MATERIALS = Path(__file__).parents[2] / "materials"
WHITE_TAPE = MATERIALS / "conspicuity_tape_white.mtlx"
DOT_C2 = ("--standard", "FMVSS 108", "--class", "DOT-C2", "--color", "white")

DIFFUSER = """<?xml version="1.0"?>
<materialx version="1.39">
  <oren_nayar_diffuse_bsdf name="d" type="BSDF">
    <input name="color" type="color3" value="{color}"/></oren_nayar_diffuse_bsdf>
  <surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="d"/></surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>
</materialx>
"""


@pytest.fixture
def here(in_process):
    """Function from arguments of `mrm photometry` to the finished command."""
    return partial(in_process, "photometry")


@pytest.fixture
def white(tmp_path):
    """A document of a white diffuser in the test's folder, by its name there."""
    (tmp_path / "white.mtlx").write_text(DIFFUSER.format(color="1, 1, 1"), encoding="utf-8")
    return "white.mtlx"


@pytest.fixture(scope="module")
def conforms(repository):
    schema = json.loads((repository / "docs" / "photometry.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    return lambda report: [error.message for error in validator.iter_errors(report)] == []


def test_a_material_of_its_class_passes(here):
    done = here(WHITE_TAPE, *DOT_C2)
    assert (done.exit_code, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "FMVSS 108, DOT-C2, white: value / minimum"
    assert lines[1] == "  49 CFR 571.108 Table XVI-c, 2015 edition (verified-primary)"
    assert "393.1 / 250 ok" in done.stdout
    assert lines[-1] == "PASSED  6 of 6 limits met, 1 surface"
    assert "FAIL" not in done.stdout


def test_a_material_below_its_class_fails_and_says_where(here, white):
    done = here(white, WHITE_TAPE, *DOT_C2)
    assert done.exit_code == 1
    assert "0.3167 / 250 FAIL" in done.stdout
    assert done.stdout.splitlines()[-1] == "FAILED  6 of 12 limits met, 2 surfaces"


def test_without_a_class_a_white_diffuser_has_the_textbook_values_and_no_verdict(here, white):
    done = here(white)
    assert done.exit_code == 0
    rows = {line.split()[1]: line.split()[2:] for line in done.stdout.splitlines() if "observation " in line}
    assert rows["0.1°"][1] == "0.3183"
    assert rows["1.05°"] == ["6.888"]
    assert done.stdout.splitlines()[-1] == "MEASURED  1 surface; no limits asked for (--list)"


def test_angles_can_be_chosen(here, white):
    done = here(white, "--observation", 0, "--entrance", 0, "--entrance", 60, "--rotation", 0)
    (row,) = [line.split() for line in done.stdout.splitlines() if "observation 0°" in line]
    # 1 / pi and a quarter of it.
    assert row[2:] == ["0.3183", "0.07958"]
    assert "; rotation 0°;" in done.stdout


def test_the_way_of_colours_is_stated_and_matters_for_a_red(here):
    red = MATERIALS / "bicycle_reflector_red.mtlx"
    values = {}
    for method in METHODS:
        done = here(red, "--observation", 0.2, "--entrance", 5, "--method", method, "--format", "json")
        report = json.loads(done.stdout)
        assert report["settings"]["method"] == method
        values[method] = report["documents"][0]["surfaces"][0]["cells"][0]["value"]
    # Luminance of pure red under A: 0.326 by its spectrum, 0.392 as a product.
    assert 0.82 < values["spectral"] / values["rgb"] < 0.84


def test_intensities_need_the_area_of_the_reflector(here):
    red = MATERIALS / "bicycle_reflector_red.mtlx"
    done = here(red, "--class", "front/rear/side", "--color", "red")
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-1] == (
        "Error: Invalid value: R_I [cd/fc] is of a whole reflector: give its area, --area CM2"
    )
    done = here(red, "--class", "front/rear/side", "--color", "red", "--area", 20)
    assert done.stdout.startswith("16 CFR 1512, front/rear/side reflector, red (1/4 of clear): value / minimum\n")
    assert "across 50°" in done.stdout
    assert " / 6.75 " in done.stdout
    assert "; rotation 0°;" in done.stdout  # a reflector is not turned


def test_a_discs_reading_is_stated_and_lower(here):
    chosen = ("--observation", 0.2, "--entrance", 5, "--format", "json")
    values = [
        json.loads(here(WHITE_TAPE, *chosen, *discs).stdout)["documents"][0]["surfaces"][0]["cells"][0]["value"]
        for discs in ((), ("--source-aperture", 0.2, "--receiver-aperture", 0.2))
    ]
    assert 0.9 < values[1] / values[0] < 0.999
    done = here(WHITE_TAPE, "--source-aperture", 0.2)
    assert "; source 0.2° and receiver 0° across\n" in done.stdout


def test_json_follows_its_schema_with_a_class_and_without(here, white, conforms, tmp_path):
    for arguments in ((), DOT_C2):
        done = here(white, WHITE_TAPE, *arguments, "--format", "json")
        report = json.loads(done.stdout)
        assert conforms(report)
        assert report["summary"]["passed"] == (done.exit_code == 0)
        assert done.stderr.splitlines()[-1].startswith("FAILED" if arguments else "MEASURED")
        assert str(tmp_path) not in done.stdout
        assert here(white, WHITE_TAPE, *arguments, "--format", "json").stdout == done.stdout
    cell = report["documents"][1]["surfaces"][0]["cells"][0]
    assert (cell["minimum"], cell["met"], cell["confidence"]) == (250.0, True, "verified-primary")
    report["summary"]["met"] = -1
    assert not conforms(report)


def test_json_of_black_and_of_what_is_not_measured_follows_its_schema(here, tmp_path, conforms):
    (tmp_path / "black.mtlx").write_text(DIFFUSER.format(color="0, 0, 0"), encoding="utf-8")
    done = here("black.mtlx", "missing.mtlx", "--format", "json")
    assert done.exit_code == 1
    report = json.loads(done.stdout)
    assert conforms(report)
    assert [document["measured"] for document in report["documents"]] == [True, False]
    assert report["documents"][0]["surfaces"][0]["colors"][0]["x"] is None


def test_every_key_of_the_schema_is_described(repository):
    schema = json.loads((repository / "docs" / "photometry.schema.json").read_text(encoding="utf-8"))

    def undescribed(part):
        if isinstance(part, list):
            return [name for item in part for name in undescribed(item)]
        if not isinstance(part, dict):
            return []
        here = [name for name, child in part.get("properties", {}).items() if not child.get("description")]
        return here + [name for child in part.values() for name in undescribed(child)]

    assert undescribed(schema) == []


def test_a_report_goes_to_a_file(here, white, tmp_path):
    done = here(white, "-o", "report.txt")
    assert (done.exit_code, done.stdout) == (0, "")
    text = (tmp_path / "report.txt").read_text(encoding="utf-8")
    assert text == here(white).stdout
    assert done.stderr == text.splitlines()[-1] + "\n"


def test_folders_are_searched(here, tmp_path):
    for name in ("b", "a"):
        (tmp_path / "in" / name).mkdir(parents=True)
        (tmp_path / "in" / name / "white.mtlx").write_text(DIFFUSER.format(color="1, 1, 1"), encoding="utf-8")
    found = re.findall(r"^\S+\.mtlx$", here("in", "in/a/white.mtlx").stdout, re.MULTILINE)
    assert found == ["in/a/white.mtlx", "in/b/white.mtlx"]


def test_what_is_excluded_of_a_folder_is_not_measured(here, white):
    done = here(".", "--exclude", white)
    assert done.exit_code == 3
    assert done.stdout.splitlines()[-1] == "NOT ALL MEASURED  0 surfaces; no limits asked for (--list)"


def test_what_cannot_be_read_is_said_and_the_others_are_measured(here, white, documents):
    done = here(documents / "READ_XML" / "triggers.mtlx", white, "nowhere.mtlx")
    assert done.exit_code == 1
    assert "error READ_XML" in done.stderr
    assert "error READ_MISSING: 'nowhere.mtlx' does not exist" in done.stderr
    assert "READ_XML/triggers.mtlx: not measured" in done.stdout
    assert "0.3183" in done.stdout
    assert done.stdout.splitlines()[-1] == ("FAILED  1 surface, 2 documents not measured; no limits asked for (--list)")


def test_what_the_reference_does_not_know_is_not_measured(here, documents):
    done = here(documents / "SHADER_COMPILE" / "triggers.mtlx", *DOT_C2)
    assert done.exit_code == 3
    assert "mrm: /material has no reference: the reference does not know ND_dust" in done.stderr
    assert done.stdout.splitlines()[-1] == "NOT ALL MEASURED  0 of 0 limits met, 0 surfaces, 1 document not measured"


@pytest.mark.parametrize("arguments", [("--list",), ("--standard", "list")])
def test_the_list_has_every_class_with_its_source_and_what_is_missing(here, arguments):
    text = here(*arguments).stdout
    for chosen in classes():
        assert f"  {chosen.class_name} | {chosen.colour}" in text
    for limit in standards():
        assert f"{limit.source} ({limit.confidence})" in text
    assert all(f"  {name}" in text for name in MISSING)


def test_the_list_as_json_has_every_minimum(here):
    report = json.loads(here("--list", "--format", "json").stdout)
    assert report["schema"] == "mrm.photometry.standards/1"
    assert len(report["limits"]) == len(standards())
    assert report["missing"] == list(MISSING)


def test_a_picture_is_drawn_of_one_surface(here, white, tmp_path):
    done = here(WHITE_TAPE, *DOT_C2, "--plot", "tape.svg")
    assert done.exit_code == 0
    assert done.stderr == "wrote tape.svg (/M_conspicuity_tape_white)\n"
    assert (tmp_path / "tape.svg").read_bytes().startswith(b"<?xml")
    done = here(WHITE_TAPE, white, "--plot", "both.svg")
    assert done.exit_code == 2
    assert "a picture is of one surface, here are 2" in done.stderr
    assert not (tmp_path / "both.svg").exists()


@pytest.fixture
def on_the_page(page_commands):
    """Arguments of each `mrm photometry` on its page."""
    return [arguments for name, *arguments in page_commands("photometry.md") if name == "photometry"]


def test_the_commands_of_the_page_run(here, on_the_page, tmp_path):
    (tmp_path / "materials").symlink_to(MATERIALS)
    assert len(on_the_page) >= 10
    for arguments in on_the_page:
        done = here(*arguments)
        # 1 where a class is not met, which is an answer too.
        assert done.exit_code in (0, 1), done.stderr
        assert "not measured" not in done.stdout


def test_the_report_on_the_page_is_what_the_command_prints(here, on_the_page, repository, tmp_path):
    (tmp_path / "materials").symlink_to(MATERIALS)
    text = (repository / "docs" / "photometry.md").read_text(encoding="utf-8")
    printed = re.search(r"\nprints\n\n((?:    .*\n|\n)*)", text)[1].strip("\n").splitlines()
    found = here(*on_the_page[0]).stdout.splitlines()
    assert [line.removeprefix("    ") for line in printed] == [line.rstrip() for line in found]


WRONG = {
    (): "name a document, or --list for the standards",
    ("white.mtlx", "--standard", "EN 12899-1"): "no single standard is called 'EN 12899-1'; expected one of: 16 CFR",
    ("white.mtlx", "--class", "DOT-C2"): "which colour is not said; expected one of: red, white",
    ("white.mtlx", "--standard", "FMVSS 108"): "which class is not said; expected one of: reflex reflector",
    ("white.mtlx", "--color", "red"): "only with --standard or --class",
    ("white.mtlx", *DOT_C2, "--area", "3"): "an area is for limits of intensity",
    ("white.mtlx", *DOT_C2, "--observation", "1"): "not with a class, which has its own angles",
    ("white.mtlx", "--observation", "-1"): "-1: expected an angle from 0 to 180 degrees",
    ("white.mtlx", "--entrance", "91"): "91: expected an angle from -90 to 90 degrees",
    ("white.mtlx", "--rotation", "nan"): "nan: expected an angle from -360 to 360 degrees",
    ("white.mtlx", "--area", "0"): "0: expected a number above 0",
    ("white.mtlx", "--source-aperture", "200"): "200: expected an angle from 0 to 180 degrees",
    ("white.mtlx", "--plot", "a.bmp"): "a.bmp: expected a name that ends in .png, .svg, .pdf",
    ("white.mtlx", "--method", "cmyk"): "'cmyk': expected one of spectral, rgb",
    ("white.mtlx", "--element", "n"): "n: expected one of m",
}


@pytest.mark.parametrize(("arguments", "message"), WRONG.items(), ids=map(" ".join, WRONG))
def test_a_wrong_call_is_refused_with_what_was_expected(here, white, arguments, message):
    done = here(*arguments)
    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr


def test_the_grid_of_angles_fits_a_terminal(mrm_here):
    lines = mrm_here("photometry", MATERIALS / "conspicuity_tape_white.mtlx").stdout.splitlines()
    table = lines[lines.index("  /M_conspicuity_tape_white") + 1 :][:7]
    assert table[0].split() == ["R_A", "[cd/lx/m2],", "entrance", "-4°", "0°", "5°", "30°", "45°", "60°"]
    assert [line.split()[0] for line in table[1:]] == ["observation"] * 6
    assert max(map(len, table)) <= 80
