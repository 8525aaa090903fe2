"""`mrm validate`: exit statuses, what goes where, and the same bytes every time."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree as ET

import pytest

from mrm_mtlx.shadergen import available_targets

# A target that is generated and not run: no driver, no compiler, a tenth of the time.
QUICK = ("--target", "mdl", "-j", "1")
GLSL = ("--target", "glsl", "--samples", "256", "-j", "1")

VERDICT = re.compile(r"^(PASSED|FAILED|NOTHING CHECKED)  \d+ errors?, \d+ warnings?, \d+ checked, \d+ skipped")


@pytest.fixture
def place(documents, tmp_path):
    """Function that copies a rule's document into the test's folder, and returns its name there."""

    def copy(code: str, which: str = "triggers") -> str:
        shutil.copy(documents / code / f"{which}.mtlx", tmp_path / f"{code.lower()}_{which}.mtlx")
        return f"{code.lower()}_{which}.mtlx"

    return copy


# Exit status ----------------------------------------------------------------------------------------------------------


def test_0_a_document_without_fault(mrm, metal, gl):
    done = mrm("validate", metal, *GLSL)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "PASSED  0 errors, 0 warnings, 1 checked, 0 skipped"


STRICT = "--strict: warnings and skips count as failures"


def test_0_warnings_alone_and_1_with_strict(mrm_here, place, gl):
    name = place("DOC_DUPLICATE_NAME")
    assert mrm_here("validate", name, *GLSL).returncode == 0
    strict = mrm_here("validate", name, *GLSL, "--strict")
    assert strict.returncode == 1
    assert strict.stdout.splitlines()[-1] == f"FAILED  0 errors, 1 warning, 1 checked, 0 skipped; {STRICT}"


def test_0_skips_beside_verdicts_and_1_with_strict(mrm_here, metal, gl):
    targets = (*GLSL, "--target", "mdl")
    assert mrm_here("validate", metal, *targets).returncode == 0
    strict = mrm_here("validate", metal, *targets, "--strict")
    assert strict.returncode == 1
    counts = "0 errors, 0 warnings, 1 checked, 1 skipped (1 mdl: no MDL compiler)"
    assert strict.stdout.splitlines()[-1] == f"FAILED  {counts}; {STRICT}"


def test_1_a_document_with_an_error(mrm_here, place):
    done = mrm_here("validate", place("DOC_INPUT_VALUE"), *QUICK)
    assert done.returncode == 1
    assert "error DOC_INPUT_VALUE" in done.stdout
    assert done.stdout.splitlines()[-1].startswith("FAILED  1 error, ")


def test_1_a_path_that_does_not_exist_and_the_others_are_checked(mrm_here, metal, gl):
    done = mrm_here("validate", "nothing.mtlx", "nowhere/", metal.name, *GLSL)
    assert done.returncode == 1
    assert done.stdout.count("error READ_MISSING") == 2
    assert done.stdout.splitlines()[-1] == "FAILED  2 errors, 0 warnings, 1 checked, 0 skipped"


def test_1_a_shader_that_differs(mrm_here, documents, gl):
    done = mrm_here("validate", documents / "SHADER_DIFFERS", *GLSL, "--target", "essl")
    assert done.returncode == 1
    assert "FAIL compare" in done.stdout
    assert re.search(r"essl: \d+ of 272 samples differ; worst at v = \(", done.stdout)


def test_1_an_ignored_finding_does_not_turn_a_failed_comparison_into_a_pass(mrm_here, place, gl):
    name = place("SHADER_DIFFERS")
    done = mrm_here("validate", name, *GLSL, "--target", "essl", "--ignore", "SHADER")
    assert done.returncode == 1
    assert "error" not in done.stdout.splitlines()[1]
    assert done.stdout.splitlines()[-1] == "FAILED  0 errors, 0 warnings, 2 checked, 0 skipped"


def test_1_when_the_process_that_checks_a_document_dies(mrm, documents, gl):
    done = mrm("validate", documents / "CHECK_CRASHED", *GLSL)
    assert done.returncode == 1
    assert "error CHECK_CRASHED" in done.stdout
    assert "- compiled" in done.stdout  # of the other document


def test_1_a_document_that_takes_too_long_is_given_up_without_a_word_on_stderr(mrm, documents, gl):
    pair = (documents / "CHECK_TIMEOUT" / f"{which}.mtlx" for which in ("triggers", "passes"))
    done = mrm("validate", *pair, "--target", "glsl", "-j", "2", "--timeout", "5")
    assert (done.returncode, done.stderr) == (1, "")
    assert "error CHECK_TIMEOUT" in done.stdout


@pytest.mark.parametrize(("form", "output"), [("text", "no/such/folder/report.txt"), ("json", ".")])
def test_2_a_report_that_cannot_be_written(mrm, form, output):
    done = mrm("validate", "nothing.mtlx", *QUICK, "--format", form, "-o", output)
    assert (done.returncode, done.stdout) == (2, "")
    assert "cannot be written" in done.stderr.splitlines()[-1]


def test_3_nothing_to_check(mrm_here, metal, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "tape.mtlx").write_text(metal.read_text(encoding="utf-8"), encoding="utf-8")
    found_nothing = "NOTHING CHECKED  0 errors, 0 warnings, 0 checked, 0 skipped; no document was found\n"
    for arguments in (["empty"], [".", "--exclude", "*.mtlx"]):
        done = mrm_here("validate", *arguments, *QUICK)
        assert (done.returncode, done.stdout) == (3, found_nothing)
    done = mrm_here("validate", metal, *QUICK)
    assert done.returncode == 3
    assert done.stdout.splitlines()[-1].startswith("NOTHING CHECKED  0 errors, 0 warnings, 0 checked, 1 skipped")


GONE_WITHIN_S = 30.0


@pytest.mark.skipif(os.name != "posix", reason="signals to processes are a matter of POSIX")
def test_130_an_interrupt_ends_the_run_and_its_processes(command, environment, documents, gl):
    path = documents / "CHECK_TIMEOUT" / "triggers.mtlx"
    process = subprocess.Popen(
        [*command, "validate", str(path), *GLSL, "--timeout", "600"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=True,
    )
    time.sleep(4.0)  # by now its process is at work, or about to be
    assert process.poll() is None
    os.kill(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=GONE_WITHIN_S)
    assert (process.returncode, out) == (130, "")
    assert "Traceback" not in err
    deadline = time.monotonic() + GONE_WITHIN_S
    while time.monotonic() < deadline:
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("processes of the run are left")


@pytest.mark.skipif(os.name != "posix", reason="signals to processes are a matter of POSIX")
def test_130_an_interrupt_from_the_keyboard_prints_no_traceback(command, environment, documents, gl):
    # The terminal sends it to all processes at once. When those of the run start depends on the machine: some moments.
    said = ""
    for moment in (1.0, 1.8):
        process = subprocess.Popen(
            [*command, "validate", str(documents / "CHECK_TIMEOUT" / "triggers.mtlx"), *GLSL],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )
        time.sleep(moment)
        os.killpg(process.pid, signal.SIGINT)
        said += process.communicate(timeout=GONE_WITHIN_S)[1]
        if "Traceback" in said:
            break
    assert "Traceback" not in said


# What goes where ------------------------------------------------------------------------------------------------------


def test_text_has_the_finding_with_its_place_and_hint_and_ends_with_the_verdict(mrm_here, place):
    name = place("DOC_UNKNOWN_NODE")
    done = mrm_here("validate", name, *QUICK)
    lines = done.stdout.splitlines()
    assert done.stderr == ""
    assert lines[:3] == [
        name,
        "  4:3 error DOC_UNKNOWN_NODE /metal",
        "      there is no node 'conducter_bsdf'; did you mean 'conductor_bsdf'?",
    ]
    assert lines[3].startswith("      Check the spelling")
    assert VERDICT.match(lines[-1])


@pytest.mark.parametrize("form", ["json", "junit", "github"])
def test_a_machine_gets_the_report_alone_on_stdout_and_the_verdict_on_stderr(mrm_here, form):
    done = mrm_here("validate", "nothing.mtlx", *QUICK, "--format", form)
    assert done.returncode == 1
    assert VERDICT.match(done.stderr)
    assert done.stderr.count("\n") == 1
    if form == "json":
        assert json.loads(done.stdout)["documents"][0]["findings"][0]["code"] == "READ_MISSING"
    elif form == "junit":
        assert ET.fromstring(done.stdout.encode()).find("testsuite").get("failures") == "1"
    else:
        assert done.stdout.startswith("::error file=nothing.mtlx,title=READ_MISSING::'nothing.mtlx' does not exist")
        assert done.stdout.count("\n") == 1


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_report_in_a_file_is_the_one_that_would_be_printed(mrm_here, tmp_path, form):
    printed = mrm_here("validate", "nothing.mtlx", *QUICK, "--format", form)
    written = mrm_here("validate", "nothing.mtlx", *QUICK, "--format", form, "--output", "report.txt")
    assert written.returncode == printed.returncode == 1
    assert written.stdout == ""
    assert VERDICT.match(written.stderr)
    assert (tmp_path / "report.txt").read_text(encoding="utf-8") == printed.stdout


@pytest.mark.parametrize(
    ("options", "expected"),
    [((), available_targets()), (("--target", "mdl", "--target", "glsl", "--target", "mdl"), ("mdl", "glsl"))],
)
def test_all_targets_are_checked_unless_some_are_named(mrm_here, place, options, expected):
    # A document with errors: nothing is generated, so that all targets cost nothing.
    done = mrm_here("validate", place("DOC_UNKNOWN_NODE"), "--format", "json", *options)
    assert tuple(json.loads(done.stdout)["documents"][0]["renderables"][0]["targets"]) == expected


@pytest.mark.parametrize(
    ("options", "status", "codes"),
    [
        (("--select", "DOC_DUP"), 3, {"DOC_DUPLICATE_NAME"}),
        (("--select", "DOC", "--ignore", "DOC_DUP"), 1, {"DOC_UNKNOWN_NODE"}),
    ],
)
def test_findings_are_selected_and_ignored(mrm_here, place, options, status, codes):
    names = [place("DOC_UNKNOWN_NODE"), place("DOC_DUPLICATE_NAME")]
    done = mrm_here("validate", *names, *QUICK, "--format", "json", *options)
    assert done.returncode == status
    assert {f["code"] for d in json.loads(done.stdout)["documents"] for f in d["findings"]} == codes


def test_two_runs_print_the_same_bytes(mrm, documents, gl):
    arguments = ("validate", documents / "ENERGY_GAIN", *GLSL, "--format", "json")
    first, second = mrm(*arguments), mrm(*arguments)
    assert first.stdout == second.stdout
    assert first.stderr == second.stderr
    assert '"max_error": 0.0' not in first.stdout  # there was something to differ


def test_reports_hold_no_absolute_path_and_no_time(mrm_here, documents, repository, tmp_path):
    done = mrm_here("validate", documents / "DOC_FILE", "nothing.mtlx", *QUICK, "--format", "json")
    for secret in (str(repository), str(tmp_path), os.path.expanduser("~") + os.sep):  # noqa: PTH111
        assert secret not in done.stdout
    assert [d["path"] for d in json.loads(done.stdout)["documents"]] == [
        "DOC_FILE/passes.mtlx",
        "DOC_FILE/triggers.mtlx",
        "nothing.mtlx",
    ]
    assert not re.search(r"\b20\d\d-\d\d|\d\d:\d\d", done.stdout)


def test_no_colours_into_a_pipe_and_none_with_no_color(mrm, command, environment, tmp_path):
    call = ("validate", "nothing.mtlx", *QUICK)
    assert "\x1b" not in mrm(*call).stdout
    pty = pytest.importorskip("pty", reason="this system has no pseudo-terminals")
    for variables, coloured in (({}, True), ({"NO_COLOR": "1"}, False)):
        terminal = {**environment, "TERM": "xterm-256color", **variables}
        shown = on_a_terminal(pty, [*command, *call], terminal, tmp_path)
        assert "READ_MISSING" in shown
        # NO_COLOR forbids colours; bold and dim remain.
        assert bool(re.search(r"\x1b\[[\d;]*3[0-7]m", shown)) is coloured


def on_a_terminal(pty, arguments: list[str], environment: dict[str, str], folder) -> str:
    """What a command prints when stdout and stderr are a terminal."""
    leader, follower = pty.openpty()
    with subprocess.Popen(arguments, stdout=follower, stderr=follower, env=environment, cwd=folder) as process:
        os.close(follower)
        shown = b""
        while True:
            try:
                part = os.read(leader, 65536)
            except OSError:  # Linux: the other end is closed
                break
            if not part:
                break
            shown += part
        process.wait()
    os.close(leader)
    return shown.decode("utf-8", errors="replace")


# Names from elsewhere -------------------------------------------------------------------------------------------------


def named(metal, name: str):
    """A document whose material has this name."""
    path = metal.with_name("named.mtlx")
    path.write_text(
        metal.read_text(encoding="utf-8").replace('name="material" type', f'name="{name}" type'), encoding="utf-8"
    )
    return path.name


@pytest.mark.parametrize(
    "name",
    [
        "[/red]",
        "[bold]sheet",
        "Schild_für_Würzburg",
    ],
)
def test_names_of_a_document_are_printed_as_they_are(mrm_here, metal, name):
    done = mrm_here("validate", named(metal, name), *QUICK)
    assert done.returncode in (1, 3)  # MaterialX takes some of these for names, and some not
    assert re.search(rf"^  {re.escape(name)} +- ", done.stdout, re.MULTILINE)


# U+009B starts a control sequence as ESC [ does, and XML may contain it.
@pytest.mark.parametrize(
    "where",
    [
        "material",
        "metal",
        "weight",
    ],
)
def test_names_of_a_document_do_not_drive_the_terminal(mrm_here, metal, where):
    text = metal.read_text(encoding="utf-8").replace(f'name="{where}" type', f'name="{where}\x9b31m\u202e" type')
    path = metal.with_name("named.mtlx")
    path.write_text(text, encoding="utf-8")
    done = mrm_here("validate", path.name, *QUICK)
    assert done.returncode == 1
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]", done.stdout)


@pytest.mark.skipif(os.name != "posix", reason="names of files are text elsewhere")
def test_names_of_files_do_not_drive_the_terminal(mrm_here, metal):
    path = metal.rename(metal.with_name("red\x1b[31m.mtlx"))
    done = mrm_here("validate", path.name, *QUICK)
    assert "\x1b" not in done.stdout + done.stderr


@pytest.mark.skipif(os.name != "posix", reason="names of files are text elsewhere")
def test_a_file_whose_name_is_no_text_is_checked_or_gets_a_finding(mrm, metal):
    os.rename(metal, os.fsencode(metal.parent) + b"/\xff.mtlx")  # noqa: PTH104
    done = mrm("validate", ".", *QUICK, "--format", "junit")
    assert done.returncode in (1, 3)
    assert " at 0x" not in done.stdout
