"""The OSL runtime: found by trying, and whatever ends it or fills the disk is said and leaves nothing behind."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import venv
from collections import namedtuple
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from mrm_mtlx.engines import osl
from mrm_mtlx.engines.base import EngineFailure
from mrm_mtlx.engines.blender.process import BlenderProcess
from mrm_mtlx.engines.blender.runtime import WHEELS
from mrm_mtlx.engines.osl import process
from mrm_mtlx.system.writing import replacing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Seconds after which a process of these tests counts as hung; the longest takes five.
TIME_LIMIT_S = 60.0
# Seconds that a server may take to notice that nobody listens any more; on a busy machine it needs one.
END_S = 10.0

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc, /dev/full and prlimit are Linux's")

WHITE = "shader white(output closure color out = 0)\n{\n    out = diffuse(N);\n}\n"
# With a header of MaterialX's, as all generated OSL.
WITH_HEADER = """#include "mx_funcs.h"
shader with_header(float a = 0, output closure color out = 0)
{
    vector2 pair = {a, a};
    out = emission() * color(pair.x, pair.y, 1.0);
}
"""


@pytest.fixture
def temporary(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Folder of temporary files of this process and of those that it starts: the test's own, empty."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, temporary: Path) -> Iterator[Path]:
    """The engine as a process has it at its start, none running; what it starts ends with the test."""
    monkeypatch.setattr(process.RUNTIME, "_running", [])
    yield temporary
    process.stop()


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch, fresh: Path) -> Callable[[str | Path], osl.Availability]:
    """Function from the value of MRM_OSL_PYTHON to what the engine then says of itself."""

    def availability(interpreter: str | Path):
        monkeypatch.setenv(process.VARIABLE, str(interpreter))
        return process.RUNTIME.tried()  # the answer of this moment, not the kept one

    return availability


def left_in(folder: Path) -> list[str]:
    """The runtime's own folders among the temporary files."""
    return [path.name for path in folder.glob("mrm-osl-*")]


