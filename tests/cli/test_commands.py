"""The real command, in a process of its own: exit statuses, streams, formats, messages."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias
from xml.etree import ElementTree as ET

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

REPOSITORY = Path(__file__).parents[2]
DOCUMENTS = REPOSITORY / "tests" / "documents"
PLATE = "materials/licence_plate.mtlx"
# Seconds after which a command that takes a few counts as hanging.
PATIENCE_S = 180

Run: TypeAlias = "Callable[..., subprocess.CompletedProcess[str]]"


@pytest.fixture(scope="module")
def mrm() -> Run:
    """Run the command in the repository; whatever it is given, it must not show a traceback."""

    def run(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "mrm_mtlx.cli.main", *arguments]
        settings = {"cwd": REPOSITORY, "capture_output": True, "text": True, "timeout": PATIENCE_S, "check": False}
        done = subprocess.run(command, **{**settings, **options})
        assert "Traceback" not in done.stderr
        return done

    return run


# Exit statuses --------------------------------------------------------------------------------------------------------


def test_a_sound_document_exits_with_0(mrm: Run, gl: object) -> None:
    done = mrm("validate", PLATE, "--target", "glsl", "--samples", "256")
    assert done.returncode == 0, done.stdout
    assert done.stdout.rstrip().splitlines()[-1] == "PASSED  0 errors, 0 warnings, 1 checked, 0 skipped"


def test_a_broken_document_exits_with_1(mrm: Run) -> None:
    done = mrm("validate", str(DOCUMENTS / "READ_XML" / "triggers.mtlx"), "--target", "glsl")
    assert done.returncode == 1
    assert "READ_XML" in done.stdout
    assert done.stdout.rstrip().splitlines()[-1].startswith("FAILED  1 error")


def test_a_path_that_does_not_exist_is_a_finding(mrm: Run) -> None:
    done = mrm("validate", "nowhere.mtlx")
    assert done.returncode == 1
    assert "READ_MISSING" in done.stdout


def test_a_folder_without_documents_exits_with_3(mrm: Run, tmp_path: Path) -> None:
    done = mrm("validate", str(tmp_path))
    assert done.returncode == 3
    assert done.stdout.startswith("NOTHING CHECKED")


def test_targets_that_cannot_be_checked_here_exit_with_3(mrm: Run) -> None:
    done = mrm("validate", PLATE, "--target", "msl", "--ignore", "SHADER")
    assert done.returncode == 3
    assert "1 skipped (1 msl: no Metal compiler" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "Missing argument"),
        ((PLATE, "--target", "hlsl"), "expected one of glsl"),
        ((PLATE, "--select", "NOPE"), "no rule starts with 'NOPE'"),
        ((PLATE, "--ignore", "NOPE"), "no rule starts with 'NOPE'"),
        ((PLATE, "--samples", "0"), "--samples"),
        ((PLATE, "--format", "yaml"), "--format"),
        ((PLATE, "--nonsense"), "No such option"),
        ((PLATE, "--target", "mdl", "--output", "no/such/folder/report"), "cannot be written"),
    ],
)
def test_a_wrong_call_exits_with_2_and_one_message(mrm: Run, arguments: tuple[str, ...], message: str) -> None:
    done = mrm("validate", *arguments)
    assert done.returncode == 2
    assert message in done.stderr


def group_lives(group: int) -> bool:
    """Whether any process of a process group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_an_interrupt_exits_with_130_and_leaves_no_process(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mrm_mtlx.cli.main", "validate", "materials", "-j", "2"]
    process = subprocess.Popen(
        command, cwd=REPOSITORY, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    time.sleep(3.0)  # workers are up by then, and thirteen documents take longer
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "Traceback" not in errors
    deadline = time.monotonic() + PATIENCE_S
    while group_lives(process.pid):
        assert time.monotonic() < deadline, "processes of the run are still there"
        time.sleep(0.2)


def test_warnings_fail_under_strict_only(mrm: Run, gl: object) -> None:
    path = str(DOCUMENTS / "DOC_VALUE_RANGE" / "triggers.mtlx")
    usual = mrm("validate", path, "--target", "glsl", "--samples", "256")
    strict = mrm("validate", path, "--target", "glsl", "--samples", "256", "--strict")
    assert (usual.returncode, strict.returncode) == (0, 1), usual.stdout


def test_skips_fail_under_strict(mrm: Run, gl: object) -> None:
    arguments = ("validate", PLATE, "--target", "glsl", "--target", "msl", "--samples", "256")
    assert mrm(*arguments).returncode == 0
    assert mrm(*arguments, "--strict").returncode == 1


def test_findings_are_selected_and_ignored_by_prefix(mrm: Run) -> None:
    arguments = ("validate", PLATE, "--target", "mdl")
    assert "SHADER_IGNORES_RETRO" in mrm(*arguments).stdout
    assert "SHADER_IGNORES_RETRO" in mrm(*arguments, "--select", "SHADER").stdout
    assert "SHADER_IGNORES_RETRO" not in mrm(*arguments, "--select", "DOC").stdout
    assert "SHADER_IGNORES_RETRO" not in mrm(*arguments, "--ignore", "SHADER_IGN").stdout


# Reports --------------------------------------------------------------------------------------------------------------


def test_json_is_on_stdout_and_the_verdict_on_stderr(mrm: Run) -> None:
    done = mrm("validate", PLATE, "--target", "glsl", "--samples", "256", "--format", "json")
    report = json.loads(done.stdout)
    assert report["schema"] == "mrm.validate/1"
    assert [d["path"] for d in report["documents"]] == [PLATE]
    assert done.stderr.startswith(("PASSED", "NOTHING CHECKED"))


def test_junit_and_github_formats_parse(mrm: Run) -> None:
    path = str(DOCUMENTS / "DOC_UNKNOWN_INPUT" / "triggers.mtlx")
    junit = ET.fromstring(mrm("validate", path, "--target", "glsl", "--format", "junit").stdout)
    assert junit.find(".//failure") is not None
    (line,) = mrm("validate", path, "--target", "glsl", "--format", "github").stdout.splitlines()
    assert line.startswith("::error file=tests/documents/DOC_UNKNOWN_INPUT/triggers.mtlx,title=DOC_UNKNOWN_INPUT::")


def test_a_report_goes_to_a_file(mrm: Run, tmp_path: Path) -> None:
    done = mrm("validate", PLATE, "--target", "mdl", "--output", str(tmp_path / "report.txt"))
    assert done.stdout == ""
    assert "NOTHING CHECKED" in done.stderr
    assert "licence_plate" in (tmp_path / "report.txt").read_text(encoding="utf-8")


def test_two_runs_print_the_same_bytes_for_any_number_of_jobs(mrm: Run) -> None:
    arguments = (
        "validate",
        "materials/cats_eye.mtlx",
        PLATE,
        "--target",
        "glsl",
        "--samples",
        "512",
        "--format",
        "json",
    )
    one, two = (mrm(*arguments, "-j", jobs).stdout for jobs in ("1", "2"))
    assert one == two
    assert str(REPOSITORY) not in one


def test_output_that_is_not_a_terminal_has_no_escape_codes(mrm: Run) -> None:
    done = mrm("validate", PLATE, "--target", "mdl")
    assert "\x1b" not in done.stdout + done.stderr


# Other commands -------------------------------------------------------------------------------------------------------


def test_the_version_is_printed(mrm: Run) -> None:
    from mrm_mtlx import __version__

    assert mrm("--version").stdout.strip() == f"mrm {__version__}"


def test_no_arguments_show_the_help(mrm: Run) -> None:
    done = mrm()
    assert done.returncode == 2
    assert "Commands:" in done.stderr


def test_rules_are_listed_and_explained(mrm: Run) -> None:
    from mrm_mtlx.validation.catalogue import RULES

    listed = mrm("rules").stdout.splitlines()
    assert [line.split()[0] for line in listed] == list(RULES)
    page = mrm("rules", "SHADER_DIFFERS").stdout
    assert "24 times" in page
    assert mrm("rules", "NOPE").returncode == 2


def test_doctor_names_every_engine(mrm: Run) -> None:
    done = mrm("doctor", "--format", "json")
    report = json.loads(done.stdout)
    assert set(report["engines"]) == {"gl", "vulkan", "slang", "osl"}
    assert done.returncode == (0 if report["engines"]["gl"]["available"] else 1)
    for engine in report["engines"].values():
        assert engine["available"] or engine["detail"]
    assert "OpenGL" in mrm("doctor").stdout


def test_doctor_says_what_to_install_where_there_is_no_driver(mrm: Run) -> None:
    # An EGL that finds no vendor is what a bare machine has.
    bare = {**os.environ, "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}
    done = mrm("doctor", env=bare)
    if done.returncode == 0:
        pytest.skip("this machine's EGL finds a driver without its vendor files")
    assert done.returncode == 1
    assert "apt-get install" in done.stdout
    checked = mrm("validate", PLATE, "--target", "glsl", env=bare)
    assert checked.returncode == 3
    assert "apt-get install" in checked.stdout


def test_library_prints_its_folders(mrm: Run) -> None:
    assert (Path(mrm("library").stdout.strip()) / "pbrlib" / "mrm_defs.mtlx").is_file()
    assert (Path(mrm("library", "--materials").stdout.strip()) / "licence_plate.mtlx").is_file()


def test_library_installs_a_copy_and_refuses_what_it_cannot_write(mrm: Run, tmp_path: Path) -> None:
    assert mrm("library", "install", str(tmp_path / "hosts")).returncode == 0
    assert (tmp_path / "hosts" / "mrm" / "mrm_defs.mtlx").is_file()
    (tmp_path / "file").write_text("")
    assert mrm("library", "install", str(tmp_path / "file")).returncode == 2


@pytest.mark.parametrize("target", ["glsl", "essl", "vulkan", "msl", "slang", "wgsl", "osl", "mdl"])
def test_source_is_generated_for_every_target(mrm: Run, target: str, tmp_path: Path) -> None:
    done = mrm("generate", PLATE, "--target", target)
    assert done.returncode == 0, done.stderr
    assert "generalized_schlick" in done.stdout
    assert "Warning" not in done.stdout + done.stderr
    assert mrm("generate", PLATE, "--target", target, "-o", str(tmp_path)).returncode == 0
    assert list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [("generate",), ("render", "-o", "picture.png")])
def test_a_document_that_cannot_be_used_is_named_with_its_finding(mrm: Run, command: tuple[str, ...]) -> None:
    for path, code in ((DOCUMENTS / "READ_XML" / "triggers.mtlx", "READ_XML"), (Path("no.mtlx"), "READ_MISSING")):
        done = mrm(command[0], str(path), *command[1:])
        assert (done.returncode, done.stdout) == (1, "")
        assert code in done.stderr


def test_an_element_that_does_not_exist_is_a_usage_error(mrm: Run) -> None:
    done = mrm("generate", PLATE, "--element", "nothing")
    assert done.returncode == 2
    assert "M_licence_plate" in done.stderr


def test_conformance_reports_its_cases(mrm: Run, gl: object) -> None:
    done = mrm("conformance", "--samples", "512", "--target", "glsl", "--format", "json")
    report = json.loads(done.stdout)
    assert report["schema"] == "mrm.conformance/1"
    wanted = {"node", "target", "engine", "retroreflective", "status", "samples", "max_error", "median_error", "reason"}
    assert all(wanted <= set(case) for case in report["cases"])
    assert {case["status"] for case in report["cases"]} == {"pass"}
    assert done.returncode == 0
