"""What a document does to the process that opens it, and what is left when a process is ended from outside."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mrm_mtlx.system import process_limits

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="signals and forks are a matter of POSIX")

COMMAND = [sys.executable, "-m", "mrm_mtlx.cli.main"]
GONE_WITHIN_S = 30.0

# Stands in for a document on which a library dies or hangs: each is done to the process in the midst of its work.
HARM = {
    "crash": "os.kill(os.getpid(), signal.SIGSEGV)",
    "hang": "signal.signal(signal.SIGINT, signal.SIG_IGN); time.sleep(600)",
    "eat": "kept = [bytearray(b'x' * 2**26) for _ in range(64)]",
}
HARMED = """
import os, signal, sys, tempfile, time
from mrm_mtlx.cli import main
harm = sys.argv.pop(1)
from mrm_mtlx.formats import reading
def read(*_):
    tempfile.mkdtemp(prefix="mrm-left-")
    exec(harm, globals())
    raise SystemExit("it was meant to end before")
reading.read_document = read
sys.argv[0] = "mrm"
main.run()
"""


@pytest.fixture
def harmed(tmp_path):
    """Function that starts a command to whose process one of `HARM` is done as it reads; temporary files lie here."""
    (tmp_path / "scratch").mkdir()
    (tmp_path / "x.mtlx").write_text('<?xml version="1.0"?><materialx version="1.39"/>', encoding="utf-8")
    environment = {**os.environ, "TMPDIR": str(tmp_path / "scratch")}

    def start(harm: str, *arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", HARMED, HARM[harm], *arguments]
        return subprocess.Popen(
            command,
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    return start


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "scratch").rglob("*"))


def processes_of(session: int) -> list[int]:
    """Living processes of a session, but not those that wait to be buried."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(entry.name))
    return found


COMMANDS = [
    pytest.param(("render", "x.mtlx", "-o", "x.png"), id="render"),
    pytest.param(("convert", "x.mtlx", "x.usda"), id="convert"),
    pytest.param(("generate", "x.mtlx"), id="generate"),
    pytest.param(("plot", "x.mtlx", "-o", "x.svg"), id="plot"),
    pytest.param(("photometry", "x.mtlx", "--class", "DOT-C2", "--color", "white"), id="photometry"),
]


@pytest.mark.parametrize("arguments", COMMANDS)
def test_a_document_that_kills_the_process_is_a_finding_of_every_command(harmed, tmp_path, arguments):
    process = harmed("crash", *arguments)
    out, err = process.communicate(timeout=GONE_WITHIN_S)
    assert (process.returncode, out) == (1, "")
    assert err.startswith("error CHECK_CRASHED: x.mtlx: the process that worked on it died (signal SIGSEGV)\n")
    assert left(tmp_path) == []


def test_a_document_that_never_ends_is_a_finding(harmed, tmp_path):
    process = harmed("hang", "generate", "x.mtlx", "--timeout", "2")
    out, err = process.communicate(timeout=GONE_WITHIN_S)
    assert (process.returncode, out) == (1, "")
    assert err.startswith("error CHECK_TIMEOUT: x.mtlx: not finished within the time limit\n")
    assert left(tmp_path) == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is limited on Linux alone")
def test_a_document_that_takes_all_memory_is_a_finding(harmed, tmp_path):
    process = harmed("eat", "generate", "x.mtlx")
    out, err = process.communicate(timeout=GONE_WITHIN_S)
    assert (process.returncode, out) == (1, "")
    assert err.startswith(f"error CHECK_CRASHED: x.mtlx: {process_limits.memory_reason()}\n")
    assert left(tmp_path) == []


def test_an_interrupt_ends_a_command_that_hangs_in_a_library_and_ignores_it(harmed, tmp_path):
    process = harmed("hang", "generate", "x.mtlx")
    wait_for(lambda: left(tmp_path) and any(name.startswith("mrm-left-") for name in left(tmp_path)))
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    out, err = process.communicate(timeout=GONE_WITHIN_S)
    assert (process.returncode, out, err) == (130, "", "mrm: interrupted\n")
    assert left(tmp_path) == []
    assert processes_of(process.pid) == []


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are found in /proc")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_signal_to_end_leaves_neither_files_nor_processes(harmed, tmp_path, name):
    process = harmed("hang", "generate", "x.mtlx")
    wait_for(lambda: any(name.startswith("mrm-left-") for name in left(tmp_path)))
    os.kill(process.pid, getattr(signal, name))
    process.communicate(timeout=GONE_WITHIN_S)
    assert process.returncode == 128 + getattr(signal, name)
    assert left(tmp_path) == []
    assert processes_of(process.pid) == []


def wait_for(condition) -> None:
    end = time.monotonic() + GONE_WITHIN_S
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.05)


# Many documents at once -----------------------------------------------------------------------------------------------


def test_a_surface_that_kills_its_process_loses_one_target_and_nothing_else(gl, repository, tmp_path):
    document = repository / "tests" / "rules" / "CHECK_CRASHED" / "triggers.mtlx"
    targets = ("--target", "mdl", "--target", "glsl", "--target", "osl")
    command = [*COMMAND, "validate", str(document), *targets, "--format", "json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    (report,) = json.loads(done.stdout)["documents"]
    # The node has source for GLSL alone.
    assert [f["code"] for f in report["findings"]] == ["SHADER_GENERATE", "CHECK_CRASHED", "SHADER_GENERATE"]
    crashed = report["findings"][1]
    assert crashed["location"] == "/material"
    assert crashed["message"].startswith("glsl: the process that checked it died (")


def test_a_hundred_thousand_mistakes_of_one_kind_are_counted_and_not_listed(tmp_path):
    nodes = "".join(f'<nothing{n} name="n{n}" type="float"/>' for n in range(100_000))
    (tmp_path / "x.mtlx").write_text(f'<?xml version="1.0"?><materialx version="1.39">{nodes}</materialx>')
    command = [*COMMAND, "validate", "x.mtlx", "--target", "mdl", "--format", "json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    (report,) = json.loads(done.stdout)["documents"]
    unknown = [f for f in report["findings"] if f["code"] == "DOC_UNKNOWN_NODE"]
    assert len(unknown) == 101
    assert unknown[-1]["message"] == "99900 more findings of DOC_UNKNOWN_NODE; the first 100 are listed"


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_ended_a_command_by_an_error_of_its_own_and_left_its_folder(tmp_path, closed):
    environment = {**os.environ, "TMPDIR": str(tmp_path), "PYTHON": sys.executable}
    command = f'"$PYTHON" -m mrm_mtlx.cli.main rules READ {closed}'
    done = subprocess.run(["sh", "-c", command], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_and_a_long_name_are_no_internal_errors(full_disk, tmp_path):
    with full_disk.open("w") as stream:
        done = subprocess.run([*COMMAND, "rules"], stdout=stream, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "mrm: No space left on device\n")
    arguments = ["convert", "x.usda", f"{'n' * 300}.mtlx"]
    done = subprocess.run([*COMMAND, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("mrm: File name too long: n")


@pytest.mark.large
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is limited on Linux alone")
def test_a_large_picture_has_the_memory_that_its_user_asked_for(gl, repository, tmp_path):
    document = repository / "materials" / "cats_eye.mtlx"
    command = [*COMMAND, "render", str(document), "-o", "a.png", "--size", "1536", "--shape", "plane"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert (done.returncode, done.stderr) == (0, "wrote a.png\n")