def running(pid: int) -> bool:
    """Whether a process exists and is more than an entry that nobody has collected."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"


def ends_within(pid: int, seconds: float) -> bool:
    """Whether a process is gone by then."""
    limit = time.monotonic() + seconds
    while running(pid) and time.monotonic() < limit:
        time.sleep(0.02)
    return not running(pid)


def emptied_within(folder: Path, seconds: float) -> bool:
    """Whether nothing of the runtime's is left in a folder by then: its keeper tidies up after the server's end."""
    limit = time.monotonic() + seconds
    while left_in(folder) and time.monotonic() < limit:
        time.sleep(0.02)
    return not left_in(folder)


def endless() -> None:
    """A request that takes hours: a picture of many paths."""
    shader = osl.compile_for_cycles(WHITE, "white")
    osl.furnace(shader, np.tile([0.0, 0.0, 1.0], (4096, 1)), {}, 10_000_000)


# Found by trying ------------------------------------------------------------------------------------------------------


def test_a_working_runtime_names_its_versions_and_needs_no_remedy(cycles):
    assert cycles is osl.availability()
    assert re.fullmatch(r"Cycles 5\.0\.\d+, OSL \d+\.\d+\.\d+", cycles.detail)
    assert cycles.remedy == ""


def assert_absent(state, *words: str) -> None:
    assert not state.available
    assert "\n" not in state.detail
    for word in words:
        assert word in state.detail
    assert state.remedy


def test_an_interpreter_without_bpy_is_tried_and_named_with_what_it_lacks(tried, tmp_path, fresh):
    venv.create(tmp_path / "bare", with_pip=False, symlinks=True)
    interpreter = tmp_path / "bare" / "bin" / "python"
    assert_absent(tried(interpreter), str(interpreter), "No module named 'bpy'")
    assert left_in(fresh) == []
    with pytest.raises(EngineFailure, match="No module named 'bpy'"):
        process.runtime()


@pytest.mark.parametrize("status", [0, 3])
def test_a_program_that_ends_at_once_is_named_with_its_exit_status(tried, tmp_path, fresh, status):
    program = script(tmp_path / "ending", f"#!/bin/sh\necho nothing to do here >&2\nexit {status}\n")
    assert_absent(tried(program), str(program), f"exit status {status}", "nothing to do here")
    assert left_in(fresh) == []


def test_an_interpreter_that_does_not_exist_is_named(tried, tmp_path):
    state = tried(tmp_path / "nowhere")
    assert_absent(state, f"bpy does not run: {tmp_path / 'nowhere'}: No such file or directory")
    assert "Error" not in state.detail
    assert_absent(tried(tmp_path), f"{tmp_path}: not a program")


def test_an_interpreter_that_does_not_exist_leaves_no_folder(tried, tmp_path, fresh):
    tried(tmp_path / "nowhere")
    assert left_in(fresh) == []


def test_asking_for_a_runtime_that_cannot_start_is_a_runtime_failure(monkeypatch, tmp_path, fresh):
    monkeypatch.setenv(process.VARIABLE, str(tmp_path / "nowhere"))
    with pytest.raises(EngineFailure, match="nowhere"):
        process.runtime()


def test_an_interpreter_may_be_named_by_a_relative_path_as_the_remedy_does(cycles, tried, monkeypatch, tmp_path):
    (tmp_path / "osl").symlink_to(Path(process.RUNTIME.interpreter()).parents[1])
    monkeypatch.chdir(tmp_path)
    state = tried("osl/bin/python")
    assert state.available, state.detail


def test_an_interpreter_that_greets_before_it_answers_is_refused_with_a_reason(tried, tmp_path, fresh):
    # As a start-up file does that prints; what it prints stands where the length of a message is expected.
    greeting = f'#!/bin/sh\necho Welcome to this environment\nexec "{sys.executable}" "$@"\n'
    assert_absent(tried(script(tmp_path / "greeting", greeting)), "greeting")
    assert left_in(fresh) == []


def script(path: Path, text: str) -> Path:
    """A program of its own."""
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)
    return path


Version = namedtuple("Version", "major minor micro")


@pytest.fixture
def without_bpy(monkeypatch: pytest.MonkeyPatch, fresh: Path) -> None:
    """No interpreter is named, and this one has no bpy."""
    monkeypatch.delenv(process.VARIABLE, raising=False)
    monkeypatch.setitem(sys.modules, "bpy", None)  # the import system's own mark of a module that is not there


@pytest.mark.parametrize("python", WHEELS)
def test_without_bpy_the_reason_and_its_remedy_fit_the_version_of_python(without_bpy, monkeypatch, python):
    monkeypatch.setattr(sys, "version_info", Version(*python, 9))
    state = process.RUNTIME.tried()
    assert_absent(state, "bpy is not installed")
    assert state.detail == "bpy is not installed"
    assert state.remedy == "pip install 'mrm-mtlx[osl]'"


def test_another_python_is_told_of_those_that_bpy_is_for(without_bpy, monkeypatch):
    monkeypatch.setattr(sys, "version_info", Version(3, 12, 1))
    state = process.RUNTIME.tried()
    assert_absent(state, "its wheels are for Python 3.11 and 3.13 (this is 3.12)")
    # A command for the other Python: an extra of this package would not resolve here.
    assert state.remedy.startswith("python3.11 -m venv ")
    assert "pip install 'bpy==5.0.*'" in state.remedy
    assert process.VARIABLE in state.remedy
    with pytest.raises(EngineFailure, match=r"its wheels are for Python 3\.11 and 3\.13 .*; python3\.11 -m venv"):
        process.runtime()


def test_the_remedy_of_a_named_interpreter_is_about_the_one_that_is_named(tried, tmp_path):
    # To install the extra here changes nothing while the variable names another interpreter.
    assert process.VARIABLE in tried(tmp_path / "nowhere").remedy


def test_an_absent_runtime_is_skipped_with_its_reason_unless_it_is_expected(repository, tmp_path):
    one = f"{__file__}::test_a_working_runtime_names_its_versions_and_needs_no_remedy"
    options = ["-q", "-n", "0", "-p", "no:cacheprovider", "-rfEs", "--rootdir", str(repository)]
    command = [sys.executable, "-m", "pytest", *options, one]
    absent = {**os.environ, process.VARIABLE: str(tmp_path / "nowhere"), "TMPDIR": str(tmp_path)}
    unexpected, expected = (
        subprocess.Popen(command, env={**absent, "MRM_EXPECT_OSL": value}, stdout=subprocess.PIPE, text=True)
        for value in ("", "1")
    )
    skipped, failed = (each.communicate(timeout=TIME_LIMIT_S)[0] for each in (unexpected, expected))
    assert "1 skipped" in skipped
    assert "OSL runtime not available: bpy does not run: " in skipped
    assert "1 error" in failed
    assert "MRM_EXPECT_OSL asks for the OSL runtime, found: bpy does not run: " in failed


def test_bpy_is_never_imported_into_this_process(python, cycles, tmp_path):
    code = (
        "import sys, numpy; from mrm_mtlx.engines import osl\n"
        f"shader = osl.compile_for_cycles({WHITE!r}, 'white')\n"
        "lit = osl.direct_light(shader, numpy.array([[0.0, 0.0, 1.0]]), {}, [[0.0, 0.0, 1.0]])\n"
        "print(lit.shape, *sorted({'bpy', '_cycles', 'mathutils'} & set(sys.modules)))"
    )
    done = python("-c", code, TMPDIR=str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[0] == "(1, 1, 3)"


def test_a_module_of_blenders_in_this_process_would_be_seen(python, cycles, tmp_path):
    code = "import sys; sys.modules['_cycles'] = sys; print(*sorted({'bpy', '_cycles'} & set(sys.modules)))"
    assert python("-c", code).stdout == "_cycles\n"


# What ends it ---------------------------------------------------------------------------------------------------------


@linux
def test_a_crash_is_named_by_its_signal_and_the_next_one_starts_anew(cycles, fresh):
    first = process.runtime()
    assert process.runtime() is first
    os.kill(first.versions["pid"], signal.SIGSEGV)
    with pytest.raises(EngineFailure, match="ended with signal SIGSEGV in 'versions'"):
        first.request("versions")
    second = process.runtime()
    assert second is not first
    assert not first.folder.exists()
    # In the middle of a request, too.
    assassin = threading.Timer(0.5, os.kill, (second.versions["pid"], signal.SIGABRT))
    assassin.start()
    with pytest.raises(EngineFailure, match="ended with signal SIGABRT in 'render'"):
        endless()
    assassin.join()
    third = process.runtime()
    assert third.request("versions")[0]["with_osl"]
    assert left_in(fresh) == [third.folder.name]


@linux
def test_a_request_that_takes_too_long_is_ended_with_the_process(cycles, fresh, monkeypatch):
    monkeypatch.setitem(BlenderProcess.request.__kwdefaults__, "timeout_s", 0.5)
    runtime = process.runtime()
    start = time.monotonic()
    with pytest.raises(EngineFailure, match=r"gave no answer within 0\.5 s"):
        endless()
    assert time.monotonic() - start < 0.5 + END_S
    assert ends_within(runtime.versions["pid"], END_S)


@linux
def test_what_follows_a_request_that_took_too_long_has_a_process_of_its_own(cycles, fresh, monkeypatch):
    with monkeypatch.context() as impatient:
        impatient.setitem(BlenderProcess.request.__kwdefaults__, "timeout_s", 0.5)
        with pytest.raises(EngineFailure, match="gave no answer"):
            endless()
    assert process.runtime().request("versions")[0]["with_osl"]


def test_a_refused_request_leaves_the_process_alive(cycles):
    runtime = process.runtime()
    with pytest.raises(EngineFailure, match="the shader has no input q; it has"):
        osl.evaluate(osl.compile_for_cycles(WITH_HEADER, "with_header"), {"q": np.zeros(3)})
    assert process.runtime() is runtime
    assert runtime.request("versions")[0]["blender"] == runtime.versions["blender"]


@linux
def test_closing_ends_the_process_and_removes_its_folder(cycles, temporary):
    with BlenderProcess(process.RUNTIME.interpreter(), process.SERVER) as own:
        assert running(own.versions["pid"])
        assert left_in(temporary) == [own.folder.name]
    assert not running(own.versions["pid"])
    assert left_in(temporary) == []
    own.close()  # again, as after a crash


def test_closing_leaves_nothing_of_blenders_either(cycles, temporary):
    BlenderProcess(process.RUNTIME.interpreter(), process.SERVER).close()
    assert list(temporary.iterdir()) == []


# A process that uses the engine: says which server it has, then waits, or has a picture made that takes hours.
USER = """
import sys, time, numpy
from mrm_mtlx.engines import osl
shader = osl.compile_for_cycles({white!r}, "white")
print(osl.process.runtime().versions["pid"], flush=True)
if sys.argv[1] == "idle":
    time.sleep(3600)
osl.furnace(shader, numpy.tile([0.0, 0.0, 1.0], (4096, 1)), {{}}, int(sys.argv[1]))
"""


@contextmanager
def user_of_the_engine(work: str, temporary: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Such a process, in a group of its own, and the id of its server; both are gone afterwards."""
    user = subprocess.Popen(
        [sys.executable, "-c", USER.format(white=WHITE), work], env={**os.environ, "TMPDIR": str(temporary)},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    server = int(user.stdout.readline())
    try:
        time.sleep(0.5)  # into the midst of it
        # What the tests below find gone is there before.
        assert running(server)
        assert len(left_in(temporary)) == 1
        yield user, server
    finally:
        for pid in (user.pid, server):
            if running(pid):
                os.kill(pid, signal.SIGKILL)
        user.communicate(timeout=TIME_LIMIT_S)


@linux
def test_an_interrupt_in_the_middle_of_a_request_leaves_no_process_and_no_folder(cycles, temporary):
    with user_of_the_engine("10000000", temporary) as (user, server):
        os.killpg(user.pid, signal.SIGINT)  # as a terminal does: to both processes
        _, errors = user.communicate(timeout=TIME_LIMIT_S)
        assert errors.strip().endswith("KeyboardInterrupt")
        assert not running(server)
        assert left_in(temporary) == []


@linux
def test_a_server_whose_user_was_killed_ends_and_removes_its_folder(cycles, temporary):
    with user_of_the_engine("idle", temporary) as (user, server):
        user.kill()
        user.wait(TIME_LIMIT_S)
        assert ends_within(server, END_S)
        assert emptied_within(temporary, END_S)


@linux
def test_a_server_whose_user_was_killed_in_the_middle_of_a_request_does_not_work_on(cycles, temporary):
    with user_of_the_engine("10000000", temporary) as (user, server):
        user.kill()
        user.wait(TIME_LIMIT_S)
        assert ends_within(server, 2.0)


@linux
def test_a_stopped_server_ends_with_its_user(cycles, temporary):
    with user_of_the_engine("idle", temporary) as (user, server):
        os.kill(server, signal.SIGSTOP)
        user.kill()
        user.wait(TIME_LIMIT_S)
        assert ends_within(server, END_S)
        assert emptied_within(temporary, END_S)


@linux
def test_a_runtime_that_dies_as_it_first_starts_is_tried_once_more(cycles, tried, tmp_path, fresh):
    once, runtime = tmp_path / "once", os.environ.get("MRM_OSL_PYTHON") or sys.executable
    once.write_text(
        f'#!/bin/sh\n[ -e {tmp_path}/died ] || {{ touch {tmp_path}/died; kill -SEGV $$; }}\nexec {runtime} "$@"\n'
    )
    once.chmod(0o755)
    assert tried(once).available


@linux
def test_a_server_whose_user_was_killed_in_the_middle_of_a_request_removes_its_folder(cycles, temporary):
    with user_of_the_engine("40000", temporary) as (user, server):
        user.kill()
        user.wait(TIME_LIMIT_S)
        assert ends_within(server, TIME_LIMIT_S)
        assert emptied_within(temporary, END_S)


@linux
def test_the_workers_of_a_run_over_documents_leave_no_folder(python, cycles, temporary, repository):
    documents = [str(repository / "materials" / f"{name}.mtlx") for name in ("cats_eye", "shoe_trim")]
    done = python("-m", "mrm_mtlx.cli.main", "validate", *documents, "--target", "osl", "--jobs", "2")
    assert done.returncode == 0, done.stdout + done.stderr
    limit = time.monotonic() + 3.0
    while left_in(temporary) and time.monotonic() < limit:
        time.sleep(0.05)
    assert left_in(temporary) == []


# A full disk ----------------------------------------------------------------------------------------------------------


@contextmanager
def files_limited_to(size: int, pid: int = 0) -> Iterator[None]:
    """No file of a process can grow beyond this size [bytes]; to a program as on a full disk, but for the words."""
    import resource

    before = resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    try:
        yield
    finally:
        resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


@linux
def test_a_source_that_does_not_fit_on_the_disk_is_a_runtime_failure(cycles):
    source = process.runtime().folder / "homeless.osl"
    source.symlink_to("/dev/full")
    try:
        with pytest.raises(EngineFailure, match=r"shader could not be written .*: No space left on device"):
            osl.check(WHITE, "homeless")
    finally:
        source.unlink()


@linux
def test_headers_that_did_not_fit_on_the_disk_are_written_when_there_is_room_again(cycles, fresh):
    process.runtime()
    with files_limited_to(100), pytest.raises(EngineFailure, match="shader could not be written"):
        osl.compile_for_cycles(WITH_HEADER, "with_header")
    osl.compile_for_cycles(WITH_HEADER, "with_header")


@linux
@pytest.mark.parametrize("room", [0, 300])
def test_a_compiled_shader_that_does_not_fit_on_the_disk_is_not_the_fault_of_the_source(cycles, room):
    with (
        files_limited_to(room, process.runtime().versions["pid"]),
        pytest.raises(EngineFailure, match="disk of temporary files full"),
    ):
        osl.compile_for_cycles(WHITE, "white")


@linux
@pytest.mark.parametrize("room", [0, 2000])
def test_a_picture_that_does_not_fit_on_the_disk_is_a_runtime_failure(cycles, room):
    shader = osl.compile_for_cycles(WITH_HEADER, "with_header")
    values = {"a": np.arange(300.0)}
    runtime = process.runtime()
    with (
        files_limited_to(room, runtime.versions["pid"]),
        pytest.raises(EngineFailure, match="picture could not be read back; is the disk of temporary files full"),
    ):
        osl.evaluate(shader, values)
    # With room again, the same process goes on.
    np.testing.assert_array_equal(osl.evaluate(shader, values)[:, 0], values["a"])
    assert process.runtime() is runtime


@pytest.mark.parametrize("content", [b"", b"half of a picture"])
def test_a_picture_that_cannot_be_read_leaves_no_words_for_the_end_of_the_process(python, tmp_path, content):
    (tmp_path / "half.exr").write_bytes(content)
    code = (
        "import sys, pathlib\n"
        "from mrm_mtlx.engines.base import EngineFailure\nfrom mrm_mtlx.engines.osl.scenes import _read\n"
        "try:\n    _read(pathlib.Path(sys.argv[1]))\nexcept EngineFailure:\n    print('refused')\n"
    )
    done = python("-c", code, str(tmp_path / "half.exr"))
    assert done.stdout == "refused\n"
    assert done.stderr == ""


def test_a_missing_folder_of_temporary_files_is_a_runtime_failure(cycles, fresh, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(fresh / "nowhere"))
    with pytest.raises(EngineFailure, match="no temporary folder could be made: No such file or directory"):
        process.runtime()
    state = process.RUNTIME.tried()
    assert_absent(state, "no temporary folder could be made")


# Files that are there whole or not at all -----------------------------------------------------------------------------


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    """A file that stands where another is to be written, alone in its folder."""
    folder = tmp_path / "precious"
    folder.mkdir()
    (folder / "m.osl").write_text("as it was", encoding="utf-8")
    return folder / "m.osl"


def assert_untouched(path: Path) -> None:
    assert path.read_text(encoding="utf-8") == "as it was"
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_a_file_takes_its_place_when_it_is_whole(precious):
    with replacing(precious) as unfinished:
        unfinished.write_text("new", encoding="utf-8")
        assert precious.read_text(encoding="utf-8") == "as it was"
        assert unfinished.suffix == precious.suffix
    assert precious.read_text(encoding="utf-8") == "new"
    assert [each.name for each in precious.parent.iterdir()] == ["m.osl"]


def test_an_interrupted_file_leaves_the_one_before_it(precious):
    def write() -> None:
        with replacing(precious) as unfinished:
            unfinished.write_text("half of", encoding="utf-8")
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        write()
    assert_untouched(precious)


@linux
def test_a_file_that_does_not_fit_on_the_disk_leaves_the_one_before_it(precious):
    with pytest.raises(OSError, match="File too large"), files_limited_to(100), replacing(precious) as unfinished:
        unfinished.write_text("more than fits" * 100, encoding="utf-8")
    assert_untouched(precious)


def test_a_file_that_was_not_written_at_all_leaves_the_one_before_it(precious):
    with pytest.raises(FileNotFoundError), replacing(precious):
        pass
    assert_untouched(precious)


@linux
def test_what_is_not_a_plain_file_is_written_to_directly():
    with pytest.raises(OSError, match="No space left"), replacing(Path("/dev/full")) as full:
        full.write_text("too much", encoding="utf-8")


@linux
def test_generate_writes_whole_files_or_none(precious, tmp_path, repository):
    document = repository / "materials" / "licence_plate.mtlx"
    command = [sys.executable, "-m", "mrm_mtlx.cli.main", "generate", str(document), "--target", "osl"]

    def small_disk() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    elsewhere = tmp_path / "elsewhere"
    subprocess.run([*command, "-o", str(elsewhere)], check=True, capture_output=True, timeout=TIME_LIMIT_S)
    (file,) = elsewhere.iterdir()
    assert file.stat().st_size > 1000
    existing = precious.rename(precious.with_name(file.name))
    done = subprocess.run(
        [*command, "-o", str(existing.parent)], preexec_fn=small_disk,
        check=False, capture_output=True, text=True, timeout=TIME_LIMIT_S,
    )  # fmt: skip
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "cannot be written: File too large" in re.sub(r"[\s│]+", " ", done.stderr)
    assert_untouched(existing)
